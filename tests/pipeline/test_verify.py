"""`verify` finds what `check` cannot: numbers that do not follow from their inputs, whoever made the digests fit."""

import math
import shutil
import sqlite3
from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest

from orient.errors import UsageError
from orient.intake.options import ReadOptions
from orient.intake.project_folder import read_project
from orient.pipeline.registry import BY_NAME
from orient.pipeline.runner import add_input, create, run_stage, run_stale, select_version
from orient.pipeline.verify import Request, verify_project
from orient.pipeline.verify_compare import TOLERANCE, compare
from orient.pipeline.verify_verdict import RunVerdict, Verification
from orient.store.check import check_project
from orient.store.project import Project, open_project
from orient.store.stage_tables import STAGE_TABLES
from orient.values import InputTables, Row, Scalar, Tables
from tests.pipeline.forger import forge

SAMPLES = Path(__file__).parents[2] / "sample_projects"
ONLY_LOOK = Request(record=False)
COMPUTED = tuple(name for name in BY_NAME if name != "absolute")  # these samples have no model


def made(folder: Path, path: Path) -> Path:
    create(path, read_project(folder, ReadOptions()), "test")
    run_stale(path, {}, "test", lambda stage: None, lambda result: None)
    return path


@pytest.fixture(scope="session")
def space_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = made(SAMPLES / "simulated-space-krasovsky", tmp_path_factory.mktemp("verify") / "space.sqlite")
    run_stage(path, "covariance", {"pairs": True}, "test")
    return path


@pytest.fixture(scope="session")
def aerial_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return made(SAMPLES / "calgary-27", tmp_path_factory.mktemp("verify") / "aerial.sqlite")


@pytest.fixture
def space(space_once: Path, tmp_path: Path) -> Path:
    """Every stage, with a map sheet, cycles, fiducial marks, check points and all pairs."""
    return Path(shutil.copy(space_once, tmp_path / "space.sqlite"))


@pytest.fixture
def aerial(aerial_once: Path, tmp_path: Path) -> Path:
    return Path(shutil.copy(aerial_once, tmp_path / "aerial.sqlite"))


def by_stage(done: Verification) -> Mapping[str, RunVerdict]:
    return {verdict.run.stage: verdict for verdict in done.verdicts}


def places(verdict: RunVerdict) -> list[str]:
    return [difference.place for difference in verdict.found.refused]


# ---------------------------------------------------------------------------------------------- what holds


def test_every_bit_of_every_stage_comes_again(space: Path) -> None:
    done = verify_project(space, ONLY_LOOK)
    assert done.holds
    assert {verdict.verdict for verdict in done.verdicts} == {"identical"}
    computed = [verdict for verdict in done.verdicts if verdict.method == "recomputed"]
    assert {verdict.run.stage for verdict in computed} == set(COMPUTED)
    with open_project(space) as project:
        for verdict in computed:
            rows = project.stored_tables(verdict.run.run_id)
            assert verdict.found.n_values >= sum(len(row) for table in rows.values() for row in table) / 2


@pytest.mark.parametrize("stage", ["refine", "digitize", "resection"])
def test_the_second_engine_agrees(space: Path, stage: str) -> None:
    verdict = by_stage(verify_project(space, ONLY_LOOK))[stage]
    assert verdict.agreements
    assert max(part.difference for part in verdict.agreements) < 1e-8


@pytest.fixture(scope="session")
def model_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return made(SAMPLES / "simulated-model-two-zones", tmp_path_factory.mktemp("verify") / "model.sqlite")


def test_the_second_engine_agrees_on_every_zone(model_once: Path) -> None:
    verdict = by_stage(verify_project(model_once, ONLY_LOOK))["absolute"]
    assert (verdict.verdict, verdict.left_out) == ("identical", "")
    assert {(part.subject, part.quantity) for part in verdict.agreements} == {
        (zone, what) for zone in ("east", "west") for what in ("rotation", "scale", "position", "cofactor", "sigma0")
    }
    assert max(part.difference for part in verdict.agreements) < 1e-7


def test_a_forged_zone_is_contradicted_by_the_second_engine_too(model_once: Path, tmp_path: Path) -> None:
    path = Path(shutil.copy(model_once, tmp_path / "model.sqlite"))
    forge(path, lambda bare: bare.execute("UPDATE absolute_orientation SET X_0_m = X_0_m + 0.001 WHERE zone = 'west'"))
    verdict = by_stage(verify_project(path, ONLY_LOOK))["absolute"]
    assert not verdict.holds
    wrong = [(part.subject, part.quantity) for part in verdict.agreements if not part.agrees]
    assert wrong == [("west", "position")]


