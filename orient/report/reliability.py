"""What the tests of an adjustment say, for people: the weakest and most suspicious readings first."""

from collections.abc import Sequence
from heapq import nsmallest

from orient.report.text import cell
from orient.values import Row, Scalar, Tables

Shown = tuple[str, list[str], list[list[str]]]
ORDER = {"suspect": 0, "not checked": 1, "hardly checked": 2, "good": 3}
MICROMETRES, MILLIMETRES, MODEL = 1000.0, "mm", "model"


def test_lines(tables: Tables) -> list[str]:
    """The global test and the limits of the single tests, a sentence for each adjustment."""
    return [_named(row) + "; ".join(sentences(row)) for row in tables.get("adjustment_test", ())]


def reliability_tables(tables: Tables, most: int) -> list[Shown]:
    """Observations by verdict, then by what their smallest findable error does; and the exclusions."""
    shown = []
    if exclusions := tables.get("exclusion", ()):
        shown.append(_exclusions(exclusions))
    if observations := tables.get("observation_test", ()):
        shown.append(_observations(observations, most))
    return shown


def _named(row: Row) -> str:
    """The sheet and coordinate of an adjustment that is one of several."""
    name = " ".join(str(row[key]) for key in ("part", "component") if row[key])
    return f"{name}: " if name else ""


def sentences(row: Row) -> list[str]:
    """What the global test of one adjustment says, and the limit of its single tests."""
    if row["redundancy"] == 0:
        return ["no redundancy: nothing is checked"]
    if row["verdict"] is None:
        return [_limit(row)]
    return [
        f"global test at 5 %: v'Pv/sigma0^2 = {cell(row['statistic'], 2)}, accepted from "
        f"{cell(row['lower'], 2)} to {cell(row['upper'], 2)}: {row['verdict']}",
        _limit(row),
    ]


def _limit(row: Row) -> str:
    if row["critical"] is None:
        return "no single test is possible with r = 1 and estimated sigma0"
    return f"|{row['test']}| up to {cell(row['critical'], 2)} is good"


def _exclusions(rows: Sequence[Row]) -> Shown:
    cells = [
        [f"{row['part']} {row['point']}".strip(), str(row["action"]), str(row["decided_by"]), cell(row["reason"])]
        for row in rows
    ]
    return "Points left out, or proposed for it", ["point", "action", "by", "reason"], cells


def _observations(rows: Sequence[Row], most: int) -> Shown:
    """MDB is the smallest error that the test finds with power 0.80."""
    ranked = nsmallest(most, rows, key=_place)
    title = "Reliability: smallest error (MDB) found with 80 %; its effect if it is not found"
    if any(row["unit"] == MODEL for row in rows):
        title += "\nX Y Z: given on the ground; x y z: of the model, in its own units"
    if len(rows) > most:
        title += f"\n{most} of {len(rows)} observations, the weakest first"
    cells = [
        [
            f"{row['part']} {row['point']} {row['axis']}".strip(),
            cell(row["share"], 2),
            cell(row["w"], 2),
            _error(row),
            cell(row["bias_to_noise"], 1),
            cell(row["ground_shift_m"], 2),
            cell(row["rho"], 2),
            "" if row["verdict"] == "good" else str(row["verdict"]),
        ]
        for row in ranked
    ]
    return title, ["reading", "r", "w, tau", "MDB", "BNR", "ground m", "rho", ""], cells


def _place(row: Row) -> tuple[bool, int, float]:
    """Points before coefficients of sheets, which a photo hardly checks anyway; bad verdicts, great effects first."""
    return row["kind"] == "coefficient", ORDER[str(row["verdict"])], -_size(row["bias_to_noise"])


def _error(row: Row) -> str:
    """Image coordinates in micrometres, all others in their own unit."""
    value = row["smallest_error"]
    if value is None:
        return cell(None)
    if row["unit"] == MILLIMETRES:
        return f"{MICROMETRES * _size(value):.1f} um"
    return f"{_size(value):.3g}" + ("" if row["unit"] == MODEL else f" {row['unit']}")


def _size(value: Scalar) -> float:
    return abs(value) if isinstance(value, int | float) else 0.0
