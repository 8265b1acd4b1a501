"""Which tables and columns `show` prints for each stage; headers are the column names, which carry the unit."""

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Section:
    """One table of a stage: its title, where it is, and columns with their decimals (None: as it is)."""

    title: str
    source: str
    columns: tuple[tuple[str, int | None], ...]
    only: str = ""
    """Column without which a row is not shown."""


def _section(title: str, source: str, columns: str, only: str = "") -> Section:
    """Columns as words; `x_mm.4` is shown with four decimals."""
    parts = [word.partition(".") for word in columns.split()]
    return Section(
        title, source, tuple((name, int(decimals) if decimals else None) for name, _, decimals in parts), only
    )


SECTIONS: Mapping[str, tuple[Section, ...]] = {
    "photo": (_section("Fiducial marks", "fiducial_mark", "mark x_mm.3 y_mm.3"),),
    "readings": (
        _section("Readings", "comparator_reading", "point kind cycle x_mm.4 y_mm.4 col_px.3 row_px.3 sigma.4"),
    ),
    "sheet": (
        _section("Sheets", "map_sheet", "sheet title crs degree sigma_mm.3"),
        _section("Crosses", "graticule_cross", "sheet cross role X_mm.3 Y_mm.3 B_deg.6 L_deg.6 E_m.1 N_m.1"),
    ),
    "control": (
        _section(
            "Control and check points",
            "control_point",
            "point role kind B_deg.6 L_deg.6 E_m.3 N_m.3 H_m.2 X_m.3 Y_m.3 Z_m.3",
        ),
    ),
    "model": (_section("Model points", "model_point", "zone point x.6 y.6 z.6 cov_xx cov_yy cov_zz"),),
    "refine": (
        _section("Interior orientation", "interior_orientation", "transformation n_marks redundancy sigma0_mm.5"),
        _section("Fiducial marks: transformed minus calibrated", "fiducial_residual", "mark vx_mm.4 vy_mm.4"),
        _section(
            "Image points and their corrections",
            "image_point",
            "point n_cycles x_mm.5 y_mm.5 dx_distortion_mm.5 dy_distortion_mm.5 dx_refraction_mm.5 dy_refraction_mm.5",
        ),
    ),
    "digitize": (
        _section(
            "Sheets",
            "sheet_transform",
            "sheet degree degree_chosen_by n_crosses redundancy sigma0_N_m.2 sigma0_E_m.2",
        ),
        _section(
            "Crosses: polynomial minus given",
            "cross_residual",
            "sheet cross role v_N_m.2 v_E_m.2 redundancy_number.2 probability.5 is_suspect",
        ),
        _section(
            "Digitised points", "digitized_point", "sheet point n_cycles B_deg.6 L_deg.6 N_m.2 E_m.2 H_m.1 sigma_H_m.1"
        ),
    ),
    "bl": (
        _section("Coordinate operation", "crs_operation", "source name accuracy_m.2 grids is_ballpark"),
        _section("Points", "geographic_point", "point role source weighting B_deg.7 L_deg.7 H_m.2 X_m.3 Y_m.3 Z_m.3"),
    ),
    "topocentric": (
        _section("Frame", "topocentric_frame", "kind B_N_deg.6 L_N_deg.6 H_N_m.1 gamma_deg.6"),
        _section("Points in T'", "topocentric_point", "point role weighting known X_m.3 Y_m.3 Z_m.3"),
    ),
    "resection": (
        _section("Known of the camera's place: adjusted minus known", "known_residual", "quantity unit sigma.4 v.4"),
        _section(
            "Calibration by steps",
            "calibration_step",
            "step unknown decision t.1 correlation.3 correlated_with",
        ),
        _section(
            "Start values that were adjusted, best first: how they fit, and where they led",
            "start_candidate",
            "candidate method points rms_mm.3 n_in_front solution",
            only="solution",
        ),
        _section(
            "Where they led: 1 is the best, only CONVERGED is a result",
            "resection_solution",
            "solution termination X_S_m.1 Y_S_m.1 Z_S_m.1 vPv.5",
        ),
    ),
    "covariance": (
        _section(
            "Ground points: where the ray meets the height; dX, dY = ray minus map, with the map's own error in them",
            "ground_covariance",
            "point role dX_m.3 dY_m.3 sigma_X_m.3 sigma_Y_m.3 ellipse_a_m.3 ellipse_b_m.3 ellipse_azimuth_deg.1",
        ),
        _section(
            "The same in the scale of the image, all parts",
            "ground_covariance_image",
            "point sigma_x_mm.5 sigma_y_mm.5 ellipse_a_mm.5 ellipse_b_mm.5 ellipse_direction_deg.1",
        ),
    ),
    "image": (_section("Image file", "image", "name media_type width_px height_px size_bytes n_parts sha256"),),
    "seal": (
        _section("Sealed", "sealed_file", "project format n_runs image image_name image_size_bytes image_sha256"),
        _section("Runs", "sealed_run", "sealed_run_id stage version is_current is_stale status output_digest"),
    ),
    "verify": (
        _section(
            "Runs",
            "verified_run",
            "verified_run_id compared verdict n_values n_identical n_different second_engine",
        ),
        _section("Differences", "verified_difference", "verified_run_id difference stored recomputed place"),
        _section(
            "Second engine", "independent_solution", "verified_run_id quantity subject difference relative_to engine"
        ),
        _section("Simulation", "simulated_spread", "verified_run_id unknown n ratio.4 allowed.4 agrees"),
    ),
}