def test_a_failed_run_fails_again_in_the_same_way(aerial: Path) -> None:
    with open_project(aerial) as project:
        control = project.read_tables(project.heads()["control"].run_id)
    first_two = {**control, "control_point": control["control_point"][:2]}
    add_input(aerial, InputTables("control", first_two), "too few")
    assert run_stale(aerial, {}, "test", lambda stage: None, lambda result: None)[4].failed
    for _ in range(2):
        done = verify_project(aerial, ONLY_LOOK)
        assert done.holds
        failed = [verdict for verdict in done.verdicts if verdict.run.status == "failed"]
        assert [(verdict.run.stage, verdict.verdict) for verdict in failed] == [("resection", "identical")]
        forge(aerial, _without_remedy)


def _without_remedy(bare: sqlite3.Connection) -> None:
    """As failures were kept at first."""
    told = "SELECT run_id FROM run_event WHERE code = 'remedy'"
    bare.execute(f"UPDATE run_seal SET row_count = row_count - 1 WHERE run_id IN ({told})")
    bare.execute("DELETE FROM run_event WHERE code = 'remedy'")


# ---------------------------------------------------------------------------------------------- evidence


def test_evidence_moves_no_head_makes_nothing_stale_and_is_sealed(aerial: Path) -> None:
    with open_project(aerial) as project:
        before, stale = project.heads(), project.query("SELECT * FROM v_stale")
    done = verify_project(aerial, Request())
    assert done.kept is not None
    with open_project(aerial) as project:
        assert (project.heads(), project.query("SELECT * FROM v_stale")) == (before, stale)
        assert project.run("verify", 1).inputs.keys() == {f"{stage} 1" for stage in before}
        _, rows = project.query("SELECT stage, verdict, is_same_run FROM v_verification")
    assert rows == [(stage, "identical", 1) for stage in (run.stage for run in sorted_runs(before))]
    assert check_project(aerial).ok
    assert run_stale(aerial, {}, "test", lambda stage: None, lambda result: None)[0].computed is False


def sorted_runs(heads: Mapping[str, object]) -> list:  # type: ignore[type-arg]
    return sorted(heads.values(), key=lambda run: run.run_id)  # type: ignore[attr-defined]


def test_altered_evidence_is_found_by_check_and_by_verify(aerial: Path) -> None:
    verify_project(aerial, Request())
    forge(aerial, lambda bare: bare.execute("UPDATE verified_run SET verdict = 'agrees'"), careful=False)
    assert not check_project(aerial).ok
    assert "rows were altered" in verify_project(aerial, ONLY_LOOK).ledger[0]


def test_evidence_can_be_verified_over_and_over(aerial: Path) -> None:
    for version in (1, 2, 3):
        done = verify_project(aerial, Request())
        assert done.kept is not None and done.kept.version == version
        assert len(done.verdicts) == 8


def test_evidence_cannot_be_selected(aerial: Path) -> None:
    verify_project(aerial, Request())
    with pytest.raises(UsageError, match="evidence"):
        select_version(aerial, "verify", 1, "why not")


# ---------------------------------------------------------------------------------------------- forgeries


def lowest_bit(value: Scalar) -> Scalar:
    """The smallest change of a value that a file can hold."""
    if isinstance(value, float):
        return math.nextafter(value, math.inf)
    return value + 1 if isinstance(value, int) else f"{value} "


def flip(bare: sqlite3.Connection, stage: str, table: str, column: str) -> None:
    """The lowest bit of a column in the first row of the stage's last run that has a value there."""
    own = f"run_id = (SELECT max(run_id) FROM stage_run WHERE stage = '{stage}')"
    rowid, value = bare.execute(
        f'SELECT rowid, "{column}" FROM {table} WHERE {own} AND "{column}" IS NOT NULL LIMIT 1'
    ).fetchone()
    bare.execute(f'UPDATE {table} SET "{column}" = ? WHERE rowid = ?', (lowest_bit(value), rowid))


def real_columns(project: Project, stage: str) -> dict[str, str]:
    """The last REAL column with a value, for every table that the stage has written."""
    rows = project.read_tables(project.heads()[stage].run_id)
    found = {}
    for table in STAGE_TABLES[stage]:
        for column, value in (rows.get(table) or [{}])[0].items():
            if isinstance(value, float):
                found[table] = column
    return found


