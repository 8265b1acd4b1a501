-- The questions that people ask, as views. `-- v_name: what it answers`, then one line for each column;
-- docs/schema.md is written from these lines. `is_current` is 1 for the selected version of the stage.

-- v_version: every run of every stage, and which of them is current
--   stage: stage
--   version: version within the stage
--   run_id: number of the run in the file
--   is_current: 1 if this version is selected
--   status: succeeded | failed
--   started_at: when it was run (UTC)
--   actor: who ran it
--   reason: why, in the words of the actor
--   summary: the result in one line
--   error: empty, or why it failed
CREATE VIEW v_version AS
SELECT r.stage, r.version, r.run_id,
       r.run_id IN (SELECT run_id FROM selection WHERE selection_id IN
                    (SELECT max(selection_id) FROM selection GROUP BY stage)) AS is_current,
       s.status, r.started_at, r.actor, r.reason, s.summary, s.error
FROM stage_run AS r JOIN run_seal AS s ON s.run_id = r.run_id
ORDER BY r.run_id;

-- v_current: which version of each stage is current, and who made it so
--   stage: stage
--   version: current version
--   run_id: number of the run in the file
--   status: succeeded; only results can be selected
--   selected_at: since when it is current (UTC)
--   actor: who selected it
--   reason: why
--   summary: the result in one line
CREATE VIEW v_current AS
SELECT r.stage, r.version, r.run_id, s.status, c.selected_at, c.actor, c.reason, s.summary
FROM selection AS c
JOIN stage_run AS r ON r.run_id = c.run_id
JOIN run_seal AS s ON s.run_id = c.run_id
WHERE c.selection_id IN (SELECT max(selection_id) FROM selection GROUP BY stage)
ORDER BY r.run_id;

-- v_dependency: what each computed stage reads
--   position: place of the stage in the order of computing
--   stage: computed stage
--   input_stage: stage that it reads
--   is_required: 1 if it cannot run without this input
--   is_alternative: 1 if at least one of the inputs marked so must exist
CREATE VIEW v_dependency AS
SELECT column1 AS position, column2 AS stage, column3 AS input_stage, column4 AS is_required, column5 AS is_alternative
FROM (VALUES
    (1, 'refine', 'photo', 1, 0),
    (1, 'refine', 'readings', 1, 0),
    (2, 'digitize', 'photo', 1, 0),
    (2, 'digitize', 'sheet', 1, 0),
    (3, 'bl', 'photo', 1, 0),
    (3, 'bl', 'control', 0, 1),
    (3, 'bl', 'digitize', 0, 1),
    (4, 'topocentric', 'photo', 1, 0),
    (4, 'topocentric', 'bl', 1, 0),
    (5, 'resection', 'photo', 1, 0),
    (5, 'resection', 'refine', 1, 0),
    (5, 'resection', 'topocentric', 1, 0),
    (5, 'resection', 'digitize', 0, 0),
    (6, 'covariance', 'photo', 1, 0),
    (6, 'covariance', 'refine', 1, 0),
    (6, 'covariance', 'topocentric', 1, 0),
    (6, 'covariance', 'resection', 1, 0));

-- v_waiting: computed stages that have no result, and which inputs are still missing
--   stage: computed stage without a current version
--   waits_for: the missing inputs; NULL if everything is there and the stage only has to be run
CREATE VIEW v_waiting AS
SELECT d.stage,
       nullif(
           coalesce(group_concat(CASE WHEN d.is_required AND c.run_id IS NULL THEN d.input_stage END, ', '), '')
           || CASE WHEN max(d.is_alternative) AND NOT max(d.is_alternative AND c.run_id IS NOT NULL)
                   THEN CASE WHEN sum(d.is_required AND c.run_id IS NULL) THEN ', ' ELSE '' END
                        || group_concat(CASE WHEN d.is_alternative THEN d.input_stage END, ' or ')
                   ELSE '' END,
           '') AS waits_for
FROM v_dependency AS d LEFT JOIN v_current AS c ON c.stage = d.input_stage
WHERE d.stage NOT IN (SELECT stage FROM v_current)
GROUP BY d.position, d.stage
ORDER BY d.position;

