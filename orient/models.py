"""The tables of a project file. Imports nothing of orient.

A row belongs to one run of a stage (`run_id`) and is never changed. Column names carry the unit; a coordinate that is
not known is NULL. Letters are those of the papers: B, L, H geodetic latitude, longitude, ellipsoidal height; X, Y, Z
of T and T' are north, east, up (docs/conventions.md). Docstrings and comments become docs/schema.md.
"""

from typing import Any

from sqlalchemy import (
    REAL,
    TEXT,
    CheckConstraint,
    ForeignKey,
    Index,
    Integer,
    LargeBinary,
    MetaData,
    UniqueConstraint,
)
from sqlalchemy.orm import DeclarativeBase, Mapped, mapped_column

SCHEMA_VERSION = 3
APPLICATION_ID = 0x4F524E54
REAL_LIMIT = "1e15"
IMAGE_PART_BYTES = 2**20

NAMES = {
    "pk": "pk_%(table_name)s",
    "fk": "fk_%(table_name)s_%(column_0_name)s",
    "uq": "uq_%(table_name)s_%(column_0_N_name)s",
    "ck": "ck_%(table_name)s_%(constraint_name)s",
    "ix": "ix_%(table_name)s_%(column_0_N_name)s",
}


class Base(DeclarativeBase):
    metadata = MetaData(naming_convention=NAMES)


def real(comment: str, **options: Any) -> Any:
    return mapped_column(REAL, comment=comment, **options)


def text(comment: str, **options: Any) -> Any:
    return mapped_column(TEXT, comment=comment, **options)


def whole(comment: str, **options: Any) -> Any:
    return mapped_column(Integer, comment=comment, **options)


def run_id() -> Any:
    return mapped_column(ForeignKey("stage_run.run_id"), primary_key=True, comment="the run that wrote the row")


def one_of(column: str, *words: str) -> CheckConstraint:
    choices = ", ".join(f"'{word}'" for word in words)
    return CheckConstraint(f"{column} IN ({choices})", name=column)


# ---------------------------------------------------------------------------------------------- the ledger


class StageRun(Base):
    """One run of one stage: an imported list or a computed result. Versions count from 1 within a stage."""

    __tablename__ = "stage_run"
    __table_args__ = (
        UniqueConstraint("stage", "version"),
        Index(None, "input_digest"),
    )
    run_id: Mapped[int] = whole("number of the run in the file", primary_key=True)
    stage: Mapped[str] = text("photo, readings, sheet, control, model, refine, digitize, bl, ...")
    version: Mapped[int] = whole("version within the stage, 1, 2, ...")
    stage_version: Mapped[int] = whole("version of the computation; a change of it can change numbers")
    settings: Mapped[str] = text("settings as canonical JSON")
    input_digest: Mapped[str] = text("sha256 over stage, stage_version, settings and the inputs' output digests")
    actor: Mapped[str] = text("who ran it")
    reason: Mapped[str] = text("why, in the words of the actor")
    tool_version: Mapped[str] = text("versions of orient, Python, SQLite, numpy, scipy, pyproj; kind of processor")
    started_at: Mapped[str] = text("UTC, ISO 8601; a decoration: run_id is the order")


class RunInput(Base):
    """Which runs a run has read. `input_run_id < run_id`, so the graph has no cycle."""

    __tablename__ = "run_input"
    __table_args__ = (
        CheckConstraint("input_run_id < run_id", name="earlier"),
        Index(None, "input_run_id"),
    )
    run_id: Mapped[int] = run_id()
    role: Mapped[str] = text("the stage that the input came from", primary_key=True)
    input_run_id: Mapped[int] = mapped_column(ForeignKey("stage_run.run_id"), comment="the run that was read")


class RunSeal(Base):
    """The end of a run: how it ended and the digest of everything it stored. A sealed run takes no more rows."""

    __tablename__ = "run_seal"
    __table_args__ = (one_of("status", "succeeded", "failed"),)
    run_id: Mapped[int] = run_id()
    status: Mapped[str] = text("succeeded | failed")
    row_count: Mapped[int] = whole("rows that the run stored in all tables together")
    output_digest: Mapped[str] = text("sha256 over all rows of the run")
    summary: Mapped[str] = text("the result in one line")
    error: Mapped[str] = text("empty, or why the run failed")
    sealed_at: Mapped[str] = text("UTC, ISO 8601")
    record_digest: Mapped[str] = text("sha256 over the run's header, inputs, seal and the record before: a chain")


class Selection(Base):
    """Which version of a stage is current: the newest row of the stage. Going back, or withdrawing it, adds a row."""

    __tablename__ = "selection"
    __table_args__ = (Index(None, "stage", "selection_id"),)
    selection_id: Mapped[int] = whole("order of the selections", primary_key=True)
    stage: Mapped[str] = text("stage whose head moves")
    run_id: Mapped[int | None] = mapped_column(
        ForeignKey("stage_run.run_id"), comment="the run that becomes current; empty: from here on none is"
    )
    actor: Mapped[str] = text("who selected it")
    reason: Mapped[str] = text("why")
    selected_at: Mapped[str] = text("UTC, ISO 8601")
    after_run_id: Mapped[int] = whole("newest run of the file at that moment: the order among runs")
    record_digest: Mapped[str] = text("sha256 over this row and the record before: a chain")


class RunEvent(Base):
    """Remarks, warnings and errors of a run (the papers' table `er`)."""

    __tablename__ = "run_event"
    __table_args__ = (one_of("severity", "info", "warning", "error"),)
    run_id: Mapped[int] = run_id()
    seq: Mapped[int] = whole("order within the run", primary_key=True)
    severity: Mapped[str] = text("info | warning | error")
    code: Mapped[str] = text("stable word for programs, e.g. cycle_outlier")
    subject: Mapped[str] = text("point, sheet or unknown that is meant; empty for the whole run")
    message: Mapped[str] = text("the sentence for people")
    value: Mapped[float | None] = real("number that belongs to the message")


# ---------------------------------------------------------------------------------------------- photo


class Photo(Base):
    """The photo, its camera, the ground it shows and what is known before the orientation."""

    __tablename__ = "photo"
    __table_args__ = (
        one_of("platform", "space", "aerial", "terrestrial"),
        one_of("ground_kind", "crs", "ellipsoid", "local"),
        one_of("refraction", "none", "integral", "ardc", "space"),
        one_of("distortion_model", "none", "brown", "opencv", "radial_table"),
        one_of("distortion_direction", "none", "correction", "ideal_to_distorted", "displacement"),
        one_of("interior_transformation", "none", "similarity", "affine", "projective"),
        one_of("x_axis", "right", "left"),
        one_of("y_axis", "up", "down"),
    )
    run_id: Mapped[int] = run_id()
    name: Mapped[str] = text("name of the photo")
    taken_on: Mapped[str | None] = text("date, ISO 8601")
    image_file: Mapped[str | None] = text("name of the image file; shown as text, never opened by itself")
    platform: Mapped[str] = text("space | aerial | terrestrial")
    f_mm: Mapped[float] = real("focal length (principal distance)")
    x0_mm: Mapped[float] = real("principal point in the fiducial (or pixel-frame) system")
    y0_mm: Mapped[float] = real("principal point in the fiducial (or pixel-frame) system")
    sigma_f_mm: Mapped[float | None] = real("standard deviation of f; NULL = taken as known")
    sigma_x0_mm: Mapped[float | None] = real("standard deviation of x0; NULL = taken as known")
    sigma_y0_mm: Mapped[float | None] = real("standard deviation of y0; NULL = taken as known")
    frame_width_mm: Mapped[float] = real("width of the frame")
    frame_height_mm: Mapped[float] = real("height of the frame")
    sigma_image_mm: Mapped[float] = real("a-priori standard deviation of one reading of an image coordinate")
    pixel_size_mm: Mapped[float | None] = real("size of a pixel when readings are in pixels")
    origin_col_px: Mapped[float | None] = real("column of the frame origin (x = 0)")
    origin_row_px: Mapped[float | None] = real("row of the frame origin (y = 0)")
    x_axis: Mapped[str] = text("direction of +x in the pixel image: right | left")
    y_axis: Mapped[str] = text("direction of +y in the pixel image: up | down")
    image_width_px: Mapped[int | None] = whole("columns of the image")
    image_height_px: Mapped[int | None] = whole("rows of the image")
    interior_transformation: Mapped[str] = text("to the fiducial system: none | similarity | affine | projective")
    distortion_model: Mapped[str] = text("none | brown | opencv | radial_table")
    distortion_direction: Mapped[str] = text(
        "correction: added to measured | displacement: taken from measured | ideal_to_distorted"
    )
    refraction: Mapped[str] = text("none | integral | ardc | space")
    ground_kind: Mapped[str] = text("crs: a named datum | ellipsoid: a figure without datum | local: Cartesian metres")
    ground_crs: Mapped[str | None] = text("geographic CRS of B, L, H (authority code)")
    ellipsoid: Mapped[str | None] = text("name of the ellipsoid")
    a_m: Mapped[float | None] = real("semi-major axis")
    inverse_flattening: Mapped[float | None] = real("1/f of the ellipsoid; 0 for a sphere")
    central_meridian_deg: Mapped[float | None] = real("central meridian L0 of the map zone; NULL: T' = T")
    handedness: Mapped[str | None] = text("of local Cartesian ground: right | left")
    ground_height_m: Mapped[float | None] = real("mean ellipsoidal height of the ground, for refraction and curvature")
    camera_height_m: Mapped[float | None] = real("approximate height of the camera, for refraction and curvature")
    curvature_radius_m: Mapped[float | None] = real("radius of the datum under a local map plane; NULL = no correction")
    station_B_deg: Mapped[float | None] = real("approximate station, latitude")
    station_L_deg: Mapped[float | None] = real("approximate station, longitude")
    station_H_m: Mapped[float | None] = real("approximate station, ellipsoidal height")
    station_X_m: Mapped[float | None] = real("approximate station, local Cartesian or geocentric")
    station_Y_m: Mapped[float | None] = real("approximate station, local Cartesian or geocentric")
    station_Z_m: Mapped[float | None] = real("approximate station, local Cartesian or geocentric")


class DistortionCoefficient(Base):
    """Coefficients of the named distortion model."""

    __tablename__ = "distortion_coefficient"
    run_id: Mapped[int] = run_id()
    name: Mapped[str] = text("k0 k1 k2 k3 (radial) p1 p2 (decentring) s1 s2 s3 s4 (thin prism)", primary_key=True)
    value: Mapped[float] = real("in powers of mm (brown) or of the normalised coordinate (opencv)")


class CameraSigma(Base):
    """Standard deviations of distortion coefficients; those of f, x0, y0 stand in `photo`."""

    __tablename__ = "camera_sigma"
    run_id: Mapped[int] = run_id()
    name: Mapped[str] = text("k1 k2 k3 p1 p2", primary_key=True)
    sigma: Mapped[float] = real("in the unit of the coefficient")


class KnownElement(Base):
    """What is known of the camera's place and attitude beforehand, with or without error ([known] of photo.toml)."""

    __tablename__ = "known_element"
    __table_args__ = (one_of("unit", "m", "deg"),)
    run_id: Mapped[int] = run_id()
    quantity: Mapped[str] = text("X_S Y_S Z_S (local ground) | B_S L_S H_S | aok_alpha ... opk_kappa", primary_key=True)
    unit: Mapped[str] = text("m | deg: of the value")
    value: Mapped[float] = real("value; metres for X_S, Y_S, Z_S, H_S, degrees else")
    sigma: Mapped[float | None] = real("m (north for B_S, east for L_S), deg for an angle; NULL = without error")


