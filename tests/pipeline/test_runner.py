"""The runner: what is fresh, what is read, what sticks."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from orient.errors import OrientError, UsageError
from orient.intake.options import ReadOptions
from orient.intake.project_folder import read_project
from orient.pipeline.registry import BY_NAME, STAGES
from orient.pipeline.runner import Result, add_input, create, run_stage, run_stale, select_version, withdraw
from orient.store.digest import input_digest
from orient.store.project import NewRun, RunInfo, open_project
from orient.values import InputTables
from tests.pipeline.conftest import SPACE
from tests.pipeline.made import row

OPTIONS = ReadOptions()


def run_all(path: Path) -> dict[str, Result]:
    return {result.stage: result for result in run_stale(path, {}, "test", lambda stage: None, lambda result: None)}


def heads(path: Path) -> dict[str, RunInfo]:
    with open_project(path) as project:
        return project.heads()


def inputs() -> dict[str, InputTables]:
    return {given.stage: given for given in read_project(SPACE, OPTIONS)}


def known_control() -> InputTables:
    """The true coordinates of the sample's control, as if they were surveyed."""
    truth = json.loads((SPACE / "truth.json").read_text("utf-8"))["points"]
    points = truth.values() if isinstance(truth, dict) else truth
    names = list(truth) if isinstance(truth, dict) else [point["point"] for point in truth]
    rows = [
        row("control_point", point=name, role="control", kind="geographic", B_deg=point["B_deg"], L_deg=point["L_deg"],
            H_m=point["H_m"])
        for name, point in list(zip(names, points, strict=True))[:20]
    ]  # fmt: skip
    given = inputs()["control"]
    return replace(given, tables={**given.tables, "control_point": rows})


@pytest.fixture
def without_sheet(tmp_path: Path) -> Path:
    given = inputs()
    path = tmp_path / "photo.sqlite"
    create(path, [given["photo"], given["readings"], known_control()], "no map yet")
    return path


@pytest.mark.parametrize(
    ("reason", "told"),
    [(7, "is no text"), (None, "is no text"), (b"x", "is no text"), (" ", "say why"), ("z" * 1001, "longer"),
     ("\ud800", "not valid text")],
    ids=["number", "nothing", "bytes", "blank", "a book", "half a letter"],
)  # fmt: skip
def test_a_reason_says_why(without_sheet: Path, tmp_path: Path, reason: str, told: str) -> None:
    before = without_sheet.read_bytes()
    given, new = inputs(), tmp_path / "new.sqlite"
    calls: list[Callable[[], object]] = [
        lambda: create(new, [given["photo"]], reason),
        lambda: add_input(without_sheet, given["readings"], reason),
        lambda: run_stage(without_sheet, "refine", {}, reason),
        lambda: run_stale(without_sheet, {}, reason, lambda stage: None, lambda result: None),
        lambda: select_version(without_sheet, "photo", 1, reason),
        lambda: withdraw(without_sheet, "photo", reason),
    ]
    for call in calls:
        with pytest.raises(UsageError, match=told):
            call()
    assert not new.exists()
    assert without_sheet.read_bytes() == before


def test_an_optional_input_that_appears_makes_its_readers_stale(without_sheet: Path) -> None:
    first = run_all(without_sheet)
    assert first["digitize"].waits_for == "sheet"
    assert [name for name, result in first.items() if result.computed] == [
        "refine", "bl", "topocentric", "resection", "covariance"
    ]  # fmt: skip
    assert set(heads(without_sheet)["bl"].inputs) == {"photo", "control"}
    add_input(without_sheet, inputs()["sheet"], "the map came")
    second = run_all(without_sheet)
    assert [name for name, result in second.items() if result.computed] == [
        "digitize", "bl", "topocentric", "resection", "covariance"
    ]  # fmt: skip
    assert set(heads(without_sheet)["bl"].inputs) == {"photo", "control", "digitize"}
    assert not any(result.computed for result in run_all(without_sheet).values())


