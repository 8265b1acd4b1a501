"""`orient export P geojson|gpkg`, read back by GDAL: control to 0.01 px, true places, styles that name real fields."""

import json
import sqlite3
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pyproj
import pytest

from orient.export import geopackage
from orient.export.layer_fields import POINT_FIELDS
from orient.export.styles import STYLES
from tests.cli.commands import orient
from tests.export.conftest import Project
from tests.export.reprojection import by_collinearity, rows, stored

pyogrio = pytest.importorskip("pyogrio")
ALLOWED_PX, VIRTUAL_PIXEL_MM = 0.01, 0.01
LAYERS = ("control", "check", "excluded", "residuals", "ellipses", "footprint", "station")
MERCATOR = 20_037_508.3427892
POINT, LINE, POLYGON = 1, 2, 3


def exported(path: Path, folder: Path, name: str, *words: object) -> Path:
    output = folder / f"layers.{name}"
    said = orient("export", path, name, "-o", output, *words)
    assert (said.code, said.err) == (0, "")
    return output


def table(file: Path, layer: str, where: str = "") -> tuple[list[np.ndarray], dict[str, list]]:
    """Places of each feature (n, 2) and the fields, as GDAL reads them."""
    options = {"where": where} if where else {}
    meta, _, geometry, data = pyogrio.raw.read(str(file), layer=layer, **options)
    fields = {name: column.tolist() for name, column in zip(meta["fields"], data, strict=True)}
    return [places_of(bytes(wkb)) for wkb in ([] if geometry is None else geometry)], fields


def places_of(wkb: bytes) -> np.ndarray:
    kind = int.from_bytes(wkb[1:5], "little")
    head = {POINT: 5, LINE: 9, POLYGON: 13}[kind]
    return np.frombuffer(wkb[head:], "<f8").reshape(-1, 2)


def geocentric(B: np.ndarray, L: np.ndarray, H: np.ndarray, a: float, rf: float) -> np.ndarray:
    figure = f"+a={a!r} +rf={rf!r}" if rf else f"+R={a!r}"
    way = pyproj.Transformer.from_pipeline(
        f"+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad +step +proj=cart {figure}"
    )
    return np.column_stack(way.transform(L, B, H))


@pytest.mark.parametrize("sample", ["pulkovo", "apollo15-metric-0585", "simulated-space-krasovsky"])
def test_control_of_a_geopackage_falls_on_its_image(sample: str, project: Project, tmp_path: Path) -> None:
    """B and L from the geometry, H from its field, the frame from the metadata: geocentric, then collinearity.

    Check points are errorless neither here nor there; control with errors was moved, and is not where it was given.
    """
    path = project(sample)
    file, proof = exported(path, tmp_path, "gpkg"), stored(path)
    layer = "control" if sample.startswith("apollo") else "check"
    shapes, fields = table(file, layer)
    frame = json.loads(pyogrio.read_info(str(file), layer=layer)["dataset_metadata"]["ground_frame"])
    L, B = np.vstack(shapes).T
    assert fields["B_deg"] == pytest.approx(B.tolist(), abs=1e-12)
    places = geocentric(B, L, np.array(fields["H_m"]), frame["a_m"], frame["inverse_flattening"])
    ground = (places - frame["origin_geocentric_m"]) @ np.array(frame["geocentric_from_ground"])
    _, station = table(file, "station")
    S = np.array([station[name][0] for name in ("Y_S_m", "X_S_m", "Z_S_m")])  # T' is north, east
    q = np.array([station[f"q_{part}"][0] for part in "wxyz"])
    computed = by_collinearity(q, S, station["f_mm"][0], ground)
    residuals = [proof.residuals[name] for name in fields["point"]]
    wanted = np.array([[row["x_mm"] + row["vx_mm"], row["y_mm"] + row["vy_mm"]] for row in residuals])
    assert np.abs(computed - wanted).max() / VIRTUAL_PIXEL_MM < ALLOWED_PX