class DistortionRadial(Base):
    """A camera certificate's table of radial distortion."""

    __tablename__ = "distortion_radial"
    run_id: Mapped[int] = run_id()
    radius_mm: Mapped[float] = real("distance from the principal point", primary_key=True)
    distortion_mm: Mapped[float] = real("displacement, positive outward; corrected r = r - D(r)")


class FiducialMark(Base):
    """Calibrated coordinates of the fiducial marks."""

    __tablename__ = "fiducial_mark"
    run_id: Mapped[int] = run_id()
    mark: Mapped[str] = text("name of the mark", primary_key=True)
    x_mm: Mapped[float] = real("x, right")
    y_mm: Mapped[float] = real("y, up")


# ---------------------------------------------------------------------------------------------- lists


class ComparatorReading(Base):
    """Readings on the photo in cycles (the papers' table `stereo`), in mm or in pixels."""

    __tablename__ = "comparator_reading"
    __table_args__ = (
        one_of("kind", "point", "fiducial"),
        CheckConstraint(
            "(x_mm IS NULL) = (y_mm IS NULL) AND (col_px IS NULL) = (row_px IS NULL) "
            "AND (x_mm IS NULL) <> (col_px IS NULL)",
            name="mm_or_px",
        ),
        Index(None, "run_id", "point"),
    )
    run_id: Mapped[int] = run_id()
    seq: Mapped[int] = whole("order in the file", primary_key=True)
    point: Mapped[str] = text("point or fiducial mark")
    kind: Mapped[str] = text("point | fiducial")
    cycle: Mapped[int] = whole("cycle of measurement, 1, 2, ...")
    x_mm: Mapped[float | None] = real("comparator x")
    y_mm: Mapped[float | None] = real("comparator y")
    col_px: Mapped[float | None] = real("image column")
    row_px: Mapped[float | None] = real("image row, downwards")
    sigma: Mapped[float | None] = real("standard deviation of the reading, in its own unit; NULL = a priori")


class MapSheet(Base):
    """A map sheet on the digitiser."""

    __tablename__ = "map_sheet"
    run_id: Mapped[int] = run_id()
    sheet: Mapped[str] = text("name of the sheet", primary_key=True)
    title: Mapped[str] = text("what the sheet is")
    crs: Mapped[str | None] = text("CRS of the graticule or grid; NULL = the photo's ground")
    degree: Mapped[int | None] = whole("degree of the polynomial; NULL = chosen (setting `choice` of digitize)")
    sigma_mm: Mapped[float | None] = real("standard deviation of one digitiser reading; NULL = from the fit")
    pixel_size_mm: Mapped[float | None] = real("size of a pixel when the sheet was read from a scan")


class GraticuleCross(Base):
    """Crosses of the graticule or grid, read on the digitiser (the papers' table `tt`)."""

    __tablename__ = "graticule_cross"
    __table_args__ = (
        one_of("role", "fit", "check"),
        CheckConstraint("(B_deg IS NULL) <> (E_m IS NULL)", name="geographic_or_grid"),
        Index(None, "run_id", "sheet"),
    )
    run_id: Mapped[int] = run_id()
    seq: Mapped[int] = whole("order in the file", primary_key=True)
    sheet: Mapped[str] = text("sheet")
    cross: Mapped[str] = text("name of the cross, unique on the sheet")
    role: Mapped[str] = text("fit: carries the polynomial | check: only compared")
    X_mm: Mapped[float] = real("digitiser X, right")
    Y_mm: Mapped[float] = real("digitiser Y, up")
    B_deg: Mapped[float | None] = real("latitude")
    L_deg: Mapped[float | None] = real("longitude")
    E_m: Mapped[float | None] = real("easting")
    N_m: Mapped[float | None] = real("northing")


class DigitizerReading(Base):
    """Readings of map points on the digitiser, in cycles (the papers' table `rg`)."""

    __tablename__ = "digitizer_reading"
    __table_args__ = (Index(None, "run_id", "sheet", "point"),)
    run_id: Mapped[int] = run_id()
    seq: Mapped[int] = whole("order in the file", primary_key=True)
    sheet: Mapped[str] = text("sheet")
    point: Mapped[str] = text("point")
    cycle: Mapped[int] = whole("cycle of measurement")
    X_mm: Mapped[float] = real("digitiser X, right")
    Y_mm: Mapped[float] = real("digitiser Y, up")
    H_m: Mapped[float | None] = real("ellipsoidal height of the point")
    sigma_H_m: Mapped[float | None] = real("standard deviation of the height; NULL = taken as known")


class ControlPoint(Base):
    """Points with known coordinates, as given. NULL coordinates are unknown (plan-only, height-only)."""

    __tablename__ = "control_point"
    __table_args__ = (
        one_of("role", "control", "check"),
        one_of("kind", "geographic", "projected", "geocentric", "local", "none"),
    )
    run_id: Mapped[int] = run_id()
    point: Mapped[str] = text("point", primary_key=True)
    role: Mapped[str] = text("control: carries the orientation | check: only compared")
    kind: Mapped[str] = text("geographic | projected | geocentric | local | none (coordinates from a sheet)")
    B_deg: Mapped[float | None] = real("latitude")
    L_deg: Mapped[float | None] = real("longitude")
    E_m: Mapped[float | None] = real("easting")
    N_m: Mapped[float | None] = real("northing")
    H_m: Mapped[float | None] = real("ellipsoidal height, or the third coordinate of the stated compound CRS")
    X_m: Mapped[float | None] = real("geocentric or local X")
    Y_m: Mapped[float | None] = real("geocentric or local Y")
    Z_m: Mapped[float | None] = real("geocentric or local Z")
    cov_XX_m2: Mapped[float | None] = real("covariance; X, Y, Z of geocentric or local points, else north, east, up")
    cov_XY_m2: Mapped[float | None] = real("covariance")
    cov_XZ_m2: Mapped[float | None] = real("covariance")
    cov_YY_m2: Mapped[float | None] = real("covariance")
    cov_YZ_m2: Mapped[float | None] = real("covariance")
    cov_ZZ_m2: Mapped[float | None] = real("covariance; all NULL = taken as known")


class ControlSystem(Base):
    """The coordinate system in which the control points are given."""

    __tablename__ = "control_system"
    run_id: Mapped[int] = run_id()
    crs: Mapped[str | None] = text("CRS of the coordinates; NULL = the photo's ground")
    handedness: Mapped[str | None] = text("of local Cartesian coordinates: right | left")


class ModelPoint(Base):
    """Points of a photogrammetric model, by zone (for the absolute orientation).

    The six covariances are all there, or none of them: then --sigma-model holds, or the model is without error.
    """

    __tablename__ = "model_point"
    __table_args__ = (
        CheckConstraint(
            "(cov_xx IS NULL) + (cov_xy IS NULL) + (cov_xz IS NULL) + (cov_yy IS NULL) + (cov_yz IS NULL) "
            "+ (cov_zz IS NULL) IN (0, 6)",
            name="covariance",
        ),
    )
    run_id: Mapped[int] = run_id()
    zone: Mapped[str] = text("group of photos with its own seven parameters", primary_key=True)
    point: Mapped[str] = text("point", primary_key=True)
    x: Mapped[float] = real("model x")
    y: Mapped[float] = real("model y")
    z: Mapped[float] = real("model z")
    cov_xx: Mapped[float | None] = real("covariance of the model coordinates, model units squared")
    cov_xy: Mapped[float | None] = real("covariance of the model coordinates, model units squared")
    cov_xz: Mapped[float | None] = real("covariance of the model coordinates, model units squared")
    cov_yy: Mapped[float | None] = real("covariance of the model coordinates, model units squared")
    cov_yz: Mapped[float | None] = real("covariance of the model coordinates, model units squared")
    cov_zz: Mapped[float | None] = real("covariance of the model coordinates, model units squared")


# ---------------------------------------------------------------------------------------------- refine


class CycleResidual(Base):
    """Deviation of each reading from the mean of its cycles."""

    __tablename__ = "cycle_residual"
    __table_args__ = (Index(None, "run_id", "point"),)
    run_id: Mapped[int] = run_id()
    seq: Mapped[int] = whole("seq of the comparator reading", primary_key=True)
    point: Mapped[str] = text("point or fiducial mark")
    kind: Mapped[str] = text("point | fiducial")
    cycle: Mapped[int] = whole("cycle")
    vx_mm: Mapped[float] = real("mean minus reading")
    vy_mm: Mapped[float] = real("mean minus reading")
    statistic: Mapped[float | None] = real("largest studentised deviation of the reading; NULL if it is single")
    is_outlier: Mapped[int] = whole("1 if beyond the critical value")
    is_used: Mapped[int] = whole("1 if it is part of the mean")


class InteriorOrientation(Base):
    """The transformation from the comparator to the fiducial system."""

    __tablename__ = "interior_orientation"
    run_id: Mapped[int] = run_id()
    transformation: Mapped[str] = text("similarity | affine | projective")
    n_marks: Mapped[int] = whole("fiducial marks used")
    redundancy: Mapped[int] = whole("equations minus parameters")
    sigma0_mm: Mapped[float | None] = real("standard deviation of unit weight; NULL without redundancy")


class InteriorParameter(Base):
    """Parameters of the interior orientation."""

    __tablename__ = "interior_parameter"
    run_id: Mapped[int] = run_id()
    name: Mapped[str] = text("a0 a1 a2 b0 b1 b2 (c1 c2): x = a0 + a1 X + a2 Y, y = b0 + b1 X + b2 Y", primary_key=True)
    value: Mapped[float] = real("value")
    sigma: Mapped[float | None] = real("standard deviation")


class InteriorCovariance(Base):
    """Covariance matrix of the parameters of the interior orientation, packed upper triangle by index IJ.

    Variance of a mark (the larger of sigma0^2 of the fit and the variance of its mean reading) times the cofactors.
    """

    __tablename__ = "interior_covariance"
    run_id: Mapped[int] = run_id()
    IJ: Mapped[int] = whole("(i-1)(2u-i)/2 + j, i <= j, from 1 (seed 000, equation (10))", primary_key=True)
    i: Mapped[int] = whole("row, from 1")
    j: Mapped[int] = whole("column, from 1")
    unknown_i: Mapped[str] = text("name of the parameter of the row")
    unknown_j: Mapped[str] = text("name of the parameter of the column")
    value: Mapped[float] = real("covariance, in the units of the parameters")


class FiducialResidual(Base):
    """Residuals at the fiducial marks."""

    __tablename__ = "fiducial_residual"
    run_id: Mapped[int] = run_id()
    mark: Mapped[str] = text("mark", primary_key=True)
    x_mm: Mapped[float] = real("transformed x")
    y_mm: Mapped[float] = real("transformed y")
    vx_mm: Mapped[float] = real("transformed minus calibrated")
    vy_mm: Mapped[float] = real("transformed minus calibrated")


