"""Digests: equal for equal content in any order, different for any change."""

import hashlib
import json
import random
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orient.store.digest import canonical, input_digest, output_digest
from orient.store.errors import OurFault
from orient.store.format import current_format
from orient.store.stage_tables import STAGE_TABLES
from orient.values import Blob, Columns, Event, Tables
from tests.store.made import EVENTS, outcome_of, readings


def test_order_of_rows_does_not_matter() -> None:
    rows = list(readings(50).tables["comparator_reading"])
    shuffled = rows[:]
    random.Random(3).shuffle(shuffled)
    assert output_digest({"comparator_reading": rows}) == output_digest({"comparator_reading": shuffled})


@pytest.mark.parametrize("stage", STAGE_TABLES)
def test_every_cell_counts(stage: str) -> None:
    tables = outcome_of(stage).tables
    before = output_digest(tables, EVENTS)
    for name, rows in tables.items():
        for column, value in rows[0].items():
            number = np.nextafter(0.5, 1) if value == 0.5 else 2
            other = {None: None, str: "another", Blob: Blob(b"another")}.get(type(value), number)
            changed = {**tables, name: [{**rows[0], column: other}]}
            assert value is None or output_digest(changed, EVENTS) != before, f"{name}.{column}"


def test_events_count() -> None:
    assert output_digest({}, EVENTS) != output_digest({})
    assert output_digest({}, [Event("info", "a", "", "b")]) != output_digest({}, [Event("info", "a", "b", "")])


def test_numpy_scalars_and_negative_zero() -> None:
    empty = dict.fromkeys(("cov_xx", "cov_xy", "cov_xz", "cov_yy", "cov_yz", "cov_zz"))
    plain = {"x": 0.0, "y": 1.5, "z": 2.0, "zone": "a", "point": "p", **empty}
    other = {"x": np.float64(-0.0), "y": np.float32(1.5), "z": np.int64(2), "zone": np.str_("a"), "point": "p", **empty}
    assert output_digest({"model_point": [plain]}) == output_digest({"model_point": [other]})


def test_tables_without_rows_do_not_count() -> None:
    assert output_digest({"model_point": []}) == output_digest({})


def test_a_missing_column_is_our_fault() -> None:
    with pytest.raises(OurFault, match="z"):
        output_digest({"model_point": [{"x": 0.0, "y": 0.0, "zone": "a", "point": "p"}]})


@given(st.floats(allow_nan=False, allow_infinity=False), st.floats(allow_nan=False, allow_infinity=False))
@settings(max_examples=200)
def test_floats_count_to_the_last_bit(first: float, second: float) -> None:
    assert (canonical(first) == canonical(second)) == (first == second)


def test_a_text_never_looks_like_a_number() -> None:
    assert canonical("f:0x1.0p+0") != canonical(1.0)
    assert canonical("1") != canonical(1)


def test_settings_and_inputs_count() -> None:
    digests = {
        input_digest("refine", 1, {}, {}),
        input_digest("refine", 2, {}, {}),
        input_digest("bl", 1, {}, {}),
        input_digest("refine", 1, {"reject": True}, {}),
        input_digest("refine", 1, {"reject": 1}, {}),
        input_digest("refine", 1, {"reject": None}, {}),
        input_digest("refine", 1, {}, {"photo": "a"}),
        input_digest("refine", 1, {}, {"readings": "a"}),
    }
    assert len(digests) == 8


def test_digest_is_the_same_in_another_process() -> None:
    code = (
        "import json; from tests.store.made import *; "
        "print(json.dumps(output_digest(outcome_of('resection').tables, EVENTS)))"
    )
    root = Path(__file__).parents[2]
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=root, env={"PYTHONHASHSEED": "7"}
    )
    assert json.loads(done.stdout) == output_digest(outcome_of("resection").tables, EVENTS)


def row_by_row(tables: Tables) -> str:
    """The digest as it is defined, without any regard to speed."""
    content = {}
    for table, rows in tables.items():
        shape = current_format().tables[table]
        used = [name for name in sorted(shape.names) if any(row.get(name) is not None for row in rows)]
        ordered = sorted(rows, key=lambda row: [row[name] for name in shape.key if name != "run_id"])
        if rows:
            content[table] = {"columns": used, "rows": [[row[name] for name in used] for row in ordered]}
    return hashlib.sha256(canonical(["output", content]).encode("ascii")).hexdigest()


NUMBERS = st.none() | st.floats(-1e15, 1e15) | st.sampled_from([0.0, -0.0, 5e-324, 1.0, 1])
WORDS = st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=5) | st.sampled_from(['"', "f:0x0p0"])
ROWS = st.dictionaries(
    WORDS, st.fixed_dictionaries({"x": NUMBERS, "y": NUMBERS, "z": NUMBERS, "cov_xy": NUMBERS}), max_size=8
)


@given(ROWS)
@settings(max_examples=200, deadline=None)
def test_the_digest_by_column_is_the_digest_row_by_row(drawn: dict[str, dict[str, float | None]]) -> None:
    empty = dict.fromkeys(("cov_xx", "cov_xz", "cov_yy", "cov_yz", "cov_zz"))
    rows = [{"zone": "a", "point": point, **empty, **values} for point, values in drawn.items()]
    real = [{k: float(v) if isinstance(v, int) else v for k, v in row.items()} for row in rows]
    assert output_digest({"model_point": rows}) == row_by_row({"model_point": real})


@pytest.mark.parametrize("count", [1, 4095, 4096, 4097, 9000])
def test_rows_in_several_portions(count: int) -> None:
    rows = readings(count).tables
    assert output_digest(rows) == row_by_row(rows)


def test_columns_are_rows() -> None:
    rows = list(readings(50).tables["comparator_reading"])
    lists = {name: [row[name] for row in rows] for name in rows[0]}
    arrays = {**lists, "x_mm": np.array(lists["x_mm"])}
    for columns in (Columns(lists), Columns(arrays)):
        assert columns == rows and columns[3] == rows[3] and columns[3:5] == rows[3:5]
        assert output_digest({"comparator_reading": columns}) == output_digest({"comparator_reading": rows})
    with pytest.raises(OurFault, match="cannot be stored as REAL"):
        output_digest({"comparator_reading": Columns({**lists, "x_mm": np.full(50, np.nan)})})
    with pytest.raises(OurFault, match="col_px"):
        output_digest({"comparator_reading": Columns({k: v for k, v in lists.items() if k != "col_px"})})