-- v_changed_input: inputs of current results that are no longer what was read
--   stage: computed stage with a current version
--   input_stage: input that differs now, or that did not exist then
--   version_read: version that was read; NULL if there was none
--   version_now: version that is current now
CREATE VIEW v_changed_input AS
SELECT d.stage, d.input_stage, was.version AS version_read, now.version AS version_now
FROM v_dependency AS d
JOIN v_current AS c ON c.stage = d.stage
JOIN v_current AS now ON now.stage = d.input_stage
JOIN run_seal AS now_seal ON now_seal.run_id = now.run_id
LEFT JOIN run_input AS i ON i.run_id = c.run_id AND i.role = d.input_stage
LEFT JOIN stage_run AS was ON was.run_id = i.input_run_id
LEFT JOIN run_seal AS was_seal ON was_seal.run_id = i.input_run_id
WHERE was_seal.output_digest IS NOT now_seal.output_digest
ORDER BY d.position, d.input_stage;

-- v_stale: which stages must be run again, and why; found from digests, nothing is stored
--   stage: stage, in the order of computing
--   version: current version; NULL if there is none
--   is_stale: 1 if `orient run` would compute it
--   why: reasons; for a stage that cannot run yet, what it waits for
CREATE VIEW v_stale AS
WITH RECURSIVE stale(stage, why) AS (
    SELECT stage, input_stage || ' is version ' || version_now
                  || coalesce(', version ' || version_read || ' was read', ', none was read')
    FROM v_changed_input
    UNION
    SELECT stage, 'not computed yet' FROM v_waiting WHERE waits_for IS NULL
    UNION
    SELECT d.stage, d.input_stage || ' is stale'
    FROM stale JOIN v_dependency AS d ON d.input_stage = stale.stage
    WHERE d.stage IN (SELECT stage FROM v_current)
)
SELECT c.stage, c.version, 0 AS is_stale, '' AS why
FROM v_current AS c WHERE c.stage NOT IN (SELECT stage FROM v_dependency)
UNION ALL
SELECT p.stage, c.version, EXISTS (SELECT 1 FROM stale WHERE stale.stage = p.stage),
       coalesce((SELECT group_concat(stale.why, '; ') FROM stale WHERE stale.stage = p.stage),
                (SELECT 'waits for ' || w.waits_for FROM v_waiting AS w WHERE w.stage = p.stage), '')
FROM (SELECT DISTINCT position, stage FROM v_dependency ORDER BY position) AS p
LEFT JOIN v_current AS c ON c.stage = p.stage;

-- v_audit: who did what, when and why, in the order it was done
--   run_id: run that was made or selected
--   at: when (UTC)
--   actor: who
--   action: run | select
--   stage: stage
--   version: version that was made or selected
--   status: succeeded | failed
--   reason: why, in the words of the actor
--   summary: the result in one line, or why there is none
CREATE VIEW v_audit AS
SELECT run_id, at, actor, action, stage, version, status, reason, summary
FROM (
    SELECT r.run_id AS place, 0 AS rank, r.run_id, r.started_at AS at, r.actor, 'run' AS action, r.stage, r.version,
           s.status, r.reason, CASE s.status WHEN 'failed' THEN s.error ELSE s.summary END AS summary
    FROM stage_run AS r JOIN run_seal AS s ON s.run_id = r.run_id
    UNION ALL
    SELECT c.after_run_id, c.selection_id, c.run_id,
           c.selected_at, c.actor, 'select', r.stage, r.version, s.status, c.reason, s.summary
    FROM selection AS c JOIN stage_run AS r ON r.run_id = c.run_id JOIN run_seal AS s ON s.run_id = c.run_id
)
ORDER BY place, rank;