class ImagePoint(Base):
    """Image coordinates (the papers' table `xy`) with each correction in its own column.

    x_mm = x_frame_mm + dx_principal_mm + dx_distortion_mm + dx_refraction_mm + dx_curvature_mm, likewise y.
    """

    __tablename__ = "image_point"
    run_id: Mapped[int] = run_id()
    point: Mapped[str] = text("point", primary_key=True)
    n_cycles: Mapped[int] = whole("readings in the mean")
    x_comparator_mm: Mapped[float] = real("mean of the cycles (pixels already as mm)")
    y_comparator_mm: Mapped[float] = real("mean of the cycles (pixels already as mm)")
    sigma_cycles_mm: Mapped[float | None] = real("standard deviation of one reading from the spread of the cycles")
    x_frame_mm: Mapped[float] = real("after the interior orientation")
    y_frame_mm: Mapped[float] = real("after the interior orientation")
    dx_principal_mm: Mapped[float] = real("reduction to the principal point")
    dy_principal_mm: Mapped[float] = real("reduction to the principal point")
    dx_distortion_mm: Mapped[float] = real("correction for lens distortion")
    dy_distortion_mm: Mapped[float] = real("correction for lens distortion")
    dx_refraction_mm: Mapped[float] = real("correction for atmospheric refraction")
    dy_refraction_mm: Mapped[float] = real("correction for atmospheric refraction")
    dx_curvature_mm: Mapped[float] = real("correction for earth curvature, for control on a map plane")
    dy_curvature_mm: Mapped[float] = real("correction for earth curvature, for control on a map plane")
    x_mm: Mapped[float] = real("image coordinate, origin at the principal point, x right")
    y_mm: Mapped[float] = real("image coordinate, origin at the principal point, y up")
    cov_xx_mm2: Mapped[float] = real("covariance of x, y")
    cov_xy_mm2: Mapped[float] = real("covariance of x, y")
    cov_yy_mm2: Mapped[float] = real("covariance of x, y")


# ---------------------------------------------------------------------------------------------- digitize


class SheetTransform(Base):
    """The polynomial of a sheet: u = (X - X0)/scale, v = (Y - Y0)/scale; coordinate = sum of c_jk u^j v^k."""

    __tablename__ = "sheet_transform"
    __table_args__ = (one_of("target", "geographic", "grid"),)
    run_id: Mapped[int] = run_id()
    sheet: Mapped[str] = text("sheet", primary_key=True)
    degree: Mapped[int] = whole("degree of the polynomial")
    degree_chosen_by: Mapped[str] = text("given | f-test | leave-one-out")
    target: Mapped[str] = text("geographic: B, L in degrees | grid: N, E in metres")
    crs: Mapped[str | None] = text("CRS of the target; NULL = the photo's ground")
    X0_mm: Mapped[float] = real("centre of the crosses")
    Y0_mm: Mapped[float] = real("centre of the crosses")
    scale_mm: Mapped[float] = real("half the extent of the crosses")
    n_crosses: Mapped[int] = whole("crosses that carry the fit")
    redundancy: Mapped[int] = whole("crosses minus coefficients, for each coordinate")
    sigma0_N_m: Mapped[float | None] = real("standard deviation of a cross northwards; NULL without redundancy")
    sigma0_E_m: Mapped[float | None] = real("standard deviation of a cross eastwards; NULL without redundancy")


class SheetCoefficient(Base):
    """Coefficients of the sheet polynomials (seed 004, equation (1))."""

    __tablename__ = "sheet_coefficient"
    __table_args__ = (one_of("coordinate", "B", "L", "N", "E"),)
    run_id: Mapped[int] = run_id()
    sheet: Mapped[str] = text("sheet", primary_key=True)
    coordinate: Mapped[str] = text("B or N; L or E", primary_key=True)
    power_u: Mapped[int] = whole("j of u^j v^k", primary_key=True)
    power_v: Mapped[int] = whole("k of u^j v^k", primary_key=True)
    value: Mapped[float] = real("coefficient, degrees (B, L) or metres (N, E)")
    sigma: Mapped[float | None] = real("standard deviation, same unit")


class SheetCofactor(Base):
    """Cofactor matrix of the coefficients of a sheet, the same for both coordinates, packed by index IJ."""

    __tablename__ = "sheet_cofactor"
    run_id: Mapped[int] = run_id()
    sheet: Mapped[str] = text("sheet", primary_key=True)
    IJ: Mapped[int] = whole("(i-1)(2u-i)/2 + j, i <= j, from 1 (seed 000, equation (10))", primary_key=True)
    i: Mapped[int] = whole("row")
    j: Mapped[int] = whole("column")
    value: Mapped[float] = real("cofactor")


class CrossResidual(Base):
    """Residuals of the crosses, in metres on the ground."""

    __tablename__ = "cross_residual"
    run_id: Mapped[int] = run_id()
    sheet: Mapped[str] = text("sheet", primary_key=True)
    cross: Mapped[str] = text("cross", primary_key=True)
    role: Mapped[str] = text("fit | check | rejected")
    v_N_m: Mapped[float] = real("polynomial minus given, northwards")
    v_E_m: Mapped[float] = real("polynomial minus given, eastwards")
    redundancy_number: Mapped[float | None] = real("share of an error of the cross that shows in its residual")
    statistic: Mapped[float | None] = real("F of the hypothesis that only this cross is wrong")
    probability: Mapped[float | None] = real("chance of so large a statistic without an error")
    is_suspect: Mapped[int] = whole("1 if it is named as a bad cross")


class DigitizedPoint(Base):
    """Map points by the polynomial of their sheet."""

    __tablename__ = "digitized_point"
    run_id: Mapped[int] = run_id()
    sheet: Mapped[str] = text("sheet", primary_key=True)
    point: Mapped[str] = text("point", primary_key=True)
    n_cycles: Mapped[int] = whole("readings in the mean")
    X_mm: Mapped[float] = real("mean digitiser X")
    Y_mm: Mapped[float] = real("mean digitiser Y")
    sigma_cycles_mm: Mapped[float | None] = real("standard deviation of one reading from the spread of the cycles")
    B_deg: Mapped[float | None] = real("latitude; NULL on a grid sheet")
    L_deg: Mapped[float | None] = real("longitude; NULL on a grid sheet")
    E_m: Mapped[float | None] = real("easting; NULL on a graticule sheet")
    N_m: Mapped[float | None] = real("northing; NULL on a graticule sheet")
    H_m: Mapped[float | None] = real("ellipsoidal height")
    cov_NN_m2: Mapped[float] = real("covariance of the plan position, north, east")
    cov_NE_m2: Mapped[float] = real("covariance of the plan position")
    cov_EE_m2: Mapped[float] = real("covariance of the plan position")
    cov_reading_NN_m2: Mapped[float] = real("the part of it that comes from the reading of the point")
    cov_reading_NE_m2: Mapped[float] = real("the part of it that comes from the reading of the point")
    cov_reading_EE_m2: Mapped[float] = real("the part of it that comes from the reading of the point")
    sigma_H_m: Mapped[float | None] = real("standard deviation of the height; NULL = taken as known")


# ---------------------------------------------------------------------------------------------- bl, topocentric


class CrsOperation(Base):
    """The exact coordinate operation that was used, with its accuracy and grids."""

    __tablename__ = "crs_operation"
    run_id: Mapped[int] = run_id()
    source: Mapped[str] = text("control, or the name of the sheet", primary_key=True)
    source_crs: Mapped[str] = text("from")
    target_crs: Mapped[str] = text("to")
    name: Mapped[str] = text("name of the operation")
    definition: Mapped[str] = text("PROJ pipeline")
    accuracy_m: Mapped[float | None] = real("stated accuracy; NULL = unknown")
    grids: Mapped[str] = text("grid files used, separated by blanks")
    is_ballpark: Mapped[int] = whole("1 if the datum shift is unknown and was allowed by the user")
    proj_version: Mapped[str] = text("version of PROJ")


class GeographicPoint(Base):
    """Points of the map on the ground's ellipsoid (the papers' table `bl`); local Cartesian points pass through."""

    __tablename__ = "geographic_point"
    __table_args__ = (
        one_of("role", "control", "check"),
        one_of("weighting", "fixed", "weighted"),
    )
    run_id: Mapped[int] = run_id()
    point: Mapped[str] = text("point", primary_key=True)
    role: Mapped[str] = text("control | check")
    source: Mapped[str] = text("control, or the name of the sheet")
    weighting: Mapped[str] = text("fixed: no error | weighted: with the covariance")
    B_deg: Mapped[float | None] = real("latitude")
    L_deg: Mapped[float | None] = real("longitude")
    H_m: Mapped[float | None] = real("ellipsoidal height")
    X_m: Mapped[float | None] = real("local Cartesian X, passed through")
    Y_m: Mapped[float | None] = real("local Cartesian Y, passed through")
    Z_m: Mapped[float | None] = real("local Cartesian Z, passed through")
    cov_XX_m2: Mapped[float | None] = real("covariance in the point's own horizon (north, east, up) or local X, Y, Z")
    cov_XY_m2: Mapped[float | None] = real("covariance")
    cov_XZ_m2: Mapped[float | None] = real("covariance")
    cov_YY_m2: Mapped[float | None] = real("covariance")
    cov_YZ_m2: Mapped[float | None] = real("covariance")
    cov_ZZ_m2: Mapped[float | None] = real("covariance")
    sheet_north_deg: Mapped[float | None] = real("azimuth of the sheet's north at the point; NULL if not from a sheet")


class TopocentricFrame(Base):
    """The frame of T and T': its origin, the ellipsoid and the convergence."""

    __tablename__ = "topocentric_frame"
    __table_args__ = (one_of("kind", "topocentric", "local_right", "local_left"),)
    run_id: Mapped[int] = run_id()
    kind: Mapped[str] = text("topocentric: X north, Y east, Z up | local_right, local_left: passed through")
    B_N_deg: Mapped[float | None] = real("latitude of the origin (nadir point)")
    L_N_deg: Mapped[float | None] = real("longitude of the origin")
    H_N_m: Mapped[float | None] = real("height of the origin")
    gamma_deg: Mapped[float | None] = real("meridian convergence, positive when grid north is east of north")
    central_meridian_deg: Mapped[float | None] = real("central meridian L0")
    a_m: Mapped[float | None] = real("semi-major axis")
    e2: Mapped[float | None] = real("first eccentricity squared")


class TopocentricPoint(Base):
    """Points in T and T' (gamma turned), with covariance and vertical in T'."""

    __tablename__ = "topocentric_point"
    __table_args__ = (one_of("known", "XYZ", "plan", "height"),)
    run_id: Mapped[int] = run_id()
    point: Mapped[str] = text("point", primary_key=True)
    role: Mapped[str] = text("control | check")
    weighting: Mapped[str] = text("fixed | weighted")
    known: Mapped[str] = text("XYZ | plan: the height is assumed | height: the plan position is assumed")
    X_T_m: Mapped[float] = real("T: north")
    Y_T_m: Mapped[float] = real("T: east")
    Z_T_m: Mapped[float] = real("T: up")
    X_m: Mapped[float] = real("T': grid north (local: X)")
    Y_m: Mapped[float] = real("T': grid east (local: Y)")
    Z_m: Mapped[float] = real("T': up (local: Z)")
    up_X: Mapped[float] = real("the point's own vertical in T'")
    up_Y: Mapped[float] = real("the point's own vertical in T'")
    up_Z: Mapped[float] = real("the point's own vertical in T'")
    cov_XX_m2: Mapped[float | None] = real("covariance in T'; for plan or height of the known part only")
    cov_XY_m2: Mapped[float | None] = real("covariance in T'")
    cov_XZ_m2: Mapped[float | None] = real("covariance in T'")
    cov_YY_m2: Mapped[float | None] = real("covariance in T'")
    cov_YZ_m2: Mapped[float | None] = real("covariance in T'")
    cov_ZZ_m2: Mapped[float | None] = real("covariance in T'")
    sheet: Mapped[str | None] = text("sheet from which the point comes; NULL if it was given in control")
    sheet_north_deg: Mapped[float | None] = real("azimuth of the sheet's north in the point's own horizon")


# ---------------------------------------------------------------------------------------------- resection


