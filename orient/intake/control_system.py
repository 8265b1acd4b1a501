"""control.toml: the coordinate system of control.csv, and whether it fits the columns and the photo's ground."""

from dataclasses import dataclass
from typing import Literal

from orient.intake.crs import crs_kind
from orient.intake.findings import BadValue, Findings, shown
from orient.intake.photo_facts import PhotoFacts
from orient.intake.toml_file import Section

Columns = Literal["BL", "EN", "XYZ", "none"]
COLUMN_WORDS = {"BL": "B_deg, L_deg", "EN": "E_m, N_m", "XYZ": "X_m, Y_m, Z_m"}
KIND_OF_COLUMNS = {"BL": "geographic", "EN": "projected", "XYZ": "geocentric"}
SAY_WHICH = "say whether X_m, Y_m, Z_m are geocentric or local: control.toml"
STATEMENTS = 'Write crs = "EPSG:...", kind = "geocentric" or local = "right"'


@dataclass(frozen=True, slots=True)
class ControlStatement:
    """What control.toml says; empty without one. `readable` is False when it has problems of its own."""

    crs: str | None = None
    crs_kind: str = ""
    geocentric: bool = False
    handedness: str | None = None
    readable: bool = True


def read_statement(document: Section) -> ControlStatement:
    """Exactly one of crs, kind, local."""
    section = document.section("control")
    document.finish()
    given = [key for key in ("crs", "kind", "local") if section.has(key)]
    if len(given) != 1:
        section.problem("", "control: give one of crs, kind, local", STATEMENTS)
    crs, kind = section.text("crs"), section.word("kind", ("geocentric",))
    local = section.word("local", ("right", "left"))
    section.finish()
    if len(given) != 1 or (crs is None and kind is None and local is None):
        return ControlStatement(readable=False)
    if crs is None:
        return ControlStatement(geocentric=kind is not None, handedness=local)
    try:
        return ControlStatement(crs=crs, crs_kind=crs_kind(crs))
    except BadValue as bad:
        section.problem("crs", f"crs: {bad.message}", bad.hint)
        return ControlStatement(readable=False)


def kind_of_points(
    file: str, columns: Columns, statement: ControlStatement, photo: PhotoFacts, findings: Findings
) -> tuple[str, str | None]:
    """geographic, projected, geocentric, local or none, and the handedness of local coordinates."""
    if columns == "none" or not statement.readable:
        return "none", None
    if statement.handedness is not None:
        return _stated_local(file, columns, statement, photo, findings)
    if statement.crs is not None:
        return _stated_crs(file, columns, statement, photo, findings)
    if columns == "XYZ" and not statement.geocentric:
        return _unstated_xyz(file, photo, findings)
    if statement.geocentric and columns != "XYZ":
        findings.problem(file, 1, f'{COLUMN_WORDS[columns]} do not go with kind = "geocentric" of control.toml')
    if columns == "EN":
        findings.problem(file, 1, "E_m, N_m need a crs", 'Write [control] crs = "EPSG:..." in control.toml')
    _refuse_local_ground(file, KIND_OF_COLUMNS[columns], photo, findings)
    return KIND_OF_COLUMNS[columns], None


def _stated_local(
    file: str, columns: Columns, statement: ControlStatement, photo: PhotoFacts, findings: Findings
) -> tuple[str, str | None]:
    if columns != "XYZ":
        findings.problem(file, 1, "local control has the columns X_m, Y_m, Z_m", "Or change control.toml")
    elif photo.known == "yes" and photo.ground_kind != "local":
        hint = "Write [ground] local in photo.toml, or the system of the coordinates in control.toml"
        findings.problem(file, 1, "control is local, but the ground of the photo is not", hint)
    return "local", statement.handedness


def _stated_crs(
    file: str, columns: Columns, statement: ControlStatement, photo: PhotoFacts, findings: Findings
) -> tuple[str, str | None]:
    wanted = KIND_OF_COLUMNS[columns]
    if statement.crs_kind != wanted:
        words = {"geographic": "is in degrees", "projected": "is in metres E, N", "geocentric": "is geocentric"}
        what = words.get(statement.crs_kind, "is of another kind")
        findings.problem(file, 1, f"{COLUMN_WORDS[columns]}, but crs {shown(statement.crs or '')} {what}")
    _refuse_local_ground(file, wanted, photo, findings)
    return wanted, None


def _unstated_xyz(file: str, photo: PhotoFacts, findings: Findings) -> tuple[str, str | None]:
    if photo.ground_kind == "local":
        return "local", photo.handedness
    if photo.known != "unreadable":
        findings.problem(file, 1, SAY_WHICH, STATEMENTS)
    return "local", None


def _refuse_local_ground(file: str, kind: str, photo: PhotoFacts, findings: Findings) -> None:
    if photo.known == "yes" and photo.ground_kind == "local":
        hint = "Give X_m, Y_m, Z_m in that system"
        findings.problem(file, 1, f"control is {kind}, but the ground of the photo is local", hint)
