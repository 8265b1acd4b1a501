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
       r.run_id IN (SELECT run_id FROM selection WHERE run_id IS NOT NULL AND selection_id IN
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
    (6, 'covariance', 'resection', 1, 0),
    (7, 'absolute', 'photo', 1, 0),
    (7, 'absolute', 'model', 1, 0),
    (7, 'absolute', 'topocentric', 1, 0));

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
--   version_now: version that is current now; NULL if it was withdrawn
CREATE VIEW v_changed_input AS
SELECT d.stage, d.input_stage, was.version AS version_read, now.version AS version_now
FROM v_dependency AS d
JOIN v_current AS c ON c.stage = d.stage
LEFT JOIN v_current AS now ON now.stage = d.input_stage
LEFT JOIN run_seal AS now_seal ON now_seal.run_id = now.run_id
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
    SELECT stage, input_stage || coalesce(' is version ' || version_now, ' was withdrawn')
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
--   run_id: run that was made or selected; NULL if a stage was left without a current version
--   at: when (UTC)
--   actor: who
--   action: run | select | withdraw
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
           c.selected_at, c.actor, CASE WHEN c.run_id IS NULL THEN 'withdraw' ELSE 'select' END,
           c.stage, r.version, s.status, c.reason, coalesce(s.summary, 'no version is current')
    FROM selection AS c LEFT JOIN stage_run AS r ON r.run_id = c.run_id LEFT JOIN run_seal AS s ON s.run_id = c.run_id
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
--   role: control | check | excluded
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
--   point: point; empty for the median over all points of the photo
--   role: control | check; median of the photo
--   quantity: X grid north | Y grid east | a semi-major axis of the error ellipse
--   source: image readings | interior orientation | digitiser | map graticule | heights | survey | camera
--   sigma_m: standard deviation that this source alone would cause
--   share_percent: share of the source in the variance of the quantity; those of a point sum to 100
--   photo_percent: share that comes through what all points of the photo have in common, its orientation
--   total_sigma_m: standard deviation of the quantity, all sources
CREATE VIEW v_error_budget AS
WITH along AS (
    SELECT run_id, point, role, 'X' AS quantity, 1.0 AS c, 0.0 AS s FROM ground_covariance
    UNION ALL SELECT run_id, point, role, 'Y', 0.0, 1.0 FROM ground_covariance
    UNION ALL SELECT run_id, point, role, 'a', cos(radians(ellipse_azimuth_deg)), sin(radians(ellipse_azimuth_deg))
    FROM ground_covariance
), part AS (
    SELECT a.run_id, a.point, a.role, a.quantity, b.source, b.part,
           a.c * a.c * b."cov_XX_m2" + 2.0 * a.c * a.s * b."cov_XY_m2" + a.s * a.s * b."cov_YY_m2" AS variance
    FROM along AS a JOIN error_budget AS b ON b.run_id = a.run_id AND b.point = a.point
), by_source AS (
    SELECT run_id, point, role, quantity, source, sum(variance) AS variance,
           sum(CASE part WHEN 'photo' THEN variance ELSE 0.0 END) AS of_photo
    FROM part GROUP BY run_id, point, role, quantity, source
), share AS (
    SELECT *, sum(variance) OVER (PARTITION BY run_id, point, quantity) AS total FROM by_source
), answer AS (
    SELECT run_id, point, role, quantity, source, sqrt(max(variance, 0.0)) AS sigma_m,
           100.0 * variance / nullif(total, 0.0) AS share_percent,
           100.0 * of_photo / nullif(total, 0.0) AS photo_percent, sqrt(total) AS total_sigma_m
    FROM share
), ranked AS (
    SELECT *, count(*) OVER of_all AS n, row_number() OVER (of_all ORDER BY sigma_m) AS by_sigma,
           row_number() OVER (of_all ORDER BY share_percent) AS by_share,
           row_number() OVER (of_all ORDER BY photo_percent) AS by_photo,
           row_number() OVER (of_all ORDER BY total_sigma_m) AS by_total
    FROM answer WINDOW of_all AS (PARTITION BY run_id, quantity, source)
), median AS (
    SELECT run_id, '' AS point, 'median of the photo' AS role, quantity, source,
           avg(CASE WHEN by_sigma IN ((n + 1) / 2, n / 2 + 1) THEN sigma_m END) AS sigma_m,
           avg(CASE WHEN by_share IN ((n + 1) / 2, n / 2 + 1) THEN share_percent END) AS share_percent,
           avg(CASE WHEN by_photo IN ((n + 1) / 2, n / 2 + 1) THEN photo_percent END) AS photo_percent,
           avg(CASE WHEN by_total IN ((n + 1) / 2, n / 2 + 1) THEN total_sigma_m END) AS total_sigma_m
    FROM ranked GROUP BY run_id, quantity, source
)
SELECT v.version, v.is_current, e.point, e.role, e.quantity, e.source, e.sigma_m, e.share_percent, e.photo_percent,
       e.total_sigma_m
FROM (SELECT * FROM median UNION ALL SELECT * FROM answer) AS e JOIN v_version AS v ON v.run_id = e.run_id
ORDER BY e.run_id, e.point, instr('XYa', e.quantity), e.share_percent DESC;

-- v_adjustment_test: does each adjustment fit the sigmas given (chi^2 at 5 %), and which test its observations met
--   stage: stage
--   version: version
--   is_current: 1 for the current version
--   part: empty, or the sheet, or the zone
--   component: empty, or N or E where they are adjusted apart
--   redundancy: r
--   statistic: v'Pv / sigma0^2 with the sigma0 a priori
--   lower: accepted from here
--   upper: accepted to here
--   verdict: accepted | too large | too small | no redundancy
--   test: w: Baarda, sigma0 known | tau: Pope, sigma0 estimated
--   critical: limit of |w| or |tau|
--   delta0: noncentrality that is found with power 0.80
CREATE VIEW v_adjustment_test AS
SELECT v.stage, v.version, v.is_current, t.part, t.component, t.redundancy, t.statistic, t.lower, t.upper, t.verdict,
       t.test, t.critical, t.delta0
