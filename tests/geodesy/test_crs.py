import numpy as np
import pytest
from pyproj import CRS

from orient.errors import OrientError
from orient.geodesy import crs
from orient.geodesy.ellipsoid import KRASOVSKY, MOON, WGS84, Ellipsoid
from orient.geodesy.topocentric import geocentric_from_geographic

SOFIA = (22.5, 42.0, 24.5, 43.5)


def named(text):
    return crs.crs_from_text(text)


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("EPSG:4326", "geographic"),
        ("EPSG:4979", "geographic"),
        ("EPSG:28404", "projected"),
        ("EPSG:4978", "geocentric"),
        ("EPSG:5773", "vertical"),
        ("EPSG:4326+5773", "geographic"),
        ("EPSG:32634+5773", "projected"),
        ("+proj=longlat +R=1737400 +type=crs", "geographic"),
        ("+proj=longlat +ellps=krass +towgs84=24,-141,-81,0,0.35,0.82,-0.12 +type=crs", "geographic"),
        (' LOCAL_CS["site"] ', "other"),
    ],
)
def test_kinds(text, kind):
    assert crs.crs_kind(named(text)) == kind


@pytest.mark.parametrize(
    "text",
    [
        "",
        "   ",
        "EPSG:999999",
        "EPSG:",
        "nowhere",
        "{}",
        "5",
        "EPSG:4326\0junk",
        "EPSG:4326\x1b[31m",
        "\ud800",
        "../../etc/passwd",
        "+proj=longlat +ellps=clrk66 +nadgrids=/data/secret.gsb +type=crs",
        "+proj=longlat +ellps=clrk66 +nadgrids=@null +type=crs",
        "+proj=utm +zone=33 +geoidgrids=/data/geoid.tif +type=crs",
        "+proj=pipeline +step +proj=hgridshift +grids=/data/secret.gsb",
        "+init=/data/file:123",
        "+init=epsg:4326",
        "EPSG:4326 " + " " * 1000,
        "G" * 1_000_000,
    ],
)
def test_what_is_no_system_is_refused(text):
    with pytest.raises(OrientError, match="unknown coordinate system") as caught:
        named(text)
    assert len(caught.value.message) < 200


def test_a_long_text_says_so():
    with pytest.raises(OrientError, match="longer than 1000 characters"):
        named("G" * 1001)


def test_ground_ellipsoids():
    assert crs.ground_ellipsoid(named("EPSG:4284")) == Ellipsoid("Krassowsky 1940", 6378245.0, 298.3)
    assert crs.ground_ellipsoid(named("EPSG:32634")).inverse_flattening == pytest.approx(298.257223563, abs=1e-9)
    for figure in (KRASOVSKY, MOON, WGS84):
        found = crs.ground_ellipsoid(crs.geographic_crs_of(figure))
        assert found.a_m == figure.a_m
        assert found.inverse_flattening == pytest.approx(figure.inverse_flattening, abs=1e-9)
    with pytest.raises(OrientError, match="has no ellipsoid"):
        crs.ground_ellipsoid(named("EPSG:5773"))


@pytest.mark.parametrize("text", ["EPSG:28404", "EPSG:4284", "EPSG:4284+5705"])
def test_the_geographic_system_of_the_same_datum(text):
    found = crs.geographic_crs(named(text))
    assert found.name == "Pulkovo 1942"
    assert len(found.axis_info) == 3


def test_the_geographic_system_of_a_geocentric_one_is_no_datum_change():
    found = crs.geographic_crs(named("EPSG:4978"))
    operation = crs.find_operation(named("EPSG:4978"), found)
    assert (operation.accuracy_m, operation.is_ballpark) == (0.0, False)
    L, B, H = operation.transform([6378137.0], [0.0], [0.0])
    np.testing.assert_allclose([L, B, H], 0.0, atol=1e-8)


def test_order_is_longitude_latitude_height():
    XYZ = crs.find_operation(named("EPSG:4326"), named("EPSG:4978")).transform([23.0], [42.7], [550.0])
    expected = geocentric_from_geographic(np.radians(42.7), np.radians(23.0), 550.0, WGS84)
    np.testing.assert_allclose(np.ravel(XYZ), expected, rtol=0, atol=1e-6)


def test_order_is_east_north_even_where_the_authority_says_north_east():
    """EPSG:28404 has the axes X north, Y east."""
    E, N, H = crs.find_operation(named("EPSG:4284"), named("EPSG:28404")).transform([23.0], [42.7], [550.0])
    assert E[0] == pytest.approx(4663873, abs=5e3)
    assert N[0] == pytest.approx(4731000, abs=5e3)
    assert H[0] == 550.0


def test_a_projection_is_exact_and_keeps_the_height():
    operation = crs.find_operation(named("EPSG:32634"), named("EPSG:4326"))
    assert (operation.accuracy_m, operation.is_ballpark, operation.grids) == (0.0, False, ())
    assert operation.transform([500000.0], [0.0], [123.0])[2][0] == 123.0


def test_the_same_system_is_an_identity():
    for pair in (("EPSG:4326", "EPSG:4326"), ("EPSG:4326", "EPSG:4979"), ("EPSG:28404", "EPSG:28404")):
        operation = crs.find_operation(*map(named, pair))
        assert (operation.definition, operation.accuracy_m) == ("noop", 0.0)
        source = np.array([1.0, 2.0])
        result = operation.transform(source, [3.0, 4.0], 5.0)
        np.testing.assert_array_equal(result, [[1, 2], [3, 4], [5, 5]])
        assert result[0] is not source


