"""B: the camera file, and what else can be wrong in photo.toml."""

from tests.catalogue.case import Case, accepted, refused
from tests.intake.conftest import PHOTO


def spoiled(old: str, new: str) -> str:
    assert PHOTO.count(old) == 1
    return PHOTO.replace(old, new)


def after(heading: str, *lines: str) -> str:
    """The good photo.toml with lines added below a heading that it has."""
    return spoiled(f"[{heading}]\n", "\n".join([f"[{heading}]", *lines, ""]))


def added(text: str) -> str:
    return PHOTO + text


F, FRAME, SIGMA = "f_mm = 76.054", "frame_mm = [114.3, 114.3]", "sigma_image_mm = 0.007"
DISTORTION = "[camera.distortion]\n"
MARKS = '[fiducials]\ntransformation = "{}"\nmarks = {{ 1 = [-50, -50], 2 = {}, 3 = [50, 50], 4 = {} }}\n'

BAD = {
    "B1": ("[photo\nname = 1\n", "1: not valid TOML: Expected ']' at the end of a table declaration"),
    "B1-text": ("The camera had f = 76 mm.\n", "1: not valid TOML: Expected '=' after a key in a key/value pair"),
    "B2": (spoiled(F, F + "\n" + F), '9: key "f_mm" given twice'),
    "B2-table": (added("[camera]\n"), "17: table [camera] given twice"),
    "B3": (spoiled("frame_mm", "frame_nm"), None),
    "B3-table": (added("[pixel]\n"), '17: unknown key "pixel". Did you mean "pixels"?'),
    "B4-nan": (spoiled(F, "f_mm = nan"), "8: f_mm: must be a finite number"),
    "B4-inf": (spoiled(F, "f_mm = -inf"), "8: f_mm: must be a finite number"),
    "B5-zero": (spoiled(F, "f_mm = 0.0"), "8: f_mm: 0 mm is not in 0.1 … 100,000 mm"),
    "B5-negative": (spoiled(F, "f_mm = -76"), "8: f_mm: -76 mm is not in 0.1 … 100,000 mm"),
    "B5-small": (spoiled(F, "f_mm = 1e-9"), "8: f_mm: 1e-09 mm is not in 0.1 … 100,000 mm"),
    "B5-large": (spoiled(F, "f_mm = 1e9"), "8: f_mm: 1,000,000,000 mm is not in 0.1 … 100,000 mm"),
    "B6-both": (spoiled(F, F + "\nf_px = 5000"), "8: give f_mm or f_px, not both"),
    "B6-none": (spoiled(F, ""), "7: f_mm is missing in [camera]. Give f_mm or f_px"),
    "B6-unit": (spoiled(F, "f_px = 5000"), "8: f_px needs the size of a pixel. Give size_mm in [pixels]"),
    "B6-no-unit": (
        spoiled(F, "f = 76"),
        '7: f_mm is missing in [camera]. Give f_mm or f_px\nphoto.toml:8: unknown key "f"',
    ),
    "B7-text": (spoiled(F, 'f_mm = "152.3"'), "8: f_mm: expected a number, got text"),
    "B7-bool": (spoiled(F, "f_mm = true"), "8: f_mm: expected a number, got true or false"),
    "B7-date": (spoiled(F, "f_mm = 1971-07-31"), "8: f_mm: expected a number, got a date"),
    "B7-list": (spoiled(F, "f_mm = [1]"), "8: f_mm: expected a number, got a list"),
    "B7-table": (spoiled(F, "f_mm = { value = 76.0 }"), "8: f_mm: expected a number, got a table"),
    "B8-zero": (
        added("[pixels]\nsize_mm = 0\nimage = [10, 10]\n"),
        "18: size_mm: 0 mm is not in 0.00001 … 10 mm",
    ),
    "B8-metre": (
        added("[pixels]\nsize_mm = 1000\nimage = [10, 10]\n"),
        "18: size_mm: 1,000 mm is not in 0.00001 … 10 mm",
    ),
    "B8-negative": (
        added("[pixels]\nsize_mm = -0.01\nimage = [10, 10]\n"),
        "18: size_mm: -0.01 mm is not in 0.00001 … 10 mm",
    ),
    "B9-zero": (
        added("[pixels]\nsize_mm = 0.01\norigin_col = 0\norigin_row = 0\nimage = [0, 10]\n"),
        "21: image: 0 px is not in 1 … 1,000,000 px",
    ),
    "B9-huge": (
        added("[pixels]\nsize_mm = 0.01\norigin_col = 0\norigin_row = 0\nimage = [1_000_000_000, 10]\n"),
        "21: image: 1,000,000,000 px is not in 1 … 1,000,000 px",
    ),
    "B9-fraction": (
        added("[pixels]\nsize_mm = 0.01\norigin_col = 0\norigin_row = 0\nimage = [10.5, 10]\n"),
        "21: image: expected 2 whole numbers, columns and rows",
    ),
    "B9-missing": (
        added("[pixels]\nsize_mm = 0.01\n"),
        "17: image is missing: without it give origin_col and origin_row",
    ),
    "B10": (
        spoiled("x0_mm = -0.006", "x0_mm = 300"),
        "9: principal point (300, -0.002) mm lies more than two frame widths outside the frame",
    ),
    "B11": (
        added(DISTORTION + 'model = "brown"\ndirection = "correction"\nk1 = -2e-4\n'),
        "17: distortion: radius 40.8 mm and beyond is not invertible. "
        "Check the unit and the direction of the coefficients",
    ),
    "B12": (
        after("camera", "distortion = [1e-6, 0, 0, 0]"),
        "8: which distortion model? Write [camera.distortion] model = none, brown, opencv or radial_table",
    ),
    "B12-table": (
        added(DISTORTION + "k1 = 1e-6\n"),
        "17: which distortion model? Write model = none, brown, opencv or radial_table",
    ),
    "B12-direction": (
        added(DISTORTION + 'model = "brown"\nk1 = 1e-6\n'),
        "17: direction is required for the model brown: correction, displacement or ideal_to_distorted",
    ),
    "B12-opencv": (
        added(DISTORTION + 'model = "opencv"\nk1 = 1e-6\ndirection = "correction"\n'),
        "20: the model opencv means direction = ideal_to_distorted. Leave the direction out",
    ),
    "B12-no-table": (
        added(DISTORTION + 'model = "radial_table"\n'),
        "17: table: expected at least 2 rows of radius and distortion. "
        "Write table = [[r_mm, d_mm], ...], radii growing",
    ),
    "B12-table-order": (
        added(DISTORTION + 'model = "radial_table"\ntable = [[0, 0], [50, 0.01], [20, 0.005]]\n'),
        "19: table: the radii do not grow. Write table = [[r_mm, d_mm], ...], radii growing",
    ),
    "B13": (spoiled(F, "f_mm = " + "7" * 5000), "8: not a number: more than 4,300 digits"),
    "B13-float": (spoiled(F, "f_mm = " + "7" * 4000), "8: f_mm: number is too large"),
    "B14": ("a = " + "[" * 20_000, "nested too deeply"),
    "B14-dots": ("a" + ".a" * 24_000 + " = 1", "1: nested too deeply"),
    "B14-table": ("[" + "a . " * 12_000 + "a]", "1: nested too deeply"),
    "B15": ("#" * 2_000_000, "larger than 1 MB, not a description of a camera, sheet or control"),
    "B16-zero": (
        after("camera", "sigma_f_mm = 0"),
        "8: sigma_f_mm: must be > 0. Leave it out for a value that is taken as known",
    ),
    "B16-negative": (
        after("camera", "sigma_x0_mm = -0.01"),
        "8: sigma_x0_mm: must be > 0. Leave it out for a value that is taken as known",
    ),
    "B16-image": (spoiled(SIGMA, "sigma_image_mm = 0"), "12: sigma_image_mm: must be > 0"),
    "B17-toml": (spoiled("1971-07-31", "1971-02-31"), "3: not a date"),
    "B17-text": (spoiled("1971-07-31", '"1971-02-31"'), "3: date: not a date. Write 1971-07-31, 1971-07 or 1971"),
    "B17-year-0": (spoiled("1971-07-31", '"0000-07-31"'), "3: date: not a date. Write 1971-07-31, 1971-07 or 1971"),
    "B18": (
        added("[station]\nB_deg = 25\nL_deg = 3\nH_m = 103000\nangles_deg = [1, 2, 3]\n"),
        "21: angle_convention is required: opk, aok or azk",
    ),
    "B18-word": (
        added('[station]\nangles_deg = [1, 2, 3]\nangle_convention = "pok"\n'),
        '19: angle_convention: "pok" is not one of opk, aok, azk',
    ),
    "B19-few": (
        added("[fiducials]\nmarks = { 1 = [0, 0], 2 = [1, 1] }\n"),
        "18: fiducial marks: need 3 that do not lie on a line",
    ),
    "B19-none": (added("[fiducials]\nmarks = {}\n"), "18: fiducial marks: need 3 that do not lie on a line"),
    "B19-one": (
        added('[fiducials]\ntransformation = "similarity"\nmarks = { 1 = [0, 0] }\n'),
        "19: fiducial marks: need 2 at different places",
    ),
    "B19-line": (
        added("[fiducials]\nmarks = { 1 = [0, 0], 2 = [1, 1], 3 = [5, 5.000001] }\n"),
        "18: fiducial marks: need 3 that do not lie on a line",
    ),
    "B19-twice": (
        added(MARKS.format("affine", "[-50, 50]", "[50, 50]")),
        "19: fiducial marks: need 3 that do not lie on a line",
    ),
    "B19-projective": (
        added(MARKS.format("projective", "[0, 0]", "[50, -50]")),
        "19: fiducial marks: need 4, no 3 of them on a line",
    ),
    "B19-mark": (
        added("[fiducials]\nmarks = { 1 = [0], 2 = [1, 1], 3 = [5, 4] }\n"),
        '18: mark "1": expected [x, y] in mm',
    ),
    "platform": (
        spoiled('platform = "space"\n', ""),
        "1: platform is missing in [photo]. Give one of space, aerial, terrestrial",
    ),
    "platform-word": (spoiled('"space"', '"drone"'), '5: platform: "drone" is not one of space, aerial, terrestrial'),
    "name": (
        spoiled('"AS15-M-0585"', '"a/b"'),
        '2: name: contains "/"; allowed are letters, digits, space and . _ - +',
    ),
    "image-escape": (
        spoiled('"as15-m-0585.tif"', '"\\u001b[2Jx"'),
        '4: image: "\\x1b[2Jx" contains a control or hidden character',
    ),
    "frame": (
        spoiled(FRAME, ""),
        "7: frame_mm is missing in [camera]. Give frame_mm = [width, height], or size_mm and image in [pixels]",
    ),
    "ground-none": (
        spoiled("a_m = 1737400\ninverse_flattening = 0\n", ""),
        '14: ground: give one of crs, ellipsoid, local. Write crs = "EPSG:4284", ellipsoid = "krasovsky", '
        'a_m and inverse_flattening, or local = "right"',
    ),
    "ground-two": (
        after("ground", 'local = "right"'),
        '14: ground: give one of crs, ellipsoid, local, not several. Write crs = "EPSG:4284", '
        'ellipsoid = "krasovsky", a_m and inverse_flattening, or local = "right"',
    ),
    "ground-half": (
        spoiled("inverse_flattening = 0\n", ""),
        "14: inverse_flattening is missing in [ground]. Give both; inverse_flattening = 0 for a sphere",
    ),
    "ground-flattening": (
        spoiled("inverse_flattening = 0\n", "inverse_flattening = 0.00335\n"),
        "16: inverse_flattening: 0.00335 is neither 0 (a sphere) nor 2 or more. Krasovsky has 298.3",
    ),
    "C9-unknown": (
        spoiled("a_m = 1737400\ninverse_flattening = 0\n", 'crs = "EPSG:999999"\n'),
        '15: crs: unknown coordinate system "EPSG:999999". Write an authority code such as "EPSG:4284"',
    ),
    "C9-long": (
        spoiled("a_m = 1737400\ninverse_flattening = 0\n", f'crs = "{"E" * 200}"\n'),
        '15: crs: longer than 60 characters. Write an authority code such as "EPSG:4284"',
    ),
    "C9-grid": (
        spoiled("a_m = 1737400\ninverse_flattening = 0\n", 'crs = "+proj=longlat +nadgrids=/etc/passwd"\n'),
        '15: crs: "+proj=longlat +nadgrids=/etc/passwd" is refused. Write an authority code such as "EPSG:4284"',
    ),
    "C8-projected-ground": (
        spoiled("a_m = 1737400\ninverse_flattening = 0\n", 'crs = "EPSG:25832"\n'),
        "15: crs: EPSG:25832 is projected. The ground needs a geographic system of B, L (and H)",
    ),
    "ellipsoid": (spoiled("a_m = 1737400\ninverse_flattening = 0\n", 'ellipsoid = "potato"\n'), None),
    "C12": (after("ground", "height_m = -20000"), "15: height_m: -20,000 m is not in -12,000 … 1,000,000 m"),
    "A36-meridian": (after("ground", "central_meridian_deg = 400"), None),
    "station-half": (
        added("[station]\nB_deg = 25\n"),
        "17: station: give B_deg, L_deg, H_m or X_m, Y_m, Z_m",
    ),
    "refraction": (
        added('[refraction]\nmodel = "ardc"\ncamera_height_m = 8000\n'),
        "18: refraction needs the heights of the camera and of the ground. "
        "Give camera_height_m (or the station) and height_m in [ground]",
    ),
}

