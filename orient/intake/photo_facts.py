"""What the other files need to know of the photo: its ground, the size of its frame, its fiducial marks."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

from orient.geometry.frame_centre import frame_centre
from orient.values import InputTables, Scalar

MARGIN = 0.1
Limits = tuple[float, float]


@dataclass(frozen=True, slots=True)
class PhotoFacts:
    """`known` is "no" when there is no photo yet and "unreadable" when its file has problems of its own."""

    known: Literal["yes", "no", "unreadable"]
    ground_kind: str = ""
    handedness: str | None = None
    pixel_size_mm: float | None = None
    limits: Mapping[str, Limits] | None = None
    marks: frozenset[str] = frozenset()


UNKNOWN = PhotoFacts("no")
UNREADABLE = PhotoFacts("unreadable")


def facts_of(photo: Mapping[str, object]) -> PhotoFacts:
    """From a row of the table `photo` and the names of its marks under the key `fiducials`."""
    row: dict[str, Scalar] = {key: value for key, value in photo.items() if isinstance(value, str | int | float)}
    row |= {key: None for key, value in photo.items() if value is None}
    names = photo.get("fiducials")
    marks = frozenset(str(name) for name in names) if isinstance(names, Iterable) else frozenset()
    handedness = row.get("handedness")
    return PhotoFacts(
        "yes",
        str(row.get("ground_kind") or ""),
        handedness if isinstance(handedness, str) else None,
        _float(row.get("pixel_size_mm")),
        _limits(row),
        marks,
    )


def facts_of_tables(photo: InputTables) -> PhotoFacts:
    marks = [str(mark["mark"]) for mark in photo.tables.get("fiducial_mark", ())]
    return facts_of({**photo.tables["photo"][0], "fiducials": marks})


def _float(value: object) -> float | None:
    return float(value) if isinstance(value, int | float) else None


def _limits(row: dict[str, Scalar]) -> dict[str, Limits]:
    """Where a reading can lie, without the margin. A comparator with its own origin has no limits."""
    limits: dict[str, Limits] = {}
    for column, key in (("col_px", "image_width_px"), ("row_px", "image_height_px")):
        if size := _float(row.get(key)):
            limits[column] = (0.0, size)
    if row.get("interior_transformation") == "none":
        middle = frame_centre(row)
        for i, (column, size_key, point_key) in enumerate(
            (("x_mm", "frame_width_mm", "x0_mm"), ("y_mm", "frame_height_mm", "y0_mm"))
        ):
            half = (_float(row.get(size_key)) or 0.0) / 2
            # readings may count from the centre of the frame or from a corner that the principal point tells of
            centres = (middle[i], _float(row.get(point_key)) or 0.0)
            limits[column] = (min(centres) - half, max(centres) + half)
    return limits