-- v_event: remarks, warnings and errors of all runs (the papers' table er)
--   stage: stage
--   version: version
--   is_current: 1 for the current version
--   seq: order within the run
--   severity: info | warning | error
--   code: stable word for programs
--   subject: point, sheet or unknown that is meant
--   message: the sentence for people
--   value: number that belongs to the message
CREATE VIEW v_event AS
SELECT v.stage, v.version, v.is_current, e.seq, e.severity, e.code, e.subject, e.message, e.value
FROM run_event AS e JOIN v_version AS v ON v.run_id = e.run_id
ORDER BY e.run_id, e.seq;

-- v_correction: image points from the comparator to the principal point, correction by correction
--   version: version of refine
--   is_current: 1 for the current version
--   point: point
--   n_cycles: readings in the mean
--   x_comparator_mm: mean of the cycles
--   y_comparator_mm: mean of the cycles
--   x_frame_mm: after the interior orientation
--   y_frame_mm: after the interior orientation
--   dx_mm: sum of principal point, distortion, refraction and curvature
--   dy_mm: sum of principal point, distortion, refraction and curvature
--   distortion_mm: length of the distortion correction
--   refraction_mm: length of the refraction correction
--   curvature_mm: length of the earth-curvature correction
--   x_mm: image coordinate, origin at the principal point
--   y_mm: image coordinate, origin at the principal point
--   sigma_x_mm: standard deviation of x
--   sigma_y_mm: standard deviation of y
CREATE VIEW v_correction AS
SELECT v.version, v.is_current, p.point, p.n_cycles, p.x_comparator_mm, p.y_comparator_mm, p.x_frame_mm, p.y_frame_mm,
       p.dx_principal_mm + p.dx_distortion_mm + p.dx_refraction_mm + p.dx_curvature_mm AS dx_mm,
       p.dy_principal_mm + p.dy_distortion_mm + p.dy_refraction_mm + p.dy_curvature_mm AS dy_mm,
       sqrt(p.dx_distortion_mm * p.dx_distortion_mm + p.dy_distortion_mm * p.dy_distortion_mm) AS distortion_mm,
       sqrt(p.dx_refraction_mm * p.dx_refraction_mm + p.dy_refraction_mm * p.dy_refraction_mm) AS refraction_mm,
       sqrt(p.dx_curvature_mm * p.dx_curvature_mm + p.dy_curvature_mm * p.dy_curvature_mm) AS curvature_mm,
       p.x_mm, p.y_mm, sqrt(p.cov_xx_mm2) AS sigma_x_mm, sqrt(p.cov_yy_mm2) AS sigma_y_mm
FROM image_point AS p JOIN v_version AS v ON v.run_id = p.run_id
ORDER BY p.run_id, p.point;

-- v_fiducial_residual: how well the fiducial marks fit
--   version: version of refine
--   is_current: 1 for the current version
--   transformation: similarity | affine | projective
--   mark: fiducial mark
--   x_mm: transformed x
--   y_mm: transformed y
--   vx_mm: transformed minus calibrated
--   vy_mm: transformed minus calibrated
--   v_mm: length of the residual
--   sigma0_mm: standard deviation of unit weight of the whole transformation
CREATE VIEW v_fiducial_residual AS
SELECT v.version, v.is_current, o.transformation, f.mark, f.x_mm, f.y_mm, f.vx_mm, f.vy_mm,
       sqrt(f.vx_mm * f.vx_mm + f.vy_mm * f.vy_mm) AS v_mm, o.sigma0_mm
FROM fiducial_residual AS f
JOIN v_version AS v ON v.run_id = f.run_id
LEFT JOIN interior_orientation AS o ON o.run_id = f.run_id
ORDER BY f.run_id, f.mark;

-- v_cross_residual: how well the crosses of the map sheets fit
--   version: version of digitize
--   is_current: 1 for the current version
--   sheet: map sheet
--   degree: degree of the polynomial
--   cross: graticule cross
--   role: fit | check | rejected
--   v_N_m: polynomial minus given, northwards
--   v_E_m: polynomial minus given, eastwards
--   v_m: length of the residual
--   redundancy_number: share of an error of the cross that shows in its residual
--   probability: chance of so large a residual without an error
--   is_suspect: 1 if it is named as a bad cross
CREATE VIEW v_cross_residual AS
SELECT v.version, v.is_current, c.sheet, t.degree, c."cross", c.role, c."v_N_m", c."v_E_m",
       sqrt(c."v_N_m" * c."v_N_m" + c."v_E_m" * c."v_E_m") AS v_m,
       c.redundancy_number, c.probability, c.is_suspect
FROM cross_residual AS c
JOIN v_version AS v ON v.run_id = c.run_id
LEFT JOIN sheet_transform AS t ON t.run_id = c.run_id AND t.sheet = c.sheet
ORDER BY c.run_id, c.sheet, c."cross";

-- v_control: points of the map with their coordinates, and where they come from
--   version: version of bl
--   is_current: 1 for the current version
--   point: point
--   role: control | check
--   source: control, or the name of the sheet
--   weighting: fixed | weighted
--   B_deg: latitude
--   L_deg: longitude
--   H_m: ellipsoidal height
--   X_m: local Cartesian X
--   Y_m: local Cartesian Y
--   Z_m: local Cartesian Z
--   sigma_X_m: standard deviation northwards (local: of X)
--   sigma_Y_m: standard deviation eastwards (local: of Y)
--   sigma_Z_m: standard deviation upwards (local: of Z)
--   operation: coordinate operation that was used
--   accuracy_m: stated accuracy of the operation; NULL = unknown
CREATE VIEW v_control AS
SELECT v.version, v.is_current, p.point, p.role, p.source, p.weighting, p."B_deg", p."L_deg", p."H_m",
       p."X_m", p."Y_m", p."Z_m", sqrt(p."cov_XX_m2") AS "sigma_X_m", sqrt(p."cov_YY_m2") AS "sigma_Y_m",
       sqrt(p."cov_ZZ_m2") AS "sigma_Z_m", o.name AS operation, o.accuracy_m
FROM geographic_point AS p
JOIN v_version AS v ON v.run_id = p.run_id
LEFT JOIN crs_operation AS o ON o.run_id = p.run_id AND o.source = p.source
ORDER BY p.run_id, p.point;

-- v_iteration: approximation and correction of every unknown in every iteration (the papers' table _r)
--   version: version of resection
--   is_current: 1 for the current version
--   iteration: 1, 2, ...
--   point: empty for the six elements, else the point or the sheet
--   unknown: alpha omega kappa X_S Y_S Z_S; X Y Z of the point; B_1_0 ... of the sheet, by the powers of u, v
--   approximation: value before the iteration
--   correction: what the iteration added
--   adjusted: value after the iteration
--   unit: deg | m
--   vPv: sum of weighted squared residuals at the approximations
--   damping: damping of the step; 0 = full Gauss-Newton step
CREATE VIEW v_iteration AS
SELECT v.version, v.is_current, p.iteration, p.point, p.unknown,
       p.approximation * CASE p.unit WHEN 'rad' THEN 57.295779513082321 ELSE 1.0 END AS approximation,
       p.correction * CASE p.unit WHEN 'rad' THEN 57.295779513082321 ELSE 1.0 END AS correction,
       (p.approximation + p.correction) * CASE p.unit WHEN 'rad' THEN 57.295779513082321 ELSE 1.0 END AS adjusted,
       CASE p.unit WHEN 'rad' THEN 'deg' ELSE p.unit END AS unit, i."vPv", i.damping
FROM iteration_parameter AS p
JOIN v_version AS v ON v.run_id = p.run_id
LEFT JOIN iteration AS i ON i.run_id = p.run_id AND i.iteration = p.iteration
ORDER BY p.run_id, p.iteration, p.point,
         instr('alpha omega phi kappa X_S Y_S Z_S X Y Z', p.unknown || CASE p.point WHEN '' THEN ' ' ELSE '' END), p.unknown;

-- v_start: every start value of the resection, how it fits, and where the adjustment from it ended
--   version: version of resection
--   is_current: 1 for the current version
--   is_latest: 1 for the last run, also when it failed and is no version to use
--   candidate: 1, 2, ...: points in front first, then by rms
--   method: three points | direct linear | plane | approximate station
--   is_reversed: 1 if its relief was taken the other way along the camera axis
--   points: the three points it comes from; empty for a form of all points
--   rms_mm: rms of the image residuals of the start; NULL if not finite
--   in_front: points in front of the camera, of all
--   height_above_m: camera above the mean ground; negative = below
--   solution: number of the end; NULL = not adjusted, a better candidate is near
--   termination: how the adjustment from it ended
--   end_vPv: sum of weighted squared residuals at the end
--   is_as_good: 1 if the end fits as well as the best valid one
CREATE VIEW v_start AS
SELECT v.version, v.is_current,
       v.run_id = (SELECT max(run_id) FROM stage_run WHERE stage = 'resection') AS is_latest,
       c.candidate, c.method, c.is_reversed, c.points, c.rms_mm,
       c.n_in_front || ' of ' || c.n_points AS in_front, c."height_above_m", c.solution, s.termination,
       s."vPv" AS "end_vPv", s.is_as_good
FROM start_candidate AS c
JOIN v_version AS v ON v.run_id = c.run_id
LEFT JOIN resection_solution AS s ON s.run_id = c.run_id AND s.solution = c.solution
ORDER BY c.run_id, c.candidate;

-- v_orientation: the orientation elements with standard deviations
--   version: version of resection
--   is_current: 1 for the current version
--   element: X_S Y_S Z_S, B_S L_S H_S, X_G Y_G Z_G, and the angles aok_alpha ... opk_kappa
--   frame: frame that the value refers to
--   value: value
--   sigma: standard deviation; NULL if it is not determined
--   unit: m | deg
CREATE VIEW v_orientation AS
SELECT v.version, v.is_current, e.element, e.frame, e.value, e.sigma, e.unit
FROM (
    SELECT o.run_id, 1 AS place, 'X_S' AS element, o.frame, o."X_S_m" AS value, 'm' AS unit,
           (SELECT sqrt(o.variance_scale * q.value) FROM cofactor AS q WHERE q.run_id = o.run_id
            AND q.unknowns = 'rotation' AND q.unknown_i = 'X_S' AND q.unknown_j = 'X_S') AS sigma
    FROM orientation AS o
    UNION ALL
    SELECT o.run_id, 2, 'Y_S', o.frame, o."Y_S_m", 'm',
           (SELECT sqrt(o.variance_scale * q.value) FROM cofactor AS q WHERE q.run_id = o.run_id
            AND q.unknowns = 'rotation' AND q.unknown_i = 'Y_S' AND q.unknown_j = 'Y_S')
    FROM orientation AS o
    UNION ALL
    SELECT o.run_id, 3, 'Z_S', o.frame, o."Z_S_m", 'm',
           (SELECT sqrt(o.variance_scale * q.value) FROM cofactor AS q WHERE q.run_id = o.run_id
            AND q.unknowns = 'rotation' AND q.unknown_i = 'Z_S' AND q.unknown_j = 'Z_S')
    FROM orientation AS o
    UNION ALL
    SELECT a.run_id,
           instr('aok_alpha aok_omega aok_kappa opk_omega opk_phi opk_kappa', a.triple || '_' || a.angle) + 3
           + CASE WHEN a.frame = 'geocentric' THEN 100 ELSE 0 END,
           a.triple || '_' || a.angle, a.frame, a.value_deg, 'deg', a.sigma_deg
    FROM orientation_angle AS a
    UNION ALL SELECT run_id, 301, 'B_S', 'ellipsoid', "B_S_deg", 'deg', NULL FROM orientation WHERE "B_S_deg" IS NOT NULL
    UNION ALL SELECT run_id, 302, 'L_S', 'ellipsoid', "L_S_deg", 'deg', NULL FROM orientation WHERE "L_S_deg" IS NOT NULL
    UNION ALL SELECT run_id, 303, 'H_S', 'ellipsoid', "H_S_m", 'm', NULL FROM orientation WHERE "H_S_m" IS NOT NULL
    UNION ALL SELECT run_id, 304, 'X_G', 'geocentric', "X_G_m", 'm', NULL FROM orientation WHERE "X_G_m" IS NOT NULL
    UNION ALL SELECT run_id, 305, 'Y_G', 'geocentric', "Y_G_m", 'm', NULL FROM orientation WHERE "Y_G_m" IS NOT NULL
    UNION ALL SELECT run_id, 306, 'Z_G', 'geocentric', "Z_G_m", 'm', NULL FROM orientation WHERE "Z_G_m" IS NOT NULL
) AS e JOIN v_version AS v ON v.run_id = e.run_id
ORDER BY e.run_id, e.place;

-- v_residual: residuals of the image points, v = adjusted minus measured
--   version: version of resection
--   is_current: 1 for the current version
--   point: point
--   role: control | check
--   x_mm: measured x
--   y_mm: measured y
--   vx_mm: computed minus measured x
--   vy_mm: computed minus measured y
--   v_mm: length of the residual
--   redundancy_x: share of an error of x that shows in its residual
--   redundancy_y: share of an error of y that shows in its residual
--   depth_m: distance of the point in front of the camera
CREATE VIEW v_residual AS
SELECT v.version, v.is_current, r.point, r.role, r.x_mm, r.y_mm, r.vx_mm, r.vy_mm,
       sqrt(r.vx_mm * r.vx_mm + r.vy_mm * r.vy_mm) AS v_mm, r.redundancy_x, r.redundancy_y, r.depth_m
FROM image_residual AS r JOIN v_version AS v ON v.run_id = r.run_id
ORDER BY r.run_id, r.point;

-- v_ground_accuracy: where the image ray of each point meets the ground, how sure that is, and how far off
--   version: version of covariance
--   is_current: 1 for the current version
--   point: point
--   role: control | check
--   X_m: ray at the height of the point, grid north
--   Y_m: ray at the height of the point, grid east
--   Z_m: height
--   dX_m: ray minus given
--   dY_m: ray minus given
--   sigma_X_m: standard deviation, all parts
--   sigma_Y_m: standard deviation, all parts
--   ellipse_a_m: semi-major axis of the standard error ellipse
--   ellipse_b_m: semi-minor axis
--   ellipse_azimuth_deg: direction of the semi-major axis from X towards Y
CREATE VIEW v_ground_accuracy AS
SELECT v.version, v.is_current, g.point, g.role, g."X_m", g."Y_m", g."Z_m", g."dX_m", g."dY_m",
       g."sigma_X_m", g."sigma_Y_m", g.ellipse_a_m, g.ellipse_b_m, g.ellipse_azimuth_deg
FROM ground_covariance AS g JOIN v_version AS v ON v.run_id = g.run_id
ORDER BY g.run_id, g.point;

-- v_error_budget: which part of the error of each ground coordinate comes from what
--   version: version of covariance
--   is_current: 1 for the current version
--   point: point
--   role: control | check
--   axis: X grid north | Y grid east
--   sigma_m: standard deviation of the coordinate, all parts
--   orientation_m: part of the orientation
--   reading_m: part of the image reading of the point
--   height_m: part of the height of the point
--   orientation_percent: share of the orientation in the variance
--   reading_percent: share of the image reading in the variance
--   height_percent: share of the height in the variance
--   image_sigma_mm: standard deviation of an image coordinate of the point, mean of x and y
CREATE VIEW v_error_budget AS
SELECT v.version, v.is_current, b.point, b.role, b.axis, sqrt(b.o + b.r + b.h) AS sigma_m,
       sqrt(b.o) AS orientation_m, sqrt(b.r) AS reading_m, sqrt(b.h) AS height_m,
       100.0 * b.o / nullif(b.o + b.r + b.h, 0.0) AS orientation_percent,
       100.0 * b.r / nullif(b.o + b.r + b.h, 0.0) AS reading_percent,
       100.0 * b.h / nullif(b.o + b.r + b.h, 0.0) AS height_percent,
       sqrt((p.cov_xx_mm2 + p.cov_yy_mm2) / 2.0) AS image_sigma_mm
FROM (
    SELECT run_id, point, role, 'X' AS axis, "K_XX_m2" AS o, "reading_XX_m2" AS r, "height_XX_m2" AS h
    FROM ground_covariance
    UNION ALL
    SELECT run_id, point, role, 'Y', "K_YY_m2", "reading_YY_m2", "height_YY_m2" FROM ground_covariance
) AS b
JOIN v_version AS v ON v.run_id = b.run_id
LEFT JOIN run_input AS i ON i.run_id = b.run_id AND i.role = 'refine'
LEFT JOIN image_point AS p ON p.run_id = i.input_run_id AND p.point = b.point
ORDER BY b.run_id, b.point, b.axis;
