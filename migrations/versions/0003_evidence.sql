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
