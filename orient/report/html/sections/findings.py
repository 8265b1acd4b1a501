"""Findings first: what is wrong and what to do about it, before any number."""

from orient.report.findings import REMEDIES, UNUSED_DATA, Finding, folded
from orient.report.html import kinds
from orient.report.html.blocks import Block, Notice, Paragraph, Section
from orient.report.html.cells import name
from orient.report.html.evidence import Evidence
from orient.report.language import tr, trn

MOST = 40


def section(evidence: Evidence) -> Section:
    told = folded(evidence.findings)
    problems = [(found, count) for found, count in told if found.is_problem]
    others = [(found, count) for found, count in told if not found.is_problem]
    blocks: list[Block] = [
        Notice("error", kinds.stage(stage), name(error), name(remedy)) for stage, error, remedy in evidence.failed
    ]
    blocks += [_notice(*each) for each in problems[:MOST]]
    if not problems and not evidence.failed:
        blocks.append(Paragraph(tr("No warning and no error was recorded for what is current.")))
    if others:
        blocks.append(Paragraph(tr("Remarks:")))
        blocks += [_notice(*each) for each in others[:MOST]]
    left = max(len(problems) - MOST, 0) + max(len(others) - MOST, 0)
    if left:
        blocks.append(Paragraph(trn("{n} more remark is in the file.", "{n} more remarks are in the file.", left)))
    if evidence.findings or evidence.failed:
        blocks.append(Paragraph(tr("Sentences in quotation marks stand in the project file as they are."), "note"))
    return Section("findings", tr("Findings"), blocks)


def _notice(found: Finding, count: int) -> Notice:
    """`count` findings of one kind, of which this one is told."""
    remedy = tr(REMEDIES[found.code]) if found.code in REMEDIES else ""
    severity = "info" if found.code in UNUSED_DATA else found.severity
    more = trn("and {n} more of this kind", "and {n} more of this kind", count - 1) if count > 1 else ""
    title = f"{kinds.stage(found.stage)}: {kinds.finding(found.code)}"
    return Notice(severity, f"{title} ({more})" if more else title, name(found.message), remedy)
