"""GeoJSON (RFC 7946): all layers as one collection in WGS 84 longitude and latitude, the covariance beside them."""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from orient.export import Format, Made, Options
from orient.export.csv_metadata import covariance_block
from orient.export.elements import PARAMETERS, UNITS
from orient.export.layers import Layer, map_layers
from orient.export.map_system import wgs84_system
from orient.export.solved import ground_frame, project_axes, provenance, read_solved, stored_covariance
from orient.pipeline.tables import Array
from orient.values import Scalar


def make(path: Path, form: Format, ending: str, name: str, options: Options) -> Made:
    """The collection, feature by feature."""
    solved = read_solved(path, form)
    system = wgs84_system(solved, options)
    source = provenance(solved, project_axes(solved))
    head = {
        "type": "FeatureCollection",
        "name": str(solved.photo["name"]),
        "covariance": covariance_block(PARAMETERS, UNITS, stored_covariance(solved)),
        "ground_frame": ground_frame(solved),
        "coordinate_notes": list(system.notes),
        "source": source,
    }
    return Made(_pieces(head, map_layers(solved, system, options.magnify)), {})


def _pieces(head: Mapping[str, object], layers: list[Layer]) -> Iterator[bytes]:
    """The features come last, so that a reader has seen what they are."""
    yield (_text(head)[:-1] + ', "features": [').encode("utf-8")
    opening = "\n"
    for layer in layers:
        for shape, values in layer.features():
            yield (opening + _text(_feature(layer, shape, values))).encode("utf-8")
            opening = ",\n"
    yield b"\n]}\n"


def _feature(layer: Layer, shape: Array, values: Sequence[Scalar]) -> dict[str, object]:
    named = {field.name: value for field, value in zip(layer.fields, values, strict=True)}
    return {
        "type": "Feature",
        "properties": {"layer": layer.name, **named},
        "geometry": {"type": layer.kind, "coordinates": _coordinates(layer, shape)},
    }


def _coordinates(layer: Layer, shape: Array) -> list[object]:
    places: list[list[float]] = _unbroken(shape).tolist()
    if layer.kind == "Point":
        return [*places[0]]
    return [places] if layer.kind == "Polygon" else [*places]


def _unbroken(shape: Array) -> Array:
    """Longitudes that do not jump by a full turn inside one shape: it may then reach beyond 180 degrees."""
    turned = shape.copy()
    turned[:, 0] = np.unwrap(shape[:, 0], period=360.0)
    return turned


def _text(value: object) -> str:
    return json.dumps(_finite(value), ensure_ascii=False, allow_nan=False)


def _finite(value: object) -> object:
    """A number that is not known is null; JSON has no NaN."""
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, Mapping):
        return {key: _finite(inner) for key, inner in value.items()}
    return [_finite(inner) for inner in value] if isinstance(value, list) else value