def test_only_what_depends_on_a_change_is_computed(without_sheet: Path) -> None:
    run_all(without_sheet)
    facts = inputs()["photo"]
    (photo,) = facts.tables["photo"]
    add_input(without_sheet, replace(facts, tables={**facts.tables, "photo": [{**photo, "name": "another"}]}), "name")
    # every stage reads the photo, but all give the same numbers as before except for their inputs
    again = run_all(without_sheet)
    assert again["refine"].computed
    assert again["bl"].computed
    before = heads(without_sheet)
    assert before["topocentric"].version == 2
    with open_project(without_sheet) as project:
        one, two = project.runs("resection")
    assert one.output_digest == two.output_digest


def test_a_new_setting_makes_its_readers_stale_and_sticks(without_sheet: Path) -> None:
    run_all(without_sheet)
    assert run_stage(without_sheet, "refine", {"reject": True}, "clean").computed
    results = run_all(without_sheet)
    assert [name for name, result in results.items() if result.computed] == ["resection", "covariance"]
    assert heads(without_sheet)["refine"].settings == {"engine": "zlatanov", "reject": True}


def test_the_ledger_names_what_was_read(without_sheet: Path) -> None:
    run_all(without_sheet)
    now = heads(without_sheet)
    for stage in STAGES:
        if stage.name in now:
            assert now[stage.name].inputs == {name: now[name].run_id for name in stage.inputs if name in now}


def test_unknown_settings_and_missing_inputs_are_refused(without_sheet: Path) -> None:
    run_all(without_sheet)
    with pytest.raises(UsageError, match="covariance has no setting degree"):
        run_stage(without_sheet, "covariance", {"degree": 3}, "x")
    with pytest.raises(OrientError, match="digitize waits for sheet"):
        run_stage(without_sheet, "digitize", {}, "x")


def test_progress_is_told_in_order(without_sheet: Path) -> None:
    told: list[str] = []
    run_stale(
        without_sheet,
        {},
        "test",
        lambda stage: told.append(f"begin {stage.name}"),
        lambda result: told.append(f"end {result.stage}"),
    )
    expected = [f"{word} {name}" for name in BY_NAME for word in ("begin", "end")]
    assert told == [line for line in expected if line not in ("begin digitize", "begin absolute")]


def with_older_refine(path: Path) -> RunInfo:
    """A run of `refine` as it was stored before it had an engine: by QR, and without the word."""
    stage = BY_NAME["refine"]
    with open_project(path, "write") as project:
        sources = {name: project.heads()[name] for name in stage.inputs}
        tables = {name: project.read_tables(run.run_id) for name, run in sources.items()}
        settings = {"reject": False}
        project.append(
            NewRun(
                stage="refine",
                stage_version=stage.version,
                settings=settings,
                inputs={name: run.run_id for name, run in sources.items()},
                input_digest=input_digest(
                    "refine", stage.version, settings, {name: run.output_digest for name, run in sources.items()}
                ),
                expected_heads={name: run.run_id for name, run in sources.items()},
                actor="test",
                reason="before the setting",
                outcome=stage.compute(tables, {**settings, "engine": "qr"}),
                select=True,
            )
        )
        return project.heads()["refine"]


def test_a_version_from_before_a_setting_stays_current(without_sheet: Path) -> None:
    older = with_older_refine(without_sheet)
    assert not run_all(without_sheet)["refine"].computed
    asked = run_stage(without_sheet, "refine", {"engine": "qr"}, "the same in words")
    assert (asked.computed, heads(without_sheet)["refine"].run_id) == (False, older.run_id)


def test_its_successor_is_made_in_the_same_way_unless_told(without_sheet: Path) -> None:
    with_older_refine(without_sheet)
    assert run_stage(without_sheet, "refine", {"reject": True}, "try").run.settings["engine"] == "qr"
    by_Z = run_stage(without_sheet, "refine", {"engine": "zlatanov", "reject": False}, "Algorithm Z")
    assert (by_Z.computed, by_Z.run.settings["engine"]) == (True, "zlatanov")


def test_a_new_project_is_adjusted_by_algorithm_Z(without_sheet: Path) -> None:
    run_all(without_sheet)
    assert heads(without_sheet)["refine"].settings["engine"] == "zlatanov"