@pytest.mark.parametrize("stage", COMPUTED)
def test_one_bit_in_any_table_is_found_though_every_digest_fits(space: Path, stage: str) -> None:
    with open_project(space) as project:
        chosen = real_columns(project, stage)
    forge(space, lambda bare: [flip(bare, stage, table, column) for table, column in chosen.items()])
    assert check_project(space).ok  # the forger was careful
    verdict = by_stage(verify_project(space, ONLY_LOOK))[stage]
    found = {(place.split()[0].rstrip(":"), place.rsplit(" ", 1)[1]) for place in places(verdict)}
    assert found == set(chosen.items())
    assert all(difference.size is not None and difference.size < 1e-15 for difference in verdict.found.refused)


FORGERIES = {
    "a word": ("resection", "UPDATE run_event SET message = 'all is well' WHERE seq = 1 AND {own}", "run_event"),
    "a count": ("resection", "UPDATE orientation SET redundancy = redundancy + 1 WHERE {own}", "orientation"),
    "a row less": ("resection", "DELETE FROM image_residual WHERE point = '101' AND {own}", "image_residual"),
    "a summary": ("resection", "UPDATE run_seal SET summary = 'sigma0 1 um' WHERE {own}", "run_seal"),
    "a sign of zero": ("refine", "UPDATE image_point SET dx_refraction_mm = -0.0 WHERE {own}", "image_point"),
}


@pytest.mark.parametrize("case", FORGERIES)
def test_other_forgeries_are_found(aerial: Path, case: str) -> None:
    stage, sql, table = FORGERIES[case]
    with open_project(aerial) as project:
        point = project.query("SELECT min(point) FROM image_residual")[1][0][0]
    own = f"run_id = (SELECT run_id FROM stage_run WHERE stage = '{stage}')"

    def change(bare: sqlite3.Connection) -> None:
        assert bare.execute(sql.format(own=own).replace("'101'", f"'{point}'")).rowcount > 0
        bare.execute(
            "UPDATE run_seal SET row_count = row_count - 1 WHERE ? AND run_id = (SELECT run_id FROM stage_run "
            "WHERE stage = ?)", (case == "a row less", stage)
        )  # fmt: skip

    forge(aerial, change)
    assert check_project(aerial).ok
    verdict = by_stage(verify_project(aerial, ONLY_LOOK))[stage]
    assert verdict.verdict == "differs"
    assert any(place.startswith(table) for place in places(verdict))


def test_a_forged_list_shows_in_what_was_computed_from_it(aerial: Path) -> None:
    forge(aerial, lambda bare: bare.execute("UPDATE control_point SET Z_m = Z_m + 1e-6 WHERE role = 'control'"))
    assert check_project(aerial).ok
    done = by_stage(verify_project(aerial, ONLY_LOOK))
    assert done["bl"].verdict == "differs"


def test_a_forger_without_care_is_found_by_the_seal_of_a_list(aerial: Path) -> None:
    forge(aerial, lambda bare: bare.execute("UPDATE photo SET name = 'another'"), careful=False)
    done = verify_project(aerial, Request())
    assert places(by_stage(done)["photo"]) == ["seal"]
    assert done.kept is not None and done.kept.status == "failed"


def test_differences_are_kept_with_both_values(aerial: Path) -> None:
    forge(aerial, lambda bare: bare.execute("UPDATE orientation SET Z_S_m = Z_S_m + 1"))
    done = verify_project(aerial, Request())
    with open_project(aerial) as project:
        _, rows = project.query("SELECT place, stored, recomputed, difference FROM verified_difference")
        _, told = project.query("SELECT verdict, largest_at, second_engine FROM v_verification WHERE stage='resection'")
    (place, stored, recomputed, size) = rows[0]
    assert place == "orientation: Z_S_m"
    assert float(stored) - float(recomputed) == pytest.approx(1.0)
    assert size == pytest.approx(1.0 / float(stored), rel=1e-9)
    assert told == [("differs", "orientation: Z_S_m", "differs")]
    assert not done.holds and done.kept is not None and "Z_S_m" in done.kept.error


# ---------------------------------------------------------------------------------------------- other software


def test_every_single_value_of_a_file_counts(aerial: Path) -> None:
    with open_project(aerial) as project:
        for stage in COMPUTED:
            if stage in project.heads():
                tables = project.stored_tables(project.heads()[stage].run_id)
                for table, rows in tables.items():
                    _flip_each(table, rows)