FROM adjustment_test AS t JOIN v_version AS v ON v.run_id = t.run_id
ORDER BY t.run_id, t.part, t.component;

-- v_reliability: what each observation shows of its own error, and what an error that is not found would do
--   stage: stage
--   version: version
--   is_current: 1 for the current version
--   kind: image | ground | coefficient | known | cross | model
--   part: sheet of a coefficient or cross, zone of a model
--   point: point or cross
--   axis: coordinate, or name of the coefficient
--   verdict: good | suspect | hardly checked | not checked
--   share: share of an error that the other observations see, 0 ... 1
--   redundancy_number: r_i; they sum to the redundancy
--   v: residual, adjusted minus observed
--   w: w or tau; NULL when nothing checks the observation
--   critical: limit of |w| or |tau|
--   smallest_error: error that the test finds with power 0.80
--   unit: unit of v and smallest_error
--   bias_to_noise: effect of smallest_error on the unknowns in units of their precision
--   ground_shift_m: largest shift of a ground point by smallest_error
--   ground_shift_point: the point that shifts most
--   rho: correlation with the most correlated test of another point; above 0.9 the two are not separable
--   rho_with: that other point
CREATE VIEW v_reliability AS
SELECT v.stage, v.version, v.is_current, o.kind, o.part, o.point, o.axis, o.verdict, o.share, o.redundancy_number, o.v,
       o.w, t.critical, o.smallest_error, o.unit, o.bias_to_noise, o.ground_shift_m, o.ground_shift_point,
       o.rho, o.rho_with
FROM observation_test AS o
JOIN v_version AS v ON v.run_id = o.run_id
LEFT JOIN adjustment_test AS t ON t.run_id = o.run_id AND (v.stage = 'resection' OR t.part = o.part)
    AND (t.component = '' OR t.component = o.axis)
ORDER BY o.run_id, o.kind DESC, o.part, o.point, o.axis;

-- v_exclusion: which points were left out of an adjustment or are proposed for it, by whom and why
--   stage: stage
--   version: version
--   is_current: 1 for the current version
--   seq: order of the decisions
--   part: sheet of a cross, zone of a model
--   point: point or cross
--   observation: the observation with the largest |w| or |tau|
--   decided_by: snooping | hand | robust
--   action: excluded | proposed | taken back | not separable | not removable
--   round: round of the snooping
--   test: w | tau | chance
--   statistic: largest |w| or |tau| of the point in that round
--   critical: limit of the test
--   other: the point that it cannot be separated from
--   reason: why, in words
--   actor: who ran it
CREATE VIEW v_exclusion AS
SELECT v.stage, v.version, v.is_current, e.seq, e.part, e.point, e.observation, e.decided_by, e.action, e.round, e.test,
       e.statistic, e.critical, e.other, e.reason, v.actor
FROM exclusion AS e JOIN v_version AS v ON v.run_id = e.run_id
ORDER BY e.run_id, e.seq;

-- v_verification: what the last verification found about each run
--   stage: stage of the run
--   version: version
--   is_current: 1 for the current version
--   verified_at: when (UTC)
--   actor: who verified it
--   software: with which software
--   evidence: version of the stage verify that holds it
--   verdict: identical: bit by bit | agrees: within 1e-9 | differs
--   is_same_run: 1 if the run still has the digest that was verified
--   method: recomputed | digest (an imported list)
--   n_values: values compared
--   n_identical: values that are equal bit by bit
--   n_different: values, rows and seals that differ by more than is allowed
--   largest_difference: relative to the scale of the number
--   largest_at: table, row and column of it
--   stored: the stored value there
--   recomputed: the recomputed value there
--   second_engine: agrees | differs | left out: why; empty where nothing is adjusted
CREATE VIEW v_verification AS
SELECT v.stage, v.version, v.is_current, e.started_at AS verified_at, e.actor, e.tool_version AS software,
       e.version AS evidence, r.verdict, r.output_digest = s.output_digest AS is_same_run, r.method,
       r.n_values, r.n_identical, r.n_different, r.largest_difference, r.largest_at, r.stored, r.recomputed,
       r.second_engine
FROM verified_run AS r
JOIN stage_run AS e ON e.run_id = r.run_id
JOIN v_version AS v ON v.run_id = r.verified_run_id
JOIN run_seal AS s ON s.run_id = r.verified_run_id
WHERE r.run_id = (SELECT max(run_id) FROM verified_run AS n WHERE n.verified_run_id = r.verified_run_id)
ORDER BY v.run_id;

