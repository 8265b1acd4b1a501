"""`seal` and `image`: what the sealed file holds, and the way of the image out of a project."""

import sys
from collections.abc import Iterator
from pathlib import Path

from orient.errors import OrientError, UsageError
from orient.pipeline.registry import IMAGE
from orient.pipeline.seal import Request, Sealed, seal
from orient.report.check import moving_count
from orient.report.output_file import STDOUT, output_path, write_output
from orient.report.text import console, print_json, printable
from orient.store.project import Project, RunInfo, open_project
from orient.values import Row


def show_sealed(path: Path, output: str, request: Request, as_json: bool) -> None:
    """Seal a project and print the manifest."""
    if output == STDOUT:
        raise UsageError("a sealed project is a file, not a stream", "Give the name of a file: -o FILE")
    target = output_path(output, path, request.force)
    with moving_count("runs examined") as progress:
        done = seal(path, target, request, progress)
    if as_json:
        print_json(_content(done))
        return
    for line in _lines(done):
        console().print(printable(line), soft_wrap=True)


def _content(done: Sealed) -> dict[str, object]:
    copied = done.copied
    file = {"file": str(copied.path), "size_bytes": copied.size, "sha256": copied.sha256}
    return {**file, "manifest": dict(done.manifest), "runs": [dict(row) for row in done.runs], "remarks": done.remarks}


def _lines(done: Sealed) -> Iterator[str]:
    copied, manifest = done.copied, done.manifest
    yield f"{copied.path}: sealed, {copied.runs} runs with the manifest, every digest verified, {copied.size} bytes"
    yield f"sha256 {copied.sha256}"
    yield from (f"warning: {remark}" for remark in done.remarks)
    yield f"image: {_image_words(manifest)}"
    for row in done.runs:
        if row["is_current"]:
            stale = ", STALE: run orient run first if this was not meant" if row["is_stale"] else ""
            yield f"  {row['stage']:<12} version {row['version']:<3} {str(row['output_digest'])[:16]}...{stale}"
    yield "The manifest with all digests: orient show SEALED seal --json; the receiver runs: orient receive SEALED COPY"


def _image_words(manifest: Row) -> str:
    if manifest["image"] == "none":
        return "none; send it along with --image FILE"
    told = f"{manifest['image_name']}, {manifest['image_size_bytes']} bytes, sha256 {manifest['image_sha256']}"
    return told if manifest["image"] == "embedded" else f"{told} (only this digest: the file is not in the project)"


def show_image(path: Path, output: str, compared: Path | None, force: bool) -> None:
    """What is known of the image; get it out of the project; or tell whether a file is it."""
    if output and compared:
        raise UsageError("--output and --compare exclude each other")
    if output == STDOUT and sys.stdout.isatty():
        raise UsageError("an image is not for the terminal", "Give the name of a file: -o FILE")
    target = output_path(output, path, force) if output and output != STDOUT else None
    with open_project(path, "read") as project:
        run = project.heads().get(IMAGE)
        if run is None:
            raise OrientError(f"{path} knows no image", "Put it in: orient seal PROJECT -o SEALED --image FILE")
        image = project.read_tables(run.run_id)["image"][0]
        if output:
            _extract(project, run, image, target, force)
    if compared is not None:
        _compare(image, compared)
    elif not output:
        _tell(image)


def _extract(project: Project, run: RunInfo, image: Row, target: Path | None, force: bool) -> None:
    """The name of the output is the user's (None: standard output); the stored one is only text."""
    if not image["n_parts"]:
        raise OrientError(
            f"the project holds only the digest of {image['name']}, not the file", "Ask its sender for the image."
        )
    if target is None:
        sys.stdout.buffer.writelines(project.image(run.run_id))
        return
    write_output(target, project.image(run.run_id), project.path, force)
    console().print(printable(f"{target}: {image['size_bytes']} bytes, SHA-256 as sealed"), soft_wrap=True)


def _compare(image: Row, path: Path) -> None:
    from orient.intake.image_file import image_facts

    facts = image_facts(path)
    if (facts.size_bytes, facts.sha256) != (image["size_bytes"], image["sha256"]):
        raise OrientError(f"{path} is not the image of this project: SHA-256 {facts.sha256}, not {image['sha256']}")
    console().print(printable(f"{path} is the image of this project."), soft_wrap=True)


def _tell(image: Row) -> None:
    pixels = f", {image['width_px']} x {image['height_px']} pixels" if image["width_px"] else ""
    where = "embedded" if image["n_parts"] else "known by its digest only"
    line = f"{image['name']}: {image['media_type']}{pixels}, {image['size_bytes']} bytes, {where}"
    for text in (line, f"sha256 {image['sha256']}"):
        console().print(printable(text), soft_wrap=True)