@pytest.mark.parametrize("sample", ["calgary-28", "strasbourg-sxb-8937"])
def test_local_ground_has_undefined_cartesian_coordinates(sample: str, project: Project, tmp_path: Path) -> None:
    path = project(sample)
    file, proof = exported(path, tmp_path, "gpkg"), stored(path)
    with sqlite3.connect(file) as connection:
        assert {row[0] for row in connection.execute("SELECT srs_id FROM gpkg_geometry_columns")} == {-1}
    shapes, fields = table(file, "control")
    _, station = table(file, "station")
    ground = np.column_stack([np.vstack(shapes), fields["Z_m"]])
    S = np.array([station[name][0] for name in ("X_S_m", "Y_S_m", "Z_S_m")])
    q = np.array([station[f"q_{part}"][0] for part in "wxyz"])
    computed = by_collinearity(q, S, station["f_mm"][0], ground)
    residuals = [proof.residuals[name] for name in fields["point"]]
    wanted = np.array([[row["x_mm"] + row["vx_mm"], row["y_mm"] + row["vy_mm"]] for row in residuals])
    if sample == "calgary-28":
        wanted += by_hand_interior_shift(path, fields["point"])
    assert np.abs(computed - wanted).max() / VIRTUAL_PIXEL_MM < ALLOWED_PX


def by_hand_interior_shift(path: Path, points: list[str]) -> np.ndarray:
    """What the adjusted affine parameters add: dx = da0 + da1 X + da2 Y of the comparator, likewise y."""
    c = {
        row["name"]: row["correction"]
        for row in rows(path, "SELECT * FROM adjusted_interior WHERE run_id = {resection}")
    }
    sql = "SELECT point, x_comparator_mm AS X, y_comparator_mm AS Y FROM image_point WHERE run_id = {refine}"
    at = {row["point"]: row for row in rows(path, sql)}
    xy = np.array([[at[point]["X"], at[point]["Y"]] for point in points])
    return np.column_stack([c[f"{k}0"] + c[f"{k}1"] * xy[:, 0] + c[f"{k}2"] * xy[:, 1] for k in "ab"])


def test_every_layer_is_there_and_in_the_datum_of_the_ground(project: Project, tmp_path: Path) -> None:
    file = exported(project("pulkovo"), tmp_path, "gpkg")
    found = {name: pyogrio.read_info(str(file), layer=name) for name in LAYERS}
    assert {name: info["features"] for name, info in found.items()} == {
        "control": 25, "check": 11, "excluded": 0, "residuals": 36, "ellipses": 36, "footprint": 1, "station": 1,
    }  # fmt: skip
    assert {info["crs"] for info in found.values()} == {"EPSG:4284"}
    assert found["excluded"]["fields"].tolist() == [field.name for field in POINT_FIELDS]
    assert "deg" in found["control"]["layer_metadata"]["B_deg"]


def test_many_features_are_written_a_page_at_a_time(
    project: Project, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = exported(project("pulkovo"), tmp_path, "gpkg")
    (tmp_path / "paged").mkdir()
    monkeypatch.setattr(geopackage, "PAGE", 7)
    paged = exported(project("pulkovo"), tmp_path / "paged", "gpkg")
    for layer in LAYERS:
        one, other = (pyogrio.read_info(str(file), layer=layer) for file in (whole, paged))
        assert str(one) == str(other)
        (shapes, values), (paged_shapes, paged_values) = (table(file, layer) for file in (whole, paged))
        assert [shape.tobytes() for shape in shapes] == [shape.tobytes() for shape in paged_shapes]
        assert str(values) == str(paged_values)


def test_the_moon_has_its_own_system(project: Project, tmp_path: Path) -> None:
    file = exported(project("apollo15-metric-0585"), tmp_path, "gpkg")
    with sqlite3.connect(file) as connection:
        sql = (
            "SELECT organization, organization_coordsys_id FROM gpkg_spatial_ref_sys WHERE srs_id NOT IN (-1, 0, 4326)"
        )
        assert connection.execute(sql).fetchall() == [("IAU_2015", 30100)]


def test_geojson_is_wgs_84_by_the_operation_that_is_named(project: Project, tmp_path: Path) -> None:
    """Against pyproj's own choice for this area, 1e-9 deg; GDAL reads it as EPSG:4326."""
    path = project("pulkovo")
    file = exported(path, tmp_path, "geojson")
    content = json.loads(file.read_text("utf-8"), parse_constant=pytest.fail)
    assert pyogrio.read_info(str(file))["crs"] == "EPSG:4326"
    assert "Pulkovo 1942 to WGS 84" in content["coordinate_notes"][0]
    features = [one for one in content["features"] if one["properties"]["layer"] in ("control", "check")]
    assert len(features) == 36
    gpkg = exported(path, tmp_path, "gpkg", "--crs", "EPSG:4326")
    shapes, fields = table(gpkg, "control")
    by_name = dict(zip(fields["point"], shapes, strict=True))
    name = features[0]["properties"]["point"]
    assert features[0]["geometry"]["coordinates"] == pytest.approx(by_name[name][0].tolist(), abs=1e-12)
    given = features[0]["properties"]
    moved = np.array(features[0]["geometry"]["coordinates"]) - [given["L_deg"], given["B_deg"]]
    assert 1e-4 < np.abs(moved).max() < 3e-3  # the datum shift: some 100 m, not none and not a map zone
    assert "coordinates" not in content


def test_shapes_of_geojson(project: Project, tmp_path: Path) -> None:
    """Rings are closed and anticlockwise (RFC 7946, 3.1.6)."""
    content = json.loads(exported(project("pulkovo"), tmp_path, "geojson").read_text("utf-8"))
    polygons = [one for one in content["features"] if one["geometry"]["type"] == "Polygon"]
    assert {one["properties"]["layer"] for one in polygons} == {"ellipses", "footprint"}
    for one in polygons:
        (ring,) = one["geometry"]["coordinates"]
        x, y = np.array(ring).T
        assert ring[0] == ring[-1]
        assert np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]) > 0


