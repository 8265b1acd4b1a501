"""`orient seal`: one file to send. A compacted copy, the photo's image in it, and a manifest of everything it holds.

Image and manifest are runs as everything else (docs/decisions/0015): the image a version of the stage `image`, the
manifest evidence of the stage `seal`, which reads the current runs and is never selected.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from orient.errors import UsageError
from orient.intake.image_file import read_image
from orient.pipeline.registry import ABOUT_RUNS, IMAGE, MANIFEST
from orient.pipeline.runner import append_input, current_user, photo_facts
from orient.store.copies import Copied, seal_project
from orient.store.digest import input_digest
from orient.store.format import current_format
from orient.store.project import NewRun, Project, RunInfo
from orient.values import InputTables, Outcome, Row, Scalar, Settings
from orient.words import counted

MANIFEST_VERSION = 1
Progress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True)
class Request:
    """The image that goes along, its bytes or (`reference`) only its digest; why the file is sealed."""

    image: Path | None = None
    reference: bool = False
    reason: str = "sealed"
    force: bool = False


@dataclass(frozen=True, slots=True)
class Sealed:
    """The sealed file, its manifest as rows, and remarks about the image."""

    copied: Copied
    manifest: Row
    runs: Sequence[Row]
    remarks: Sequence[str]


def seal(path: Path, target: Path, request: Request, progress: Progress | None = None) -> Sealed:
    """Make the file to send; the project itself is only read."""
    given = _image(path, request)
    made: list[Outcome] = []

    def add(copy: Project) -> None:
        if not copy.runs():
            raise UsageError(f"{path} has no runs to seal")
        if given is not None:
            append_input(copy, given, request.reason)
        made.append(_append_manifest(copy, path.name, request.reason))

    copied = seal_project(path, target, add, progress, request.force)
    tables = made[0].tables
    remarks = [event.message for event in given.events] if given else []
    return Sealed(copied, tables["sealed_file"][0], tables["sealed_run"], remarks)


def _image(path: Path, request: Request) -> InputTables | None:
    if request.image is None:
        if request.reference:
            raise UsageError("--reference says how an image goes along", "Give it: --image FILE")
        return None
    facts = photo_facts(path)
    with suppress(OSError):  # an image that cannot be found or read is refused below
        if request.image.samefile(path):
            raise UsageError(f"{request.image} is the project itself", "Give the image of the photo.")
    return read_image(request.image, not request.reference, facts)


def _append_manifest(copy: Project, name: str, reason: str) -> Outcome:
    heads = {stage: run for stage, run in copy.heads().items() if stage not in ABOUT_RUNS}
    outcome = _manifest(copy, name, heads)
    settings: Settings = {"image": outcome.tables["sealed_file"][0]["image"]}
    copy.append(
        NewRun(
            stage=MANIFEST,
            stage_version=MANIFEST_VERSION,
            settings=settings,
            inputs={stage: run.run_id for stage, run in heads.items()},
            input_digest=_digest(settings, heads),
            outcome=outcome,
            expected_heads={},
            actor=current_user(),
            reason=reason,
            select=False,
        )
    )
    return outcome


def _digest(settings: Settings, heads: Mapping[str, RunInfo]) -> str:
    basis = {stage: run.output_digest for stage, run in heads.items()}
    return input_digest(MANIFEST, MANIFEST_VERSION, settings, basis)


def _manifest(copy: Project, name: str, heads: Mapping[str, RunInfo]) -> Outcome:
    rows = _run_rows(copy)
    last_selection = "SELECT count(*), coalesce(max(selection_id), 0) FROM selection"
    n_selections, newest = copy.query(last_selection)[1][0]
    found = copy.query("SELECT record_digest FROM selection WHERE selection_id = ?", (newest,))[1]
    image = _image_columns(copy, heads.get(IMAGE))
    row: Row = {
        "project": name.encode("utf-8", "backslashreplace").decode("utf-8"),
        "format": current_format().version,
        "n_runs": len(rows),
        "n_selections": int(n_selections),
        "last_run_digest": rows[-1]["record_digest"],
        "last_selection_digest": str(found[0][0]) if found else "",
        **image,
    }
    summary = f"{counted(len(rows), 'run')}, {len(heads)} of them current, image {image['image']}"
    return Outcome({"sealed_file": [row], "sealed_run": rows}, summary=summary)


def _run_rows(copy: Project) -> list[Row]:
    """Every run of the file, in the order they were made."""
    sql = "SELECT run_id, is_current FROM v_version ORDER BY run_id"
    is_current = {run_id: bool(current) for run_id, current in copy.query(sql)[1]}
    stale = {stage for (stage,) in copy.query("SELECT stage FROM v_stale WHERE is_stale")[1]}
    seals = copy.query("SELECT run_id, record_digest FROM run_seal")[1]
    records: dict[int, str] = dict(seals)
    return [
        {
            "sealed_run_id": run.run_id,
            "stage": run.stage,
            "version": run.version,
            "is_current": int(is_current[run.run_id]),
            "is_stale": int(is_current[run.run_id] and run.stage in stale),
            "status": run.status,
            "output_digest": run.output_digest,
            "record_digest": records[run.run_id],
            "tool_version": run.tool_version,
        }
        for run in copy.runs()
    ]


def _image_columns(copy: Project, run: RunInfo | None) -> dict[str, Scalar]:
    if run is None:
        return {"image": "none", "image_name": None, "image_size_bytes": None, "image_sha256": None}
    image = copy.read_tables(run.run_id)["image"][0]
    return {
        "image": "embedded" if image["n_parts"] else "referenced",
        "image_name": image["name"],
        "image_size_bytes": image["size_bytes"],
        "image_sha256": image["sha256"],
    }
