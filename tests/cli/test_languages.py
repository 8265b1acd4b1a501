"""The languages of report and pictures: no message is missing, fields agree, numbers are the same in all of them."""

import gettext
import re
import string
import sys
from pathlib import Path

import pytest
from babel.messages.catalog import Catalog

from orient.report import catalogues, language
from orient.report.findings import REMEDIES
from orient.report.html.kinds import FINDINGS
from orient.report.language import LANGUAGES, speaking, tr, trn
from tests.cli.commands import ROOT, orient
from tests.cli.report_page import report

OTHERS = [code for code in LANGUAGES if code != "en"]
EVENT_CODE = re.compile(r'Event\(\s*"(?:info|warning|error)",\s*"([a-z_]+)"')
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]\d+)?")
SAME_IN_ALL = re.compile(
    r"[\W\d_]*|(a posteriori|a priori|σ a priori|[XY]|gon|rad|k?m|[|]v[|], (m|px|µm)|[xy], mm|RMS .*)"
)
"""Messages of which a translation may be the message itself."""


def fields(text: str) -> set[str]:
    return {name for _, name, _, _ in string.Formatter().parse(text) if name is not None}


def forms(catalogue: Catalog, one: str) -> tuple[str, ...]:
    found = catalogue.get(one)
    assert found is not None, one
    return found.string if isinstance(found.string, tuple) else (found.string,)


@pytest.mark.parametrize("code", OTHERS)
def test_no_message_is_missing_and_none_is_left_over(code: str) -> None:
    catalogue = catalogues.catalogue(code)
    said = {message if isinstance(message, str) else message[0] for message in catalogues.messages()}
    kept = {message.id if isinstance(message.id, str) else message.id[0] for message in catalogue if message.id}
    assert said == kept, "run: python -m orient.report.catalogues"
    assert [one for one in said if not all(forms(catalogue, one))] == []
    assert [message.id for message in catalogue if message.id and message.fuzzy] == []
    untouched = [one for one in said if forms(catalogue, one) == (one,) and not SAME_IN_ALL.fullmatch(one)]
    assert [one for one in untouched if one not in language_neutral(code)] == []


def language_neutral(code: str) -> set[str]:
    """Words that happen to be the same."""
    return {one for one in ("{zone}", "camera") if code}


@pytest.mark.parametrize("code", OTHERS)
def test_the_fields_of_a_translation_are_those_of_the_message(code: str) -> None:
    catalogue = catalogues.catalogue(code)
    for message in set(catalogues.messages()):
        one = message if isinstance(message, str) else message[0]
        found = forms(catalogue, one)
        assert [form for form in found if fields(form) != fields(one)] == [], one
        assert len(found) == (1 if isinstance(message, str) else catalogue.num_plurals), one


def test_the_files_are_as_the_tool_writes_them() -> None:
    for code in OTHERS:
        assert (catalogues.FOLDER / f"{code}.po").read_bytes() == catalogues.updated(code), code


PLURALS = {
    "bg": {1: "1 опорна точка", 2: "2 опорни точки", 5: "5 опорни точки", 21: "21 опорни точки"},
    "uk": {1: "1 опорна точка", 2: "2 опорні точки", 5: "5 опорних точок", 21: "21 опорна точка"},
    "ru": {1: "1 опорная точка", 2: "2 опорные точки", 5: "5 опорных точек", 21: "21 опорная точка"},
}


@pytest.mark.parametrize(("code", "n"), [(code, n) for code, table in PLURALS.items() for n in table])
def test_number_and_noun_agree(code: str, n: int) -> None:
    with speaking(code):
        assert trn("{n} control point", "{n} control points", n) == PLURALS[code][n]
    assert tr("principal point") == "principal point"


def test_every_finding_has_a_title() -> None:
    """Codes that the stages write, as their source has them, and codes with a remedy."""
    source = "".join(path.read_text("utf-8") for path in (ROOT / "orient").rglob("*.py"))
    assert sorted({*EVENT_CODE.findall(source), *REMEDIES} - set(FINDINGS)) == []


@pytest.mark.parametrize("project", ["aerial", "space", "model"])
def test_a_report_says_nothing_that_is_not_in_the_catalogue(
    request: pytest.FixtureRequest, project: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Messages that are put together where the extraction does not see them would be found here."""
    asked: list[str] = []
    found = language._catalogue("bg")
    assert isinstance(found, gettext.GNUTranslations)
    original = gettext.GNUTranslations.gettext

    def noted(self: gettext.GNUTranslations, message: str) -> str:
        asked.append(message)
        return original(self, message)

    monkeypatch.setattr(gettext.GNUTranslations, "gettext", noted)
    page = report(request.getfixturevalue(project), "--language", "bg")
    known = {message if isinstance(message, str) else message[0] for message in catalogues.messages()}
    assert len(asked) > 100
    assert sorted(set(asked) - known) == []
    assert dict(page.tags)["html"] == {"lang": "bg"}


def test_numbers_are_the_same_in_every_language(space: Path) -> None:
    """Only words differ: the numbers of all tables, in their order, keep the point."""
    tables = {}
    for code in LANGUAGES:
        rows = [row for table in report(space, "--language", code).tables.values() for row in table[1:]]
        tables[code] = [cell for row in rows for cell in row if NUMBER.fullmatch(cell)]
    assert len(tables["en"]) > 1000
    assert all(numbers == tables["en"] for numbers in tables.values())


@pytest.mark.parametrize("code", OTHERS)
def test_a_picture_speaks_the_language(space: Path, code: str) -> None:
    svg = orient("plot", space, "sheet", "-o", "-", "--language", code).out
    with speaking(code):
        assert tr("digitiser X, mm") in svg
    assert "digitiser" not in svg


def test_without_babel_english_is_left(space: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "babel", None)
    said = orient("plot", space, "sheet", "-o", "-", "--language", "ru")
    assert (said.code, "babel" in said.err) == (2, True)
    assert orient("plot", space, "sheet", "-o", "-").code == 0
