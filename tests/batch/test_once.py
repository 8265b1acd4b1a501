"""The ledger itself keeps a second identical run out, also when two workers have the same photo at the same moment."""

import os
from pathlib import Path

import pytest

from orient.batch.coordinator import chunks, planned
from orient.batch.photo_task import file_stamp, work_through
from orient.batch.summary import Done
from orient.batch.values import Item, Order, Refusal
from orient.batch.work_list import WorkList
from orient.batch.worker import version
from orient.pipeline.registry import STAGES, Stage
from orient.pipeline.runner import Result, run_stale
from orient.store.project import open_project
from tests.batch.reading import COMPUTED, versions
from tests.batch.test_bad_files import in_a_line


def test_two_at_the_same_moment_store_one_run(projects: Path) -> None:
    """Before each stage of the first command is stored, a second command runs the whole project."""
    path = projects / "P000.sqlite"
    real = Stage.compute
    others: list[list[Result]] = []

    def compute_slowly(stage: Stage, *given: object) -> object:
        outcome = real(stage, *given)  # type: ignore[arg-type]
        if not others:
            others.append([])
            others[0] += run_stale(path, {}, "the other", lambda stage: None, lambda result: None)
        return outcome

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Stage, "compute", compute_slowly)
        (ending,) = work_through([Item(str(path))], Order(reason="the first"))
    assert (ending.exit_code, ending.message) == (0, "")
    assert len(others[0]) == len(STAGES)
    assert versions(path) == dict.fromkeys(COMPUTED, 1)
    with open_project(path) as project:
        assert {run.reason for run in project.runs() if run.stage in COMPUTED} == {"the other"}


def test_the_same_failure_at_the_same_moment_is_one_run(projects: Path) -> None:
    path = projects / "P001.sqlite"
    in_a_line(path)
    work_through([Item(str(path))], Order())
    before = versions(path)
    assert before["resection"] == 1
    work_through([Item(str(path))] * 2, Order())
    assert versions(path) == before


def test_a_task_that_runs_twice_ends_the_same(projects: Path) -> None:
    item = Item(str(projects / "P000.sqlite"))
    first, second = work_through([item, item], Order())
    assert (first.numbers["n_computed"], second.numbers["n_computed"]) == (len(COMPUTED), 0)
    assert (first.covariances, first.findings, first.numbers["x_s_m"], first.numbers["file_stamp"]) == (
        second.covariances, second.findings, second.numbers["x_s_m"], second.numbers["file_stamp"]
    )  # fmt: skip
    digests = [[(row["stage"], row["output_digest"]) for row in ending.stages] for ending in (first, second)]
    assert digests[0] == digests[1]


def test_any_write_changes_the_stamp(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_text("one")
    before, times = file_stamp(str(path)), path.stat()
    with path.open("r+") as file:
        file.write("two")
    os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))  # as rsync or cp -p do
    assert file_stamp(str(path)) != before
    assert file_stamp(str(tmp_path / "missing")) == ""


CODES = [(0, False, "done"), (0, True, "done"), (1, False, "refused"), (1, True, "to do"), (3, False, "to do"),
         (70, False, "to do")]  # fmt: skip


@pytest.mark.parametrize(("code", "retry", "state"), CODES)
def test_what_is_tried_again(code: int, retry: bool, state: str, tmp_path: Path) -> None:
    path = tmp_path / "photo.sqlite"
    path.write_text("x")
    last = Done(1, code, Refusal("why", "", code), file_stamp(str(path)), "{}", version())
    work = WorkList((Item(str(path)),), 0)
    plan = planned(work, {str(path): last}, "{}", retry)
    assert (len(plan.to_do), len(plan.done), len(plan.refused)) == {
        "to do": (1, 0, 0), "done": (0, 1, 0), "refused": (0, 0, 1)
    }[state]  # fmt: skip
    other_settings = planned(work, {str(path): last}, '{"reject": true}', retry)
    assert len(other_settings.to_do) == 1
    path.write_text("changed")
    assert len(planned(work, {str(path): last}, "{}", retry).to_do) == 1


@pytest.mark.parametrize(
    ("photos", "workers", "largest"), [(1, 2, 1), (12, 2, 1), (1000, 2, 8), (1000, 64, 1), (100_000, 64, 8)]
)
def test_chunks(photos: int, workers: int, largest: int) -> None:
    items = [Item(str(number)) for number in range(photos)]
    made = chunks(items, workers)
    assert [item for chunk in made for item in chunk] == items
    assert max(len(chunk) for chunk in made) == largest
