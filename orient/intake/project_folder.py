"""A project folder, or the files of one input, as tables: all or nothing, with every problem named."""

import stat
from collections.abc import Mapping, Sequence
from pathlib import Path

from orient.errors import UsageError
from orient.intake.control import check_some_control, read_control, warn_without_control
from orient.intake.findings import Findings, shown
from orient.intake.model import read_model
from orient.intake.options import ReadOptions
from orient.intake.photo_facts import UNKNOWN, UNREADABLE, PhotoFacts, facts_of, facts_of_tables
from orient.intake.photo_toml import read_photo
from orient.intake.readings import Files, read_readings
from orient.intake.sheet import read_sheets
from orient.intake.text_file import check_encoding, reason
from orient.values import InputTables, Row

__all__ = ["FILES_OF_STAGE", "ReadOptions", "read_input", "read_project"]

FILES_OF_STAGE: Mapping[str, tuple[str, ...]] = {
    "photo": ("photo.toml",),
    "readings": ("readings.csv",),
    "sheet": ("sheet.toml", "crosses.csv", "digitizer.csv"),
    "control": ("control.toml", "control.csv"),
    "model": ("model.csv",),
}
"""The input stages and the names of their files in a project folder."""


def read_project(directory: Path, options: ReadOptions) -> list[InputTables]:
    """The inputs of a project folder, photo first; what has no files is left out.

    Raises `InputError` with the problems of all files together.
    """
    check_encoding(options.encoding)
    findings = Findings()
    _check_folder(directory, findings)
    photo = read_photo(directory / "photo.toml", "photo.toml", options, findings)
    facts = facts_of_tables(photo) if photo is not None else UNREADABLE
    inputs = [_with_events(photo, findings, 0)] if photo is not None else []
    for stage, names in FILES_OF_STAGE.items():
        files = [(directory / name, name) for name in names if _is_there(directory / name)]
        if stage != "photo" and files:
            start = len(findings.events)
            tables = _read_stage(stage, files, options, facts, findings)
            inputs.append(_with_events(tables, findings, start))
    inputs = _check_together(inputs, findings)
    findings.raise_problems()
    return inputs


def read_input(
    stage: str, files: Sequence[Path], options: ReadOptions, photo: Mapping[str, object] | None = None
) -> InputTables:
    """The tables of one input stage from the files given for it, told apart by suffix and header.

    `photo`: the row of the table `photo` (and the names of its marks as `fiducials`) for checks against the camera
    and the ground. Raises `InputError` with all problems.
    """
    if stage not in FILES_OF_STAGE:
        raise UsageError(f'"{stage}" is not an input.', f"Inputs are {', '.join(FILES_OF_STAGE)}.")
    if not files:
        raise UsageError(f"no files for {stage}.", f"Give {', '.join(FILES_OF_STAGE[stage])}.")
    check_encoding(options.encoding)
    _check_each_once(files)
    findings = Findings()
    facts = facts_of(photo) if photo is not None else UNKNOWN
    tables = _read_stage(stage, _labelled(files), options, facts, findings)
    findings.raise_problems()
    return _with_events(tables, findings, 0)


def _check_each_once(files: Sequence[Path]) -> None:
    seen: set[Path] = set()
    for path in files:
        if path.absolute() in seen:
            raise UsageError(f"{shown(str(path))} is given twice.", "Give each file once.")
        seen.add(path.absolute())


def _read_stage(stage: str, files: Files, options: ReadOptions, facts: PhotoFacts, findings: Findings) -> InputTables:
    _check_suffixes(stage, files, findings)
    if stage == "photo":
        path, file = files[0]
        return read_photo(path, file, options, findings) or InputTables(stage, {})
    if stage == "readings":
        return read_readings(files, options, facts, findings)
    if stage == "sheet":
        return read_sheets(files, options, findings)
    if stage == "control":
        return read_control(files, options, facts, findings)
    return read_model(files, options, findings)


def _check_suffixes(stage: str, files: Files, findings: Findings) -> None:
    """How many TOML and other files a stage takes."""
    tomls = [file for path, file in files if path.suffix.lower() == ".toml"]
    others = len(files) - len(tomls)
    most_tomls = sum(name.endswith(".toml") for name in FILES_OF_STAGE[stage])
    if len(tomls) > most_tomls:
        findings.path_problem(tomls[-1], f"{stage} takes {most_tomls or 'no'} TOML file", "")
    if stage == "photo" and others:
        findings.path_problem(files[0][1], "photo takes one TOML file")
    elif stage != "photo" and not others:
        wanted = " or ".join(name for name in FILES_OF_STAGE[stage] if name.endswith(".csv"))
        findings.path_problem(files[0][1], f"does not suffice for {stage}", f"Give {wanted} too")


def _labelled(files: Sequence[Path]) -> list[tuple[Path, str]]:
    """Files are called by their names, or by their paths when two have the same name."""
    names = [path.name for path in files]
    return [(path, shown(path.name if names.count(path.name) == 1 else str(path))) for path in files]


def _check_folder(directory: Path, findings: Findings) -> None:
    name = shown(directory.name or str(directory))
    try:
        mode = directory.stat().st_mode
        if stat.S_ISREG(mode):
            findings.path_problem(name, "is a file", "Give the folder that holds photo.toml")
        elif not stat.S_ISDIR(mode):
            findings.path_problem(name, "no such folder")
        elif not _is_there(directory / "photo.toml"):
            findings.path_problem(name, "no photo.toml in this folder", "Give a folder that holds one")
    except (FileNotFoundError, NotADirectoryError, ValueError):
        findings.path_problem(name, "no such folder")
    except OSError as error:
        findings.path_problem(name, reason(error))
    findings.raise_problems()


def _is_there(path: Path) -> bool:
    """Also a link to nothing; an OSError where the folder may not be searched."""
    try:
        path.lstat()
    except FileNotFoundError:
        return False
    return True


def _with_events(tables: InputTables, findings: Findings, start: int) -> InputTables:
    return InputTables(tables.stage, tables.tables, tuple(findings.events[start:]), tables.files)


def _check_together(inputs: list[InputTables], findings: Findings) -> list[InputTables]:
    """What can be seen only with the readings, the control list and the sheets side by side."""
    rows = {name: list(table) for tables in inputs for name, table in tables.tables.items()}
    control, digitized = rows.get("control_point", []), rows.get("digitizer_reading", [])
    if findings.problems or not (control or digitized):
        return inputs
    check_some_control("control.csv", control, digitized, findings)
    return [_with_unused(tables, control, digitized) if tables.stage == "readings" else tables for tables in inputs]


def _with_unused(tables: InputTables, control: list[Row], digitized: list[Row]) -> InputTables:
    findings = Findings()
    warn_without_control("readings.csv", tables.tables["comparator_reading"], control, digitized, findings)
    return InputTables(tables.stage, tables.tables, (*tables.events, *findings.events), tables.files)