class Orientation(Base):
    """The exterior orientation (the papers' table `el`). The quaternion is the truth; angles are views of it."""

    __tablename__ = "orientation"
    run_id: Mapped[int] = run_id()
    frame: Mapped[str] = text("frame of X_S, Y_S, Z_S: topocentric (T') | local_right | local_left")
    X_S_m: Mapped[float] = real("projection centre")
    Y_S_m: Mapped[float] = real("projection centre")
    Z_S_m: Mapped[float] = real("projection centre")
    q_w: Mapped[float] = real("unit quaternion image -> right-handed ground (east, north, up of T'), w >= 0")
    q_x: Mapped[float] = real("unit quaternion")
    q_y: Mapped[float] = real("unit quaternion")
    q_z: Mapped[float] = real("unit quaternion")
    f_mm: Mapped[float] = real("focal length; the adjusted one if it was estimated")
    B_S_deg: Mapped[float | None] = real("projection centre, latitude; NULL for a local frame")
    L_S_deg: Mapped[float | None] = real("projection centre, longitude")
    H_S_m: Mapped[float | None] = real("projection centre, ellipsoidal height")
    X_G_m: Mapped[float | None] = real("projection centre, geocentric; NULL for a local frame")
    Y_G_m: Mapped[float | None] = real("projection centre, geocentric")
    Z_G_m: Mapped[float | None] = real("projection centre, geocentric")
    n_control: Mapped[int] = whole("control points")
    n_equations: Mapped[int] = whole("n, image and ground equations together")
    n_unknowns: Mapped[int] = whole("u, the elements and the unknown ground coordinates")
    redundancy: Mapped[int] = whole("r = n - u")
    vPv: Mapped[float] = real("sum of weighted squared residuals, unit sigma0 a priori")
    sigma0_apriori_mm: Mapped[float] = real("standard deviation of unit weight a priori")
    sigma0_mm: Mapped[float | None] = real("a posteriori, sqrt(vPv/r); NULL without redundancy")
    variance_scale: Mapped[float] = real("mm^2; factor on the cofactors in every stored standard deviation")
    variance_basis: Mapped[str] = text("a posteriori | a priori: which sigma0 scales the covariances")
    condition_ratio: Mapped[float] = real("smallest to largest singular value of the scaled design matrix")
    iterations: Mapped[int] = whole("iterations")
    termination: Mapped[str] = text("CONVERGED, MAX_ITERATIONS, SINGULAR, ...")


class OrientationAngle(Base):
    """The rotation as named angle triples."""

    __tablename__ = "orientation_angle"
    run_id: Mapped[int] = run_id()
    triple: Mapped[str] = text("aok: alpha, omega, kappa of the papers | opk: omega, phi, kappa", primary_key=True)
    frame: Mapped[str] = text("ground: T' as east, north, up, or local | geocentric", primary_key=True)
    angle: Mapped[str] = text("alpha, omega, phi, kappa", primary_key=True)
    value_deg: Mapped[float] = real("angle")
    sigma_deg: Mapped[float | None] = real("standard deviation; NULL near the blind view")
    near_blind: Mapped[int] = whole("1 if the middle angle is near 90 degrees, where the triple loses its meaning")


class Cofactor(Base):
    """Cofactor matrix Q of the elements, packed upper triangle with the papers' index IJ.

    Covariance = variance_scale x Q. `aok`: alpha, omega, kappa, X_S, Y_S, Z_S; `rotation`: small rotation about the
    right-handed ground axes (east, north, up), then X_S, Y_S, Z_S. Units rad and m. Elements of the camera that were
    estimated follow (u = 6 + m), in the units of `camera_element`; a station without error has zeros. `ray`: those of
    `rotation` and the parameters of the interior orientation, where they were unknowns: all that a new image ray
    depends on.
    """

    __tablename__ = "cofactor"
    run_id: Mapped[int] = run_id()
    unknowns: Mapped[str] = text("aok | rotation | ray", primary_key=True)
    IJ: Mapped[int] = whole("(i-1)(2u-i)/2 + j, i <= j, from 1 (seed 000, equation (10))", primary_key=True)
    i: Mapped[int] = whole("row, from 1")
    j: Mapped[int] = whole("column, from 1")
    unknown_i: Mapped[str] = text("name of the unknown of the row")
    unknown_j: Mapped[str] = text("name of the unknown of the column")
    value: Mapped[float] = real("cofactor")


class Iteration(Base):
    """One iteration of the adjustment."""

    __tablename__ = "iteration"
    run_id: Mapped[int] = run_id()
    iteration: Mapped[int] = whole("1, 2, ...", primary_key=True)
    vPv: Mapped[float] = real("sum of weighted squared residuals at the approximations")
    max_scaled_step: Mapped[float] = real("largest correction in units of its scale (1 rad, camera distance)")
    damping: Mapped[float] = real("damping of the step; 0 = full Gauss-Newton step")
    q_w: Mapped[float] = real("rotation at the approximations")
    q_x: Mapped[float] = real("rotation at the approximations")
    q_y: Mapped[float] = real("rotation at the approximations")
    q_z: Mapped[float] = real("rotation at the approximations")


class IterationParameter(Base):
    """Approximation and correction of every unknown in every iteration (the papers' table `_r`)."""

    __tablename__ = "iteration_parameter"
    run_id: Mapped[int] = run_id()
    iteration: Mapped[int] = whole("iteration", primary_key=True)
    point: Mapped[str] = text(
        "empty for the elements, else the point, the sheet or interior orientation", primary_key=True
    )
    unknown: Mapped[str] = text(
        "alpha omega kappa X_S Y_S Z_S, f k1 ... of the camera; X Y Z of the point; B_1_0 ... of the sheet (as "
        "sheet_coefficient); a0 ...",
        primary_key=True,
    )
    unit: Mapped[str] = text("rad | m | deg | mm | 1 | 1/mm, or as in camera_element")
    approximation: Mapped[float] = real("value before the iteration")
    correction: Mapped[float] = real("what the iteration added")


class Equation(Base):
    """Compact coefficients of the correction equations (the papers' table `kl`): v = a1 d1 + ... + a9 d9 + l.

    Order of the unknowns: alpha, omega, kappa, X_S, Y_S, Z_S, X, Y, Z; at the last linearisation.
    """

    __tablename__ = "equation"
    __table_args__ = (one_of("axis", "x", "y"),)
    run_id: Mapped[int] = run_id()
    point: Mapped[str] = text("point", primary_key=True)
    axis: Mapped[str] = text("x | y", primary_key=True)
    a1: Mapped[float] = real("by alpha, mm/rad")
    a2: Mapped[float] = real("by omega, mm/rad")
    a3: Mapped[float] = real("by kappa, mm/rad")
    a4: Mapped[float] = real("by X_S, mm/m")
    a5: Mapped[float] = real("by Y_S, mm/m")
    a6: Mapped[float] = real("by Z_S, mm/m")
    a7: Mapped[float] = real("by X of the point, mm/m")
    a8: Mapped[float] = real("by Y of the point, mm/m")
    a9: Mapped[float] = real("by Z of the point, mm/m")
    l_mm: Mapped[float] = real("computed minus measured")


class ImageResidual(Base):
    """Residuals of the image coordinates: v = adjusted minus measured; an excluded point like a check point."""

    __tablename__ = "image_residual"
    run_id: Mapped[int] = run_id()
    point: Mapped[str] = text("point", primary_key=True)
    role: Mapped[str] = text("control | check | excluded")
    x_mm: Mapped[float] = real("measured x; with an estimated camera what v compares with (docs/calibration.md)")
    y_mm: Mapped[float] = real("measured y")
    vx_mm: Mapped[float] = real("computed minus measured x")
    vy_mm: Mapped[float] = real("computed minus measured y")
    redundancy_x: Mapped[float | None] = real("redundancy number of x; NULL if not control")
    redundancy_y: Mapped[float | None] = real("redundancy number of y; NULL if not control")
    depth_m: Mapped[float] = real("distance of the point from the image plane's parallel through S, positive in front")


class AdjustedCamera(Base):
    """The interior orientation after an adjustment that estimated parts of it; the lens goes on in `camera_element`.

    Coefficients that are not in `camera_element` keep the value of `distortion_coefficient`.
    """

    __tablename__ = "adjusted_camera"
    __table_args__ = (
        one_of("distortion_model", "none", "brown", "opencv", "radial_table"),
        one_of("distortion_direction", "none", "correction", "ideal_to_distorted", "displacement"),
    )
    run_id: Mapped[int] = run_id()
    f_mm: Mapped[float] = real("focal length")
    x0_mm: Mapped[float] = real("principal point")
    y0_mm: Mapped[float] = real("principal point")
    b1: Mapped[float] = real("affinity: x grows by b1 x")
    b2: Mapped[float] = real("affinity: x grows by b2 y")
    distortion_model: Mapped[str] = text("none | brown | opencv | radial_table")
    distortion_direction: Mapped[str] = text("none | correction | displacement | ideal_to_distorted")


class CameraElement(Base):
    """Elements of the interior orientation that were unknowns of the resection, in the definition of photo.toml."""

    __tablename__ = "camera_element"
    run_id: Mapped[int] = run_id()
    unknown: Mapped[str] = text("f x0 y0 k1 k2 k3 p1 p2 b1 b2", primary_key=True)
    unit: Mapped[str] = text("mm, mm^-2 ... or 1; also of the cofactors (times 1/mm)")
    value_apriori: Mapped[float] = real("value of photo.toml, 0 if it has none")
    sigma_apriori: Mapped[float | None] = real("standard deviation a priori; NULL = free")
    value: Mapped[float] = real("adjusted value")
    correction: Mapped[float] = real("adjusted minus a priori")
    sigma: Mapped[float | None] = real("standard deviation after the adjustment")
    t: Mapped[float | None] = real("correction / sigma")
    t_limit: Mapped[float] = real("two-sided 1 % point of Student's t (of the normal law with sigma0 a priori)")
    is_significant: Mapped[int] = whole("1 if |t| exceeds t_limit")
    redundancy_number: Mapped[float | None] = real("of the value a priori; NULL for a free element")


class CameraEquation(Base):
    """Further coefficients of the correction equations in `equation`: by the elements of the camera."""

    __tablename__ = "camera_equation"
    __table_args__ = (one_of("axis", "x", "y"),)
    run_id: Mapped[int] = run_id()
    point: Mapped[str] = text("point", primary_key=True)
    axis: Mapped[str] = text("x | y", primary_key=True)
    unknown: Mapped[str] = text("element of the camera", primary_key=True)
    coefficient: Mapped[float] = real("mm per unit of the element")


class KnownResidual(Base):
    """What was known of the exterior orientation, after the adjustment: v = adjusted minus known."""

    __tablename__ = "known_residual"
    run_id: Mapped[int] = run_id()
    quantity: Mapped[str] = text("as in known_element", primary_key=True)
    unit: Mapped[str] = text("m | deg")
    sigma: Mapped[float] = real("standard deviation a priori")
    v: Mapped[float] = real("adjusted minus known; metres to north and east for B_S and L_S")
    redundancy_number: Mapped[float] = real("redundancy number")


class CalibrationStep(Base):
    """Which elements of the camera `--calibrate auto` tried in each step, and why they were taken or not."""

    __tablename__ = "calibration_step"
    __table_args__ = (
        one_of("decision", "taken", "not significant", "not separable", "not solved", "less significant"),
    )
    run_id: Mapped[int] = run_id()
    step: Mapped[int] = whole("1, 2, ...: one element is taken in each", primary_key=True)
    unknown: Mapped[str] = text("element that was tried", primary_key=True)
    decision: Mapped[str] = text(
        "taken | less significant (tried again) | not significant | not separable | not solved"
    )
    value: Mapped[float | None] = real("its adjusted value; NULL if the adjustment did not converge")
    sigma: Mapped[float | None] = real("its standard deviation")
    t: Mapped[float | None] = real("correction / sigma")
    t_limit: Mapped[float | None] = real("what |t| has to exceed")
    correlation: Mapped[float | None] = real("its strongest correlation with another unknown")
    correlated_with: Mapped[str | None] = text("that other unknown")
    sigma0_mm: Mapped[float | None] = real("sigma0 a posteriori with it")
    condition_ratio: Mapped[float | None] = real("smallest to largest singular value of the scaled design matrix")
    reason: Mapped[str] = text("the decision in words")


