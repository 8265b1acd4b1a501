CREATE TABLE stage_run (
	run_id INTEGER NOT NULL, 
	stage TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	stage_version INTEGER NOT NULL, 
	settings TEXT NOT NULL, 
	input_digest TEXT NOT NULL, 
	actor TEXT NOT NULL, 
	reason TEXT NOT NULL, 
	tool_version TEXT NOT NULL, 
	started_at TEXT NOT NULL, 
	CONSTRAINT pk_stage_run PRIMARY KEY (run_id), 
	CONSTRAINT uq_stage_run_stage_version UNIQUE (stage, version)
)
 STRICT;

CREATE INDEX ix_stage_run_input_digest ON stage_run (input_digest);

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

CREATE TABLE adjusted_coefficient (
	run_id INTEGER NOT NULL, 
	sheet TEXT NOT NULL, 
	coordinate TEXT NOT NULL, 
	power_u INTEGER NOT NULL, 
	power_v INTEGER NOT NULL, 
	value REAL NOT NULL, 
	correction REAL NOT NULL, 
	q REAL NOT NULL, 
	variance_ratio REAL NOT NULL, 
	CONSTRAINT pk_adjusted_coefficient PRIMARY KEY (run_id, sheet, coordinate, power_u, power_v), 
	CONSTRAINT ck_adjusted_coefficient_coordinate CHECK (coordinate IN ('B', 'L', 'N', 'E')), 
	CONSTRAINT fk_adjusted_coefficient_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_adjusted_coefficient_value_finite CHECK (value BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_adjusted_coefficient_correction_finite CHECK (correction BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_adjusted_coefficient_q_finite CHECK (q BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_adjusted_coefficient_variance_ratio_finite CHECK (variance_ratio BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE adjusted_point (
	run_id INTEGER NOT NULL, 
	point TEXT NOT NULL, 
	"X_m" REAL NOT NULL, 
	"Y_m" REAL NOT NULL, 
	"Z_m" REAL NOT NULL, 
	"dX_m" REAL NOT NULL, 
	"dY_m" REAL NOT NULL, 
	"dZ_m" REAL NOT NULL, 
	"q_XX" REAL NOT NULL, 
	"q_XY" REAL NOT NULL, 
	"q_XZ" REAL NOT NULL, 
	"q_YY" REAL NOT NULL, 
	"q_YZ" REAL NOT NULL, 
	"q_ZZ" REAL NOT NULL, 
	CONSTRAINT pk_adjusted_point PRIMARY KEY (run_id, point), 
	CONSTRAINT fk_adjusted_point_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT "ck_adjusted_point_X_m_finite" CHECK (X_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_adjusted_point_Y_m_finite" CHECK (Y_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_adjusted_point_Z_m_finite" CHECK (Z_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_adjusted_point_dX_m_finite" CHECK (dX_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_adjusted_point_dY_m_finite" CHECK (dY_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_adjusted_point_dZ_m_finite" CHECK (dZ_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_adjusted_point_q_XX_finite" CHECK (q_XX BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_adjusted_point_q_XY_finite" CHECK (q_XY BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_adjusted_point_q_XZ_finite" CHECK (q_XZ BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_adjusted_point_q_YY_finite" CHECK (q_YY BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_adjusted_point_q_YZ_finite" CHECK (q_YZ BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_adjusted_point_q_ZZ_finite" CHECK (q_ZZ BETWEEN -1e15 AND 1e15)
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

CREATE TABLE cofactor (
	run_id INTEGER NOT NULL, 
	unknowns TEXT NOT NULL, 
	"IJ" INTEGER NOT NULL, 
	i INTEGER NOT NULL, 
	j INTEGER NOT NULL, 
	unknown_i TEXT NOT NULL, 
	unknown_j TEXT NOT NULL, 
	value REAL NOT NULL, 
	CONSTRAINT pk_cofactor PRIMARY KEY (run_id, unknowns, "IJ"), 
	CONSTRAINT fk_cofactor_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_cofactor_value_finite CHECK (value BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE comparator_reading (
	run_id INTEGER NOT NULL, 
	seq INTEGER NOT NULL, 
	point TEXT NOT NULL, 
	kind TEXT NOT NULL, 
	cycle INTEGER NOT NULL, 
	x_mm REAL, 
	y_mm REAL, 
	col_px REAL, 
	row_px REAL, 
	sigma REAL, 
	CONSTRAINT pk_comparator_reading PRIMARY KEY (run_id, seq), 
	CONSTRAINT ck_comparator_reading_kind CHECK (kind IN ('point', 'fiducial')), 
	CONSTRAINT ck_comparator_reading_mm_or_px CHECK ((x_mm IS NULL) = (y_mm IS NULL) AND (col_px IS NULL) = (row_px IS NULL) AND (x_mm IS NULL) <> (col_px IS NULL)), 
	CONSTRAINT fk_comparator_reading_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_comparator_reading_x_mm_finite CHECK (x_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_comparator_reading_y_mm_finite CHECK (y_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_comparator_reading_col_px_finite CHECK (col_px BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_comparator_reading_row_px_finite CHECK (row_px BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_comparator_reading_sigma_finite CHECK (sigma BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE INDEX ix_comparator_reading_run_id_point ON comparator_reading (run_id, point);

CREATE TABLE control_point (
	run_id INTEGER NOT NULL, 
	point TEXT NOT NULL, 
	role TEXT NOT NULL, 
	kind TEXT NOT NULL, 
	"B_deg" REAL, 
	"L_deg" REAL, 
	"E_m" REAL, 
	"N_m" REAL, 
	"H_m" REAL, 
	"X_m" REAL, 
	"Y_m" REAL, 
	"Z_m" REAL, 
	"cov_XX_m2" REAL, 
	"cov_XY_m2" REAL, 
	"cov_XZ_m2" REAL, 
	"cov_YY_m2" REAL, 
	"cov_YZ_m2" REAL, 
	"cov_ZZ_m2" REAL, 
	CONSTRAINT pk_control_point PRIMARY KEY (run_id, point), 
	CONSTRAINT ck_control_point_role CHECK (role IN ('control', 'check')), 
	CONSTRAINT ck_control_point_kind CHECK (kind IN ('geographic', 'projected', 'geocentric', 'local', 'none')), 
	CONSTRAINT fk_control_point_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT "ck_control_point_B_deg_finite" CHECK (B_deg BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_control_point_L_deg_finite" CHECK (L_deg BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_control_point_E_m_finite" CHECK (E_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_control_point_N_m_finite" CHECK (N_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_control_point_H_m_finite" CHECK (H_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_control_point_X_m_finite" CHECK (X_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_control_point_Y_m_finite" CHECK (Y_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_control_point_Z_m_finite" CHECK (Z_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_control_point_cov_XX_m2_finite" CHECK (cov_XX_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_control_point_cov_XY_m2_finite" CHECK (cov_XY_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_control_point_cov_XZ_m2_finite" CHECK (cov_XZ_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_control_point_cov_YY_m2_finite" CHECK (cov_YY_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_control_point_cov_YZ_m2_finite" CHECK (cov_YZ_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_control_point_cov_ZZ_m2_finite" CHECK (cov_ZZ_m2 BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE control_system (
	run_id INTEGER NOT NULL, 
	crs TEXT, 
	handedness TEXT, 
	CONSTRAINT pk_control_system PRIMARY KEY (run_id), 
	CONSTRAINT fk_control_system_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id)
)
 STRICT;

CREATE TABLE cross_residual (
	run_id INTEGER NOT NULL, 
	sheet TEXT NOT NULL, 
	"cross" TEXT NOT NULL, 
	role TEXT NOT NULL, 
	"v_N_m" REAL NOT NULL, 
	"v_E_m" REAL NOT NULL, 
	redundancy_number REAL, 
	statistic REAL, 
	probability REAL, 
	is_suspect INTEGER NOT NULL, 
	CONSTRAINT pk_cross_residual PRIMARY KEY (run_id, sheet, "cross"), 
	CONSTRAINT fk_cross_residual_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT "ck_cross_residual_v_N_m_finite" CHECK (v_N_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_cross_residual_v_E_m_finite" CHECK (v_E_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_cross_residual_redundancy_number_finite CHECK (redundancy_number BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_cross_residual_statistic_finite CHECK (statistic BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_cross_residual_probability_finite CHECK (probability BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE crs_operation (
	run_id INTEGER NOT NULL, 
	source TEXT NOT NULL, 
	source_crs TEXT NOT NULL, 
	target_crs TEXT NOT NULL, 
	name TEXT NOT NULL, 
	definition TEXT NOT NULL, 
	accuracy_m REAL, 
	grids TEXT NOT NULL, 
	is_ballpark INTEGER NOT NULL, 
	proj_version TEXT NOT NULL, 
	CONSTRAINT pk_crs_operation PRIMARY KEY (run_id, source), 
	CONSTRAINT fk_crs_operation_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_crs_operation_accuracy_m_finite CHECK (accuracy_m BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE cycle_residual (
	run_id INTEGER NOT NULL, 
	seq INTEGER NOT NULL, 
	point TEXT NOT NULL, 
	kind TEXT NOT NULL, 
	cycle INTEGER NOT NULL, 
	vx_mm REAL NOT NULL, 
	vy_mm REAL NOT NULL, 
	statistic REAL, 
	is_outlier INTEGER NOT NULL, 
	is_used INTEGER NOT NULL, 
	CONSTRAINT pk_cycle_residual PRIMARY KEY (run_id, seq), 
	CONSTRAINT fk_cycle_residual_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_cycle_residual_vx_mm_finite CHECK (vx_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_cycle_residual_vy_mm_finite CHECK (vy_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_cycle_residual_statistic_finite CHECK (statistic BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE INDEX ix_cycle_residual_run_id_point ON cycle_residual (run_id, point);

CREATE TABLE digitized_point (
	run_id INTEGER NOT NULL, 
	sheet TEXT NOT NULL, 
	point TEXT NOT NULL, 
	n_cycles INTEGER NOT NULL, 
	"X_mm" REAL NOT NULL, 
	"Y_mm" REAL NOT NULL, 
	sigma_cycles_mm REAL, 
	"B_deg" REAL, 
	"L_deg" REAL, 
	"E_m" REAL, 
	"N_m" REAL, 
	"H_m" REAL, 
	"cov_NN_m2" REAL NOT NULL, 
	"cov_NE_m2" REAL NOT NULL, 
	"cov_EE_m2" REAL NOT NULL, 
	"cov_reading_NN_m2" REAL NOT NULL, 
	"cov_reading_NE_m2" REAL NOT NULL, 
	"cov_reading_EE_m2" REAL NOT NULL, 
	"sigma_H_m" REAL, 
	CONSTRAINT pk_digitized_point PRIMARY KEY (run_id, sheet, point), 
	CONSTRAINT fk_digitized_point_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT "ck_digitized_point_X_mm_finite" CHECK (X_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_digitized_point_Y_mm_finite" CHECK (Y_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_digitized_point_sigma_cycles_mm_finite CHECK (sigma_cycles_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_digitized_point_B_deg_finite" CHECK (B_deg BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_digitized_point_L_deg_finite" CHECK (L_deg BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_digitized_point_E_m_finite" CHECK (E_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_digitized_point_N_m_finite" CHECK (N_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_digitized_point_H_m_finite" CHECK (H_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_digitized_point_cov_NN_m2_finite" CHECK (cov_NN_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_digitized_point_cov_NE_m2_finite" CHECK (cov_NE_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_digitized_point_cov_EE_m2_finite" CHECK (cov_EE_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_digitized_point_cov_reading_NN_m2_finite" CHECK (cov_reading_NN_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_digitized_point_cov_reading_NE_m2_finite" CHECK (cov_reading_NE_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_digitized_point_cov_reading_EE_m2_finite" CHECK (cov_reading_EE_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_digitized_point_sigma_H_m_finite" CHECK (sigma_H_m BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE digitizer_reading (
	run_id INTEGER NOT NULL, 
	seq INTEGER NOT NULL, 
	sheet TEXT NOT NULL, 
	point TEXT NOT NULL, 
	cycle INTEGER NOT NULL, 
	"X_mm" REAL NOT NULL, 
	"Y_mm" REAL NOT NULL, 
	"H_m" REAL, 
	"sigma_H_m" REAL, 
	CONSTRAINT pk_digitizer_reading PRIMARY KEY (run_id, seq), 
	CONSTRAINT fk_digitizer_reading_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT "ck_digitizer_reading_X_mm_finite" CHECK (X_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_digitizer_reading_Y_mm_finite" CHECK (Y_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_digitizer_reading_H_m_finite" CHECK (H_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_digitizer_reading_sigma_H_m_finite" CHECK (sigma_H_m BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE INDEX ix_digitizer_reading_run_id_sheet_point ON digitizer_reading (run_id, sheet, point);

CREATE TABLE distortion_coefficient (
	run_id INTEGER NOT NULL, 
	name TEXT NOT NULL, 
	value REAL NOT NULL, 
	CONSTRAINT pk_distortion_coefficient PRIMARY KEY (run_id, name), 
	CONSTRAINT fk_distortion_coefficient_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_distortion_coefficient_value_finite CHECK (value BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE distortion_radial (
	run_id INTEGER NOT NULL, 
	radius_mm REAL NOT NULL, 
	distortion_mm REAL NOT NULL, 
	CONSTRAINT pk_distortion_radial PRIMARY KEY (run_id, radius_mm), 
	CONSTRAINT fk_distortion_radial_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_distortion_radial_radius_mm_finite CHECK (radius_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_distortion_radial_distortion_mm_finite CHECK (distortion_mm BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE equation (
	run_id INTEGER NOT NULL, 
	point TEXT NOT NULL, 
	axis TEXT NOT NULL, 
	a1 REAL NOT NULL, 
	a2 REAL NOT NULL, 
	a3 REAL NOT NULL, 
	a4 REAL NOT NULL, 
	a5 REAL NOT NULL, 
	a6 REAL NOT NULL, 
	a7 REAL NOT NULL, 
	a8 REAL NOT NULL, 
	a9 REAL NOT NULL, 
	l_mm REAL NOT NULL, 
	CONSTRAINT pk_equation PRIMARY KEY (run_id, point, axis), 
	CONSTRAINT ck_equation_axis CHECK (axis IN ('x', 'y')), 
	CONSTRAINT fk_equation_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_equation_a1_finite CHECK (a1 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_equation_a2_finite CHECK (a2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_equation_a3_finite CHECK (a3 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_equation_a4_finite CHECK (a4 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_equation_a5_finite CHECK (a5 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_equation_a6_finite CHECK (a6 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_equation_a7_finite CHECK (a7 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_equation_a8_finite CHECK (a8 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_equation_a9_finite CHECK (a9 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_equation_l_mm_finite CHECK (l_mm BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE fiducial_mark (
	run_id INTEGER NOT NULL, 
	mark TEXT NOT NULL, 
	x_mm REAL NOT NULL, 
	y_mm REAL NOT NULL, 
	CONSTRAINT pk_fiducial_mark PRIMARY KEY (run_id, mark), 
	CONSTRAINT fk_fiducial_mark_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_fiducial_mark_x_mm_finite CHECK (x_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_fiducial_mark_y_mm_finite CHECK (y_mm BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE fiducial_residual (
	run_id INTEGER NOT NULL, 
	mark TEXT NOT NULL, 
	x_mm REAL NOT NULL, 
	y_mm REAL NOT NULL, 
	vx_mm REAL NOT NULL, 
	vy_mm REAL NOT NULL, 
	CONSTRAINT pk_fiducial_residual PRIMARY KEY (run_id, mark), 
	CONSTRAINT fk_fiducial_residual_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_fiducial_residual_x_mm_finite CHECK (x_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_fiducial_residual_y_mm_finite CHECK (y_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_fiducial_residual_vx_mm_finite CHECK (vx_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_fiducial_residual_vy_mm_finite CHECK (vy_mm BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE geographic_point (
	run_id INTEGER NOT NULL, 
	point TEXT NOT NULL, 
	role TEXT NOT NULL, 
	source TEXT NOT NULL, 
	weighting TEXT NOT NULL, 
	"B_deg" REAL, 
	"L_deg" REAL, 
	"H_m" REAL, 
	"X_m" REAL, 
	"Y_m" REAL, 
	"Z_m" REAL, 
	"cov_XX_m2" REAL, 
	"cov_XY_m2" REAL, 
	"cov_XZ_m2" REAL, 
	"cov_YY_m2" REAL, 
	"cov_YZ_m2" REAL, 
	"cov_ZZ_m2" REAL, 
	sheet_north_deg REAL, 
	CONSTRAINT pk_geographic_point PRIMARY KEY (run_id, point), 
	CONSTRAINT ck_geographic_point_role CHECK (role IN ('control', 'check')), 
	CONSTRAINT ck_geographic_point_weighting CHECK (weighting IN ('fixed', 'weighted')), 
	CONSTRAINT fk_geographic_point_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT "ck_geographic_point_B_deg_finite" CHECK (B_deg BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_geographic_point_L_deg_finite" CHECK (L_deg BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_geographic_point_H_m_finite" CHECK (H_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_geographic_point_X_m_finite" CHECK (X_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_geographic_point_Y_m_finite" CHECK (Y_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_geographic_point_Z_m_finite" CHECK (Z_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_geographic_point_cov_XX_m2_finite" CHECK (cov_XX_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_geographic_point_cov_XY_m2_finite" CHECK (cov_XY_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_geographic_point_cov_XZ_m2_finite" CHECK (cov_XZ_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_geographic_point_cov_YY_m2_finite" CHECK (cov_YY_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_geographic_point_cov_YZ_m2_finite" CHECK (cov_YZ_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_geographic_point_cov_ZZ_m2_finite" CHECK (cov_ZZ_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_geographic_point_sheet_north_deg_finite CHECK (sheet_north_deg BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE graticule_cross (
	run_id INTEGER NOT NULL, 
	seq INTEGER NOT NULL, 
	sheet TEXT NOT NULL, 
	"cross" TEXT NOT NULL, 
	role TEXT NOT NULL, 
	"X_mm" REAL NOT NULL, 
	"Y_mm" REAL NOT NULL, 
	"B_deg" REAL, 
	"L_deg" REAL, 
	"E_m" REAL, 
	"N_m" REAL, 
	CONSTRAINT pk_graticule_cross PRIMARY KEY (run_id, seq), 
	CONSTRAINT ck_graticule_cross_role CHECK (role IN ('fit', 'check')), 
	CONSTRAINT ck_graticule_cross_geographic_or_grid CHECK ((B_deg IS NULL) <> (E_m IS NULL)), 
	CONSTRAINT fk_graticule_cross_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT "ck_graticule_cross_X_mm_finite" CHECK (X_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_graticule_cross_Y_mm_finite" CHECK (Y_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_graticule_cross_B_deg_finite" CHECK (B_deg BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_graticule_cross_L_deg_finite" CHECK (L_deg BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_graticule_cross_E_m_finite" CHECK (E_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_graticule_cross_N_m_finite" CHECK (N_m BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE INDEX ix_graticule_cross_run_id_sheet ON graticule_cross (run_id, sheet);

CREATE TABLE ground_covariance (
	run_id INTEGER NOT NULL, 
	point TEXT NOT NULL, 
	role TEXT NOT NULL, 
	"X_m" REAL NOT NULL, 
	"Y_m" REAL NOT NULL, 
	"Z_m" REAL NOT NULL, 
	"dX_m" REAL, 
	"dY_m" REAL, 
	"K_XX_m2" REAL NOT NULL, 
	"K_XY_m2" REAL NOT NULL, 
	"K_YY_m2" REAL NOT NULL, 
	"reading_XX_m2" REAL NOT NULL, 
	"reading_XY_m2" REAL NOT NULL, 
	"reading_YY_m2" REAL NOT NULL, 
	"height_XX_m2" REAL NOT NULL, 
	"height_XY_m2" REAL NOT NULL, 
	"height_YY_m2" REAL NOT NULL, 
	"sigma_X_m" REAL NOT NULL, 
	"sigma_Y_m" REAL NOT NULL, 
	ellipse_a_m REAL NOT NULL, 
	ellipse_b_m REAL NOT NULL, 
	ellipse_azimuth_deg REAL NOT NULL, 
	CONSTRAINT pk_ground_covariance PRIMARY KEY (run_id, point), 
	CONSTRAINT fk_ground_covariance_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT "ck_ground_covariance_X_m_finite" CHECK (X_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_covariance_Y_m_finite" CHECK (Y_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_covariance_Z_m_finite" CHECK (Z_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_covariance_dX_m_finite" CHECK (dX_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_covariance_dY_m_finite" CHECK (dY_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_covariance_K_XX_m2_finite" CHECK (K_XX_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_covariance_K_XY_m2_finite" CHECK (K_XY_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_covariance_K_YY_m2_finite" CHECK (K_YY_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_covariance_reading_XX_m2_finite" CHECK (reading_XX_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_covariance_reading_XY_m2_finite" CHECK (reading_XY_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_covariance_reading_YY_m2_finite" CHECK (reading_YY_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_covariance_height_XX_m2_finite" CHECK (height_XX_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_covariance_height_XY_m2_finite" CHECK (height_XY_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_covariance_height_YY_m2_finite" CHECK (height_YY_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_covariance_sigma_X_m_finite" CHECK (sigma_X_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_covariance_sigma_Y_m_finite" CHECK (sigma_Y_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_ground_covariance_ellipse_a_m_finite CHECK (ellipse_a_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_ground_covariance_ellipse_b_m_finite CHECK (ellipse_b_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_ground_covariance_ellipse_azimuth_deg_finite CHECK (ellipse_azimuth_deg BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE ground_covariance_pair (
	run_id INTEGER NOT NULL, 
	point_i TEXT NOT NULL, 
	point_j TEXT NOT NULL, 
	"K_XX_m2" REAL NOT NULL, 
	"K_XY_m2" REAL NOT NULL, 
	"K_YX_m2" REAL NOT NULL, 
	"K_YY_m2" REAL NOT NULL, 
	CONSTRAINT pk_ground_covariance_pair PRIMARY KEY (run_id, point_i, point_j), 
	CONSTRAINT fk_ground_covariance_pair_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT "ck_ground_covariance_pair_K_XX_m2_finite" CHECK (K_XX_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_covariance_pair_K_XY_m2_finite" CHECK (K_XY_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_covariance_pair_K_YX_m2_finite" CHECK (K_YX_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_ground_covariance_pair_K_YY_m2_finite" CHECK (K_YY_m2 BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE image_point (
	run_id INTEGER NOT NULL, 
	point TEXT NOT NULL, 
	n_cycles INTEGER NOT NULL, 
	x_comparator_mm REAL NOT NULL, 
	y_comparator_mm REAL NOT NULL, 
	sigma_cycles_mm REAL, 
	x_frame_mm REAL NOT NULL, 
	y_frame_mm REAL NOT NULL, 
	dx_principal_mm REAL NOT NULL, 
	dy_principal_mm REAL NOT NULL, 
	dx_distortion_mm REAL NOT NULL, 
	dy_distortion_mm REAL NOT NULL, 
	dx_refraction_mm REAL NOT NULL, 
	dy_refraction_mm REAL NOT NULL, 
	dx_curvature_mm REAL NOT NULL, 
	dy_curvature_mm REAL NOT NULL, 
	x_mm REAL NOT NULL, 
	y_mm REAL NOT NULL, 
	cov_xx_mm2 REAL NOT NULL, 
	cov_xy_mm2 REAL NOT NULL, 
	cov_yy_mm2 REAL NOT NULL, 
	CONSTRAINT pk_image_point PRIMARY KEY (run_id, point), 
	CONSTRAINT fk_image_point_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_image_point_x_comparator_mm_finite CHECK (x_comparator_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_image_point_y_comparator_mm_finite CHECK (y_comparator_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_image_point_sigma_cycles_mm_finite CHECK (sigma_cycles_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_image_point_x_frame_mm_finite CHECK (x_frame_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_image_point_y_frame_mm_finite CHECK (y_frame_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_image_point_dx_principal_mm_finite CHECK (dx_principal_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_image_point_dy_principal_mm_finite CHECK (dy_principal_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_image_point_dx_distortion_mm_finite CHECK (dx_distortion_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_image_point_dy_distortion_mm_finite CHECK (dy_distortion_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_image_point_dx_refraction_mm_finite CHECK (dx_refraction_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_image_point_dy_refraction_mm_finite CHECK (dy_refraction_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_image_point_dx_curvature_mm_finite CHECK (dx_curvature_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_image_point_dy_curvature_mm_finite CHECK (dy_curvature_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_image_point_x_mm_finite CHECK (x_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_image_point_y_mm_finite CHECK (y_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_image_point_cov_xx_mm2_finite CHECK (cov_xx_mm2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_image_point_cov_xy_mm2_finite CHECK (cov_xy_mm2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_image_point_cov_yy_mm2_finite CHECK (cov_yy_mm2 BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE image_residual (
	run_id INTEGER NOT NULL, 
	point TEXT NOT NULL, 
	role TEXT NOT NULL, 
	x_mm REAL NOT NULL, 
	y_mm REAL NOT NULL, 
	vx_mm REAL NOT NULL, 
	vy_mm REAL NOT NULL, 
	redundancy_x REAL, 
	redundancy_y REAL, 
	depth_m REAL NOT NULL, 
	CONSTRAINT pk_image_residual PRIMARY KEY (run_id, point), 
	CONSTRAINT fk_image_residual_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_image_residual_x_mm_finite CHECK (x_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_image_residual_y_mm_finite CHECK (y_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_image_residual_vx_mm_finite CHECK (vx_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_image_residual_vy_mm_finite CHECK (vy_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_image_residual_redundancy_x_finite CHECK (redundancy_x BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_image_residual_redundancy_y_finite CHECK (redundancy_y BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_image_residual_depth_m_finite CHECK (depth_m BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE interior_orientation (
	run_id INTEGER NOT NULL, 
	transformation TEXT NOT NULL, 
	n_marks INTEGER NOT NULL, 
	redundancy INTEGER NOT NULL, 
	sigma0_mm REAL, 
	CONSTRAINT pk_interior_orientation PRIMARY KEY (run_id), 
	CONSTRAINT fk_interior_orientation_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_interior_orientation_sigma0_mm_finite CHECK (sigma0_mm BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE interior_parameter (
	run_id INTEGER NOT NULL, 
	name TEXT NOT NULL, 
	value REAL NOT NULL, 
	sigma REAL, 
	CONSTRAINT pk_interior_parameter PRIMARY KEY (run_id, name), 
	CONSTRAINT fk_interior_parameter_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_interior_parameter_value_finite CHECK (value BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_interior_parameter_sigma_finite CHECK (sigma BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE iteration (
	run_id INTEGER NOT NULL, 
	iteration INTEGER NOT NULL, 
	"vPv" REAL NOT NULL, 
	max_scaled_step REAL NOT NULL, 
	damping REAL NOT NULL, 
	q_w REAL NOT NULL, 
	q_x REAL NOT NULL, 
	q_y REAL NOT NULL, 
	q_z REAL NOT NULL, 
	CONSTRAINT pk_iteration PRIMARY KEY (run_id, iteration), 
	CONSTRAINT fk_iteration_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT "ck_iteration_vPv_finite" CHECK (vPv BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_iteration_max_scaled_step_finite CHECK (max_scaled_step BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_iteration_damping_finite CHECK (damping BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_iteration_q_w_finite CHECK (q_w BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_iteration_q_x_finite CHECK (q_x BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_iteration_q_y_finite CHECK (q_y BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_iteration_q_z_finite CHECK (q_z BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE iteration_parameter (
	run_id INTEGER NOT NULL, 
	iteration INTEGER NOT NULL, 
	point TEXT NOT NULL, 
	unknown TEXT NOT NULL, 
	unit TEXT NOT NULL, 
	approximation REAL NOT NULL, 
	correction REAL NOT NULL, 
	CONSTRAINT pk_iteration_parameter PRIMARY KEY (run_id, iteration, point, unknown), 
	CONSTRAINT fk_iteration_parameter_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_iteration_parameter_approximation_finite CHECK (approximation BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_iteration_parameter_correction_finite CHECK (correction BETWEEN -1e15 AND 1e15)
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

CREATE TABLE map_sheet (
	run_id INTEGER NOT NULL, 
	sheet TEXT NOT NULL, 
	title TEXT NOT NULL, 
	crs TEXT, 
	degree INTEGER, 
	sigma_mm REAL, 
	pixel_size_mm REAL, 
	CONSTRAINT pk_map_sheet PRIMARY KEY (run_id, sheet), 
	CONSTRAINT fk_map_sheet_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_map_sheet_sigma_mm_finite CHECK (sigma_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_map_sheet_pixel_size_mm_finite CHECK (pixel_size_mm BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE model_point (
	run_id INTEGER NOT NULL, 
	zone TEXT NOT NULL, 
	point TEXT NOT NULL, 
	x REAL NOT NULL, 
	y REAL NOT NULL, 
	z REAL NOT NULL, 
	CONSTRAINT pk_model_point PRIMARY KEY (run_id, zone, point), 
	CONSTRAINT fk_model_point_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_model_point_x_finite CHECK (x BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_model_point_y_finite CHECK (y BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_model_point_z_finite CHECK (z BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE orientation (
	run_id INTEGER NOT NULL, 
	frame TEXT NOT NULL, 
	"X_S_m" REAL NOT NULL, 
	"Y_S_m" REAL NOT NULL, 
	"Z_S_m" REAL NOT NULL, 
	q_w REAL NOT NULL, 
	q_x REAL NOT NULL, 
	q_y REAL NOT NULL, 
	q_z REAL NOT NULL, 
	f_mm REAL NOT NULL, 
	"B_S_deg" REAL, 
	"L_S_deg" REAL, 
	"H_S_m" REAL, 
	"X_G_m" REAL, 
	"Y_G_m" REAL, 
	"Z_G_m" REAL, 
	n_control INTEGER NOT NULL, 
	n_equations INTEGER NOT NULL, 
	n_unknowns INTEGER NOT NULL, 
	redundancy INTEGER NOT NULL, 
	"vPv" REAL NOT NULL, 
	sigma0_apriori_mm REAL NOT NULL, 
	sigma0_mm REAL, 
	variance_scale REAL NOT NULL, 
	variance_basis TEXT NOT NULL, 
	condition_ratio REAL NOT NULL, 
	iterations INTEGER NOT NULL, 
	termination TEXT NOT NULL, 
	CONSTRAINT pk_orientation PRIMARY KEY (run_id), 
	CONSTRAINT fk_orientation_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT "ck_orientation_X_S_m_finite" CHECK (X_S_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_orientation_Y_S_m_finite" CHECK (Y_S_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_orientation_Z_S_m_finite" CHECK (Z_S_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_orientation_q_w_finite CHECK (q_w BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_orientation_q_x_finite CHECK (q_x BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_orientation_q_y_finite CHECK (q_y BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_orientation_q_z_finite CHECK (q_z BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_orientation_f_mm_finite CHECK (f_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_orientation_B_S_deg_finite" CHECK (B_S_deg BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_orientation_L_S_deg_finite" CHECK (L_S_deg BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_orientation_H_S_m_finite" CHECK (H_S_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_orientation_X_G_m_finite" CHECK (X_G_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_orientation_Y_G_m_finite" CHECK (Y_G_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_orientation_Z_G_m_finite" CHECK (Z_G_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_orientation_vPv_finite" CHECK (vPv BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_orientation_sigma0_apriori_mm_finite CHECK (sigma0_apriori_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_orientation_sigma0_mm_finite CHECK (sigma0_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_orientation_variance_scale_finite CHECK (variance_scale BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_orientation_condition_ratio_finite CHECK (condition_ratio BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE orientation_angle (
	run_id INTEGER NOT NULL, 
	triple TEXT NOT NULL, 
	frame TEXT NOT NULL, 
	angle TEXT NOT NULL, 
	value_deg REAL NOT NULL, 
	sigma_deg REAL, 
	near_blind INTEGER NOT NULL, 
	CONSTRAINT pk_orientation_angle PRIMARY KEY (run_id, triple, frame, angle), 
	CONSTRAINT fk_orientation_angle_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_orientation_angle_value_deg_finite CHECK (value_deg BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_orientation_angle_sigma_deg_finite CHECK (sigma_deg BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE photo (
	run_id INTEGER NOT NULL, 
	name TEXT NOT NULL, 
	taken_on TEXT, 
	image_file TEXT, 
	platform TEXT NOT NULL, 
	f_mm REAL NOT NULL, 
	x0_mm REAL NOT NULL, 
	y0_mm REAL NOT NULL, 
	sigma_f_mm REAL, 
	sigma_x0_mm REAL, 
	sigma_y0_mm REAL, 
	frame_width_mm REAL NOT NULL, 
	frame_height_mm REAL NOT NULL, 
	sigma_image_mm REAL NOT NULL, 
	pixel_size_mm REAL, 
	origin_col_px REAL, 
	origin_row_px REAL, 
	x_axis TEXT NOT NULL, 
	y_axis TEXT NOT NULL, 
	image_width_px INTEGER, 
	image_height_px INTEGER, 
	interior_transformation TEXT NOT NULL, 
	distortion_model TEXT NOT NULL, 
	distortion_direction TEXT NOT NULL, 
	refraction TEXT NOT NULL, 
	ground_kind TEXT NOT NULL, 
	ground_crs TEXT, 
	ellipsoid TEXT, 
	a_m REAL, 
	inverse_flattening REAL, 
	central_meridian_deg REAL, 
	handedness TEXT, 
	ground_height_m REAL, 
	camera_height_m REAL, 
	curvature_radius_m REAL, 
	"station_B_deg" REAL, 
	"station_L_deg" REAL, 
	"station_H_m" REAL, 
	"station_X_m" REAL, 
	"station_Y_m" REAL, 
	"station_Z_m" REAL, 
	CONSTRAINT pk_photo PRIMARY KEY (run_id), 
	CONSTRAINT ck_photo_platform CHECK (platform IN ('space', 'aerial', 'terrestrial')), 
	CONSTRAINT ck_photo_ground_kind CHECK (ground_kind IN ('crs', 'ellipsoid', 'local')), 
	CONSTRAINT ck_photo_refraction CHECK (refraction IN ('none', 'integral', 'ardc', 'space')), 
	CONSTRAINT ck_photo_distortion_model CHECK (distortion_model IN ('none', 'brown', 'opencv', 'radial_table')), 
	CONSTRAINT ck_photo_distortion_direction CHECK (distortion_direction IN ('none', 'correction', 'ideal_to_distorted', 'displacement')), 
	CONSTRAINT ck_photo_interior_transformation CHECK (interior_transformation IN ('none', 'similarity', 'affine', 'projective')), 
	CONSTRAINT ck_photo_x_axis CHECK (x_axis IN ('right', 'left')), 
	CONSTRAINT ck_photo_y_axis CHECK (y_axis IN ('up', 'down')), 
	CONSTRAINT fk_photo_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_photo_f_mm_finite CHECK (f_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_photo_x0_mm_finite CHECK (x0_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_photo_y0_mm_finite CHECK (y0_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_photo_sigma_f_mm_finite CHECK (sigma_f_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_photo_sigma_x0_mm_finite CHECK (sigma_x0_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_photo_sigma_y0_mm_finite CHECK (sigma_y0_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_photo_frame_width_mm_finite CHECK (frame_width_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_photo_frame_height_mm_finite CHECK (frame_height_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_photo_sigma_image_mm_finite CHECK (sigma_image_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_photo_pixel_size_mm_finite CHECK (pixel_size_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_photo_origin_col_px_finite CHECK (origin_col_px BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_photo_origin_row_px_finite CHECK (origin_row_px BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_photo_a_m_finite CHECK (a_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_photo_inverse_flattening_finite CHECK (inverse_flattening BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_photo_central_meridian_deg_finite CHECK (central_meridian_deg BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_photo_ground_height_m_finite CHECK (ground_height_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_photo_camera_height_m_finite CHECK (camera_height_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_photo_curvature_radius_m_finite CHECK (curvature_radius_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_photo_station_B_deg_finite" CHECK (station_B_deg BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_photo_station_L_deg_finite" CHECK (station_L_deg BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_photo_station_H_m_finite" CHECK (station_H_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_photo_station_X_m_finite" CHECK (station_X_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_photo_station_Y_m_finite" CHECK (station_Y_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_photo_station_Z_m_finite" CHECK (station_Z_m BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE run_event (
	run_id INTEGER NOT NULL, 
	seq INTEGER NOT NULL, 
	severity TEXT NOT NULL, 
	code TEXT NOT NULL, 
	subject TEXT NOT NULL, 
	message TEXT NOT NULL, 
	value REAL, 
	CONSTRAINT pk_run_event PRIMARY KEY (run_id, seq), 
	CONSTRAINT ck_run_event_severity CHECK (severity IN ('info', 'warning', 'error')), 
	CONSTRAINT fk_run_event_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_run_event_value_finite CHECK (value BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE run_input (
	run_id INTEGER NOT NULL, 
	role TEXT NOT NULL, 
	input_run_id INTEGER NOT NULL, 
	CONSTRAINT pk_run_input PRIMARY KEY (run_id, role), 
	CONSTRAINT ck_run_input_earlier CHECK (input_run_id < run_id), 
	CONSTRAINT fk_run_input_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT fk_run_input_input_run_id FOREIGN KEY(input_run_id) REFERENCES stage_run (run_id)
)
 STRICT;

CREATE INDEX ix_run_input_input_run_id ON run_input (input_run_id);

CREATE TABLE run_seal (
	run_id INTEGER NOT NULL, 
	status TEXT NOT NULL, 
	row_count INTEGER NOT NULL, 
	output_digest TEXT NOT NULL, 
	summary TEXT NOT NULL, 
	error TEXT NOT NULL, 
	sealed_at TEXT NOT NULL, 
	record_digest TEXT NOT NULL, 
	CONSTRAINT pk_run_seal PRIMARY KEY (run_id), 
	CONSTRAINT ck_run_seal_status CHECK (status IN ('succeeded', 'failed')), 
	CONSTRAINT fk_run_seal_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id)
)
 STRICT;

CREATE TABLE selection (
	selection_id INTEGER NOT NULL, 
	stage TEXT NOT NULL, 
	run_id INTEGER NOT NULL, 
	actor TEXT NOT NULL, 
	reason TEXT NOT NULL, 
	selected_at TEXT NOT NULL, 
	after_run_id INTEGER NOT NULL, 
	record_digest TEXT NOT NULL, 
	CONSTRAINT pk_selection PRIMARY KEY (selection_id), 
	CONSTRAINT fk_selection_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id)
)
 STRICT;

CREATE INDEX ix_selection_stage_selection_id ON selection (stage, selection_id);

CREATE TABLE sheet_coefficient (
	run_id INTEGER NOT NULL, 
	sheet TEXT NOT NULL, 
	coordinate TEXT NOT NULL, 
	power_u INTEGER NOT NULL, 
	power_v INTEGER NOT NULL, 
	value REAL NOT NULL, 
	sigma REAL, 
	CONSTRAINT pk_sheet_coefficient PRIMARY KEY (run_id, sheet, coordinate, power_u, power_v), 
	CONSTRAINT ck_sheet_coefficient_coordinate CHECK (coordinate IN ('B', 'L', 'N', 'E')), 
	CONSTRAINT fk_sheet_coefficient_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_sheet_coefficient_value_finite CHECK (value BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_sheet_coefficient_sigma_finite CHECK (sigma BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE sheet_cofactor (
	run_id INTEGER NOT NULL, 
	sheet TEXT NOT NULL, 
	"IJ" INTEGER NOT NULL, 
	i INTEGER NOT NULL, 
	j INTEGER NOT NULL, 
	value REAL NOT NULL, 
	CONSTRAINT pk_sheet_cofactor PRIMARY KEY (run_id, sheet, "IJ"), 
	CONSTRAINT fk_sheet_cofactor_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_sheet_cofactor_value_finite CHECK (value BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE sheet_transform (
	run_id INTEGER NOT NULL, 
	sheet TEXT NOT NULL, 
	degree INTEGER NOT NULL, 
	degree_chosen_by TEXT NOT NULL, 
	target TEXT NOT NULL, 
	crs TEXT, 
	"X0_mm" REAL NOT NULL, 
	"Y0_mm" REAL NOT NULL, 
	scale_mm REAL NOT NULL, 
	n_crosses INTEGER NOT NULL, 
	redundancy INTEGER NOT NULL, 
	"sigma0_N_m" REAL, 
	"sigma0_E_m" REAL, 
	CONSTRAINT pk_sheet_transform PRIMARY KEY (run_id, sheet), 
	CONSTRAINT ck_sheet_transform_target CHECK (target IN ('geographic', 'grid')), 
	CONSTRAINT fk_sheet_transform_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT "ck_sheet_transform_X0_mm_finite" CHECK (X0_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_sheet_transform_Y0_mm_finite" CHECK (Y0_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_sheet_transform_scale_mm_finite CHECK (scale_mm BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_sheet_transform_sigma0_N_m_finite" CHECK (sigma0_N_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_sheet_transform_sigma0_E_m_finite" CHECK (sigma0_E_m BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE topocentric_frame (
	run_id INTEGER NOT NULL, 
	kind TEXT NOT NULL, 
	"B_N_deg" REAL, 
	"L_N_deg" REAL, 
	"H_N_m" REAL, 
	gamma_deg REAL, 
	central_meridian_deg REAL, 
	a_m REAL, 
	e2 REAL, 
	CONSTRAINT pk_topocentric_frame PRIMARY KEY (run_id), 
	CONSTRAINT ck_topocentric_frame_kind CHECK (kind IN ('topocentric', 'local_right', 'local_left')), 
	CONSTRAINT fk_topocentric_frame_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT "ck_topocentric_frame_B_N_deg_finite" CHECK (B_N_deg BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_topocentric_frame_L_N_deg_finite" CHECK (L_N_deg BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_topocentric_frame_H_N_m_finite" CHECK (H_N_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_topocentric_frame_gamma_deg_finite CHECK (gamma_deg BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_topocentric_frame_central_meridian_deg_finite CHECK (central_meridian_deg BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_topocentric_frame_a_m_finite CHECK (a_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_topocentric_frame_e2_finite CHECK (e2 BETWEEN -1e15 AND 1e15)
)
 STRICT;

CREATE TABLE topocentric_point (
	run_id INTEGER NOT NULL, 
	point TEXT NOT NULL, 
	role TEXT NOT NULL, 
	weighting TEXT NOT NULL, 
	known TEXT NOT NULL, 
	"X_T_m" REAL NOT NULL, 
	"Y_T_m" REAL NOT NULL, 
	"Z_T_m" REAL NOT NULL, 
	"X_m" REAL NOT NULL, 
	"Y_m" REAL NOT NULL, 
	"Z_m" REAL NOT NULL, 
	"up_X" REAL NOT NULL, 
	"up_Y" REAL NOT NULL, 
	"up_Z" REAL NOT NULL, 
	"cov_XX_m2" REAL, 
	"cov_XY_m2" REAL, 
	"cov_XZ_m2" REAL, 
	"cov_YY_m2" REAL, 
	"cov_YZ_m2" REAL, 
	"cov_ZZ_m2" REAL, 
	sheet TEXT, 
	sheet_north_deg REAL, 
	CONSTRAINT pk_topocentric_point PRIMARY KEY (run_id, point), 
	CONSTRAINT ck_topocentric_point_known CHECK (known IN ('XYZ', 'plan', 'height')), 
	CONSTRAINT fk_topocentric_point_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT "ck_topocentric_point_X_T_m_finite" CHECK (X_T_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_topocentric_point_Y_T_m_finite" CHECK (Y_T_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_topocentric_point_Z_T_m_finite" CHECK (Z_T_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_topocentric_point_X_m_finite" CHECK (X_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_topocentric_point_Y_m_finite" CHECK (Y_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_topocentric_point_Z_m_finite" CHECK (Z_m BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_topocentric_point_up_X_finite" CHECK (up_X BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_topocentric_point_up_Y_finite" CHECK (up_Y BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_topocentric_point_up_Z_finite" CHECK (up_Z BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_topocentric_point_cov_XX_m2_finite" CHECK (cov_XX_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_topocentric_point_cov_XY_m2_finite" CHECK (cov_XY_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_topocentric_point_cov_XZ_m2_finite" CHECK (cov_XZ_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_topocentric_point_cov_YY_m2_finite" CHECK (cov_YY_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_topocentric_point_cov_YZ_m2_finite" CHECK (cov_YZ_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT "ck_topocentric_point_cov_ZZ_m2_finite" CHECK (cov_ZZ_m2 BETWEEN -1e15 AND 1e15), 
	CONSTRAINT ck_topocentric_point_sheet_north_deg_finite CHECK (sheet_north_deg BETWEEN -1e15 AND 1e15)
)
 STRICT;
