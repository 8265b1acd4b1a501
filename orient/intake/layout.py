"""layout.csv: control points that are only planned, in the image of a photo to come."""

from dataclasses import dataclass
from pathlib import Path

from orient.intake.cells import CellReader
from orient.intake.checks import Places
from orient.intake.csv_table import Layout, open_csv
from orient.intake.findings import Findings, shown
from orient.intake.names import NameRegister
from orient.intake.options import ReadOptions

LAYOUT = Layout(("point", "x_mm", "y_mm"), optional=("dZ_m",))
ON_THE_EDGE = 1e-9


@dataclass(frozen=True, slots=True)
class Frame:
    """Width, height and centre of the frame as seen from the principal point [mm]."""

    width: float
    height: float
    centre: tuple[float, float]

    def sees(self, x: float, y: float) -> bool:
        across, along = abs(x - self.centre[0]), abs(y - self.centre[1])
        return 2 * across <= self.width * (1 + ON_THE_EDGE) and 2 * along <= self.height * (1 + ON_THE_EDGE)


@dataclass(frozen=True, slots=True)
class PlannedPoint:
    """x, y [mm] from the principal point, dZ [m] above the mean ground."""

    name: str
    x: float
    y: float
    dZ: float


def read_layout(path: Path, frame: Frame, options: ReadOptions) -> tuple[PlannedPoint, ...]:
    """The points of a CSV file with the columns point, x_mm, y_mm and perhaps dZ_m; every problem of it is named."""
    findings = Findings()
    file = shown(path.name)
    table = open_csv(path, file, (LAYOUT,), options, findings)
    names, places = NameRegister(file, "point", findings), Places()
    points = []
    for record in table.records if table else ():
        cells = CellReader(file, record, options, findings)
        name = cells.name("point", names)
        x, y = (cells.number(axis, required=True) for axis in ("x_mm", "y_mm"))
        dZ = cells.number("dZ_m") or 0.0
        if x is not None and y is not None and cells.ok and places.is_new(cells, name, f'point "{shown(name)}"'):
            _check_in_frame(cells, name, x, y, frame)
            points.append(PlannedPoint(name, x, y, dZ))
    findings.raise_problems()
    return tuple(points)


def _check_in_frame(cells: CellReader, name: str, x: float, y: float, frame: Frame) -> None:
    if not frame.sees(x, y):
        size = f"{frame.width:g} x {frame.height:g} mm"
        cells.problem(f'point "{name}" at {x:g}, {y:g} mm lies outside the frame of {size}')