-- v_ground_pair: covariance between two ground points through their common orientation (after `covariance --pairs`)
--   version: version of covariance
--   is_current: 1 for the current version
--   point_i: first point
--   point_j: second point
--   K_XX_m2: covariance of X of the first and X of the second point
--   K_XY_m2: covariance of X and Y
--   K_YX_m2: covariance of Y and X
--   K_YY_m2: covariance of Y and Y
--   correlation_X: of both X, all parts of the points counted
--   correlation_Y: of both Y, all parts of the points counted
--   K_xx_mm2: the same in the scale of the image, B_i K B_j'
--   K_xy_mm2: covariance of x of the first and y of the second point
--   K_yx_mm2: covariance of y and x
--   K_yy_mm2: covariance of y and y
CREATE VIEW v_ground_pair AS
SELECT v.version, v.is_current, p.point_i, p.point_j, p."K_XX_m2", p."K_XY_m2", p."K_YX_m2", p."K_YY_m2",
       p."K_XX_m2" / nullif(gi."sigma_X_m" * gj."sigma_X_m", 0.0) AS "correlation_X",
       p."K_YY_m2" / nullif(gi."sigma_Y_m" * gj."sigma_Y_m", 0.0) AS "correlation_Y",
       (i."dx_dX_mm_m" * p."K_XX_m2" + i."dx_dY_mm_m" * p."K_YX_m2") * j."dx_dX_mm_m"
       + (i."dx_dX_mm_m" * p."K_XY_m2" + i."dx_dY_mm_m" * p."K_YY_m2") * j."dx_dY_mm_m" AS "K_xx_mm2",
       (i."dx_dX_mm_m" * p."K_XX_m2" + i."dx_dY_mm_m" * p."K_YX_m2") * j."dy_dX_mm_m"
       + (i."dx_dX_mm_m" * p."K_XY_m2" + i."dx_dY_mm_m" * p."K_YY_m2") * j."dy_dY_mm_m" AS "K_xy_mm2",
       (i."dy_dX_mm_m" * p."K_XX_m2" + i."dy_dY_mm_m" * p."K_YX_m2") * j."dx_dX_mm_m"
       + (i."dy_dX_mm_m" * p."K_XY_m2" + i."dy_dY_mm_m" * p."K_YY_m2") * j."dx_dY_mm_m" AS "K_yx_mm2",
       (i."dy_dX_mm_m" * p."K_XX_m2" + i."dy_dY_mm_m" * p."K_YX_m2") * j."dy_dX_mm_m"
       + (i."dy_dX_mm_m" * p."K_XY_m2" + i."dy_dY_mm_m" * p."K_YY_m2") * j."dy_dY_mm_m" AS "K_yy_mm2"
FROM ground_covariance_pair AS p
JOIN v_version AS v ON v.run_id = p.run_id
JOIN ground_covariance AS gi ON gi.run_id = p.run_id AND gi.point = p.point_i
JOIN ground_covariance AS gj ON gj.run_id = p.run_id AND gj.point = p.point_j
JOIN ground_covariance_image AS i ON i.run_id = p.run_id AND i.point = p.point_i
JOIN ground_covariance_image AS j ON j.run_id = p.run_id AND j.point = p.point_j
ORDER BY p.run_id, p.point_i, p.point_j;

-- v_ground_map: how sure a new ground point is over the frame, on the ground and in the scale of the image
--   version: version of covariance
--   is_current: 1 for the current version
--   x_mm: place in the frame
--   y_mm: place in the frame
--   X_m: ray at the mean height of the points, grid north; NULL where the place sees no ground
--   Y_m: grid east
--   sigma_m: sqrt((sigma_X^2 + sigma_Y^2)/2), all parts
--   orientation_m: the same of the part of the orientation
--   sigma_X_m: standard deviation, all parts
--   sigma_Y_m: standard deviation, all parts
--   ellipse_a_m: semi-major axis of the standard error ellipse
--   ellipse_b_m: semi-minor axis
--   ellipse_azimuth_deg: direction of the semi-major axis from X towards Y
--   sigma_x_mm: standard deviation in the scale of the image, all parts
--   sigma_y_mm: standard deviation in the scale of the image, all parts
CREATE VIEW v_ground_map AS
SELECT v.version, v.is_current, a.x_mm, a.y_mm, a."X_m", a."Y_m",
       sqrt((a."sigma_X_m" * a."sigma_X_m" + a."sigma_Y_m" * a."sigma_Y_m") / 2.0) AS sigma_m,
       sqrt((a."K_XX_m2" + a."K_YY_m2") / 2.0) AS orientation_m, a."sigma_X_m", a."sigma_Y_m",
       a.ellipse_a_m, a.ellipse_b_m, a.ellipse_azimuth_deg, a.sigma_x_mm, a.sigma_y_mm
FROM ground_accuracy AS a JOIN v_version AS v ON v.run_id = a.run_id
ORDER BY a.run_id, a.line, a.place;

-- v_absolute_orientation: the absolute orientation of each zone of the model as a whole
--   version: version of absolute
--   is_current: 1 for the current version
--   zone: zone of the model
--   n_full: control points with all three coordinates
--   n_plan: plan-only control points
--   n_height: height-only control points
--   redundancy: equations minus seven
--   sigma0: standard deviation of unit weight; NULL without redundancy
--   sigma0_unit: m with equal weights on the ground, 1 with weights from covariances
--   H: homothety coefficient, model units per metre
--   t: scale denominator 1/H
--   tilt_deg: angle between the model's Z axis and up
--   condition_ratio: smallest to largest singular value of the scaled design matrix
--   other_solutions: other orientations in which the adjustment converged
--   iterations: iterations
CREATE VIEW v_absolute_orientation AS
SELECT v.version, v.is_current, o.zone, o.n_full, o.n_plan, o.n_height, o.redundancy, o.sigma0, o.sigma0_unit,
       o."H", o.t, 57.295779513082321 * acos(max(-1.0, min(1.0, 1.0 - 2.0 * (o.q_x * o.q_x + o.q_y * o.q_y)))) AS tilt_deg,
       o.condition_ratio,
       (SELECT count(*) FROM absolute_alternative AS a WHERE a.run_id = o.run_id AND a.zone = o.zone) AS other_solutions,
       o.iterations
FROM absolute_orientation AS o JOIN v_version AS v ON v.run_id = o.run_id
ORDER BY o.run_id, o.zone;