def _flip_each(table: str, rows: Sequence[Row]) -> None:
    for row in rows:
        for column, value in row.items():
            if value is not None:
                altered = {**row, column: lowest_bit(value)}
                assert compare({table: [altered]}, {table: [row]}, exact=True).refused, (table, column)


NEAR: dict[str, tuple[str, dict[str, Scalar], dict[str, Scalar], bool]] = {
    "a residual near zero belongs to its coordinate": (
        "fiducial_residual", {"x_mm": 100.0, "vx_mm": 1e-9}, {"x_mm": 100.0, "vx_mm": 1.00001e-9}, True,
    ),
    "a residual that is wrong": (
        "fiducial_residual", {"x_mm": 100.0, "vx_mm": 1e-3}, {"x_mm": 100.0, "vx_mm": 1.001e-3}, False,
    ),
    "one axis of the station is near zero": (
        "orientation", {"X_S_m": 1e-12, "Z_S_m": 6e3}, {"X_S_m": -1e-12, "Z_S_m": 6e3}, True,
    ),
    "a standard deviation counts by itself": (
        "orientation_angle", {"value_deg": 45.0, "sigma_deg": 1e-5}, {"value_deg": 45.0, "sigma_deg": 1.0001e-5}, False,
    ),
    "a count is exact": ("orientation", {"redundancy": 10}, {"redundancy": 11}, False),
    "a word is exact": ("orientation", {"termination": "CONVERGED"}, {"termination": "SINGULAR"}, False),
    "a value that is missing": ("orientation", {"sigma0_mm": None}, {"sigma0_mm": 0.004}, False),
    "the way to the solution": ("orientation", {"iterations": 5}, {"iterations": 6}, True),
    "a sentence holds rounded numbers": ("run_seal", {"summary": "sigma0 1.00"}, {"summary": "sigma0 0.99"}, True),
}  # fmt: skip


@pytest.mark.parametrize("case", NEAR)
def test_what_1e_9_means(case: str) -> None:
    table, stored, again, is_same = NEAR[case]
    key: dict[str, Scalar] = {"mark": "1", "triple": "aok", "frame": "ground", "angle": "alpha"}
    found = compare({table: [{**key, **stored}]}, {table: [{**key, **again}]}, exact=False)
    assert bool(found.refused) is not is_same


def test_a_covariance_is_as_large_as_its_variances() -> None:
    def cofactors(q_12: float) -> Tables:
        values = {1: (1, 1, 4.0), 2: (1, 2, q_12), 3: (2, 2, 9e-8)}
        names = {"unknowns": "aok", "unknown_i": "a", "unknown_j": "b"}
        return {"cofactor": [{**names, "IJ": IJ, "i": i, "j": j, "value": v} for IJ, (i, j, v) in values.items()]}

    scale = math.sqrt(4.0 * 9e-8)
    assert not compare(cofactors(0.0), cofactors(0.9 * TOLERANCE * scale), exact=False).refused
    assert compare(cofactors(0.0), cofactors(1.1 * TOLERANCE * scale), exact=False).refused


def test_a_run_of_an_older_stage_is_compared_to_1e_9_and_named(aerial: Path) -> None:
    def older(bare: sqlite3.Connection) -> None:
        bare.execute("UPDATE stage_run SET stage_version = 1 WHERE stage = 'resection'")
        bare.execute("UPDATE image_residual SET depth_m = depth_m * (1 + 1e-12)")

    forge(aerial, older)
    verdict = by_stage(verify_project(aerial, ONLY_LOOK))["resection"]
    assert verdict.because == f"made by version 1 of the stage, this orient has version {BY_NAME['resection'].version}"
    assert (verdict.verdict, verdict.holds) == ("agrees", True)
    assert verdict.found.accepted is not None and verdict.found.accepted.place.startswith("image_residual")
    forge(aerial, lambda bare: bare.execute("UPDATE image_residual SET depth_m = depth_m * (1 + 1e-8)"))
    verdict = by_stage(verify_project(aerial, ONLY_LOOK))["resection"]
    assert {place.split()[0] for place in places(verdict)} == {"image_residual"}


def test_columns_that_an_older_stage_did_not_know_are_left_out() -> None:
    then: Tables = {"orientation": [{"f_mm": 150.0, "sigma0_mm": None}]}
    now: Tables = {"orientation": [{"f_mm": 150.0, "sigma0_mm": 0.004}], "cofactor": [{"value": 1.0}]}
    assert not compare(then, now, exact=False, is_older=True).refused
    assert compare(then, {"orientation": now["orientation"]}, exact=False).refused