class AdjustedPoint(Base):
    """Ground points that were unknowns of the resection (weighted or partial control), in T'."""

    __tablename__ = "adjusted_point"
    run_id: Mapped[int] = run_id()
    point: Mapped[str] = text("point", primary_key=True)
    X_m: Mapped[float] = real("adjusted X")
    Y_m: Mapped[float] = real("adjusted Y")
    Z_m: Mapped[float] = real("adjusted Z")
    dX_m: Mapped[float] = real("adjusted minus given")
    dY_m: Mapped[float] = real("adjusted minus given")
    dZ_m: Mapped[float] = real("adjusted minus given")
    q_XX: Mapped[float] = real("cofactor, m^2/mm^2: covariance = variance_scale x q")
    q_XY: Mapped[float] = real("cofactor")
    q_XZ: Mapped[float] = real("cofactor")
    q_YY: Mapped[float] = real("cofactor")
    q_YZ: Mapped[float] = real("cofactor")
    q_ZZ: Mapped[float] = real("cofactor")


class AdjustedCoefficient(Base):
    """Coefficients of the sheet polynomials that were common unknowns of the points of a sheet (see sheet_transform).

    The covariance of the fit to the crosses (`digitize`) is their weight a priori; points of a sheet move together.
    """

    __tablename__ = "adjusted_coefficient"
    __table_args__ = (one_of("coordinate", "B", "L", "N", "E"),)
    run_id: Mapped[int] = run_id()
    sheet: Mapped[str] = text("sheet", primary_key=True)
    coordinate: Mapped[str] = text("B or N; L or E", primary_key=True)
    power_u: Mapped[int] = whole("j of u^j v^k", primary_key=True)
    power_v: Mapped[int] = whole("k of u^j v^k", primary_key=True)
    value: Mapped[float] = real("adjusted coefficient, degrees (B, L) or metres (N, E)")
    correction: Mapped[float] = real("adjusted minus fitted to the crosses")
    q: Mapped[float] = real("cofactor, unit^2/mm^2: variance = variance_scale x q")
    variance_ratio: Mapped[float] = real("cofactor after the adjustment to that before; 1 = the photo adds nothing")


class StartCandidate(Base):
    """An approximate orientation from a closed form, best first: how it fits all full control points."""

    __tablename__ = "start_candidate"
    __table_args__ = (one_of("method", "three points", "direct linear", "plane", "approximate station"),)
    run_id: Mapped[int] = run_id()
    candidate: Mapped[int] = whole("1, 2, ...: points in front first, then by rms", primary_key=True)
    method: Mapped[str] = text("three points | direct linear | plane | approximate station")
    is_reversed: Mapped[int] = whole("1 if its relief was taken the other way along the camera axis")
    points: Mapped[str] = text("the three points it comes from; empty for a form of all points")
    X_S_m: Mapped[float] = real("projection centre, frame as in orientation")
    Y_S_m: Mapped[float] = real("projection centre")
    Z_S_m: Mapped[float] = real("projection centre")
    q_w: Mapped[float] = real("unit quaternion, as in orientation")
    q_x: Mapped[float] = real("unit quaternion")
    q_y: Mapped[float] = real("unit quaternion")
    q_z: Mapped[float] = real("unit quaternion")
    rms_mm: Mapped[float | None] = real("sqrt(sum |v|^2 / n_points) of the image; NULL if not finite")
    n_points: Mapped[int] = whole("points it was judged on")
    n_in_front: Mapped[int] = whole("points in front of the camera")
    height_above_m: Mapped[float] = real("Z_S minus the mean Z of these points; negative = camera below the ground")
    solution: Mapped[int | None] = whole("where the adjustment from it ended; NULL = not adjusted")


class ResectionSolution(Base):
    """The distinct orientations in which the adjustment ended, from all starts; 1 is the one that was judged best.

    A run has a result only if solution 1 is CONVERGED and no other one fits as well without an approximate station.
    """

    __tablename__ = "resection_solution"
    run_id: Mapped[int] = run_id()
    solution: Mapped[int] = whole("1 = the best, then valid ones, then the others", primary_key=True)
    termination: Mapped[str] = text("CONVERGED, BEHIND_CAMERA, BELOW_GROUND, SINGULAR, MAX_ITERATIONS, ...")
    is_as_good: Mapped[int] = whole("1 if it fits as well as the best valid one")
    X_S_m: Mapped[float | None] = real("projection centre, frame as in orientation; NULL if not finite")
    Y_S_m: Mapped[float | None] = real("projection centre")
    Z_S_m: Mapped[float | None] = real("projection centre")
    q_w: Mapped[float | None] = real("unit quaternion, as in orientation; NULL if not finite")
    q_x: Mapped[float | None] = real("unit quaternion")
    q_y: Mapped[float | None] = real("unit quaternion")
    q_z: Mapped[float | None] = real("unit quaternion")
    vPv: Mapped[float | None] = real("sum of weighted squared residuals; NULL if not finite")
    n_points: Mapped[int] = whole("control points")
    n_in_front: Mapped[int] = whole("control points in front of the camera")
    height_above_m: Mapped[float | None] = real("Z_S minus the mean Z of the control; negative = below")
    iterations: Mapped[int] = whole("iterations")


class AdjustedInterior(Base):
    """Parameters of the interior orientation that were common unknowns of all image points (setting `interior`).

    The covariance of their fit to the fiducial marks (`refine`) is their weight a priori.
    """

    __tablename__ = "adjusted_interior"
    run_id: Mapped[int] = run_id()
    name: Mapped[str] = text("a0 a1 a2 b0 b1 b2 (c1 c2), as interior_parameter", primary_key=True)
    value: Mapped[float] = real("adjusted parameter")
    correction: Mapped[float] = real("adjusted minus fitted to the fiducial marks")
    q: Mapped[float] = real("cofactor, unit^2/mm^2: variance = variance_scale x q")
    variance_ratio: Mapped[float] = real("cofactor after the adjustment to that before; 1 = the control adds nothing")


class SourceCofactor(Base):
    """The part of each source of errors in the cofactors of everything a ray depends on, by index IJ.

    The parts sum to `cofactor` (unknowns `ray`, or `rotation` where the interior orientation is taken as known).
    """

    __tablename__ = "source_cofactor"
    run_id: Mapped[int] = run_id()
    source: Mapped[str] = text(
        "image readings | interior orientation | digitiser | map graticule | heights | survey | camera",
        primary_key=True,
    )
    IJ: Mapped[int] = whole("(i-1)(2u-i)/2 + j, i <= j, from 1 (seed 000, equation (10))", primary_key=True)
    i: Mapped[int] = whole("row, from 1")
    j: Mapped[int] = whole("column, from 1")
    unknown_i: Mapped[str] = text("name of the unknown of the row")
    unknown_j: Mapped[str] = text("name of the unknown of the column")
    value: Mapped[float] = real("cofactor; covariance = variance_scale x value")


# ---------------------------------------------------------------------------------------------- covariance


class GroundCovariance(Base):
    """Where the image ray of a point meets its height, and how sure that is: K = C Q C' (seed 003).

    The covariance of the plan position has three parts: orientation (K), the reading of the image point, its height.
    Axes: grid north X, grid east Y, in the horizon of the point.
    """

    __tablename__ = "ground_covariance"
    run_id: Mapped[int] = run_id()
    point: Mapped[str] = text("point", primary_key=True)
    role: Mapped[str] = text("control | check")
    X_m: Mapped[float] = real("ray at the height of the point, T'")
    Y_m: Mapped[float] = real("ray at the height of the point, T'")
    Z_m: Mapped[float] = real("ray at the height of the point, T'")
    dX_m: Mapped[float | None] = real("ray minus given; NULL when the plan position was not given")
    dY_m: Mapped[float | None] = real("ray minus given")
    K_XX_m2: Mapped[float] = real("orientation part")
    K_XY_m2: Mapped[float] = real("orientation part")
    K_YY_m2: Mapped[float] = real("orientation part")
    reading_XX_m2: Mapped[float] = real("part of the image reading")
    reading_XY_m2: Mapped[float] = real("part of the image reading")
    reading_YY_m2: Mapped[float] = real("part of the image reading")
    height_XX_m2: Mapped[float] = real("part of the height")
    height_XY_m2: Mapped[float] = real("part of the height")
    height_YY_m2: Mapped[float] = real("part of the height")
    sigma_X_m: Mapped[float] = real("standard deviation, all parts")
    sigma_Y_m: Mapped[float] = real("standard deviation, all parts")
    ellipse_a_m: Mapped[float] = real("semi-major axis of the standard error ellipse, all parts")
    ellipse_b_m: Mapped[float] = real("semi-minor axis")
    ellipse_azimuth_deg: Mapped[float] = real("direction of the semi-major axis from X towards Y, 0 ... 180")


class GroundCovariancePair(Base):
    """Covariance between two ground points through the common orientation (on request)."""

    __tablename__ = "ground_covariance_pair"
    run_id: Mapped[int] = run_id()
    point_i: Mapped[str] = text("first point", primary_key=True)
    point_j: Mapped[str] = text("second point", primary_key=True)
    K_XX_m2: Mapped[float] = real("cov(X_i, X_j)")
    K_XY_m2: Mapped[float] = real("cov(X_i, Y_j)")
    K_YX_m2: Mapped[float] = real("cov(Y_i, X_j)")
    K_YY_m2: Mapped[float] = real("cov(Y_i, Y_j)")


# ---------------------------------------------------------------------------------------------- reliability


class AdjustmentTest(Base):
    """The global test of an adjustment, and the test that decided about its observations."""

    __tablename__ = "adjustment_test"
    __table_args__ = (
        one_of("test", "w", "tau"),
        one_of("verdict", "accepted", "too large", "too small", "no redundancy"),
    )
    run_id: Mapped[int] = run_id()
    part: Mapped[str] = text("empty, or the sheet, or the zone", primary_key=True)
    component: Mapped[str] = text("empty, or N or E where they are adjusted apart", primary_key=True)
    redundancy: Mapped[int] = whole("r")
    sigma0_known: Mapped[float | None] = real("sigma0 a priori, unit of the observations; NULL = not known")
    statistic: Mapped[float | None] = real("v'Pv / sigma0^2 with the sigma0 a priori; NULL without one")
    lower: Mapped[float | None] = real("accepted from here, chi^2 of r degrees of freedom at 5 %")
    upper: Mapped[float | None] = real("accepted to here")
    probability: Mapped[float | None] = real("chance of a statistic so far out, both sides")
    verdict: Mapped[str | None] = text(
        "accepted | too large | too small | no redundancy; NULL without a sigma0 a priori"
    )
    test: Mapped[str] = text("w: Baarda, sigma0 known | tau: Pope, sigma0 estimated")
    sigma0: Mapped[float] = real("sigma0 of the test, unit of the observations")
    critical: Mapped[float | None] = real("limit of |w| or |tau|, alpha0 = 0.001; NULL: no test is possible (r < 2)")
    delta0: Mapped[float | None] = real("noncentrality that is found with power 0.80")


