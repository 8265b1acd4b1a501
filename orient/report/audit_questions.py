"""What a suspicious reviewer asks of a project, answered by the shipped views (docs/audit.md)."""

from orient.report.question import Parameter, Question

CHOSEN_STAGE = "stage = CASE :stage WHEN '' THEN 'resection' ELSE :stage END"
RESULTS = f"SELECT max(version) FROM v_version WHERE status = 'succeeded' AND {CHOSEN_STAGE}"
SECOND = f"CASE :second WHEN '' THEN ({RESULTS}) ELSE CAST(:second AS INTEGER) END"
FIRST = f"CASE :first WHEN '' THEN ({RESULTS} AND version < {SECOND}) ELSE CAST(:first AS INTEGER) END"
"""Versions that are not given are the last result and the one before."""

AUDIT_QUESTIONS: tuple[Question, ...] = (
    Question(
        "moved-most",
        "Which reading moved an element of the orientation most?",
        "SELECT element, kind, point, axis, moved, unit, moved_sigmas, share_percent, per_unit, reading_unit, v "
        "FROM v_influence WHERE is_current AND element = CASE :element WHEN '' THEN 'X_S' ELSE :element END "
        "AND kind IN ('image', 'ground') AND moved IS NOT NULL ORDER BY abs(moved) DESC, kind, point, axis",
        (Parameter("element", "X_S, Y_S, Z_S, rotation_1 (about grid east), _2 (grid north), _3 (up), f ...", "X_S"),),
        brief=("point", "axis", "moved", "unit", "moved_sigmas", "share_percent"),
        nothing="No orientation yet, or nothing checks its readings.",
    ),
    Question(
        "who-excluded",
        "Who left a point out, when and why?",
        "SELECT e.stage, e.version, e.is_current, e.part, e.point, e.action, e.decided_by, e.actor, "
        "v.started_at, v.reason AS message, e.reason, e.test, e.statistic, e.critical "
        "FROM v_exclusion AS e JOIN v_version AS v ON v.stage = e.stage AND v.version = e.version "
        "WHERE :point IN ('', e.point) ORDER BY v.run_id, e.seq",
        (Parameter("point", "one point; empty: all"),),
        brief=("stage", "version", "point", "action", "decided_by", "actor", "reason"),
        nothing="No point was left out or proposed for it.",
    ),
    Question(
        "version-change",
        "What changed between two versions of a stage?",
        "SELECT what, name, before, after, difference FROM v_version_change "
        f"WHERE {CHOSEN_STAGE} AND first = {FIRST} AND second = {SECOND}",
        (
            Parameter("stage", "a stage or a list", "resection"),
            Parameter("first", "earlier version; empty: the result before"),
            Parameter("second", "later version; empty: the last result"),
        ),
        brief=("what", "name", "before", "after", "difference"),
        nothing="Nothing: there is one version only, or the two are equal.",
    ),
    Question(
        "single-point",
        "Which numbers rest on a single point, or on nothing that checks them?",
        "SELECT stage, what, subject, rests_on, value, why FROM v_single_point WHERE is_current",
        brief=("what", "subject", "rests_on", "value", "why"),
        nothing="None: every reading is checked by others, no element rests on one point.",
    ),
    Question(
        "after-change",
        "What was computed from each version of a list; was anything computed after the list changed?",
        "SELECT stage, version, is_current, given_at, actor, reason, n_results, results, current_results "
        "FROM v_list_use",
        brief=("stage", "version", "is_current", "n_results", "current_results"),
        nothing="There is no list yet.",
    ),
    Question(
        "sigmas",
        "Which standard deviation was given, and which was used?",
        "SELECT what, n, given, used, unit, how FROM v_sigma_use WHERE is_current",
        brief=("what", "n", "given", "used", "unit", "how"),
        nothing="No orientation yet.",
    ),
    Question(
        "doubtful-current",
        "Is a result current that is stale, that failed later, or that nobody verified?",
        "SELECT stage, version, reason, told FROM v_doubt",
        brief=("stage", "version", "reason", "told"),
        nothing="No: everything current is fresh, the newest of its kind, and verified.",
    ),
    Question(
        "went-back",
        "Who made an older version current again, and why?",
        "SELECT s.at, s.actor, s.stage, s.version, max(later.version) AS instead_of, s.reason "
        "FROM v_audit AS s JOIN v_audit AS later ON later.stage = s.stage AND later.action = 'run' "
        "AND later.status = 'succeeded' AND later.version > s.version AND later.at <= s.at "
        "WHERE s.action = 'select' GROUP BY s.at, s.actor, s.stage, s.version, s.reason ORDER BY s.at",
        brief=("stage", "version", "instead_of", "actor", "reason"),
        nothing="Nobody: the newest result of each stage is current.",
    ),
    Question(
        "not-acted-on",
        "Which warnings about the current results were never acted on?",
        "SELECT e.stage, e.version, e.severity, e.code, e.subject, e.message FROM v_event AS e "
        "WHERE e.is_current AND e.severity <> 'info' AND NOT EXISTS (SELECT 1 FROM v_exclusion AS x "
        "WHERE x.stage = e.stage AND x.version = e.version AND x.point = e.subject AND x.action = 'excluded')",
        brief=("stage", "version", "code", "message"),
        nothing="None: no warning stands.",
    ),
    Question(
        "check-points",
        "How far off are the points that took no part, in sigmas of the place?",
        "SELECT point, dX_m, dY_m, sigma_X_m, sigma_Y_m, dX_m / nullif(sigma_X_m, 0) AS dX_sigmas, "
        "dY_m / nullif(sigma_Y_m, 0) AS dY_sigmas FROM v_ground_accuracy WHERE is_current AND (role = 'check' "
        "OR point IN (SELECT point FROM v_exclusion WHERE is_current AND action = 'excluded'))",
        brief=("point", "dX_m", "dY_m", "sigma_X_m", "sigma_Y_m", "dX_sigmas", "dY_sigmas"),
        nothing="There is no check point: nothing independent says how good the result is.",
    ),
)
