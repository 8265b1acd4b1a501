CREATE TABLE absolute_alternative (
	run_id INTEGER NOT NULL, 
	zone TEXT NOT NULL, 
	number INTEGER NOT NULL, 
	"X_0_m" REAL NOT NULL, 
	"Y_0_m" REAL NOT NULL, 
	"Z_0_m" REAL NOT NULL, 
	"H" REAL NOT NULL, 
	q_w REAL NOT NULL, 
	q_x REAL NOT NULL, 
	q_y REAL NOT NULL, 
	q_z REAL NOT NULL, 
	tilt_deg REAL NOT NULL, 
	"vPv" REAL NOT NULL, 
	is_as_good INTEGER NOT NULL, 
	CONSTRAINT pk_absolute_alternative PRIMARY KEY (run_id, zone, number), 
	CONSTRAINT fk_absolute_alternative_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT "ck_absolute_alternative_X_0_m_finite" CHECK (X_0_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_absolute_alternative_Y_0_m_finite" CHECK (Y_0_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_absolute_alternative_Z_0_m_finite" CHECK (Z_0_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_absolute_alternative_H_finite" CHECK (H BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_alternative_q_w_finite CHECK (q_w BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_alternative_q_x_finite CHECK (q_x BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_alternative_q_y_finite CHECK (q_y BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_alternative_q_z_finite CHECK (q_z BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_alternative_tilt_deg_finite CHECK (tilt_deg BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_absolute_alternative_vPv_finite" CHECK (vPv BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE absolute_cofactor (
	run_id INTEGER NOT NULL, 
	zone TEXT NOT NULL, 
	unknowns TEXT NOT NULL, 
	"IJ" INTEGER NOT NULL, 
	i INTEGER NOT NULL, 
	j INTEGER NOT NULL, 
	unknown_i TEXT NOT NULL, 
	unknown_j TEXT NOT NULL, 
	value REAL NOT NULL, 
	CONSTRAINT pk_absolute_cofactor PRIMARY KEY (run_id, zone, unknowns, "IJ"), 
	CONSTRAINT fk_absolute_cofactor_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_absolute_cofactor_value_finite CHECK (value BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE absolute_element (
	run_id INTEGER NOT NULL, 
	zone TEXT NOT NULL, 
	"view" TEXT NOT NULL, 
	unknown TEXT NOT NULL, 
	unit TEXT NOT NULL, 
	value REAL NOT NULL, 
	sigma REAL, 
	near_blind INTEGER NOT NULL, 
	CONSTRAINT pk_absolute_element PRIMARY KEY (run_id, zone, "view", unknown), 
	CONSTRAINT ck_absolute_element_view CHECK (view IN ('homothety', 'joint', 'scale')), 
	CONSTRAINT fk_absolute_element_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_absolute_element_value_finite CHECK (value BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_element_sigma_finite CHECK (sigma BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE absolute_equation (
	run_id INTEGER NOT NULL, 
	zone TEXT NOT NULL, 
	form TEXT NOT NULL, 
	point TEXT NOT NULL, 
	axis TEXT NOT NULL, 
	a1 REAL NOT NULL, 
	a2 REAL NOT NULL, 
	a3 REAL NOT NULL, 
	a4 REAL NOT NULL, 
	a5 REAL NOT NULL, 
	a6 REAL NOT NULL, 
	a7 REAL NOT NULL, 
	l_m REAL NOT NULL, 
	CONSTRAINT pk_absolute_equation PRIMARY KEY (run_id, zone, form, point, axis), 
	CONSTRAINT ck_absolute_equation_form CHECK (form IN ('homothety', 'joint', 'scale')), 
	CONSTRAINT ck_absolute_equation_axis CHECK (axis IN ('X', 'Y', 'Z')), 
	CONSTRAINT fk_absolute_equation_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_absolute_equation_a1_finite CHECK (a1 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_equation_a2_finite CHECK (a2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_equation_a3_finite CHECK (a3 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_equation_a4_finite CHECK (a4 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_equation_a5_finite CHECK (a5 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_equation_a6_finite CHECK (a6 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_equation_a7_finite CHECK (a7 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_equation_l_m_finite CHECK (l_m BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE absolute_iteration (
	run_id INTEGER NOT NULL, 
	zone TEXT NOT NULL, 
	iteration INTEGER NOT NULL, 
	"vPv" REAL NOT NULL, 
	max_scaled_step REAL NOT NULL, 
	damping REAL NOT NULL, 
	q_w REAL NOT NULL, 
	q_x REAL NOT NULL, 
	q_y REAL NOT NULL, 
	q_z REAL NOT NULL, 
	CONSTRAINT pk_absolute_iteration PRIMARY KEY (run_id, zone, iteration), 
	CONSTRAINT fk_absolute_iteration_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT "ck_absolute_iteration_vPv_finite" CHECK (vPv BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_iteration_max_scaled_step_finite CHECK (max_scaled_step BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_iteration_damping_finite CHECK (damping BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_iteration_q_w_finite CHECK (q_w BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_iteration_q_x_finite CHECK (q_x BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_iteration_q_y_finite CHECK (q_y BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_iteration_q_z_finite CHECK (q_z BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE absolute_iteration_parameter (
	run_id INTEGER NOT NULL, 
	zone TEXT NOT NULL, 
	iteration INTEGER NOT NULL, 
	unknown TEXT NOT NULL, 
	unit TEXT NOT NULL, 
	approximation REAL NOT NULL, 
	correction REAL NOT NULL, 
	CONSTRAINT pk_absolute_iteration_parameter PRIMARY KEY (run_id, zone, iteration, unknown), 
	CONSTRAINT fk_absolute_iteration_parameter_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_absolute_iteration_parameter_approximation_finite CHECK (approximation BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_iteration_parameter_correction_finite CHECK (correction BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE absolute_orientation (
	run_id INTEGER NOT NULL, 
	zone TEXT NOT NULL, 
	frame TEXT NOT NULL, 
	"X_0_m" REAL NOT NULL, 
	"Y_0_m" REAL NOT NULL, 
	"Z_0_m" REAL NOT NULL, 
	"H" REAL NOT NULL, 
	t REAL NOT NULL, 
	q_w REAL NOT NULL, 
	q_x REAL NOT NULL, 
	q_y REAL NOT NULL, 
	q_z REAL NOT NULL, 
	n_full INTEGER NOT NULL, 
	n_plan INTEGER NOT NULL, 
	n_height INTEGER NOT NULL, 
	n_equations INTEGER NOT NULL, 
	n_unknowns INTEGER NOT NULL, 
	redundancy INTEGER NOT NULL, 
	"vPv" REAL NOT NULL, 
	"vPv_mirrored" REAL, 
	sigma0 REAL, 
	sigma0_unit TEXT NOT NULL, 
	variance_scale REAL, 
	variance_basis TEXT NOT NULL, 
	condition_ratio REAL NOT NULL, 
	iterations INTEGER NOT NULL, 
	termination TEXT NOT NULL, 
	CONSTRAINT pk_absolute_orientation PRIMARY KEY (run_id, zone), 
	CONSTRAINT ck_absolute_orientation_sigma0_unit CHECK (sigma0_unit IN ('m', '1')), 
	CONSTRAINT fk_absolute_orientation_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT "ck_absolute_orientation_X_0_m_finite" CHECK (X_0_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_absolute_orientation_Y_0_m_finite" CHECK (Y_0_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_absolute_orientation_Z_0_m_finite" CHECK (Z_0_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_absolute_orientation_H_finite" CHECK (H BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_orientation_t_finite CHECK (t BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_orientation_q_w_finite CHECK (q_w BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_orientation_q_x_finite CHECK (q_x BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_orientation_q_y_finite CHECK (q_y BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_orientation_q_z_finite CHECK (q_z BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_absolute_orientation_vPv_finite" CHECK (vPv BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_absolute_orientation_vPv_mirrored_finite" CHECK (vPv_mirrored BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_orientation_sigma0_finite CHECK (sigma0 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_orientation_variance_scale_finite CHECK (variance_scale BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_orientation_condition_ratio_finite CHECK (condition_ratio BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE absolute_residual (
	run_id INTEGER NOT NULL, 
	zone TEXT NOT NULL, 
	point TEXT NOT NULL, 
	role TEXT NOT NULL, 
	known TEXT NOT NULL, 
	"vX_m" REAL, 
	"vY_m" REAL, 
	"vZ_m" REAL, 
	"v_ground_X_m" REAL, 
	"v_ground_Y_m" REAL, 
	"v_ground_Z_m" REAL, 
	v_model_x REAL, 
	v_model_y REAL, 
	v_model_z REAL, 
	"redundancy_X" REAL, 
	"redundancy_Y" REAL, 
	"redundancy_Z" REAL, 
	CONSTRAINT pk_absolute_residual PRIMARY KEY (run_id, zone, point), 
	CONSTRAINT ck_absolute_residual_role CHECK (role IN ('control', 'check')), 
	CONSTRAINT ck_absolute_residual_known CHECK (known IN ('XYZ', 'plan', 'height')), 
	CONSTRAINT fk_absolute_residual_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT "ck_absolute_residual_vX_m_finite" CHECK (vX_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_absolute_residual_vY_m_finite" CHECK (vY_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_absolute_residual_vZ_m_finite" CHECK (vZ_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_absolute_residual_v_ground_X_m_finite" CHECK (v_ground_X_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_absolute_residual_v_ground_Y_m_finite" CHECK (v_ground_Y_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_absolute_residual_v_ground_Z_m_finite" CHECK (v_ground_Z_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_residual_v_model_x_finite CHECK (v_model_x BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_residual_v_model_y_finite CHECK (v_model_y BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_residual_v_model_z_finite CHECK (v_model_z BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_absolute_residual_redundancy_X_finite" CHECK (redundancy_X BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_absolute_residual_redundancy_Y_finite" CHECK (redundancy_Y BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_absolute_residual_redundancy_Z_finite" CHECK (redundancy_Z BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE absolute_small_angle (
	run_id INTEGER NOT NULL, 
	zone TEXT NOT NULL, 
	unknown TEXT NOT NULL, 
	unit TEXT NOT NULL, 
	value REAL NOT NULL, 
	rigorous REAL NOT NULL, 
	difference REAL NOT NULL, 
	CONSTRAINT pk_absolute_small_angle PRIMARY KEY (run_id, zone, unknown), 
	CONSTRAINT fk_absolute_small_angle_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_absolute_small_angle_value_finite CHECK (value BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_small_angle_rigorous_finite CHECK (rigorous BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_absolute_small_angle_difference_finite CHECK (difference BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE adjusted_camera (
	run_id INTEGER NOT NULL, 
	f_mm REAL NOT NULL, 
	x0_mm REAL NOT NULL, 
	y0_mm REAL NOT NULL, 
	b1 REAL NOT NULL, 
	b2 REAL NOT NULL, 
	distortion_model TEXT NOT NULL, 
	distortion_direction TEXT NOT NULL, 
	CONSTRAINT pk_adjusted_camera PRIMARY KEY (run_id), 
	CONSTRAINT ck_adjusted_camera_distortion_model CHECK (distortion_model IN ('none', 'brown', 'opencv', 'radial_table')), 
	CONSTRAINT ck_adjusted_camera_distortion_direction CHECK (distortion_direction IN ('none', 'correction', 'ideal_to_distorted', 'displacement')), 
	CONSTRAINT fk_adjusted_camera_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_adjusted_camera_f_mm_finite CHECK (f_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_adjusted_camera_x0_mm_finite CHECK (x0_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_adjusted_camera_y0_mm_finite CHECK (y0_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_adjusted_camera_b1_finite CHECK (b1 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_adjusted_camera_b2_finite CHECK (b2 BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE adjusted_interior (
	run_id INTEGER NOT NULL, 
	name TEXT NOT NULL, 
	value REAL NOT NULL, 
	correction REAL NOT NULL, 
	q REAL NOT NULL, 
	variance_ratio REAL NOT NULL, 
	CONSTRAINT pk_adjusted_interior PRIMARY KEY (run_id, name), 
	CONSTRAINT fk_adjusted_interior_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_adjusted_interior_value_finite CHECK (value BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_adjusted_interior_correction_finite CHECK (correction BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_adjusted_interior_q_finite CHECK (q BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_adjusted_interior_variance_ratio_finite CHECK (variance_ratio BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE adjustment_test (
	run_id INTEGER NOT NULL, 
	part TEXT NOT NULL, 
	component TEXT NOT NULL, 
	redundancy INTEGER NOT NULL, 
	sigma0_known REAL, 
	statistic REAL, 
	lower REAL, 
	upper REAL, 
	probability REAL, 
	verdict TEXT, 
	test TEXT NOT NULL, 
	sigma0 REAL NOT NULL, 
	critical REAL, 
	delta0 REAL, 
	CONSTRAINT pk_adjustment_test PRIMARY KEY (run_id, part, component), 
	CONSTRAINT ck_adjustment_test_test CHECK (test IN ('w', 'tau')), 
	CONSTRAINT ck_adjustment_test_verdict CHECK (verdict IN ('accepted', 'too large', 'too small', 'no redundancy')), 
	CONSTRAINT fk_adjustment_test_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_adjustment_test_sigma0_known_finite CHECK (sigma0_known BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_adjustment_test_statistic_finite CHECK (statistic BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_adjustment_test_lower_finite CHECK (lower BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_adjustment_test_upper_finite CHECK (upper BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_adjustment_test_probability_finite CHECK (probability BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_adjustment_test_sigma0_finite CHECK (sigma0 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_adjustment_test_critical_finite CHECK (critical BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_adjustment_test_delta0_finite CHECK (delta0 BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE calibration_step (
	run_id INTEGER NOT NULL, 
	step INTEGER NOT NULL, 
	unknown TEXT NOT NULL, 
	decision TEXT NOT NULL, 
	value REAL, 
	sigma REAL, 
	t REAL, 
	t_limit REAL, 
	correlation REAL, 
	correlated_with TEXT, 
	sigma0_mm REAL, 
	condition_ratio REAL, 
	reason TEXT NOT NULL, 
	CONSTRAINT pk_calibration_step PRIMARY KEY (run_id, step, unknown), 
	CONSTRAINT ck_calibration_step_decision CHECK (decision IN ('taken', 'not significant', 'not separable', 'not solved', 'less significant')), 
	CONSTRAINT fk_calibration_step_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_calibration_step_value_finite CHECK (value BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_calibration_step_sigma_finite CHECK (sigma BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_calibration_step_t_finite CHECK (t BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_calibration_step_t_limit_finite CHECK (t_limit BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_calibration_step_correlation_finite CHECK (correlation BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_calibration_step_sigma0_mm_finite CHECK (sigma0_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_calibration_step_condition_ratio_finite CHECK (condition_ratio BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE camera_element (
	run_id INTEGER NOT NULL, 
	unknown TEXT NOT NULL, 
	unit TEXT NOT NULL, 
	value_apriori REAL NOT NULL, 
	sigma_apriori REAL, 
	value REAL NOT NULL, 
	correction REAL NOT NULL, 
	sigma REAL, 
	t REAL, 
	t_limit REAL NOT NULL, 
	is_significant INTEGER NOT NULL, 
	redundancy_number REAL, 
	CONSTRAINT pk_camera_element PRIMARY KEY (run_id, unknown), 
	CONSTRAINT fk_camera_element_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_camera_element_value_apriori_finite CHECK (value_apriori BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_camera_element_sigma_apriori_finite CHECK (sigma_apriori BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_camera_element_value_finite CHECK (value BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_camera_element_correction_finite CHECK (correction BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_camera_element_sigma_finite CHECK (sigma BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_camera_element_t_finite CHECK (t BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_camera_element_t_limit_finite CHECK (t_limit BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_camera_element_redundancy_number_finite CHECK (redundancy_number BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE camera_equation (
	run_id INTEGER NOT NULL, 
	point TEXT NOT NULL, 
	axis TEXT NOT NULL, 
	unknown TEXT NOT NULL, 
	coefficient REAL NOT NULL, 
	CONSTRAINT pk_camera_equation PRIMARY KEY (run_id, point, axis, unknown), 
	CONSTRAINT ck_camera_equation_axis CHECK (axis IN ('x', 'y')), 
	CONSTRAINT fk_camera_equation_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_camera_equation_coefficient_finite CHECK (coefficient BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE camera_sigma (
	run_id INTEGER NOT NULL, 
	name TEXT NOT NULL, 
	sigma REAL NOT NULL, 
	CONSTRAINT pk_camera_sigma PRIMARY KEY (run_id, name), 
	CONSTRAINT fk_camera_sigma_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_camera_sigma_sigma_finite CHECK (sigma BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE closed_form_condition (
	run_id INTEGER NOT NULL, 
	seq INTEGER NOT NULL, 
	condition TEXT NOT NULL, 
	needed_for TEXT NOT NULL, 
	value REAL, 
	limit_value REAL NOT NULL, 
	is_met INTEGER NOT NULL, 
	CONSTRAINT pk_closed_form_condition PRIMARY KEY (run_id, seq), 
	CONSTRAINT ck_closed_form_condition_needed_for CHECK (needed_for IN ('normal case', 'separation', 'one D')), 
	CONSTRAINT fk_closed_form_condition_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_closed_form_condition_value_finite CHECK (value BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_closed_form_condition_limit_value_finite CHECK (limit_value BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE element_use (
	run_id INTEGER NOT NULL, 
	elements TEXT NOT NULL, 
	sigma_m REAL NOT NULL, 
	factor REAL NOT NULL, 
	factor_least REAL NOT NULL, 
	factor_most REAL NOT NULL, 
	CONSTRAINT pk_element_use PRIMARY KEY (run_id, elements), 
	CONSTRAINT fk_element_use_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_element_use_sigma_m_finite CHECK (sigma_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_element_use_factor_finite CHECK (factor BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_element_use_factor_least_finite CHECK (factor_least BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_element_use_factor_most_finite CHECK (factor_most BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE error_budget (
	run_id INTEGER NOT NULL, 
	point TEXT NOT NULL, 
	source TEXT NOT NULL, 
	part TEXT NOT NULL, 
	"cov_XX_m2" REAL NOT NULL, 
	"cov_XY_m2" REAL NOT NULL, 
	"cov_YY_m2" REAL NOT NULL, 
	CONSTRAINT pk_error_budget PRIMARY KEY (run_id, point, source, part), 
	CONSTRAINT ck_error_budget_part CHECK (part IN ('photo', 'point')), 
	CONSTRAINT fk_error_budget_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT "ck_error_budget_cov_XX_m2_finite" CHECK (cov_XX_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_error_budget_cov_XY_m2_finite" CHECK (cov_XY_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_error_budget_cov_YY_m2_finite" CHECK (cov_YY_m2 BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE exclusion (
	run_id INTEGER NOT NULL, 
	seq INTEGER NOT NULL, 
	part TEXT NOT NULL, 
	point TEXT NOT NULL, 
	decided_by TEXT NOT NULL, 
	observation TEXT, 
	action TEXT NOT NULL, 
	round INTEGER, 
	test TEXT, 
	statistic REAL, 
	critical REAL, 
	other TEXT, 
	reason TEXT NOT NULL, 
	CONSTRAINT pk_exclusion PRIMARY KEY (run_id, seq), 
	CONSTRAINT ck_exclusion_decided_by CHECK (decided_by IN ('snooping', 'hand', 'robust')), 
	CONSTRAINT ck_exclusion_action CHECK (action IN ('excluded', 'proposed', 'taken back', 'not separable', 'not removable')), 
	CONSTRAINT fk_exclusion_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_exclusion_statistic_finite CHECK (statistic BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_exclusion_critical_finite CHECK (critical BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE external_reliability (
	run_id INTEGER NOT NULL, 
	kind TEXT NOT NULL, 
	part TEXT NOT NULL, 
	point TEXT NOT NULL, 
	axis TEXT NOT NULL, 
	unknown TEXT NOT NULL, 
	unit TEXT NOT NULL, 
	effect REAL NOT NULL, 
	CONSTRAINT pk_external_reliability PRIMARY KEY (run_id, kind, part, point, axis, unknown), 
	CONSTRAINT ck_external_reliability_kind CHECK (kind IN ('image', 'ground', 'coefficient', 'known')), 
	CONSTRAINT fk_external_reliability_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_external_reliability_effect_finite CHECK (effect BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE focal_cofactor (
	run_id INTEGER NOT NULL, 
	"IJ" INTEGER NOT NULL, 
	i INTEGER NOT NULL, 
	j INTEGER NOT NULL, 
	unknown_i TEXT NOT NULL, 
	unknown_j TEXT NOT NULL, 
	by_focal_length REAL NOT NULL, 
	by_layout REAL NOT NULL, 
	closed_form REAL, 
	CONSTRAINT pk_focal_cofactor PRIMARY KEY (run_id, "IJ"), 
	CONSTRAINT fk_focal_cofactor_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_focal_cofactor_by_focal_length_finite CHECK (by_focal_length BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_focal_cofactor_by_layout_finite CHECK (by_layout BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_focal_cofactor_closed_form_finite CHECK (closed_form BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE focal_sum (
	run_id INTEGER NOT NULL, 
	point TEXT NOT NULL, 
	axis TEXT NOT NULL, 
	focal_sum REAL NOT NULL, 
	focal_largest REAL NOT NULL, 
	layout_sum REAL NOT NULL, 
	rigorous REAL NOT NULL, 
	CONSTRAINT pk_focal_sum PRIMARY KEY (run_id, point, axis), 
	CONSTRAINT ck_focal_sum_axis CHECK (axis IN ('x', 'y')), 
	CONSTRAINT fk_focal_sum_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_focal_sum_focal_sum_finite CHECK (focal_sum BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_focal_sum_focal_largest_finite CHECK (focal_largest BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_focal_sum_layout_sum_finite CHECK (layout_sum BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_focal_sum_rigorous_finite CHECK (rigorous BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE ground_accuracy (
	run_id INTEGER NOT NULL, 
	line INTEGER NOT NULL, 
	place INTEGER NOT NULL, 
	x_mm REAL NOT NULL, 
	y_mm REAL NOT NULL, 
	"X_m" REAL, 
	"Y_m" REAL, 
	"Z_m" REAL, 
	"K_XX_m2" REAL, 
	"K_XY_m2" REAL, 
	"K_YY_m2" REAL, 
	"reading_XX_m2" REAL, 
	"reading_XY_m2" REAL, 
	"reading_YY_m2" REAL, 
	"height_XX_m2" REAL, 
	"height_XY_m2" REAL, 
	"height_YY_m2" REAL, 
	"sigma_X_m" REAL, 
	"sigma_Y_m" REAL, 
	ellipse_a_m REAL, 
	ellipse_b_m REAL, 
	ellipse_azimuth_deg REAL, 
	"K_xx_mm2" REAL, 
	"K_xy_mm2" REAL, 
	"K_yy_mm2" REAL, 
	sigma_x_mm REAL, 
	sigma_y_mm REAL, 
	ellipse_a_mm REAL, 
	ellipse_b_mm REAL, 
	ellipse_direction_deg REAL, 
	CONSTRAINT pk_ground_accuracy PRIMARY KEY (run_id, line, place), 
	CONSTRAINT fk_ground_accuracy_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_ground_accuracy_x_mm_finite CHECK (x_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_ground_accuracy_y_mm_finite CHECK (y_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_accuracy_X_m_finite" CHECK (X_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_accuracy_Y_m_finite" CHECK (Y_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_accuracy_Z_m_finite" CHECK (Z_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_accuracy_K_XX_m2_finite" CHECK (K_XX_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_accuracy_K_XY_m2_finite" CHECK (K_XY_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_accuracy_K_YY_m2_finite" CHECK (K_YY_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_accuracy_reading_XX_m2_finite" CHECK (reading_XX_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_accuracy_reading_XY_m2_finite" CHECK (reading_XY_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_accuracy_reading_YY_m2_finite" CHECK (reading_YY_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_accuracy_height_XX_m2_finite" CHECK (height_XX_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_accuracy_height_XY_m2_finite" CHECK (height_XY_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_accuracy_height_YY_m2_finite" CHECK (height_YY_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_accuracy_sigma_X_m_finite" CHECK (sigma_X_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_accuracy_sigma_Y_m_finite" CHECK (sigma_Y_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_ground_accuracy_ellipse_a_m_finite CHECK (ellipse_a_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_ground_accuracy_ellipse_b_m_finite CHECK (ellipse_b_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_ground_accuracy_ellipse_azimuth_deg_finite CHECK (ellipse_azimuth_deg BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_accuracy_K_xx_mm2_finite" CHECK (K_xx_mm2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_accuracy_K_xy_mm2_finite" CHECK (K_xy_mm2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_accuracy_K_yy_mm2_finite" CHECK (K_yy_mm2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_ground_accuracy_sigma_x_mm_finite CHECK (sigma_x_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_ground_accuracy_sigma_y_mm_finite CHECK (sigma_y_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_ground_accuracy_ellipse_a_mm_finite CHECK (ellipse_a_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_ground_accuracy_ellipse_b_mm_finite CHECK (ellipse_b_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_ground_accuracy_ellipse_direction_deg_finite CHECK (ellipse_direction_deg BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE ground_covariance_image (
	run_id INTEGER NOT NULL, 
	point TEXT NOT NULL, 
	"dx_dX_mm_m" REAL NOT NULL, 
	"dx_dY_mm_m" REAL NOT NULL, 
	"dy_dX_mm_m" REAL NOT NULL, 
	"dy_dY_mm_m" REAL NOT NULL, 
	"K_xx_mm2" REAL NOT NULL, 
	"K_xy_mm2" REAL NOT NULL, 
	"K_yy_mm2" REAL NOT NULL, 
	sigma_x_mm REAL NOT NULL, 
	sigma_y_mm REAL NOT NULL, 
	ellipse_a_mm REAL NOT NULL, 
	ellipse_b_mm REAL NOT NULL, 
	ellipse_direction_deg REAL NOT NULL, 
	CONSTRAINT pk_ground_covariance_image PRIMARY KEY (run_id, point), 
	CONSTRAINT fk_ground_covariance_image_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT "ck_ground_covariance_image_dx_dX_mm_m_finite" CHECK (dx_dX_mm_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_covariance_image_dx_dY_mm_m_finite" CHECK (dx_dY_mm_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_covariance_image_dy_dX_mm_m_finite" CHECK (dy_dX_mm_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_covariance_image_dy_dY_mm_m_finite" CHECK (dy_dY_mm_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_covariance_image_K_xx_mm2_finite" CHECK (K_xx_mm2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_covariance_image_K_xy_mm2_finite" CHECK (K_xy_mm2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_covariance_image_K_yy_mm2_finite" CHECK (K_yy_mm2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_ground_covariance_image_sigma_x_mm_finite CHECK (sigma_x_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_ground_covariance_image_sigma_y_mm_finite CHECK (sigma_y_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_ground_covariance_image_ellipse_a_mm_finite CHECK (ellipse_a_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_ground_covariance_image_ellipse_b_mm_finite CHECK (ellipse_b_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_ground_covariance_image_ellipse_direction_deg_finite CHECK (ellipse_direction_deg BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE independent_solution (
	run_id INTEGER NOT NULL, 
	verified_run_id INTEGER NOT NULL, 
	engine TEXT NOT NULL, 
	subject TEXT NOT NULL, 
	quantity TEXT NOT NULL, 
	difference REAL NOT NULL, 
	relative_to TEXT NOT NULL, 
	allowed REAL NOT NULL, 
	agrees INTEGER NOT NULL, 
	CONSTRAINT pk_independent_solution PRIMARY KEY (run_id, verified_run_id, engine, subject, quantity), 
	CONSTRAINT fk_independent_solution_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT fk_independent_solution_verified_run_id FOREIGN KEY(verified_run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_independent_solution_difference_finite CHECK (difference BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_independent_solution_allowed_finite CHECK (allowed BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE interior_covariance (
	run_id INTEGER NOT NULL, 
	"IJ" INTEGER NOT NULL, 
	i INTEGER NOT NULL, 
	j INTEGER NOT NULL, 
	unknown_i TEXT NOT NULL, 
	unknown_j TEXT NOT NULL, 
	value REAL NOT NULL, 
	CONSTRAINT pk_interior_covariance PRIMARY KEY (run_id, "IJ"), 
	CONSTRAINT fk_interior_covariance_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_interior_covariance_value_finite CHECK (value BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE known_element (
	run_id INTEGER NOT NULL, 
	quantity TEXT NOT NULL, 
	unit TEXT NOT NULL, 
	value REAL NOT NULL, 
	sigma REAL, 
	CONSTRAINT pk_known_element PRIMARY KEY (run_id, quantity), 
	CONSTRAINT ck_known_element_unit CHECK (unit IN ('m', 'deg')), 
	CONSTRAINT fk_known_element_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_known_element_value_finite CHECK (value BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_known_element_sigma_finite CHECK (sigma BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE known_residual (
	run_id INTEGER NOT NULL, 
	quantity TEXT NOT NULL, 
	unit TEXT NOT NULL, 
	sigma REAL NOT NULL, 
	v REAL NOT NULL, 
	redundancy_number REAL NOT NULL, 
	CONSTRAINT pk_known_residual PRIMARY KEY (run_id, quantity), 
	CONSTRAINT fk_known_residual_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_known_residual_sigma_finite CHECK (sigma BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_known_residual_v_finite CHECK (v BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_known_residual_redundancy_number_finite CHECK (redundancy_number BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE model_ground_point (
	run_id INTEGER NOT NULL, 
	zone TEXT NOT NULL, 
	point TEXT NOT NULL, 
	role TEXT NOT NULL, 
	"X_m" REAL NOT NULL, 
	"Y_m" REAL NOT NULL, 
	"Z_m" REAL NOT NULL, 
	"B_deg" REAL, 
	"L_deg" REAL, 
	"H_m" REAL, 
	"cov_XX_m2" REAL, 
	"cov_XY_m2" REAL, 
	"cov_XZ_m2" REAL, 
	"cov_YY_m2" REAL, 
	"cov_YZ_m2" REAL, 
	"cov_ZZ_m2" REAL, 
	CONSTRAINT pk_model_ground_point PRIMARY KEY (run_id, zone, point), 
	CONSTRAINT ck_model_ground_point_role CHECK (role IN ('control', 'check', 'free')), 
	CONSTRAINT fk_model_ground_point_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT "ck_model_ground_point_X_m_finite" CHECK (X_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_model_ground_point_Y_m_finite" CHECK (Y_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_model_ground_point_Z_m_finite" CHECK (Z_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_model_ground_point_B_deg_finite" CHECK (B_deg BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_model_ground_point_L_deg_finite" CHECK (L_deg BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_model_ground_point_H_m_finite" CHECK (H_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_model_ground_point_cov_XX_m2_finite" CHECK (cov_XX_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_model_ground_point_cov_XY_m2_finite" CHECK (cov_XY_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_model_ground_point_cov_XZ_m2_finite" CHECK (cov_XZ_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_model_ground_point_cov_YY_m2_finite" CHECK (cov_YY_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_model_ground_point_cov_YZ_m2_finite" CHECK (cov_YZ_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_model_ground_point_cov_ZZ_m2_finite" CHECK (cov_ZZ_m2 BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE INDEX ix_model_ground_point_run_id_point ON model_ground_point (run_id, point);

ALTER TABLE model_point RENAME TO before_model_point;

CREATE TABLE model_point (
	run_id INTEGER NOT NULL, 
	zone TEXT NOT NULL, 
	point TEXT NOT NULL, 
	x REAL NOT NULL, 
	y REAL NOT NULL, 
	z REAL NOT NULL, 
	cov_xx REAL, 
	cov_xy REAL, 
	cov_xz REAL, 
	cov_yy REAL, 
	cov_yz REAL, 
	cov_zz REAL, 
	CONSTRAINT pk_model_point PRIMARY KEY (run_id, zone, point), 
	CONSTRAINT ck_model_point_covariance CHECK ((cov_xx IS NULL) + (cov_xy IS NULL) + (cov_xz IS NULL) + (cov_yy IS NULL) + (cov_yz IS NULL) + (cov_zz IS NULL) IN (0, 6)), 
	CONSTRAINT fk_model_point_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_model_point_x_finite CHECK (x BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_model_point_y_finite CHECK (y BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_model_point_z_finite CHECK (z BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_model_point_cov_xx_finite CHECK (cov_xx BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_model_point_cov_xy_finite CHECK (cov_xy BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_model_point_cov_xz_finite CHECK (cov_xz BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_model_point_cov_yy_finite CHECK (cov_yy BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_model_point_cov_yz_finite CHECK (cov_yz BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_model_point_cov_zz_finite CHECK (cov_zz BETWEEN -1e15 AND 1e15)
)
 STRICT;

INSERT INTO model_point ("run_id", "zone", "point", "x", "y", "z") SELECT "run_id", "zone", "point", "x", "y", "z" FROM before_model_point;

DROP TABLE before_model_point;

CREATE TABLE observation_test (
	run_id INTEGER NOT NULL, 
	kind TEXT NOT NULL, 
	part TEXT NOT NULL, 
	point TEXT NOT NULL, 
	axis TEXT NOT NULL, 
	unit TEXT NOT NULL, 
	v REAL NOT NULL, 
	redundancy_number REAL NOT NULL, 
	share REAL NOT NULL, 
	w REAL, 
	smallest_error REAL, 
	bias_to_noise REAL, 
	ground_shift_m REAL, 
	ground_shift_point TEXT, 
	rho REAL, 
	rho_with TEXT, 
	verdict TEXT NOT NULL, 
	CONSTRAINT pk_observation_test PRIMARY KEY (run_id, kind, part, point, axis), 
	CONSTRAINT ck_observation_test_kind CHECK (kind IN ('image', 'ground', 'coefficient', 'known', 'cross')), 
	CONSTRAINT ck_observation_test_verdict CHECK (verdict IN ('good', 'suspect', 'hardly checked', 'not checked')), 
	CONSTRAINT fk_observation_test_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_observation_test_v_finite CHECK (v BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_observation_test_redundancy_number_finite CHECK (redundancy_number BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_observation_test_share_finite CHECK (share BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_observation_test_w_finite CHECK (w BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_observation_test_smallest_error_finite CHECK (smallest_error BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_observation_test_bias_to_noise_finite CHECK (bias_to_noise BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_observation_test_ground_shift_m_finite CHECK (ground_shift_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_observation_test_rho_finite CHECK (rho BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE point_test (
	run_id INTEGER NOT NULL, 
	part TEXT NOT NULL, 
	point TEXT NOT NULL, 
	statistic REAL, 
	freedom INTEGER NOT NULL, 
	probability REAL, 
	CONSTRAINT pk_point_test PRIMARY KEY (run_id, part, point), 
	CONSTRAINT fk_point_test_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_point_test_statistic_finite CHECK (statistic BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_point_test_probability_finite CHECK (probability BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE resection_solution (
	run_id INTEGER NOT NULL, 
	solution INTEGER NOT NULL, 
	termination TEXT NOT NULL, 
	is_as_good INTEGER NOT NULL, 
	"X_S_m" REAL, 
	"Y_S_m" REAL, 
	"Z_S_m" REAL, 
	q_w REAL, 
	q_x REAL, 
	q_y REAL, 
	q_z REAL, 
	"vPv" REAL, 
	n_points INTEGER NOT NULL, 
	n_in_front INTEGER NOT NULL, 
	height_above_m REAL, 
	iterations INTEGER NOT NULL, 
	CONSTRAINT pk_resection_solution PRIMARY KEY (run_id, solution), 
	CONSTRAINT fk_resection_solution_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT "ck_resection_solution_X_S_m_finite" CHECK (X_S_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_resection_solution_Y_S_m_finite" CHECK (Y_S_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_resection_solution_Z_S_m_finite" CHECK (Z_S_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_resection_solution_q_w_finite CHECK (q_w BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_resection_solution_q_x_finite CHECK (q_x BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_resection_solution_q_y_finite CHECK (q_y BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_resection_solution_q_z_finite CHECK (q_z BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_resection_solution_vPv_finite" CHECK (vPv BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_resection_solution_height_above_m_finite CHECK (height_above_m BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE simulated_spread (
	run_id INTEGER NOT NULL, 
	verified_run_id INTEGER NOT NULL, 
	unknown TEXT NOT NULL, 
	n INTEGER NOT NULL, 
	n_failed INTEGER NOT NULL, 
	predicted REAL NOT NULL, 
	simulated REAL NOT NULL, 
	ratio REAL NOT NULL, 
	allowed REAL NOT NULL, 
	agrees INTEGER NOT NULL, 
	CONSTRAINT pk_simulated_spread PRIMARY KEY (run_id, verified_run_id, unknown), 
	CONSTRAINT fk_simulated_spread_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT fk_simulated_spread_verified_run_id FOREIGN KEY(verified_run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_simulated_spread_predicted_finite CHECK (predicted BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_simulated_spread_simulated_finite CHECK (simulated BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_simulated_spread_ratio_finite CHECK (ratio BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_simulated_spread_allowed_finite CHECK (allowed BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE source_cofactor (
	run_id INTEGER NOT NULL, 
	source TEXT NOT NULL, 
	"IJ" INTEGER NOT NULL, 
	i INTEGER NOT NULL, 
	j INTEGER NOT NULL, 
	unknown_i TEXT NOT NULL, 
	unknown_j TEXT NOT NULL, 
	value REAL NOT NULL, 
	CONSTRAINT pk_source_cofactor PRIMARY KEY (run_id, source, "IJ"), 
	CONSTRAINT fk_source_cofactor_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_source_cofactor_value_finite CHECK (value BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE start_candidate (
	run_id INTEGER NOT NULL, 
	candidate INTEGER NOT NULL, 
	method TEXT NOT NULL, 
	is_reversed INTEGER NOT NULL, 
	points TEXT NOT NULL, 
	"X_S_m" REAL NOT NULL, 
	"Y_S_m" REAL NOT NULL, 
	"Z_S_m" REAL NOT NULL, 
	q_w REAL NOT NULL, 
	q_x REAL NOT NULL, 
	q_y REAL NOT NULL, 
	q_z REAL NOT NULL, 
	rms_mm REAL, 
	n_points INTEGER NOT NULL, 
	n_in_front INTEGER NOT NULL, 
	height_above_m REAL NOT NULL, 
	solution INTEGER, 
	CONSTRAINT pk_start_candidate PRIMARY KEY (run_id, candidate), 
	CONSTRAINT ck_start_candidate_method CHECK (method IN ('three points', 'direct linear', 'plane', 'approximate station')), 
	CONSTRAINT fk_start_candidate_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT "ck_start_candidate_X_S_m_finite" CHECK (X_S_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_start_candidate_Y_S_m_finite" CHECK (Y_S_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_start_candidate_Z_S_m_finite" CHECK (Z_S_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_start_candidate_q_w_finite CHECK (q_w BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_start_candidate_q_x_finite CHECK (q_x BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_start_candidate_q_y_finite CHECK (q_y BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_start_candidate_q_z_finite CHECK (q_z BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_start_candidate_rms_mm_finite CHECK (rms_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_start_candidate_height_above_m_finite CHECK (height_above_m BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE verified_difference (
	run_id INTEGER NOT NULL, 
	seq INTEGER NOT NULL, 
	verified_run_id INTEGER, 
	place TEXT NOT NULL, 
	stored TEXT NOT NULL, 
	recomputed TEXT NOT NULL, 
	difference REAL, 
	CONSTRAINT pk_verified_difference PRIMARY KEY (run_id, seq), 
	CONSTRAINT fk_verified_difference_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT fk_verified_difference_verified_run_id FOREIGN KEY(verified_run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_verified_difference_difference_finite CHECK (difference BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE verified_run (
	run_id INTEGER NOT NULL, 
	verified_run_id INTEGER NOT NULL, 
	output_digest TEXT NOT NULL, 
	method TEXT NOT NULL, 
	compared TEXT NOT NULL, 
	because TEXT NOT NULL, 
	verdict TEXT NOT NULL, 
	n_values INTEGER NOT NULL, 
	n_identical INTEGER NOT NULL, 
	n_different INTEGER NOT NULL, 
	largest_difference REAL, 
	largest_at TEXT NOT NULL, 
	stored TEXT NOT NULL, 
	recomputed TEXT NOT NULL, 
	second_engine TEXT NOT NULL, 
	CONSTRAINT pk_verified_run PRIMARY KEY (run_id, verified_run_id), 
	CONSTRAINT ck_verified_run_method CHECK (method IN ('recomputed', 'digest')), 
	CONSTRAINT ck_verified_run_compared CHECK (compared IN ('bits', '1e-9')), 
	CONSTRAINT ck_verified_run_verdict CHECK (verdict IN ('identical', 'agrees', 'differs')), 
	CONSTRAINT fk_verified_run_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT fk_verified_run_verified_run_id FOREIGN KEY(verified_run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_verified_run_largest_difference_finite CHECK (largest_difference BETWEEN -1e15 AND 1e15)
)
 STRICT;