-- v_absolute_element: the seven elements of each zone as each paper names them, with standard deviations
--   version: version of absolute
--   is_current: 1 for the current version
--   zone: zone of the model
--   view: homothety with X0 (2') | joint with T = H X0 (4') | scale with t = 1/H (108)
--   element: xi eta theta H X_0 Y_0 Z_0, T_X T_Y T_Z, t
--   value: value; X_0, Y_0, T_X, T_Y in the axes of the stored frame
--   sigma: standard deviation; NULL if it is not determined
--   unit: deg | m | model | model/m | m/model
--   near_blind: 1 where the angles have lost their meaning one by one
CREATE VIEW v_absolute_element AS
SELECT v.version, v.is_current, e.zone, e.view, e.unknown AS element, e.value, e.sigma, e.unit, e.near_blind
FROM absolute_element AS e JOIN v_version AS v ON v.run_id = e.run_id
ORDER BY e.run_id, e.zone, e.view,
         CASE e.view WHEN 'scale' THEN instr('X_0 Y_0 Z_0 t xi eta theta', e.unknown)
                     ELSE instr('xi eta theta H X_0 Y_0 Z_0 T_X T_Y T_Z', e.unknown) END;

-- v_absolute_iteration: approximation and correction of each element of each zone in every iteration
--   version: version of absolute
--   is_current: 1 for the current version
--   zone: zone of the model
--   iteration: 1, 2, ...
--   unknown: xi eta theta (fixed axes) H X_0 Y_0 Z_0
--   approximation: value before the iteration
--   correction: what the iteration added
--   adjusted: value after the iteration
--   unit: deg | model/m | m
--   vPv: sum of weighted squared residuals at the approximations
--   damping: damping of the step; 0 = full Gauss-Newton step
CREATE VIEW v_absolute_iteration AS
SELECT v.version, v.is_current, p.zone, p.iteration, p.unknown,
       p.approximation * CASE p.unit WHEN 'rad' THEN 57.295779513082321 ELSE 1.0 END AS approximation,
       p.correction * CASE p.unit WHEN 'rad' THEN 57.295779513082321 ELSE 1.0 END AS correction,
       (p.approximation + p.correction) * CASE p.unit WHEN 'rad' THEN 57.295779513082321 ELSE 1.0 END AS adjusted,
       CASE p.unit WHEN 'rad' THEN 'deg' ELSE p.unit END AS unit, i."vPv", i.damping
FROM absolute_iteration_parameter AS p
JOIN v_version AS v ON v.run_id = p.run_id
LEFT JOIN absolute_iteration AS i ON i.run_id = p.run_id AND i.zone = p.zone AND i.iteration = p.iteration
ORDER BY p.run_id, p.zone, p.iteration, instr('xi eta theta H X_0 Y_0 Z_0', p.unknown);

