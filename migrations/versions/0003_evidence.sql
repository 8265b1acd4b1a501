ALTER TABLE absolute_residual RENAME TO before_absolute_residual;

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
	CONSTRAINT ck_absolute_residual_role CHECK (role IN ('control', 'check', 'excluded')), 
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

INSERT INTO absolute_residual ("run_id", "zone", "point", "role", "known", "vX_m", "vY_m", "vZ_m", "v_ground_X_m", "v_ground_Y_m", "v_ground_Z_m", "v_model_x", "v_model_y", "v_model_z", "redundancy_X", "redundancy_Y", "redundancy_Z") SELECT "run_id", "zone", "point", "role", "known", "vX_m", "vY_m", "vZ_m", "v_ground_X_m", "v_ground_Y_m", "v_ground_Z_m", "v_model_x", "v_model_y", "v_model_z", "redundancy_X", "redundancy_Y", "redundancy_Z" FROM before_absolute_residual;

DROP TABLE before_absolute_residual;

ALTER TABLE external_reliability RENAME TO before_external_reliability;

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
	CONSTRAINT ck_external_reliability_kind CHECK (kind IN ('image', 'ground', 'coefficient', 'known', 'model')), 
	CONSTRAINT fk_external_reliability_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT ck_external_reliability_effect_finite CHECK (effect BETWEEN -1e15 AND 1e15)
)
 STRICT;

INSERT INTO external_reliability ("run_id", "kind", "part", "point", "axis", "unknown", "unit", "effect") SELECT "run_id", "kind", "part", "point", "axis", "unknown", "unit", "effect" FROM before_external_reliability;

DROP TABLE before_external_reliability;

CREATE TABLE image (
	run_id INTEGER NOT NULL, 
	name TEXT NOT NULL, 
	media_type TEXT NOT NULL, 
	size_bytes INTEGER NOT NULL, 
	sha256 TEXT NOT NULL, 
	width_px INTEGER, 
	height_px INTEGER, 
	n_parts INTEGER NOT NULL, 
	CONSTRAINT pk_image PRIMARY KEY (run_id), 
	CONSTRAINT ck_image_size_bytes CHECK (size_bytes > 0), 
	CONSTRAINT ck_image_sha256 CHECK (length(sha256) = 64), 
	CONSTRAINT ck_image_n_parts CHECK (n_parts >= 0), 
	CONSTRAINT fk_image_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id)
)
 STRICT;

CREATE TABLE image_part (
	run_id INTEGER NOT NULL, 
	seq INTEGER NOT NULL, 
	content BLOB NOT NULL, 
	CONSTRAINT pk_image_part PRIMARY KEY (run_id, seq), 
	CONSTRAINT ck_image_part_content CHECK (length(content) BETWEEN 1 AND 1048576), 
	CONSTRAINT ck_image_part_seq CHECK (seq >= 1), 
	CONSTRAINT fk_image_part_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id)
)
 STRICT;

ALTER TABLE model_ground_point RENAME TO before_model_ground_point;

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
	CONSTRAINT ck_model_ground_point_role CHECK (role IN ('control', 'check', 'free', 'excluded')), 
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

INSERT INTO model_ground_point ("run_id", "zone", "point", "role", "X_m", "Y_m", "Z_m", "B_deg", "L_deg", "H_m", "cov_XX_m2", "cov_XY_m2", "cov_XZ_m2", "cov_YY_m2", "cov_YZ_m2", "cov_ZZ_m2") SELECT "run_id", "zone", "point", "role", "X_m", "Y_m", "Z_m", "B_deg", "L_deg", "H_m", "cov_XX_m2", "cov_XY_m2", "cov_XZ_m2", "cov_YY_m2", "cov_YZ_m2", "cov_ZZ_m2" FROM before_model_ground_point;

DROP TABLE before_model_ground_point;

CREATE INDEX ix_model_ground_point_run_id_point ON model_ground_point (run_id, point);

ALTER TABLE observation_test RENAME TO before_observation_test;

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
	CONSTRAINT ck_observation_test_kind CHECK (kind IN ('image', 'ground', 'coefficient', 'known', 'cross', 'model')), 
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

INSERT INTO observation_test ("run_id", "kind", "part", "point", "axis", "unit", "v", "redundancy_number", "share", "w", "smallest_error", "bias_to_noise", "ground_shift_m", "ground_shift_point", "rho", "rho_with", "verdict") SELECT "run_id", "kind", "part", "point", "axis", "unit", "v", "redundancy_number", "share", "w", "smallest_error", "bias_to_noise", "ground_shift_m", "ground_shift_point", "rho", "rho_with", "verdict" FROM before_observation_test;

DROP TABLE before_observation_test;

CREATE TABLE sealed_file (
	run_id INTEGER NOT NULL, 
	project TEXT NOT NULL, 
	format INTEGER NOT NULL, 
	n_runs INTEGER NOT NULL, 
	n_selections INTEGER NOT NULL, 
	last_run_digest TEXT NOT NULL, 
	last_selection_digest TEXT NOT NULL, 
	image TEXT NOT NULL, 
	image_name TEXT, 
	image_size_bytes INTEGER, 
	image_sha256 TEXT, 
	CONSTRAINT pk_sealed_file PRIMARY KEY (run_id), 
	CONSTRAINT ck_sealed_file_image CHECK (image IN ('embedded', 'referenced', 'none')), 
	CONSTRAINT fk_sealed_file_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id)
)
 STRICT;

CREATE TABLE sealed_run (
	run_id INTEGER NOT NULL, 
	sealed_run_id INTEGER NOT NULL, 
	stage TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	is_current INTEGER NOT NULL, 
	is_stale INTEGER NOT NULL, 
	status TEXT NOT NULL, 
	output_digest TEXT NOT NULL, 
	record_digest TEXT NOT NULL, 
	tool_version TEXT NOT NULL, 
	CONSTRAINT pk_sealed_run PRIMARY KEY (run_id, sealed_run_id), 
	CONSTRAINT fk_sealed_run_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id), 
	CONSTRAINT fk_sealed_run_sealed_run_id FOREIGN KEY(sealed_run_id) REFERENCES stage_run (run_id)
)
 STRICT;

ALTER TABLE selection RENAME TO before_selection;

CREATE TABLE selection (
	selection_id INTEGER NOT NULL, 
	stage TEXT NOT NULL, 
	run_id INTEGER, 
	actor TEXT NOT NULL, 
	reason TEXT NOT NULL, 
	selected_at TEXT NOT NULL, 
	after_run_id INTEGER NOT NULL, 
	record_digest TEXT NOT NULL, 
	CONSTRAINT pk_selection PRIMARY KEY (selection_id), 
	CONSTRAINT fk_selection_run_id FOREIGN KEY(run_id) REFERENCES stage_run (run_id)
)
 STRICT;

INSERT INTO selection ("selection_id", "stage", "run_id", "actor", "reason", "selected_at", "after_run_id", "record_digest") SELECT "selection_id", "stage", "run_id", "actor", "reason", "selected_at", "after_run_id", "record_digest" FROM before_selection;

DROP TABLE before_selection;

CREATE INDEX ix_selection_stage_selection_id ON selection (stage, selection_id);
