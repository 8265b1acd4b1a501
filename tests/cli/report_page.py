"""A report as a parser sees it: elements, attributes, text, tables; and projects with names that try to be markup."""

import re
from dataclasses import dataclass, field, replace
from html.parser import HTMLParser
from pathlib import Path

from orient.intake.options import ReadOptions
from orient.intake.project_folder import read_project
from orient.pipeline.runner import create
from orient.values import InputTables, Row
from tests.cli.commands import orient
from tests.cli.made_photo import NAMES, MadePhoto

ACTIVE = {
    "script",
    "iframe",
    "object",
    "embed",
    "link",
    "base",
    "form",
    "img",
    "image",
    "foreignobject",
    "video",
    "audio",
}
VOID = {"meta", "br", "hr", "img", "input", "link"}
HOSTILE = (
    "<script>alert(1)</script>",
    '"><img src=x onerror=alert(1)>',
    "]]></svg><svg onload=alert(1)>",
    "--><script>alert(2)</script><!--",
    "javascript:alert(1)",
    "{{ 7 * 7 }}{% for x in y %}",
    "$\\frac{1}{2}$ &amp; ' `",
    "a‮b\u200bc",
)


@dataclass
class Page(HTMLParser):
    """`tables`: rows of cells below each h3; `problems`: elements that were not closed in order."""

    tags: list[tuple[str, dict[str, str | None]]] = field(default_factory=list)
    tables: dict[str, list[list[str]]] = field(default_factory=dict)
    titles: list[str] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)
    text: str = ""
    style: str = ""

    def __post_init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self._open: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self._open.append(tag)
        if tag in ("h2", "h3"):
            self.titles.append("")
        if tag == "tr":
            self.tables.setdefault(self.titles[-1], []).append([])
        if tag in ("td", "th"):
            self.tables[self.titles[-1]][-1].append("")

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        if not self._open or self._open.pop() != tag:
            self.problems.append(tag)

    def handle_data(self, data: str) -> None:
        self.text += data
        inner = self._open[-1] if self._open else ""
        if inner == "style":
            self.style += data
        if inner in ("h2", "h3"):
            self.titles[-1] += data
        if inner in ("td", "th"):
            self.tables[self.titles[-1]][-1][-1] += data

    def table(self, title: str) -> list[list[str]]:
        """The only table whose title begins so."""
        (found,) = [rows for name, rows in self.tables.items() if name.startswith(title)]
        return found

    @property
    def active(self) -> list[str]:
        """Everything that could run, load or send something."""
        found = [tag for tag, _ in self.tags if tag in ACTIVE]
        for tag, attributes in self.tags:
            for name, value in attributes.items():
                outside = name in ("src", "href", "xlink:href", "action", "data") and not str(value).startswith("#")
                if (
                    name.startswith("on")
                    or name == "style"
                    or outside
                    or "url(" in re.sub(r"url\(#[\w-]+\)", "", str(value))
                ):
                    found.append(f"{tag} {name}={value}")
        return found


def parsed(html: str) -> Page:
    page = Page()
    page.feed(html)
    page.close()
    return page


def report(path: Path, *words: object) -> Page:
    said = orient("report", path, "-o", "-", *words)
    assert (said.code, said.err) == (0, "")
    return parsed(said.out)


def hostile_project(folder: Path) -> Path:
    """A stranger's file: photo, points and reasons have names that are markup (a list with such names is refused)."""
    path = folder / "hostile.sqlite"
    create(
        path, [_renamed(given) for given in read_project(MadePhoto().write(folder / "in"), ReadOptions())], HOSTILE[0]
    )
    for command in (
        ("run", path, "-m", HOSTILE[1]),
        ("resection", path, "--exclude", HOSTILE[4], "--reason", HOSTILE[3], "-m", HOSTILE[2]),
        ("run", path),
    ):
        said = orient(*command)
        assert said.code == 0, said.err
    return path


def _renamed(given: InputTables) -> InputTables:
    tables = {table: [_hostile(row) for row in rows] for table, rows in given.tables.items()}
    return replace(given, tables=tables, events=())


def _hostile(row: Row) -> Row:
    if "point" in row:
        return {**row, "point": HOSTILE[NAMES.index(str(row["point"]))]}
    return {**row, "name": HOSTILE[1], "image_file": HOSTILE[4]} if "image_file" in row else row
