"""Which tables a stage writes, and what it reads."""

TEST_TABLES = ("adjustment_test", "observation_test", "point_test", "exclusion")
"""Tables that every stage with an adjustment by points writes."""

STAGE_TABLES: dict[str, tuple[str, ...]] = {
    "photo": ("photo", "distortion_coefficient", "distortion_radial", "fiducial_mark"),
    "readings": ("comparator_reading",),
    "sheet": ("map_sheet", "graticule_cross", "digitizer_reading"),
    "control": ("control_point", "control_system"),
    "model": ("model_point",),
    "refine": (
        "cycle_residual",
        "interior_orientation",
        "interior_parameter",
        "interior_covariance",
        "fiducial_residual",
        "image_point",
    ),
    "digitize": (
        "sheet_transform",
        "sheet_coefficient",
        "sheet_cofactor",
        "cross_residual",
        "digitized_point",
        *TEST_TABLES,
    ),
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
        *TEST_TABLES,
        "external_reliability",
        "adjusted_interior",
        "source_cofactor",
        "start_candidate",
        "resection_solution",
    ),
    "covariance": (
        "ground_covariance",
        "ground_covariance_pair",
        "ground_covariance_image",
        "ground_accuracy",
        "element_use",
        "closed_form_condition",
        "focal_cofactor",
        "focal_sum",
        "error_budget",
    ),
    "absolute": (
        "absolute_orientation",
        "absolute_element",
        "absolute_cofactor",
        "absolute_iteration",
        "absolute_iteration_parameter",
        "absolute_residual",
        "absolute_alternative",
        "absolute_small_angle",
        "model_ground_point",
    ),
    "verify": ("verified_run", "verified_difference", "independent_solution", "simulated_spread"),
}

LEDGER_TABLES = ("stage_run", "run_input", "run_seal", "selection", "run_event")
EVENT_TABLE = "run_event"