class ObservationTest(Base):
    """What each observation shows of its own error, and the smallest error in it that the others would find."""

    __tablename__ = "observation_test"
    __table_args__ = (
        one_of("kind", "image", "ground", "coefficient", "known", "cross", "model"),
        one_of("verdict", "good", "suspect", "hardly checked", "not checked"),
    )
    run_id: Mapped[int] = run_id()
    kind: Mapped[str] = text(
        "image | ground: given control | coefficient: of a sheet | known: of camera, station, angles | cross | model",
        primary_key=True,
    )
    part: Mapped[str] = text("sheet of a coefficient or cross, zone of a model, else empty", primary_key=True)
    point: Mapped[str] = text("point or cross; empty for a coefficient", primary_key=True)
    axis: Mapped[str] = text(
        "x y of the image, X Y Z of the ground, N E of a cross, x y z of the model, name of the coefficient or of what "
        "is known",
        primary_key=True,
    )
    unit: Mapped[str] = text("mm | m | deg | rad | model, or as in camera_element: unit of v and smallest_error")
    v: Mapped[float] = real("residual, adjusted minus observed")
    redundancy_number: Mapped[float] = real("r_i, diagonal of Q_v P; all r_i sum to the redundancy")
    share: Mapped[float] = real("(P Q_v P)_ii / P_ii: share of an error that the others see, 0 ... 1")
    w: Mapped[float | None] = real("w or tau (see adjustment_test); NULL when no other observation checks it")
    smallest_error: Mapped[float | None] = real("MDB: error that the test finds with power 0.80; NULL: none is found")
    bias_to_noise: Mapped[float | None] = real("effect of smallest_error on the unknowns, in units of their precision")
    ground_shift_m: Mapped[float | None] = real(
        "largest shift of a ground point of the photo (sheet, zone) by smallest_error"
    )
    ground_shift_point: Mapped[str | None] = text("the point that shifts most")
    rho: Mapped[float | None] = real(
        "correlation |rho_w| with the most correlated test of another point; NULL: not asked"
    )
    rho_with: Mapped[str | None] = text("that other point (and sheet)")
    verdict: Mapped[str] = text("good | suspect: |w| > critical | hardly checked: share < 0.1 | not checked")


class PointTest(Base):
    """All coordinates of one reading tested together: is there any error in the point?"""

    __tablename__ = "point_test"
    run_id: Mapped[int] = run_id()
    part: Mapped[str] = text("sheet of a cross, zone of a model, else empty", primary_key=True)
    point: Mapped[str] = text("point or cross", primary_key=True)
    statistic: Mapped[float | None] = real("(Pv)'(P Q_v P)^-1 (Pv) / sigma0^2; NULL when nothing checks it")
    freedom: Mapped[int] = whole("degrees of freedom")
    probability: Mapped[float | None] = real("chance of so large a value without an error")


class ExternalReliability(Base):
    """What an error of `smallest_error` in an observation, not found, does to the elements: Q A'P e_i times it."""

    __tablename__ = "external_reliability"
    __table_args__ = (one_of("kind", "image", "ground", "coefficient", "known", "model"),)
    run_id: Mapped[int] = run_id()
    kind: Mapped[str] = text("image | ground | coefficient | known | model", primary_key=True)
    part: Mapped[str] = text("sheet of a coefficient, zone of a model, else empty", primary_key=True)
    point: Mapped[str] = text("point; empty for a coefficient", primary_key=True)
    axis: Mapped[str] = text("as observation_test", primary_key=True)
    unknown: Mapped[str] = text(
        "rotation_1 rotation_2 rotation_3 X_S Y_S Z_S, f k1 ..., as in cofactor; of a model xi eta theta H "
        "X_0 Y_0 Z_0, near their blind view r_X r_Y r_Z instead of the angles",
        primary_key=True,
    )
    unit: Mapped[str] = text("deg | m | model/m, or as in camera_element")
    effect: Mapped[float] = real("change of the element")


class Exclusion(Base):
    """Points and crosses that were left out of an adjustment, or that are proposed for it, with the reason."""

    __tablename__ = "exclusion"
    __table_args__ = (
        one_of("decided_by", "snooping", "hand", "robust"),
        one_of("action", "excluded", "proposed", "taken back", "not separable", "not removable"),
    )
    run_id: Mapped[int] = run_id()
    seq: Mapped[int] = whole("order of the decisions", primary_key=True)
    part: Mapped[str] = text("sheet of a cross, zone of a model, else empty")
    point: Mapped[str] = text("point or cross")
    decided_by: Mapped[str] = text("snooping | hand | robust")
    observation: Mapped[str | None] = text("the observation with the largest |w| or |tau|; NULL: not by a test")
    action: Mapped[str] = text("excluded | proposed | taken back | not separable | not removable: the rest is too weak")
    round: Mapped[int | None] = whole("round of the snooping")
    test: Mapped[str | None] = text("w | tau | chance: of the misfit of a point that was taken back")
    statistic: Mapped[float | None] = real("largest |w| or |tau| of the point in that round")
    critical: Mapped[float | None] = real("limit of the test")
    other: Mapped[str | None] = text("the point that it cannot be separated from")
    reason: Mapped[str] = text("why, in words")


# ---------------------------------------------------------------------------------------------- image, seal


class Image(Base):
    """The image file of the photo: embedded in parts, or known by its digest only. The name is text, never a path."""

    __tablename__ = "image"
    __table_args__ = (
        CheckConstraint("size_bytes > 0", name="size_bytes"),
        CheckConstraint("length(sha256) = 64", name="sha256"),
        CheckConstraint("n_parts >= 0", name="n_parts"),
    )
    run_id: Mapped[int] = run_id()
    name: Mapped[str] = text("name that the file had, without its folder")
    media_type: Mapped[str] = text("image/tiff, image/png, image/jpeg ...; by its first bytes")
    size_bytes: Mapped[int] = whole("size of the file")
    sha256: Mapped[str] = text("SHA-256 of the whole file")
    width_px: Mapped[int | None] = whole("columns, as the file says; NULL if it does not say so simply")
    height_px: Mapped[int | None] = whole("rows, as the file says")
    n_parts: Mapped[int] = whole("parts in image_part; 0 = the file is not here, only its digest")


class ImagePart(Base):
    """The bytes of an embedded image file, in parts of 1 MiB; joined in order of seq they are the file."""

    __tablename__ = "image_part"
    __table_args__ = (
        CheckConstraint(f"length(content) BETWEEN 1 AND {IMAGE_PART_BYTES}", name="content"),
        CheckConstraint("seq >= 1", name="seq"),
    )
    run_id: Mapped[int] = run_id()
    seq: Mapped[int] = whole("1, 2, ... n_parts", primary_key=True)
    content: Mapped[bytes] = mapped_column(LargeBinary, comment="the bytes; digests go over their number and SHA-256")


class SealedFile(Base):
    """The manifest of a project that was sealed to be sent: what the file held at that moment."""

    __tablename__ = "sealed_file"
    __table_args__ = (one_of("image", "embedded", "referenced", "none"),)
    run_id: Mapped[int] = run_id()
    project: Mapped[str] = text("name of the project file that was sealed, without its folder")
    format: Mapped[int] = whole("format of the file (user_version)")
    n_runs: Mapped[int] = whole("runs before the manifest")
    n_selections: Mapped[int] = whole("selections")
    last_run_digest: Mapped[str] = text("record_digest of the newest run: end of the chain of runs")
    last_selection_digest: Mapped[str] = text("record_digest of the newest selection: end of the chain of selections")
    image: Mapped[str] = text("embedded | referenced: by digest only | none")
    image_name: Mapped[str | None] = text("name of the image file")
    image_size_bytes: Mapped[int | None] = whole("size of the image file")
    image_sha256: Mapped[str | None] = text("SHA-256 of the image file")


class SealedRun(Base):
    """One run that the sealed file held."""

    __tablename__ = "sealed_run"
    run_id: Mapped[int] = run_id()
    sealed_run_id: Mapped[int] = mapped_column(
        ForeignKey("stage_run.run_id"), primary_key=True, comment="the run that is listed"
    )
    stage: Mapped[str] = text("stage")
    version: Mapped[int] = whole("version within the stage")
    is_current: Mapped[int] = whole("1 if it was the selected version")
    is_stale: Mapped[int] = whole("1 if it was current and its inputs had changed")
    status: Mapped[str] = text("succeeded | failed")
    output_digest: Mapped[str] = text("sha256 over its rows, as sealed")
    record_digest: Mapped[str] = text("sha256 over its ledger entry, as sealed")
    tool_version: Mapped[str] = text("software that made it")


# ---------------------------------------------------------------------------------------------- verify


class VerifiedRun(Base):
    """Evidence about one run: what a second computation from its recorded inputs and settings found.

    `recomputed`: every number again; `digest`: an imported list, compared with its seal only. Bits are compared when
    the run was made by the same software on the same kind of processor, else 1e-9 of the number's scale, without
    sentences and iterations.
    """

    __tablename__ = "verified_run"
    __table_args__ = (
        one_of("method", "recomputed", "digest"),
        one_of("compared", "bits", "1e-9"),
        one_of("verdict", "identical", "agrees", "differs"),
    )
    run_id: Mapped[int] = run_id()
    verified_run_id: Mapped[int] = mapped_column(
        ForeignKey("stage_run.run_id"), primary_key=True, comment="the run that was examined"
    )
    output_digest: Mapped[str] = text("digest that its seal held at that moment")
    method: Mapped[str] = text("recomputed | digest")
    compared: Mapped[str] = text("bits | 1e-9")
    because: Mapped[str] = text("why not bits: other software, other version of the stage; else empty")
    verdict: Mapped[str] = text("identical: bit by bit | agrees: within 1e-9 | differs")
    n_values: Mapped[int] = whole("values compared; 0 for an imported list")
    n_identical: Mapped[int] = whole("values that are equal bit by bit")
    n_different: Mapped[int] = whole("values, rows and seals that differ by more than is allowed")
    largest_difference: Mapped[float | None] = real("relative to the scale of the number; NULL if nothing was compared")
    largest_at: Mapped[str] = text("table, row and column of the largest difference; empty if all bits are equal")
    stored: Mapped[str] = text("the stored value there, all digits")
    recomputed: Mapped[str] = text("the recomputed value there, all digits")
    second_engine: Mapped[str] = text("agrees | differs | left out: why; empty where nothing is adjusted")


class VerifiedDifference(Base):
    """One value that differs by more than is allowed, or a seal that does not fit (the largest of them per run)."""

    __tablename__ = "verified_difference"
    run_id: Mapped[int] = run_id()
    seq: Mapped[int] = whole("1, 2, ...; by run, the largest first", primary_key=True)
    verified_run_id: Mapped[int | None] = mapped_column(
        ForeignKey("stage_run.run_id"), comment="the run that was examined; NULL for the ledger as a whole"
    )
    place: Mapped[str] = text("table, row and column; or what of the seal")
    stored: Mapped[str] = text("the stored value, all digits")
    recomputed: Mapped[str] = text("the recomputed value, all digits")
    difference: Mapped[float | None] = real("relative to the scale of the number; NULL if it is not one of two numbers")


