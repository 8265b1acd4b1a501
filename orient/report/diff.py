"""`diff STAGE A B`: settings, inputs, rows and numbers that differ between two versions."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from orient.report.text import cell, console, print_json, print_table
from orient.store.project import Project, RunInfo, open_project
from orient.values import Row, Scalar

SHOWN = 60
BULKY = (
    "cofactor",
    "sheet_cofactor",
    "iteration",
    "iteration_parameter",
    "equation",
    "camera_equation",
    "absolute_cofactor",
    "absolute_iteration",
    "absolute_iteration_parameter",
)
Difference = dict[str, Scalar]


def show_diff(path: Path, stage: str, first: int, second: int, as_json: bool) -> None:
    """Print what changed from version `first` to version `second`."""
    with open_project(path, "read") as project, project.snapshot():
        before, after = project.run(stage, first), project.run(stage, second)
        keys = _keys(project)
        found = [*_header(before, after), *_inputs(project, before, after)]
        old, new = project.read_tables(before.run_id), project.read_tables(after.run_id)
    for name in dict.fromkeys([*old, *new]):
        found += _rows(name, keys[name], old.get(name, []), new.get(name, []))
    if as_json:
        print_json(found)
        return
    if not found:
        console().print(f"{stage} versions {first} and {second} hold the same numbers.")
        return
    bulky = [entry for entry in found if entry["table"] in BULKY]
    found = [entry for entry in found if entry["table"] not in BULKY]
    headers = ["table", "row", "column", f"version {first}", f"version {second}", "change"]
    cells = [[cell(value) for value in entry.values()] for entry in found[:SHOWN]]
    print_table(headers, cells, [False, False, False, True, True, True])
    if len(found) > SHOWN:
        console().print(f"... {len(found) - SHOWN} more differences: --json")
    if bulky:
        names = ", ".join(dict.fromkeys(str(entry["table"]) for entry in bulky))
        console().print(f"Also {len(bulky)} values of {names}: --json")
    if any(entry["column"] == "version" and entry["row"] == "topocentric" for entry in found):
        console().print("T' may begin elsewhere in the two versions; B_S, L_S, H_S tell how far the camera moved.")


def _keys(project: Project) -> dict[str, list[str]]:
    """Primary key columns of every table, without the run."""
    _, rows = project.query(
        "SELECT m.name, c.name FROM sqlite_schema AS m JOIN pragma_table_info(m.name) AS c "
        "WHERE m.type = 'table' AND c.pk > 0 AND c.name <> 'run_id' ORDER BY m.name, c.pk"
    )
    _, names = project.query("SELECT name FROM sqlite_schema WHERE type = 'table'")
    keys: dict[str, list[str]] = {str(name): [] for (name,) in names}
    for name, column in rows:
        keys[name].append(column)
    return keys


def _header(before: RunInfo, after: RunInfo) -> list[Difference]:
    found = [
        _entry("run", "", name, getattr(before, name), getattr(after, name))
        for name in ("status", "stage_version")
        if getattr(before, name) != getattr(after, name)
    ]
    for name in sorted({*before.settings, *after.settings}):
        old, new = before.settings.get(name), after.settings.get(name)
        if old != new:
            found.append(_entry("settings", "", name, old, new))
    return found


def _inputs(project: Project, before: RunInfo, after: RunInfo) -> list[Difference]:
    versions = {run.run_id: run.version for run in project.runs()}
    found = []
    for role in sorted({*before.inputs, *after.inputs}):
        old, new = before.inputs.get(role), after.inputs.get(role)
        if old != new:
            found.append(_entry("inputs", role, "version", versions.get(old or 0), versions.get(new or 0)))
    return found


def _rows(name: str, keys: Sequence[str], old: Sequence[Row], new: Sequence[Row]) -> list[Difference]:
    before, after = ({tuple(row[key] for key in keys): row for row in rows} for rows in (old, new))
    found = []
    for key in dict.fromkeys([*before, *after]):
        label = " ".join(str(part) for part in key)
        if key not in after:
            found.append(_entry(name, label, "", "present", None))
        elif key not in before:
            found.append(_entry(name, label, "", None, "present"))
        else:
            found += _columns(name, label, before[key], after[key])
    return found


def _columns(name: str, label: str, old: Mapping[str, Scalar], new: Mapping[str, Scalar]) -> list[Difference]:
    return [_entry(name, label, column, old[column], new[column]) for column in old if old[column] != new[column]]


def _entry(place: str, row: str, column: str, old: Scalar, new: Scalar) -> Difference:
    change = new - old if isinstance(old, int | float) and isinstance(new, int | float) else None
    return {"table": place, "row": row, "column": column, "before": old, "after": new, "change": change}