@pytest.mark.parametrize("sample", ["calgary-28", "pulkovo"])
def test_vectors_and_ellipses_have_their_true_size(sample: str, project: Project, tmp_path: Path) -> None:
    """With --magnify 1 in metres on the ground: 1e-4 of the length (the horizon of the point, the ellipsoid)."""
    path = project(sample)
    file = exported(path, tmp_path, "gpkg", "--magnify", "1")

    def metres(places: np.ndarray, other: np.ndarray) -> float:
        if sample == "calgary-28":
            return float(np.hypot(*(other - places)))
        geod = pyproj.Geod(a=6378245.0, rf=298.3)
        return float(geod.inv(*places, *other)[2])

    shapes, fields = table(file, "residuals")
    for shape, length in zip(shapes, fields["length_m"], strict=True):
        assert metres(shape[0], shape[1]) == pytest.approx(length, rel=1e-3, abs=1e-3)
    rings, ellipses = table(file, "ellipses")
    for ring, a, b in zip(rings, ellipses["a_m"], ellipses["b_m"], strict=True):
        half = len(ring) // 2
        diameters = [metres(ring[i], ring[i + half]) for i in range(half)]
        assert max(diameters) == pytest.approx(2 * a, rel=2e-3)
        assert min(diameters) == pytest.approx(2 * b, rel=2e-3)
    twice = exported(path, tmp_path, "gpkg", "--magnify", "20", "--force")
    (first, *_), numbers = table(twice, "residuals")
    assert metres(first[0], first[1]) == pytest.approx(20 * numbers["length_m"][0], rel=1e-3)
    assert set(numbers["magnified"]) == {20.0}


def test_the_footprint_is_where_the_corners_look(project: Project, tmp_path: Path) -> None:
    """Calgary 28: 23 cm at 1:4900 from 750 m above the ground, and the control inside."""
    file = exported(project("calgary-28"), tmp_path, "gpkg")
    (ring,), fields = table(file, "footprint")
    extent = np.ptp(ring, axis=0)
    assert extent == pytest.approx([1146, 1146], rel=0.02)
    assert fields["is_whole"] == [1]
    control = np.vstack(table(file, "control")[0])
    assert (control > ring.min(axis=0)).all()
    assert (control < ring.max(axis=0)).all()


def test_the_map_system_of_the_control_is_taken(project: Project, tmp_path: Path) -> None:
    """`--crs` in metres: the distance of two points is that of the project within the scale of the projection."""
    file = exported(project("pulkovo"), tmp_path, "gpkg", "--crs", "EPSG:28404")
    assert pyogrio.read_info(str(file), layer="control")["crs"] == "EPSG:28404"
    shapes, fields = table(file, "control")
    places, own = np.vstack(shapes), np.column_stack([fields["Y_m"], fields["X_m"]])
    assert np.linalg.norm(places[0] - places[1]) == pytest.approx(np.linalg.norm(own[0] - own[1]), rel=2e-3)