class IndependentSolution(Base):
    """The same adjustment, solved by another program from the same observations."""

    __tablename__ = "independent_solution"
    run_id: Mapped[int] = run_id()
    verified_run_id: Mapped[int] = mapped_column(
        ForeignKey("stage_run.run_id"), primary_key=True, comment="the run whose adjustment was solved again"
    )
    engine: Mapped[str] = text("program and method", primary_key=True)
    subject: Mapped[str] = text("sheet of a polynomial; empty for the only adjustment of the run", primary_key=True)
    quantity: Mapped[str] = text("station, rotation, sigma0, cofactor, parameters, residuals", primary_key=True)
    difference: Mapped[float] = real("largest difference, in units of `relative_to`")
    relative_to: Mapped[str] = text("standard deviation | value | standard deviations of both unknowns")
    allowed: Mapped[float] = real("largest difference that counts as agreement")
    agrees: Mapped[int] = whole("1 if the difference is allowed")


class SimulatedSpread(Base):
    """Spread of the elements in simulated adjustments (Monte Carlo), beside what Q predicts."""

    __tablename__ = "simulated_spread"
    run_id: Mapped[int] = run_id()
    verified_run_id: Mapped[int] = mapped_column(
        ForeignKey("stage_run.run_id"), primary_key=True, comment="the resection that was simulated"
    )
    unknown: Mapped[str] = text("r_X r_Y r_Z (rad) X_S Y_S Z_S (m), solver axes: east, north, up", primary_key=True)
    n: Mapped[int] = whole("adjustments that converged")
    n_failed: Mapped[int] = whole("adjustments that did not")
    predicted: Mapped[float] = real("standard deviation by Q and sigma0 a priori")
    simulated: Mapped[float] = real("standard deviation of the simulated solutions about the true value")
    ratio: Mapped[float] = real("simulated to predicted")
    allowed: Mapped[float] = real("largest distance of the ratio from 1 that counts as agreement")
    agrees: Mapped[int] = whole("1 if the ratio is allowed")


class GroundCovarianceImage(Base):
    """The covariance of a ground point in the scale of the image: by how much its image point is uncertain.

    B = d(x, y)/d(X, Y), the image scale in the horizon of the point; K and all parts together as B K B' [mm^2].
    """

    __tablename__ = "ground_covariance_image"
    run_id: Mapped[int] = run_id()
    point: Mapped[str] = text("point", primary_key=True)
    dx_dX_mm_m: Mapped[float] = real("image scale, mm in the image for 1 m on the ground")
    dx_dY_mm_m: Mapped[float] = real("image scale")
    dy_dX_mm_m: Mapped[float] = real("image scale")
    dy_dY_mm_m: Mapped[float] = real("image scale")
    K_xx_mm2: Mapped[float] = real("orientation part")
    K_xy_mm2: Mapped[float] = real("orientation part")
    K_yy_mm2: Mapped[float] = real("orientation part")
    sigma_x_mm: Mapped[float] = real("standard deviation, all parts")
    sigma_y_mm: Mapped[float] = real("standard deviation, all parts")
    ellipse_a_mm: Mapped[float] = real("semi-major axis of the standard error ellipse, all parts")
    ellipse_b_mm: Mapped[float] = real("semi-minor axis")
    ellipse_direction_deg: Mapped[float] = real("direction of the semi-major axis from x towards y, 0 ... 180")


class GroundAccuracy(Base):
    """Map over the frame: how sure a new ground point would be, read once more at this place of the photo.

    The ray meets the mean height of the points; ground columns are NULL where the place sees no ground. Parts and axes
    as in `ground_covariance` (X grid north, Y grid east, in the place's own horizon).
    """

    __tablename__ = "ground_accuracy"
    run_id: Mapped[int] = run_id()
    line: Mapped[int] = whole("line of the grid, 1 at the top of the frame", primary_key=True)
    place: Mapped[int] = whole("place in the line, 1 at the left", primary_key=True)
    x_mm: Mapped[float] = real("image coordinate, origin at the principal point")
    y_mm: Mapped[float] = real("image coordinate")
    X_m: Mapped[float | None] = real("ray at the mean height, T'")
    Y_m: Mapped[float | None] = real("ray at the mean height, T'")
    Z_m: Mapped[float | None] = real("ray at the mean height, T'")
    K_XX_m2: Mapped[float | None] = real("orientation part")
    K_XY_m2: Mapped[float | None] = real("orientation part")
    K_YY_m2: Mapped[float | None] = real("orientation part")
    reading_XX_m2: Mapped[float | None] = real("part of the image reading")
    reading_XY_m2: Mapped[float | None] = real("part of the image reading")
    reading_YY_m2: Mapped[float | None] = real("part of the image reading")
    height_XX_m2: Mapped[float | None] = real("part of the height (setting map_height_sigma_m)")
    height_XY_m2: Mapped[float | None] = real("part of the height")
    height_YY_m2: Mapped[float | None] = real("part of the height")
    sigma_X_m: Mapped[float | None] = real("standard deviation, all parts")
    sigma_Y_m: Mapped[float | None] = real("standard deviation, all parts")
    ellipse_a_m: Mapped[float | None] = real("semi-major axis of the standard error ellipse, all parts")
    ellipse_b_m: Mapped[float | None] = real("semi-minor axis")
    ellipse_azimuth_deg: Mapped[float | None] = real("direction of the semi-major axis from X towards Y, 0 ... 180")
    K_xx_mm2: Mapped[float | None] = real("orientation part in the scale of the image")
    K_xy_mm2: Mapped[float | None] = real("orientation part in the scale of the image")
    K_yy_mm2: Mapped[float | None] = real("orientation part in the scale of the image")
    sigma_x_mm: Mapped[float | None] = real("standard deviation in the scale of the image, all parts")
    sigma_y_mm: Mapped[float | None] = real("standard deviation in the scale of the image, all parts")
    ellipse_a_mm: Mapped[float | None] = real("semi-major axis in the scale of the image, all parts")
    ellipse_b_mm: Mapped[float | None] = real("semi-minor axis in the scale of the image")
    ellipse_direction_deg: Mapped[float | None] = real("its direction from x towards y, 0 ... 180")


class ElementUse(Base):
    """What the ground sigmas would be if less than the full cofactor matrix of the six elements were used.

    Root mean square over the points and both axes, of the part of the orientation; only `six elements` is right.
    """

    __tablename__ = "element_use"
    run_id: Mapped[int] = run_id()
    elements: Mapped[str] = text("six elements | standard deviations only | position only | ...", primary_key=True)
    sigma_m: Mapped[float] = real("ground sigma that would be found")
    factor: Mapped[float] = real("against the right one, root mean square over the points")
    factor_least: Mapped[float] = real("least factor of a point and axis")
    factor_most: Mapped[float] = real("greatest factor of a point and axis")


class ClosedFormCondition(Base):
    """Conditions of the formulas of seed 003, and whether this photo meets them; sums are per control point.

    `normal case`: without it no formula of the seed applies; `separation`: without it only the inverse, no closed form;
    `one D`: without it the closed form needs two determinants.
    """

    __tablename__ = "closed_form_condition"
    __table_args__ = (one_of("needed_for", "normal case", "separation", "one D"),)
    run_id: Mapped[int] = run_id()
    seq: Mapped[int] = whole("order", primary_key=True)
    condition: Mapped[str] = text("what must hold")
    needed_for: Mapped[str] = text("normal case | separation | one D")
    value: Mapped[float | None] = real("found; NULL where a condition before it makes it meaningless")
    limit_value: Mapped[float] = real("its absolute value may not exceed this")
    is_met: Mapped[int] = whole("1 if it holds")


class FocalCofactor(Base):
    """Q_z = Q^(f,c) + Q^(xi,eta) of seed 003 (7), packed upper triangle; only for a photo of the normal case.

    Unknowns (f dX_S/(Hc), f dY_S/(Hc), dZ_S/H, (c/f) dalpha, (c/f) domega, dkappa) along the image axes, readings in
    units of c with unit weight.
    """

    __tablename__ = "focal_cofactor"
    run_id: Mapped[int] = run_id()
    IJ: Mapped[int] = whole("(i-1)(2u-i)/2 + j, i <= j, from 1", primary_key=True)
    i: Mapped[int] = whole("row, from 1")
    j: Mapped[int] = whole("column, from 1")
    unknown_i: Mapped[str] = text("name of the unknown of the row")
    unknown_j: Mapped[str] = text("name of the unknown of the column")
    by_focal_length: Mapped[float] = real("Q^(f,c)")
    by_layout: Mapped[float] = real("Q^(xi,eta)")
    closed_form: Mapped[float | None] = real("the sum by (8)-(10); NULL where the layout allows no closed form")


class FocalSum(Base):
    """K of a coordinate element by element, (12) = (14) + (15) of seed 003; only for a photo of the normal case.

    In units of the variance of one reading. The part of f/c sums to zero whatever the layout: the ground accuracy in
    the scale of the image does not know the focal length.
    """

    __tablename__ = "focal_sum"
    __table_args__ = (one_of("axis", "x", "y"),)
    run_id: Mapped[int] = run_id()
    point: Mapped[str] = text("point", primary_key=True)
    axis: Mapped[str] = text("x | y: direction on the ground that the image axis has", primary_key=True)
    focal_sum: Mapped[float] = real("sum of the elements of K^(f,c): zero but for rounding")
    focal_largest: Mapped[float] = real("largest absolute element of K^(f,c)")
    layout_sum: Mapped[float] = real("sum of the elements of K^(xi,eta): K by the seed")
    rigorous: Mapped[float] = real("K of the resection with its interior orientation known, in the same unit")


class ErrorBudget(Base):
    """The part of each source of errors in the covariance of the plan position of a ground point.

    `photo`: through what all points of the photo share, the orientation and the interior orientation; `point`: own
    reading and height of the point. The parts sum to the covariance that ground_covariance holds. Its axes.
    """

    __tablename__ = "error_budget"
    __table_args__ = (one_of("part", "photo", "point"),)
    run_id: Mapped[int] = run_id()
    point: Mapped[str] = text("point", primary_key=True)
    source: Mapped[str] = text("image readings | heights | ..., as in source_cofactor", primary_key=True)
    part: Mapped[str] = text("photo | point", primary_key=True)
    cov_XX_m2: Mapped[float] = real("part of the covariance")
    cov_XY_m2: Mapped[float] = real("part of the covariance")
    cov_YY_m2: Mapped[float] = real("part of the covariance")


# ---------------------------------------------------------------------------------------------- absolute


class AbsoluteOrientation(Base):
    """The absolute orientation of each zone: X_G = R x/H + X0 (seed 000, (2) corrected), t = 1/H (seed 002, (108))."""

    __tablename__ = "absolute_orientation"
    __table_args__ = (one_of("sigma0_unit", "m", "1"),)
    run_id: Mapped[int] = run_id()
    zone: Mapped[str] = text("zone of the model", primary_key=True)
    frame: Mapped[str] = text("frame of X_0, Y_0, Z_0: topocentric (T') | local_right | local_left")
    X_0_m: Mapped[float] = real("ground position of the model's origin")
    Y_0_m: Mapped[float] = real("ground position of the model's origin")
    Z_0_m: Mapped[float] = real("ground position of the model's origin")
    H: Mapped[float] = real("homothety coefficient, model units per metre")
    t: Mapped[float] = real("scale denominator 1/H, metres per model unit")
    q_w: Mapped[float] = real("unit quaternion model -> right-handed ground (east, north, up of T'), w >= 0")
    q_x: Mapped[float] = real("unit quaternion")
    q_y: Mapped[float] = real("unit quaternion")
    q_z: Mapped[float] = real("unit quaternion")
    n_full: Mapped[int] = whole("control points with all three coordinates: 3 equations each")
    n_plan: Mapped[int] = whole("plan-only control points: 2 equations each")
    n_height: Mapped[int] = whole("height-only control points: 1 equation each")
    n_equations: Mapped[int] = whole("n = 3 n_full + 2 n_plan + n_height")
    n_unknowns: Mapped[int] = whole("7")
    redundancy: Mapped[int] = whole("r = n - 7")
    vPv: Mapped[float] = real("sum of weighted squared residuals")
    vPv_mirrored: Mapped[float | None] = real("what the mirrored model would leave; NULL = no reason to ask")
    sigma0: Mapped[float | None] = real("mu = sqrt(vPv/r) in the unit of sigma0_unit; NULL without redundancy")
    sigma0_unit: Mapped[str] = text("m: equal weights on the ground | 1: weights from covariances")
    variance_scale: Mapped[float | None] = real("factor on the cofactors; NULL = not known")
    variance_basis: Mapped[str] = text("a posteriori | a priori | unknown")
    condition_ratio: Mapped[float] = real("smallest to largest singular value of the scaled design matrix")
    iterations: Mapped[int] = whole("iterations")
    termination: Mapped[str] = text("CONVERGED")