PARTS = {
    "B3": ['photo.toml:11: unknown key "frame_nm". Did you mean "frame_mm"?'],
    "ellipsoid": ['photo.toml:15: ellipsoid: "potato" is not a known ellipsoid.'],
    "A36-meridian": ["photo.toml:15: central_meridian_deg: 400 is not in -360 … 360. Grads? Write degrees"],
}

STATION_ANGLES = '[station]\nangles_deg = [1, 2, 3]\nangle_convention = "{}"\n'

CASES: dict[str, Case] = {
    **{
        case: refused(("photo.toml:" if message[0].isdigit() else "photo.toml: ") + message, photo=text)
        for case, (text, message) in BAD.items()
        if message is not None
    },
    **{case: Case(files={"photo.toml": BAD[case][0]}, says=parts) for case, parts in PARTS.items()},
    "B10 outside": accepted(
        says=["warning: photo.toml: principal point (60, -0.002) mm lies outside the frame"],
        photo=spoiled("x0_mm = -0.006", "x0_mm = 60"),
    ),
    "B18 told": accepted(says=["angles"], photo=added(STATION_ANGLES.format("opk"))),
    "photo missing": Case(
        files={"photo.toml": None}, code=2, says=["no photo.toml in this folder. Give a folder that holds one"]
    ),
}
