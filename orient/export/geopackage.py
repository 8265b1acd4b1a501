"""GeoPackage (OGC 12-128) by GDAL: the layers in the map's system, the covariance as a table, styles for QGIS."""

import json
import struct
import tempfile
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.util import find_spec
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orient.errors import NotInstalled
from orient.export import Format, Made, Options
from orient.export.elements import covariance_rows
from orient.export.layer_fields import COVARIANCE_FIELDS, STYLE_FIELDS, Field
from orient.export.layers import Feature, Layer, map_layers
from orient.export.map_system import MapSystem, map_system
from orient.export.solved import Solved, ground_frame, project_axes, provenance, read_solved
from orient.export.styles import style_rows
from orient.pipeline.tables import Array
from orient.values import Scalar

UNDEFINED_CARTESIAN = -1
"""srs_id of the standard for Cartesian coordinates without a reference system."""
PIECE = 1 << 20
SECONDS = len("2026-01-01T00:00:00")
PAGE = 10_000
"""Features that are in memory at a time."""
GEOMETRY = "geom"
VERSION = "1.2"
"""Nothing of a later version of the standard is used, and older programs read this one without a warning."""
WKB = {"Point": 1, "LineString": 2, "Polygon": 3}
TYPES: dict[str, Any] = {
    "text": object,
    "real": np.float64,
    "integer": np.int64,
    "boolean": np.bool_,
    "datetime": "datetime64[ms]",
}
_FILLERS: dict[str, Scalar] = {"real": 0.0, "integer": 0, "boolean": 0}
"""What stands under the mask of a NULL."""
COVARIANCE, STYLES = "orientation_covariance", "layer_styles"


def make(path: Path, form: Format, ending: str, name: str, options: Options) -> Made:
    """The bytes of the file, made in a folder of its own; the time in it is that of the resection."""
    if find_spec("pyogrio") is None:
        raise NotInstalled("a GeoPackage needs", ["pyogrio"], "gis")
    solved = read_solved(path, form)
    system = map_system(solved, options)
    layers = map_layers(solved, system, options.magnify)
    return Made(_bytes(solved, system, layers), {})


def _bytes(solved: Solved, system: MapSystem, layers: Sequence[Layer]) -> Iterator[bytes]:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "layers.gpkg"
        with _time_of(solved.current.runs["resection"].started_at):
            _write(file, solved, system, layers)
        with file.open("rb") as content:
            while piece := content.read(PIECE):
                yield piece


def _write(file: Path, solved: Solved, system: MapSystem, layers: Sequence[Layer]) -> None:
    about = {
        "coordinate_notes": " ".join(system.notes) or system.name,
        "ground_frame": json.dumps(ground_frame(solved), allow_nan=False),
        "source": json.dumps(provenance(solved, project_axes(solved)), ensure_ascii=False, allow_nan=False),
    }
    for layer in layers:
        _write_layer(file, layer, system, about)
        about = {}
    _write_table(file, COVARIANCE, "6 x 6 covariance of the orientation", COVARIANCE_FIELDS, covariance_rows(solved))
    styles = style_rows(layers, GEOMETRY, solved.current.runs["resection"].started_at[:SECONDS])
    _write_table(file, STYLES, "styles for QGIS", STYLE_FIELDS, styles)


def _write_layer(file: Path, layer: Layer, system: MapSystem, about: dict[str, str]) -> None:
    """A layer without a feature too; a page at a time."""
    options = {"GEOMETRY_NAME": GEOMETRY, "DESCRIPTION": layer.title}
    if not system.text:
        options["SRID"] = str(UNDEFINED_CARTESIAN)
    features = layer.features()
    page = list(islice(features, PAGE))
    _write_page(file, layer, page, system, about, options)
    while page := list(islice(features, PAGE)):
        _write_page(file, layer, page, system, {}, {})


def _write_page(
    file: Path, layer: Layer, page: Sequence[Feature], system: MapSystem, about: dict[str, str], options: dict[str, str]
) -> None:
    """Features of a layer; `options` make it, without them it is there already."""
    from pyogrio.raw import write

    geometry = np.array([_wkb(layer, shape) for shape, _ in page], dtype=object)
    data, masks = _columns(layer.fields, [values for _, values in page])
    meanings = {field.name: field.meaning for field in layer.fields} if options else None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # "crs was not provided": so it is meant
        write(
            str(file),
            geometry,
            data,
            [field.name for field in layer.fields],
            field_mask=masks,
            layer=layer.name,
            driver="GPKG",
            geometry_type=layer.kind,
            crs=system.text or None,
            append=file.exists(),
            dataset_metadata=about or None,
            dataset_options=None if file.exists() else {"VERSION": VERSION},
            layer_metadata=meanings,
            layer_options=options or None,
        )


def _write_table(file: Path, name: str, title: str, fields: Sequence[Field], rows: Sequence[Sequence[Scalar]]) -> None:
    from pyogrio.raw import write

    data, masks = _columns(fields, rows)
    write(
        str(file),
        None,
        data,
        [field.name for field in fields],
        field_mask=masks,
        layer=name,
        driver="GPKG",
        geometry_type=None,
        append=True,
        layer_metadata=None if name == STYLES else {field.name: field.meaning for field in fields},
        layer_options={"DESCRIPTION": title, "FID": "id"},
    )


def _columns(
    fields: Sequence[Field], rows: Sequence[Sequence[Scalar]]
) -> tuple[list[NDArray[Any]], list[NDArray[np.bool_] | None]]:
    """One array for each field, and where it is NULL: never NaN."""
    data: list[NDArray[Any]] = []
    masks: list[NDArray[np.bool_] | None] = []
    for i, field in enumerate(fields):
        values = [row[i] for row in rows]
        empty = np.array([value is None for value in values], dtype=np.bool_)
        filled = [_FILLERS.get(field.type) if value is None else value for value in values]
        data.append(np.array(filled, dtype=TYPES[field.type]))
        masks.append(empty if field.type in _FILLERS else None)
    return data, masks


def _wkb(layer: Layer, shape: Array) -> bytes:
    """Well-known binary, little-endian."""
    head = struct.pack("<BI", 1, WKB[layer.kind])
    places = np.ascontiguousarray(shape, dtype="<f8").tobytes()
    if layer.kind == "Point":
        return head + places
    count = struct.pack("<I", len(shape))
    return head + (struct.pack("<I", 1) if layer.kind == "Polygon" else b"") + count + places


@contextmanager
def _time_of(started_at: str) -> Iterator[None]:
    """The same project gives the same bytes: GDAL would write the present time."""
    from pyogrio import set_gdal_config_options

    set_gdal_config_options({"OGR_CURRENT_DATE": started_at[:SECONDS] + ".000Z"})
    try:
        yield
    finally:
        set_gdal_config_options({"OGR_CURRENT_DATE": None})