-- v_absolute_equation: correction equations of each zone in the forms of the papers, v = a1 d(u1) + ... + a7 d(u7) + l
--   version: version of absolute
--   is_current: 1 for the current version
--   zone: zone of the model
--   form: homothety with X0 (2') | joint with T = H X0 (4') | scale with t = 1/H (108)
--   point: control point
--   axis: given coordinate, right-handed ground (east, north, up of T'; local: X, Y, Z)
--   a1: coefficient of xi (homothety, joint) or X_0 (scale)
--   a2: of eta or Y_0
--   a3: of theta or Z_0
--   a4: of H or t
--   a5: of X_0, T_X or xi
--   a6: of Y_0, T_Y or eta
--   a7: of Z_0, T_Z or theta
--   l_m: free term, computed minus given
CREATE VIEW v_absolute_equation AS
SELECT v.version, v.is_current, e.zone, e.form, e.point, e.axis, e.a1, e.a2, e.a3, e.a4, e.a5, e.a6, e.a7, e.l_m
FROM absolute_equation AS e JOIN v_version AS v ON v.run_id = e.run_id
ORDER BY e.run_id, e.zone, e.form, e.point, e.axis;

-- v_absolute_residual: residuals of the control and check points of each zone, v = computed minus given
--   version: version of absolute
--   is_current: 1 for the current version
--   zone: zone of the model
--   point: point
--   role: control | check
--   known: XYZ | plan | height
--   vX_m: computed from the observed model point minus given, grid north (local: X)
--   vY_m: computed minus given, grid east (local: Y)
--   vZ_m: computed minus given, up (local: Z)
--   v_m: length of the residual
--   redundancy_X: share of an error of X that shows in its residual
--   redundancy_Y: share of an error of Y that shows in its residual
--   redundancy_Z: share of an error of the height that shows in its residual
CREATE VIEW v_absolute_residual AS
SELECT v.version, v.is_current, r.zone, r.point, r.role, r.known, r."vX_m", r."vY_m", r."vZ_m",
       sqrt(coalesce(r."vX_m" * r."vX_m", 0.0) + coalesce(r."vY_m" * r."vY_m", 0.0)
            + coalesce(r."vZ_m" * r."vZ_m", 0.0)) AS v_m,
       r."redundancy_X", r."redundancy_Y", r."redundancy_Z"
FROM absolute_residual AS r JOIN v_version AS v ON v.run_id = r.run_id
ORDER BY r.run_id, r.zone, r.point;

-- v_model_ground_point: all points of the model on the ground, and how sure that is
--   version: version of absolute
--   is_current: 1 for the current version
--   zone: zone of the model
--   point: point
--   role: control | check | free
--   X_m: grid north (local: X)
--   Y_m: grid east (local: Y)
--   Z_m: up (local: Z)
--   B_deg: latitude; NULL for a local frame
--   L_deg: longitude
--   H_m: ellipsoidal height
--   sigma_X_m: standard deviation; NULL when sigma0 is unknown
--   sigma_Y_m: standard deviation
--   sigma_Z_m: standard deviation
CREATE VIEW v_model_ground_point AS
SELECT v.version, v.is_current, p.zone, p.point, p.role, p."X_m", p."Y_m", p."Z_m", p."B_deg", p."L_deg", p."H_m",
       sqrt(p."cov_XX_m2") AS "sigma_X_m", sqrt(p."cov_YY_m2") AS "sigma_Y_m", sqrt(p."cov_ZZ_m2") AS "sigma_Z_m"
FROM model_ground_point AS p JOIN v_version AS v ON v.run_id = p.run_id
ORDER BY p.run_id, p.zone, p.point;

-- v_influence: what each reading does to each element of the orientation: by how much it moved it, and carries it
--   version: version of resection
--   is_current: 1 for the current version
--   element: rotation_1 rotation_2 rotation_3 (about grid east, grid north, up) X_S Y_S Z_S, f k1 ... of the camera
--   kind: image | ground | coefficient | known
--   part: sheet of a coefficient
--   point: point; empty for a coefficient
--   axis: coordinate, or name of the coefficient
--   moved: element with the reading minus element without it, -(Q A'P e) (Pv) / (P Q_v P); NULL: without it there is none
--   unit: deg | m, or as in camera_element
--   moved_sigmas: the same in standard deviations of the element
--   per_unit: change of the element by one unit of the reading, Q A'P e
--   reading_unit: unit of the reading
--   share_percent: share of the reading's own error in the variance of the element; NULL for coefficients (correlated)
--   v: residual of the reading, adjusted minus observed
--   redundancy_number: share of an error of the reading that shows in its residual
CREATE VIEW v_influence AS
WITH influence AS (
    SELECT o.run_id, e.unknown, o.kind, o.part, o.point, o.axis, e.unit, e.effect, o.unit AS reading_unit,
           o.smallest_error, o.share, o.w, o.v, o.redundancy_number, t.delta0, t.sigma0,
           CASE e.unit WHEN 'deg' THEN 57.295779513082321 ELSE 1.0 END AS turn
    FROM external_reliability AS e
    JOIN observation_test AS o ON o.run_id = e.run_id AND o.kind = e.kind AND o.part = e.part AND o.point = e.point
                               AND o.axis = e.axis
    JOIN adjustment_test AS t ON t.run_id = e.run_id AND t.part = '' AND t.component = ''
)
SELECT v.version, v.is_current, i.unknown AS element, i.kind, i.part, i.point, i.axis,
       -i.effect * i.w / i.delta0 AS moved, i.unit,
       -i.effect * i.w / i.delta0 / nullif(i.turn * sqrt(a.variance_scale * q.value), 0.0) AS moved_sigmas,
       i.effect / i.smallest_error AS per_unit, i.reading_unit,
       CASE WHEN i.kind <> 'coefficient'
            THEN 100.0 * i.effect * i.effect * i.share
                 / nullif(i.delta0 * i.delta0 * i.sigma0 * i.sigma0 * i.turn * i.turn * q.value, 0.0)
            END AS share_percent,
       i.v, i.redundancy_number
FROM influence AS i
JOIN v_version AS v ON v.run_id = i.run_id
JOIN orientation AS a ON a.run_id = i.run_id
JOIN cofactor AS q ON q.run_id = i.run_id AND q.unknowns = 'rotation' AND q.unknown_i = i.unknown
                   AND q.unknown_j = i.unknown
ORDER BY i.run_id, i.unknown, i.kind DESC, i.part, i.point, i.axis;

-- v_single_point: what rests on a single point, or on nothing that checks it
--   stage: stage
--   version: version
--   is_current: 1 for the current version
--   what: element | reading | adjustment | interior orientation | sheet
--   subject: element, point and axis, or sheet
--   rests_on: the point that carries it; empty: on as many observations as unknowns
--   value: share_percent of the point in the variance of an element; share of an error of a reading that others see
--   why: in words
CREATE VIEW v_single_point AS
SELECT v.stage, v.version, v.is_current, s.what, s.subject, s.rests_on, s.value, s.why
FROM (
    SELECT r.run_id, 1 AS place, 'element' AS what, i.element AS subject, i.point AS rests_on,
           sum(i.share_percent) AS value, 'more than half of its variance comes from this point' AS why
    FROM v_influence AS i JOIN stage_run AS r ON r.stage = 'resection' AND r.version = i.version
    WHERE i.point <> ''
    GROUP BY r.run_id, i.element, i.point HAVING sum(i.share_percent) > 50.0
    UNION ALL
    SELECT run_id, 2, 'reading', trim(part || ' ' || point || ' ' || axis), point, share,
           CASE verdict WHEN 'not checked' THEN 'no other observation would show an error of it'
                        ELSE 'the others see less than a tenth of an error of it' END
    FROM observation_test
    WHERE verdict IN ('not checked', 'hardly checked') AND kind IN ('image', 'ground', 'cross')
    UNION ALL
    SELECT run_id, 3, 'adjustment', 'exterior orientation', '', redundancy, 'as many observations as unknowns'
    FROM orientation WHERE redundancy = 0
    UNION ALL
    SELECT run_id, 4, 'interior orientation', transformation, '', redundancy, 'as many marks as the parameters need'
    FROM interior_orientation WHERE redundancy = 0
    UNION ALL
    SELECT run_id, 5, 'sheet', sheet, '', redundancy, 'as many crosses as coefficients'
    FROM sheet_transform WHERE redundancy = 0
) AS s JOIN v_version AS v ON v.run_id = s.run_id
ORDER BY s.run_id, s.place, s.subject, s.rests_on;

-- v_list_value: the numbers of the imported lists one by one, as they were given
--   stage: photo | readings | sheet | control | model
--   version: version
--   is_current: 1 for the current version
--   subject: point, cycle, mark, cross or part of the camera
--   quantity: column of the list
--   value: number or word; NULL = not given
CREATE VIEW v_list_value AS
WITH given AS (
    SELECT run_id, kind || ' ' || point || ' cycle ' || cycle AS subject, quantity.column1 AS quantity,
           CASE quantity.column1 WHEN 'x_mm' THEN x_mm WHEN 'y_mm' THEN y_mm WHEN 'col_px' THEN col_px
                                 WHEN 'row_px' THEN row_px ELSE sigma END AS value
    FROM comparator_reading, (VALUES ('x_mm'), ('y_mm'), ('col_px'), ('row_px'), ('sigma')) AS quantity
    UNION ALL
    SELECT run_id, 'point ' || point, quantity.column1,
           CASE quantity.column1
               WHEN 'role' THEN role WHEN 'B_deg' THEN "B_deg" WHEN 'L_deg' THEN "L_deg" WHEN 'E_m' THEN "E_m"
               WHEN 'N_m' THEN "N_m" WHEN 'H_m' THEN "H_m" WHEN 'X_m' THEN "X_m" WHEN 'Y_m' THEN "Y_m"
               WHEN 'Z_m' THEN "Z_m" WHEN 'cov_XX_m2' THEN "cov_XX_m2" WHEN 'cov_YY_m2' THEN "cov_YY_m2"
               ELSE "cov_ZZ_m2" END
    FROM control_point, (VALUES ('role'), ('B_deg'), ('L_deg'), ('E_m'), ('N_m'), ('H_m'), ('X_m'), ('Y_m'), ('Z_m'),
                                ('cov_XX_m2'), ('cov_YY_m2'), ('cov_ZZ_m2')) AS quantity
    UNION ALL
    SELECT run_id, 'sheet ' || sheet || ' cross ' || "cross", quantity.column1,
           CASE quantity.column1
               WHEN 'role' THEN role WHEN 'X_mm' THEN "X_mm" WHEN 'Y_mm' THEN "Y_mm" WHEN 'B_deg' THEN "B_deg"
               WHEN 'L_deg' THEN "L_deg" WHEN 'E_m' THEN "E_m" ELSE "N_m" END
    FROM graticule_cross, (VALUES ('role'), ('X_mm'), ('Y_mm'), ('B_deg'), ('L_deg'), ('E_m'), ('N_m')) AS quantity
    UNION ALL
    SELECT run_id, 'sheet ' || sheet || ' point ' || point || ' cycle ' || cycle, quantity.column1,
           CASE quantity.column1 WHEN 'X_mm' THEN "X_mm" WHEN 'Y_mm' THEN "Y_mm" WHEN 'H_m' THEN "H_m"
                                 ELSE "sigma_H_m" END
    FROM digitizer_reading, (VALUES ('X_mm'), ('Y_mm'), ('H_m'), ('sigma_H_m')) AS quantity
    UNION ALL
    SELECT run_id, 'zone ' || zone || ' point ' || point, quantity.column1,
           CASE quantity.column1 WHEN 'x' THEN x WHEN 'y' THEN y ELSE z END
    FROM model_point, (VALUES ('x'), ('y'), ('z')) AS quantity
    UNION ALL
    SELECT run_id, 'mark ' || mark, quantity.column1, CASE quantity.column1 WHEN 'x_mm' THEN x_mm ELSE y_mm END
    FROM fiducial_mark, (VALUES ('x_mm'), ('y_mm')) AS quantity
    UNION ALL
    SELECT run_id, 'distortion', name, value FROM distortion_coefficient
    UNION ALL
    SELECT run_id, 'photo', quantity.column1,
           CASE quantity.column1
               WHEN 'name' THEN name WHEN 'f_mm' THEN f_mm WHEN 'x0_mm' THEN x0_mm WHEN 'y0_mm' THEN y0_mm
               WHEN 'sigma_f_mm' THEN sigma_f_mm WHEN 'sigma_image_mm' THEN sigma_image_mm
               WHEN 'pixel_size_mm' THEN pixel_size_mm WHEN 'refraction' THEN refraction
               WHEN 'distortion_model' THEN distortion_model
               WHEN 'interior_transformation' THEN interior_transformation
               WHEN 'ground' THEN coalesce(ground_crs, ellipsoid, ground_kind)
               WHEN 'ground_height_m' THEN ground_height_m WHEN 'camera_height_m' THEN camera_height_m
               ELSE central_meridian_deg END
    FROM photo, (VALUES ('name'), ('f_mm'), ('x0_mm'), ('y0_mm'), ('sigma_f_mm'), ('sigma_image_mm'), ('pixel_size_mm'),
                        ('refraction'), ('distortion_model'), ('interior_transformation'), ('ground'),
                        ('ground_height_m'), ('camera_height_m'), ('central_meridian_deg')) AS quantity
)
SELECT v.stage, v.version, v.is_current, g.subject, g.quantity, g.value
FROM given AS g JOIN v_version AS v ON v.run_id = g.run_id
WHERE g.value IS NOT NULL
ORDER BY g.run_id, g.subject, g.quantity;

-- v_version_change: what differs between any two versions of a stage: settings, inputs, software, numbers
--   stage: stage
--   first: earlier version
--   second: later version
--   what: setting | input | software | computation | outcome | list | element | sigma | excluded
--   name: setting, input stage, row of a list, element, or point
--   before: in the earlier version; NULL = not there
--   after: in the later version; NULL = not there
--   difference: after minus before, where both are numbers
CREATE VIEW v_version_change AS
WITH told AS (
    SELECT r.run_id, 'setting' AS what, s.key AS name, s.value AS value
    FROM stage_run AS r, json_each(r.settings) AS s WHERE r.stage IN (SELECT stage FROM v_dependency)
    UNION ALL
    SELECT i.run_id, 'input', i.role, r.version FROM run_input AS i JOIN stage_run AS r ON r.run_id = i.input_run_id
    UNION ALL
    SELECT run_id, 'software', 'orient and its libraries', tool_version
    FROM stage_run WHERE stage IN (SELECT stage FROM v_dependency)
    UNION ALL
    SELECT run_id, 'computation', 'version of the computation', stage_version FROM stage_run
    UNION ALL
    SELECT run_id, 'outcome', 'status', status FROM run_seal
    UNION ALL
    SELECT run_id, 'outcome', 'sigma0_mm', sigma0_mm FROM orientation
    UNION ALL
    SELECT run_id, 'outcome', 'redundancy', redundancy FROM orientation
    UNION ALL
    SELECT run_id, 'excluded', trim(part || ' ' || point), reason FROM exclusion WHERE action = 'excluded'
    UNION ALL
    SELECT r.run_id, 'list', l.subject || ' ' || l.quantity, l.value
    FROM v_list_value AS l JOIN stage_run AS r ON r.stage = l.stage AND r.version = l.version
    UNION ALL
    SELECT r.run_id, 'element', o.frame || ' ' || o.element || ' ' || o.unit, o.value
    FROM v_orientation AS o JOIN stage_run AS r ON r.stage = 'resection' AND r.version = o.version
    UNION ALL
    SELECT r.run_id, 'sigma', o.frame || ' ' || o.element || ' ' || o.unit, o.sigma
    FROM v_orientation AS o JOIN stage_run AS r ON r.stage = 'resection' AND r.version = o.version
), pair AS (
    SELECT a.stage, a.version AS first, b.version AS second, a.run_id AS run_1, b.run_id AS run_2
    FROM stage_run AS a JOIN stage_run AS b ON b.stage = a.stage AND b.version > a.version
), side AS (
    SELECT p.stage, p.first, p.second, t.what, t.name,
           max(CASE t.run_id WHEN p.run_1 THEN t.value END) AS before,
           max(CASE t.run_id WHEN p.run_2 THEN t.value END) AS after
    FROM pair AS p JOIN told AS t ON t.run_id IN (p.run_1, p.run_2)
    GROUP BY p.stage, p.first, p.second, t.what, t.name
)
SELECT stage, first, second, what, name, before, after,
       CASE WHEN typeof(before) IN ('real', 'integer') AND typeof(after) IN ('real', 'integer')
            THEN after - before END AS difference
FROM side WHERE before IS NOT after
ORDER BY stage, first, second,
         instr('outcome computation software setting input list excluded element sigma', what), name;

-- v_list_use: every version of every imported list, and what was computed from it, also through other stages
--   stage: photo | readings | sheet | control | model
--   version: version of the list
--   is_current: 1 for the current version
--   given_at: when it was imported (UTC)
--   actor: who gave it
--   reason: why
--   n_results: results that rest on it
--   results: these results, in the order they were computed
--   current_results: those of them that are current
CREATE VIEW v_list_use AS
WITH RECURSIVE rests(list_run, run_id) AS (
    SELECT input_run_id, run_id FROM run_input WHERE input_run_id NOT IN (SELECT run_id FROM run_input)
    UNION
    SELECT rests.list_run, i.run_id FROM rests JOIN run_input AS i ON i.input_run_id = rests.run_id
), computed AS (
    SELECT rests.list_run, v.run_id, v.stage || ' ' || v.version AS result, v.is_current
    FROM rests JOIN v_version AS v ON v.run_id = rests.run_id WHERE v.status = 'succeeded'
)
SELECT v.stage, v.version, v.is_current, v.started_at AS given_at, v.actor, v.reason,
       (SELECT count(*) FROM computed WHERE list_run = v.run_id) AS n_results,
       (SELECT coalesce(group_concat(result, ', '), '')
        FROM (SELECT result FROM computed WHERE list_run = v.run_id ORDER BY run_id)) AS results,
       (SELECT coalesce(group_concat(result, ', '), '')
        FROM (SELECT result FROM computed WHERE list_run = v.run_id AND is_current ORDER BY run_id)) AS current_results
FROM v_version AS v
WHERE v.stage NOT IN (SELECT stage FROM v_dependency) AND v.run_id NOT IN (SELECT run_id FROM verified_run)
ORDER BY v.run_id;

-- v_sigma_use: which standard deviation was given, and which one the adjustment used
--   version: version of resection
--   is_current: 1 for the current version
--   what: the observations or elements that are meant
--   n: how many of them
--   given: standard deviation that was given; of several the median; NULL = none
--   used: standard deviation that was used as weight; NULL = taken as known
--   unit: mm | m
--   how: in words
CREATE VIEW v_sigma_use AS
WITH used AS (
    SELECT o.run_id, o.sigma0_mm, o.sigma0_apriori_mm, o.variance_scale, o.variance_basis, r.settings,
           photo.input_run_id AS photo_run, refine.input_run_id AS refine_run, top.input_run_id AS top_run
    FROM orientation AS o
    JOIN stage_run AS r ON r.run_id = o.run_id
    JOIN run_input AS photo ON photo.run_id = o.run_id AND photo.role = 'photo'
    JOIN run_input AS refine ON refine.run_id = o.run_id AND refine.role = 'refine'
    JOIN run_input AS top ON top.run_id = o.run_id AND top.role = 'topocentric'
), ranked_image AS (
    SELECT u.run_id, sqrt(i.cov_xx_mm2) AS sigma, count(*) OVER of_run AS n,
           row_number() OVER (PARTITION BY u.run_id ORDER BY i.cov_xx_mm2) AS place
    FROM used AS u JOIN image_residual AS m ON m.run_id = u.run_id AND m.role = 'control'
    JOIN image_point AS i ON i.run_id = u.refine_run AND i.point = m.point
    WINDOW of_run AS (PARTITION BY u.run_id)
), ranked_ground AS (
    SELECT u.run_id, (g."cov_XX_m2" IS NOT NULL) AS has_sigma, sqrt(g."cov_XX_m2") AS sigma,
           EXISTS (SELECT 1 FROM adjusted_point AS a WHERE a.run_id = u.run_id AND a.point = g.point) AS is_adjusted,
           row_number() OVER (PARTITION BY u.run_id, g."cov_XX_m2" IS NOT NULL ORDER BY g."cov_XX_m2") AS place,
           count(*) OVER (PARTITION BY u.run_id, g."cov_XX_m2" IS NOT NULL) AS n
    FROM used AS u JOIN image_residual AS m ON m.run_id = u.run_id AND m.role = 'control'
    JOIN topocentric_point AS g ON g.run_id = u.top_run AND g.point = m.point
)
SELECT v.version, v.is_current, s.what, s.n, s.given, s.used, s.unit, s.how
FROM (
    SELECT u.run_id, 1 AS place, 'one reading of an image coordinate' AS what, NULL AS n, p.sigma_image_mm AS given,
           u.sigma0_apriori_mm AS used, 'mm' AS unit, 'sigma_image of photo.toml; unit of all weights' AS how
    FROM used AS u JOIN photo AS p ON p.run_id = u.photo_run
    UNION ALL
    SELECT run_id, 2, 'image coordinates of the control', n, NULL, avg(sigma), 'mm',
           'mean of the cycles, or as given for each reading; the median'
    FROM ranked_image WHERE place IN ((n + 1) / 2, n / 2 + 1) GROUP BY run_id
    UNION ALL
    SELECT run_id, 3, 'unit weight of every stored standard deviation', NULL, sigma0_apriori_mm, sqrt(variance_scale),
           'mm', 'sigma0 ' || variance_basis
    FROM used
    UNION ALL
    SELECT run_id, 4, 'X of control with a standard deviation', n, avg(sigma),
           CASE max(is_adjusted) WHEN 1 THEN avg(sigma) END, 'm',
           CASE max(is_adjusted) WHEN 1 THEN 'weighted as given; the median'
                                 ELSE 'given, but taken as known (--control fixed)' END
    FROM ranked_ground WHERE has_sigma AND place IN ((n + 1) / 2, n / 2 + 1) GROUP BY run_id
    UNION ALL
    SELECT run_id, 5, 'control without a standard deviation', max(n), NULL, NULL, 'm', 'taken as known'
    FROM ranked_ground WHERE NOT has_sigma GROUP BY run_id
    UNION ALL
    SELECT u.run_id, 6, 'focal length', 1, p.sigma_f_mm, c.sigma_apriori, 'mm',
           CASE WHEN c.unknown IS NULL THEN 'taken as known' WHEN c.sigma_apriori IS NULL THEN 'estimated freely'
                ELSE 'estimated, held by the given one' END
    FROM used AS u JOIN photo AS p ON p.run_id = u.photo_run
    LEFT JOIN camera_element AS c ON c.run_id = u.run_id AND c.unknown = 'f'
) AS s JOIN v_version AS v ON v.run_id = s.run_id
ORDER BY s.run_id, s.place;

-- v_doubt: reasons not to take a current result for the last word
--   stage: stage
--   version: current version
--   reason: stale | failed later | newer version | not verified | differs | selected by hand
--   told: in words
CREATE VIEW v_doubt AS
SELECT stage, version, reason, told
FROM (
    SELECT s.stage, s.version, 1 AS place, 'stale' AS reason, s.why AS told
    FROM v_stale AS s WHERE s.is_stale AND s.version IS NOT NULL
    UNION ALL
    SELECT c.stage, c.version, 2, 'failed later',
           'version ' || v.version || ' of ' || substr(v.started_at, 1, 16) || ' failed: ' || v.error
    FROM v_current AS c JOIN v_version AS v ON v.stage = c.stage AND v.run_id > c.run_id AND v.status = 'failed'
    UNION ALL
    SELECT c.stage, c.version, 3, 'newer version',
           'version ' || v.version || ' by ' || v.actor || ' (' || v.reason || ') is not the current one: ' || c.reason
    FROM v_current AS c JOIN v_version AS v ON v.stage = c.stage AND v.run_id > c.run_id AND v.status = 'succeeded'
    UNION ALL
    SELECT c.stage, c.version, 4, 'differs',
           'verification of ' || substr(k.verified_at, 1, 16) || ': ' || k.n_different || ' values differ'
    FROM v_current AS c JOIN v_verification AS k ON k.stage = c.stage AND k.version = c.version
    WHERE k.verdict = 'differs' OR NOT k.is_same_run
    UNION ALL
    SELECT c.stage, c.version, 5, 'not verified', 'no verification has computed it again'
    FROM v_current AS c
    WHERE c.stage IN (SELECT stage FROM v_dependency)
      AND NOT EXISTS (SELECT 1 FROM v_verification AS k WHERE k.stage = c.stage AND k.version = c.version)
)
ORDER BY place, stage;
