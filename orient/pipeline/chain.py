"""What stands behind the coordinates of the control points: interior orientation, sheet coefficients, their errors."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from orient.pipeline.common_coefficients import CommonCoefficients, SheetErrors
from orient.pipeline.frames import Frame
from orient.pipeline.interior_unknowns import InteriorUnknowns
from orient.pipeline.resection_trace import NamedUnknown
from orient.pipeline.tables import Array
from orient.solvers.camera_unknowns import CameraUnknowns
from orient.solvers.common_unknowns import CommonUnknowns, together

INTERIOR = "interior orientation"


@dataclass(frozen=True, slots=True)
class Chain:
    """Common unknowns of the control points in the order of the solver: interior orientation, then the sheets'.

    `shared` speaks of the points of one adjustment; `sheets` are the errors of their digitised coordinates; `camera`
    has the elements of the camera that are unknowns, with the readings of these points.
    """

    interior: InteriorUnknowns | None
    shared: CommonCoefficients | None
    sheets: Sequence[SheetErrors]
    sigma0: float
    camera: CameraUnknowns | None = None

    @property
    def interior_unknowns(self) -> int:
        return 0 if self.interior is None else len(self.interior.names)

    def at(self, keep: Sequence[int]) -> "Chain":
        """The same for some of the points, without the errors of the sheets."""
        shared = None if self.shared is None else self.shared.at(keep)
        return replace(self, shared=shared, sheets=(), camera=None if self.camera is None else self.camera.of(keep))

    @property
    def unknowns(self) -> list[NamedUnknown]:
        """Subject, name, unit and a-priori value of the common unknowns."""
        interior = self.interior
        listed: list[NamedUnknown] = []
        if interior is not None:
            in_order = zip(interior.names, interior.units, interior.values.tolist(), strict=True)
            listed = [NamedUnknown(INTERIOR, name, unit, value) for name, unit, value in in_order]
        coefficients = () if self.shared is None else self.shared.coefficients
        return listed + [NamedUnknown(one.sheet, one.name, one.unit, one.value) for one in coefficients]

    def in_solver(self, comparator: Array, frame: Frame) -> CommonUnknowns | None:
        """The common unknowns of points with these comparator coordinates (n, 2) [mm], for the solver."""
        parts = []
        if self.interior is not None:
            parts.append(self.interior.in_solver(comparator, self.sigma0))
        if self.shared is not None:
            parts.append(self.shared.in_solver(frame, self.sigma0))
        return together(parts)
