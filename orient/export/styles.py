"""Styles of the layers for QGIS (QML), as rows of `layer_styles`: QGIS takes them when it opens the GeoPackage."""

from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree import ElementTree as ET

from orient.export.layers import Layer
from orient.values import Scalar

QGIS_VERSION = "3.28.0"
BLUE, RED, GREY, INK = "0,114,178,255", "213,94,0,255", "136,136,136,255", "34,34,34,255"
"""Blue and vermilion are told apart by every eye."""
CLEAR = "255,255,255,0"
GEOMETRY_NUMBERS = {"Point": "0", "LineString": "1", "Polygon": "2"}


@dataclass(frozen=True, slots=True)
class Style:
    """How a layer is drawn: class of the symbol layer with its properties, the labelled field ("": none)."""

    kind: str
    symbol: str
    properties: dict[str, str]
    label: str
    told: str


def _marker(name: str, colour: str, size: str, label: str, told: str) -> Style:
    properties = {"name": name, "color": colour, "outline_color": INK, "size": size, "size_unit": "MM"}
    return Style("marker", "SimpleMarker", {**properties, "outline_width": "0.2"}, label, told)


def _outline(colour: str, width: str, dash: str, told: str) -> Style:
    properties = {"color": CLEAR, "style": "no", "outline_color": colour, "outline_style": dash, "outline_width": width}
    return Style("fill", "SimpleFill", {**properties, "outline_width_unit": "MM"}, "", told)


STYLES = {
    "control": _marker("triangle", BLUE, "3", "point", "control points with their names"),
    "check": _marker("circle", RED, "2.6", "point", "check points with their names"),
    "excluded": _marker("cross2", GREY, "3", "point", "excluded points with their names"),
    "residuals": Style(
        "line",
        "ArrowLine",
        {
            "arrow_width": "0.3",
            "arrow_start_width": "0.3",
            "head_length": "1.5",
            "head_thickness": "1",
            "is_curved": "0",
        },
        "",
        "residuals, magnified as the field `magnified` says",
    ),
    "ellipses": _outline(BLUE, "0.3", "solid", "standard error ellipses, magnified as the field `magnified` says"),
    "footprint": _outline(GREY, "0.4", "dash", "the frame on the ground"),
    "station": _marker("star", INK, "5", "photo", "projection centre"),
}


def style_rows(layers: Sequence[Layer], geometry: str, made_at: str) -> list[list[Scalar]]:
    """Rows of `layer_styles` in the order of its fields; every style is its layer's default."""
    rows: list[list[Scalar]] = []
    for layer in layers:
        style = STYLES[layer.name]
        qml = _qml(layer, style)
        rows.append(["", "", layer.name, geometry, layer.title, qml, "", True, style.told, "", "", made_at])
    return rows


def _qml(layer: Layer, style: Style) -> str:
    root = ET.Element("qgis", version=QGIS_VERSION, styleCategories="Symbology|Labeling")
    renderer = ET.SubElement(
        root, "renderer-v2", type="singleSymbol", symbollevels="0", enableorderby="0", forceraster="0"
    )
    _symbol(ET.SubElement(renderer, "symbols"), style)
    if style.label:
        _labels(root, style.label)
    ET.SubElement(root, "layerGeometryType").text = GEOMETRY_NUMBERS[layer.kind]
    return "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n" + ET.tostring(root, encoding="unicode")


def _symbol(parent: ET.Element, style: Style) -> None:
    symbol = ET.SubElement(parent, "symbol", type=style.kind, name="0", alpha="1", clip_to_extent="1", force_rhr="0")
    layer = ET.SubElement(symbol, "layer", {"class": style.symbol, "enabled": "1", "locked": "0", "pass": "0"})
    _options(layer, style.properties)
    if style.symbol == "ArrowLine":
        inner = ET.SubElement(layer, "symbol", type="fill", name="@0@0", alpha="1", clip_to_extent="1", force_rhr="0")
        fill = ET.SubElement(inner, "layer", {"class": "SimpleFill", "enabled": "1", "locked": "0", "pass": "0"})
        _options(fill, {"color": RED, "style": "solid", "outline_style": "no"})


def _options(parent: ET.Element, properties: dict[str, str]) -> None:
    """As QGIS 3.26 and later writes them, and as older ones read them."""
    options = ET.SubElement(parent, "Option", type="Map")
    for name, value in properties.items():
        ET.SubElement(options, "Option", type="QString", name=name, value=value)
    for name, value in properties.items():
        ET.SubElement(parent, "prop", k=name, v=value)


def _labels(root: ET.Element, field: str) -> None:
    labeling = ET.SubElement(root, "labeling", type="simple")
    settings = ET.SubElement(labeling, "settings", calloutType="simple")
    text = ET.SubElement(settings, "text-style", fieldName=field, isExpression="0", fontSize="8", textColor=INK)
    ET.SubElement(text, "text-buffer", bufferDraw="1", bufferSize="0.7", bufferColor="255,255,255,255")
    ET.SubElement(settings, "placement", placement="6", dist="1", distUnits="MM")
