"""Which source the ground error comes from."""

from statistics import median

from orient.report.budget import median_shares, plan_variances
from orient.report.html.blocks import Block, Paragraph, Section, Table
from orient.report.html.cells import digits, fixed
from orient.report.html.evidence import Evidence
from orient.report.language import tr, trn

COLUMNS = ("point", "source", "part", "cov_XX_m2", "cov_YY_m2")


def section(evidence: Evidence) -> Section | None:
    rows = evidence.rows("covariance", "error_budget", COLUMNS)
    shares = median_shares({"error_budget": rows})
    if not shares:
        return None
    by_point = plan_variances(rows).values()
    total = median(sum(parts.values()) ** 0.5 for parts in by_point)
    largest = shares[0]
    told = tr(
        "The largest source is: {source}, {percent} % of the variance. The ground sigma is {total} m.",
        source=tr(largest.source),
        percent=fixed(largest.percent, 0),
        total=digits(total, 3),
    )
    rest = median(sum(v for (name, _), v in parts.items() if name != largest.source) ** 0.5 for parts in by_point)
    without = tr("Without this source {rest} m would be left.", rest=digits(rest, 3)) if len(shares) > 1 else ""
    cells = [
        [tr(share.source), fixed(share.percent, 1), fixed(share.through_photo, 1), digits(share.sigma_m, 3)]
        for share in shares
    ]
    headers = [tr("source"), tr("share, %"), tr("through the photo, %"), "σ, m"]
    note = trn("Medians of {n} point.", "Medians of {n} points.", len(by_point))
    blocks: list[Block] = [
        Paragraph(f"{told} {without}".strip()),
        evidence.figure("budget", tr("Error budget")),
        Table(tr("Where the ground error comes from"), headers, cells, note=note),
    ]
    return Section("budget", tr("Error budget"), blocks)
