"""The report of a project as plain sections, in the order in which a reviewer reads them."""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import cast

from orient.report.html import kinds
from orient.report.html.blocks import Section
from orient.report.html.cells import moment, name
from orient.report.html.evidence import Evidence, gather
from orient.report.language import spoken, tr
from orient.store.project import open_project

ORDER = (
    "findings", "meaning", "photo", "orientation", "residuals", "reliability", "accuracy", "budget",
    "absolute", "sheets",
    "image", "iterations", "formulas", "provenance",
)  # fmt: skip
FINAL = ("resection", "absolute")


@dataclass(frozen=True, slots=True)
class Page:
    """What the template lays out."""

    language: str
    title: str
    subtitle: str
    verdict: str
    verdict_word: str
    sections: tuple[Section, ...]


def build_page(path: Path) -> Page:
    """One moment of the project as a page in the language that is spoken."""
    with open_project(path, "read") as project, project.snapshot():
        evidence = gather(project)
        sections = [_builder(key)(evidence) for key in ORDER]
        photo = evidence.photo
    return Page(
        language=spoken(),
        title=tr("Orientation report") + ("" if photo is None else f": {name(photo['name'])}"),
        subtitle=_subtitle(evidence),
        verdict=tr(kinds.VERDICTS[evidence.verdict.word]),
        verdict_word=evidence.verdict.word,
        sections=tuple(section for section in sections if section is not None),
    )


def _builder(key: str) -> Callable[[Evidence], Section | None]:
    module = import_module(f"orient.report.html.sections.{key}")
    return cast(Callable[[Evidence], Section | None], module.section)


def _subtitle(evidence: Evidence) -> str:
    """The final results with their versions."""
    told = [
        tr("{stage}, version {version}, {when} by {actor}",
           stage=kinds.stage(stage), version=run.version, when=moment(run.started_at), actor=name(run.actor))
        for stage in FINAL
        if (run := evidence.runs.get(stage)) is not None
    ]  # fmt: skip
    return "; ".join(told)