def test_styles_are_xml_and_name_real_fields(project: Project, tmp_path: Path) -> None:
    file = exported(project("calgary-28"), tmp_path, "gpkg")
    meta, _, _, data = pyogrio.raw.read(str(file), layer="layer_styles")
    styles = dict(zip(meta["fields"], data, strict=True))
    assert set(styles["f_table_name"].tolist()) == set(STYLES) == set(LAYERS)
    assert styles["useAsDefault"].all()
    for layer, geometry, qml in zip(
        styles["f_table_name"], styles["f_geometry_column"], styles["styleQML"], strict=True
    ):
        root = ElementTree.fromstring(qml)
        info = pyogrio.read_info(str(file), layer=layer)
        assert geometry == info["geometry_name"]
        labels = [element.get("fieldName") for element in root.iter("text-style")]
        assert set(labels) <= set(info["fields"].tolist())
        kinds = {"Point": "marker", "LineString": "line", "Polygon": "fill"}
        assert [one.get("type") for one in root.findall("renderer-v2/symbols/symbol")] == [kinds[info["geometry_type"]]]
        assert len(root.findall(".//symbols/symbol/layer/Option/Option")) >= 4


def test_the_covariance_lies_beside_the_layers(project: Project, tmp_path: Path) -> None:
    path = project("pulkovo")
    file, proof = exported(path, tmp_path, "gpkg"), stored(path)
    meta, _, _, data = pyogrio.raw.read(str(file), layer="orientation_covariance")
    found = dict(zip(meta["fields"], data, strict=True))
    order = ["X_S", "Y_S", "Z_S", "rotation_1", "rotation_2", "rotation_3"]
    assert found["parameter"].tolist() == order
    assert found["unit"].tolist() == ["m"] * 3 + ["rad"] * 3
    covariance = np.column_stack([found[f"cov_{name}"] for name in order])
    sql = "SELECT unknown_i, unknown_j, value FROM cofactor WHERE run_id = {resection} AND unknowns = 'rotation'"
    for row in rows(path, sql):
        i, j = order.index(str(row["unknown_i"])), order.index(str(row["unknown_j"]))
        wanted = row["value"] * proof.orientation["variance_scale"]
        assert covariance[i, j] == pytest.approx(wanted, rel=1e-12)
        assert covariance[j, i] == pytest.approx(wanted, rel=1e-12)
    content = json.loads(exported(path, tmp_path, "geojson").read_text("utf-8"))
    assert content["covariance"]["parameters"] == order
    assert np.array(content["covariance"]["matrix"]) == pytest.approx(covariance, rel=1e-12)


REFUSED = {
    "local ground": ("calgary-28", "geojson", (), 1, "the ground of this photo is local Cartesian metres"),
    "the Moon": ("apollo15-metric-0585", "geojson", (), 1, "WGS 84 on the Earth"),
    "no datum": ("simulated-space-krasovsky", "geojson", (), 1, "has no datum from which WGS 84 can be reached"),
    "geojson in another system": ("pulkovo", "geojson", ("--crs", "EPSG:28404"), 2, "is always in WGS 84"),
    "local with a system": ("calgary-28", "gpkg", ("--crs", "EPSG:4326"), 2, "--crs cannot be used"),
    "no system": ("pulkovo", "gpkg", ("--crs", "EPSG:0"), 1, 'unknown coordinate system "EPSG:0"'),
    "geocentric": ("pulkovo", "gpkg", ("--crs", "EPSG:4978"), 2, "is not a system of maps"),
    "another body": ("apollo15-metric-0585", "gpkg", ("--crs", "EPSG:4326"), 1, "orient: "),
    "magnified by nothing": ("pulkovo", "gpkg", ("--magnify", "0"), 2, "is not a number above 0"),
    "magnified by nan": ("pulkovo", "gpkg", ("--magnify", "nan"), 2, "is not a number above 0"),
}


@pytest.mark.parametrize(("sample", "name", "words", "code", "message"), REFUSED.values(), ids=REFUSED)
def test_what_is_refused(
    sample: str, name: str, words: tuple[str, ...], code: int, message: str, project: Project, tmp_path: Path
) -> None:
    said = orient("export", project(sample), name, "-o", tmp_path / f"x.{name}", *words)
    assert said.code == code, said.err
    assert message in said.err
    assert list(tmp_path.iterdir()) == []


def test_a_bare_figure_of_wgs_84_is_taken_for_the_datum(project: Project, tmp_path: Path) -> None:
    content = json.loads(exported(project("wgs84"), tmp_path, "geojson").read_text("utf-8"))
    assert content["coordinate_notes"] == ["The ground is the ellipsoid of WGS 84; its datum is taken as WGS 84."]
    first = content["features"][0]
    assert first["geometry"]["coordinates"] == [first["properties"]["L_deg"], first["properties"]["B_deg"]]