def test_a_datum_change_names_its_operation_and_moves_the_height():
    operation = crs.find_operation(named("EPSG:4284"), named("EPSG:4326"), area=SOFIA)
    assert "Pulkovo 1942 to WGS 84 (20)" in operation.name
    assert "proj=helmert" in operation.definition
    assert operation.accuracy_m == 3.0
    assert operation.grids == ()
    assert operation.proj_version
    L, _, H = operation.transform([23.0], [42.7], [550.0])
    assert 10 < abs(L[0] - 23.0) * 3600 * 20 < 500
    assert 1.0 < abs(H[0] - 550.0) < 100.0


def test_the_area_chooses_the_operation():
    """One datum, several countries."""
    finland, greece, turkey = (24.0, 61.0, 27.0, 63.0), (22.0, 38.0, 24.0, 40.0), (32.0, 38.0, 35.0, 40.0)
    source, target = named("EPSG:4230"), named("EPSG:4326")
    names = {crs.find_operation(source, target, area=area).name for area in (finland, greece, turkey)}
    assert len(names) == 3


def test_a_partly_covering_operation_is_better_than_a_ballpark():
    egypt = (29.0, 27.0, 32.0, 30.0)
    operation = crs.find_operation(named("EPSG:4230"), named("EPSG:4326"), area=egypt)
    assert "ED50 to WGS 84" in operation.name


def test_own_parameters_are_used():
    own = named("+proj=longlat +ellps=krass +towgs84=24,-141,-81,0,0.35,0.82,-0.12 +type=crs")
    operation = crs.find_operation(own, named("EPSG:4326"))
    assert "x=24 y=-141 z=-81" in operation.definition
    assert not operation.is_ballpark
    assert operation.accuracy_m is None


BRITISH = ("EPSG:4277", "EPSG:4326", (-3.0, 51.0, -1.0, 53.0))


def test_a_missing_grid_is_named():
    source, target, area = BRITISH
    with pytest.raises(OrientError, match=r"from \"OSGB36\" to \"WGS 84\" needs the grid uk_os_OSTN15") as caught:
        crs.find_operation(named(source), named(target), area=area)
    assert "allow-ballpark" in caught.value.hint
    assert "://" not in caught.value.message


def test_a_missing_grid_may_be_done_without():
    source, target, area = BRITISH
    operation = crs.find_operation(named(source), named(target), allow_ballpark=True, area=area)
    assert "helmert" in operation.definition
    assert operation.missing_grids == ("uk_os_OSTN15_NTv2_OSGBtoETRS.tif",)
    assert operation.accuracy_m is not None and operation.accuracy_m >= 1


def test_a_vertical_datum_needs_its_grid():
    with pytest.raises(OrientError, match="needs the grid us_nga_egm96"):
        crs.find_operation(named("EPSG:4326+5773"), named("EPSG:4979"))
    operation = crs.find_operation(named("EPSG:4326+5773"), named("EPSG:4979"), allow_ballpark=True)
    assert operation.is_ballpark


def test_a_figure_without_datum_is_a_ballpark():
    bare = crs.geographic_crs_of(KRASOVSKY)
    for pair in ((bare, named("EPSG:4326")), (named("EPSG:4284"), bare)):
        with pytest.raises(OrientError, match="only a ballpark operation is known"):
            crs.find_operation(*pair)
        assert crs.find_operation(*pair, allow_ballpark=True).is_ballpark


@pytest.mark.parametrize("ellipsoid", [KRASOVSKY, MOON, Ellipsoid("own", 2e6, 111.1)], ids=lambda e: e.name)
def test_figures_without_datum_go_together(ellipsoid):
    geographic = crs.geographic_crs_of(ellipsoid)
    geocentric = named(f"+proj=geocent {crs.figure(ellipsoid)} +units=m +type=crs")
    operation = crs.find_operation(geographic, geocentric)
    assert not operation.is_ballpark
    XYZ = operation.transform([23.0], [42.7], [550.0])
    expected = geocentric_from_geographic(np.radians(42.7), np.radians(23.0), 550.0, ellipsoid)
    np.testing.assert_allclose(np.ravel(XYZ), expected, rtol=0, atol=1e-6)
    figure = crs.figure(ellipsoid)
    grid = named(f"+proj=tmerc +lon_0=21 {figure} +units=m +type=crs")
    assert not crs.find_operation(grid, geographic).is_ballpark
    assert crs.find_operation(named(f"+proj=longlat {figure} +type=crs"), geographic).definition == "noop"


def test_different_bodies_do_not_mix():
    with pytest.raises(OrientError):
        crs.find_operation(named("IAU_2015:30100"), named("EPSG:4326"))
    with pytest.raises(OrientError, match="no operation"):
        crs.find_operation(named("IAU_2015:30100"), named("EPSG:4326"), allow_ballpark=True)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("EPSG:4807", "is in grad, not in degrees"),
        ("EPSG:2263", "is in US survey foot, not in metres"),
        ("EPSG:5773", "is not geographic, projected or geocentric"),
    ],
)
def test_units_other_than_degrees_and_metres_are_refused(text, message):
    with pytest.raises(OrientError, match=message):
        crs.find_operation(named(text), named("EPSG:4326"))


def test_a_point_that_cannot_be_transformed_is_named():
    operation = crs.find_operation(named("EPSG:4326"), named("EPSG:32634"))
    with pytest.raises(OrientError, match=r"point number 2 \(21, 95, 0\) cannot be transformed"):
        operation.transform([21.0, 21.0], [42.0, 95.0], 0.0)


def test_the_network_is_off():
    import pyproj.network

    assert not pyproj.network.is_network_enabled()
    assert isinstance(crs.geographic_crs_of(MOON), CRS)
