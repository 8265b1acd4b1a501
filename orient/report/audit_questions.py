"""What a suspicious reviewer asks of a project, answered by the shipped views (docs/audit.md)."""

from orient.report.question import Parameter, Question

AUDIT_QUESTIONS: tuple[Question, ...] = (
    Question(
        "who-excluded",
        "Who left a point out, when and why?",
        "SELECT e.stage, e.version, e.is_current, e.part, e.point, e.action, e.decided_by, e.actor, v.started_at, "
        "v.reason AS message, e.reason, e.test, e.statistic, e.critical "
        "FROM v_exclusion AS e JOIN v_version AS v ON v.stage = e.stage AND v.version = e.version "
        "WHERE :point IN ('', e.point) ORDER BY v.run_id, e.seq",
        (Parameter("point", "one point; empty: all"),),
    ),
)
