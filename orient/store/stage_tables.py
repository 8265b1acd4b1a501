"""Which tables a stage writes, and what it reads."""

STAGE_TABLES: dict[str, tuple[str, ...]] = {
    "photo": (
        "photo",
        "distortion_coefficient",
        "camera_sigma",
        "distortion_radial",
        "fiducial_mark",
        "known_element",
    ),
    "readings": ("comparator_reading",),
    "sheet": ("map_sheet", "graticule_cross", "digitizer_reading"),
    "control": ("control_point", "control_system"),
    "model": ("model_point",),
    "refine": ("cycle_residual", "interior_orientation", "interior_parameter", "fiducial_residual", "image_point"),
    "digitize": ("sheet_transform", "sheet_coefficient", "sheet_cofactor", "cross_residual", "digitized_point"),
    "bl": ("crs_operation", "geographic_point"),
    "topocentric": ("topocentric_frame", "topocentric_point"),
    "resection": (
        "orientation",
        "orientation_angle",
        "cofactor",
        "iteration",
        "iteration_parameter",
        "equation",
        "image_residual",
        "adjusted_point",
        "adjusted_coefficient",
        "adjusted_camera",
        "camera_element",
        "camera_equation",
        "known_residual",
        "calibration_step",
    ),
    "covariance": ("ground_covariance", "ground_covariance_pair"),
}

LEDGER_TABLES = ("stage_run", "run_input", "run_seal", "selection", "run_event")
EVENT_TABLE = "run_event"