class AbsoluteElement(Base):
    """The seven elements as each paper names them; the translation in the axes of the stored frame.

    homothety: xi, eta, theta about the fixed ground axes X, Y, Z (of the right-handed partner), H, X_0, Y_0, Z_0 (seed
    000, (2)); joint: the same with T = H X0 (seed 000, (4)); scale: X_0, Y_0, Z_0, t, xi longitudinal, eta transverse
    tilt, theta (seed 002, (108)).
    """

    __tablename__ = "absolute_element"
    __table_args__ = (one_of("view", "homothety", "joint", "scale"),)
    run_id: Mapped[int] = run_id()
    zone: Mapped[str] = text("zone", primary_key=True)
    view: Mapped[str] = text("homothety | joint | scale", primary_key=True)
    unknown: Mapped[str] = text("xi eta theta H X_0 Y_0 Z_0, T_X T_Y T_Z, t", primary_key=True)
    unit: Mapped[str] = text("deg | m | model | model/m | m/model")
    value: Mapped[float] = real("value")
    sigma: Mapped[float | None] = real("standard deviation mu sqrt(Q_ii), seed 002 (59); NULL = unknown or blind view")
    near_blind: Mapped[int] = whole("1 if the middle angle is near 90 degrees, where the triple loses its meaning")


class AbsoluteCofactor(Base):
    """Cofactor matrix Q_x of the seven elements of each view, packed upper triangle with the papers' index IJ.

    `rotation`: small rotation about the right-handed ground axes (east, north, up), H, X_0, Y_0, Z_0; the other views
    as in absolute_element. Units rad, m, model units. Covariance = variance_scale x Q.
    """

    __tablename__ = "absolute_cofactor"
    run_id: Mapped[int] = run_id()
    zone: Mapped[str] = text("zone", primary_key=True)
    unknowns: Mapped[str] = text("rotation | homothety | joint | scale", primary_key=True)
    IJ: Mapped[int] = whole("(i-1)(2u-i)/2 + j, i <= j, from 1 (seed 000, equation (10))", primary_key=True)
    i: Mapped[int] = whole("row, from 1")
    j: Mapped[int] = whole("column, from 1")
    unknown_i: Mapped[str] = text("name of the unknown of the row")
    unknown_j: Mapped[str] = text("name of the unknown of the column")
    value: Mapped[float] = real("cofactor")


class AbsoluteIteration(Base):
    """One iteration of the adjustment of a zone."""

    __tablename__ = "absolute_iteration"
    run_id: Mapped[int] = run_id()
    zone: Mapped[str] = text("zone", primary_key=True)
    iteration: Mapped[int] = whole("1, 2, ...", primary_key=True)
    vPv: Mapped[float] = real("sum of weighted squared residuals at the approximations")
    max_scaled_step: Mapped[float] = real("largest correction in units of its scale (1 rad, H, extent of the control)")
    damping: Mapped[float] = real("damping of the step; 0 = full Gauss-Newton step")
    q_w: Mapped[float] = real("rotation at the approximations")
    q_x: Mapped[float] = real("rotation at the approximations")
    q_y: Mapped[float] = real("rotation at the approximations")
    q_z: Mapped[float] = real("rotation at the approximations")


class AbsoluteIterationParameter(Base):
    """Approximation and correction of xi, eta, theta, H, X_0, Y_0, Z_0 (seed 000) in every iteration."""

    __tablename__ = "absolute_iteration_parameter"
    run_id: Mapped[int] = run_id()
    zone: Mapped[str] = text("zone", primary_key=True)
    iteration: Mapped[int] = whole("iteration", primary_key=True)
    unknown: Mapped[str] = text("xi eta theta (fixed axes) H X_0 Y_0 Z_0", primary_key=True)
    unit: Mapped[str] = text("rad | model/m | m")
    approximation: Mapped[float] = real("value before the iteration")
    correction: Mapped[float] = real("what the iteration added")


class AbsoluteResidual(Base):
    """Residuals of control and check points: v = computed (from the observed model point) minus given, T' or local."""

    __tablename__ = "absolute_residual"
    __table_args__ = (one_of("role", "control", "check", "excluded"), one_of("known", "XYZ", "plan", "height"))
    run_id: Mapped[int] = run_id()
    zone: Mapped[str] = text("zone", primary_key=True)
    point: Mapped[str] = text("point", primary_key=True)
    role: Mapped[str] = text("control | check | excluded")
    known: Mapped[str] = text("XYZ | plan | height: the given coordinates; the others are NULL")
    vX_m: Mapped[float | None] = real("computed minus given X")
    vY_m: Mapped[float | None] = real("computed minus given Y")
    vZ_m: Mapped[float | None] = real("computed minus given Z; of a height-only point along its own vertical")
    v_ground_X_m: Mapped[float | None] = real("adjusted minus given ground coordinate; NULL for check and excluded")
    v_ground_Y_m: Mapped[float | None] = real("adjusted minus given")
    v_ground_Z_m: Mapped[float | None] = real("adjusted minus given")
    v_model_x: Mapped[float | None] = real("adjusted minus observed model x, model units; NULL for a check point")
    v_model_y: Mapped[float | None] = real("adjusted minus observed model y")
    v_model_z: Mapped[float | None] = real("adjusted minus observed model z")
    redundancy_X: Mapped[float | None] = real("redundancy number of the X equation; NULL for a check point")
    redundancy_Y: Mapped[float | None] = real("redundancy number of the Y equation")
    redundancy_Z: Mapped[float | None] = real("redundancy number of the Z (height) equation")


class AbsoluteAlternative(Base):
    """Other orientations in which the adjustment of a zone converged (two full points and a height have two)."""

    __tablename__ = "absolute_alternative"
    run_id: Mapped[int] = run_id()
    zone: Mapped[str] = text("zone", primary_key=True)
    number: Mapped[int] = whole("1, 2, ... by growing vPv", primary_key=True)
    X_0_m: Mapped[float] = real("ground position of the model's origin")
    Y_0_m: Mapped[float] = real("ground position of the model's origin")
    Z_0_m: Mapped[float] = real("ground position of the model's origin")
    H: Mapped[float] = real("homothety coefficient")
    q_w: Mapped[float] = real("unit quaternion model -> right-handed ground")
    q_x: Mapped[float] = real("unit quaternion")
    q_y: Mapped[float] = real("unit quaternion")
    q_z: Mapped[float] = real("unit quaternion")
    tilt_deg: Mapped[float] = real("angle between the model's Z axis and up")
    vPv: Mapped[float] = real("sum of weighted squared residuals")
    is_as_good: Mapped[int] = whole("1 if it fits as well as the one that was taken")


class AbsoluteEquation(Base):
    """Correction equations v = a1 d(u1) + ... + a7 d(u7) + l of the given coordinates, in the forms of the papers.

    Unknowns in order: homothety xi eta theta H X_0 Y_0 Z_0 (seed 000, (2'), (7)); joint the same with T_X T_Y T_Z
    (4'); scale X_0 Y_0 Z_0 t xi eta theta (seed 002, (109), (110)). Radians, metres, model units; right-handed ground
    (east, north, up of T'; local: X, Y, Z).
    """

    __tablename__ = "absolute_equation"
    __table_args__ = (one_of("form", "homothety", "joint", "scale"), one_of("axis", "X", "Y", "Z"))
    run_id: Mapped[int] = run_id()
    zone: Mapped[str] = text("zone", primary_key=True)
    form: Mapped[str] = text("homothety | joint | scale", primary_key=True)
    point: Mapped[str] = text("control point", primary_key=True)
    axis: Mapped[str] = text("X | Y | Z: the given coordinate", primary_key=True)
    a1: Mapped[float] = real("coefficient of unknown 1 of the form")
    a2: Mapped[float] = real("coefficient of unknown 2 of the form")
    a3: Mapped[float] = real("coefficient of unknown 3 of the form")
    a4: Mapped[float] = real("coefficient of unknown 4 of the form")
    a5: Mapped[float] = real("coefficient of unknown 5 of the form")
    a6: Mapped[float] = real("coefficient of unknown 6 of the form")
    a7: Mapped[float] = real("coefficient of unknown 7 of the form")
    l_m: Mapped[float] = real("free term, computed minus given, at the solution")


class AbsoluteSmallAngle(Base):
    """The small-angle elements (seed 002, (111)) beside the rigorous ones (on request)."""

    __tablename__ = "absolute_small_angle"
    run_id: Mapped[int] = run_id()
    zone: Mapped[str] = text("zone", primary_key=True)
    unknown: Mapped[str] = text("X_0 Y_0 Z_0 t xi eta theta (tilts)", primary_key=True)
    unit: Mapped[str] = text("m | m/model | deg")
    value: Mapped[float] = real("by the small-angle formulas")
    rigorous: Mapped[float] = real("by the adjustment")
    difference: Mapped[float] = real("value minus rigorous")


class ModelGroundPoint(Base):
    """All model points on the ground, with the covariance of the elements and of their own model coordinates."""

    __tablename__ = "model_ground_point"
    __table_args__ = (one_of("role", "control", "check", "free", "excluded"), Index(None, "run_id", "point"))
    run_id: Mapped[int] = run_id()
    zone: Mapped[str] = text("zone", primary_key=True)
    point: Mapped[str] = text("point", primary_key=True)
    role: Mapped[str] = text("control | check | free: without given ground coordinates | excluded: left out")
    X_m: Mapped[float] = real("T': grid north (local: X)")
    Y_m: Mapped[float] = real("T': grid east (local: Y)")
    Z_m: Mapped[float] = real("T': up (local: Z)")
    B_deg: Mapped[float | None] = real("latitude; NULL for a local frame")
    L_deg: Mapped[float | None] = real("longitude")
    H_m: Mapped[float | None] = real("ellipsoidal height")
    cov_XX_m2: Mapped[float | None] = real("covariance in T'; NULL when sigma0 is unknown")
    cov_XY_m2: Mapped[float | None] = real("covariance in T'")
    cov_XZ_m2: Mapped[float | None] = real("covariance in T'")
    cov_YY_m2: Mapped[float | None] = real("covariance in T'")
    cov_YZ_m2: Mapped[float | None] = real("covariance in T'")
    cov_ZZ_m2: Mapped[float | None] = real("covariance in T'")


def _make_strict_and_finite() -> None:
    """STRICT tables store no text as number; NaN binds as NULL, and infinity fails the range check."""
    for table in Base.metadata.tables.values():
        table.dialect_options["sqlite"]["strict"] = True
        for column in table.columns:
            if isinstance(column.type, REAL):
                name = f"{column.name}_finite"
                condition = f"{column.name} BETWEEN -{REAL_LIMIT} AND {REAL_LIMIT}"
                table.append_constraint(CheckConstraint(condition, name=name))


_make_strict_and_finite()
