"""The report as PDF, laid out for A4 by WeasyPrint; the letters come with matplotlib, so every machine has them."""

import hashlib
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from orient.errors import OrientError
from orient.report.html.render import NEEDED, make_report, require_libraries

FONTS = {"normal": "DejaVuSans.ttf", "bold": "DejaVuSans-Bold.ttf"}
FACE = '@font-face {{ font-family: "DejaVu Sans"; font-weight: {weight}; src: url("{address}"); }}'
CLOCK = "SOURCE_DATE_EPOCH"


def make_pdf(path: Path, language: str) -> bytes:
    """The same project gives the same bytes."""
    require_libraries((*NEEDED, "weasyprint"), "pdf")
    page = make_report(path, language, for_print=True)
    try:
        from weasyprint import CSS, HTML
        from weasyprint.text.fonts import FontConfiguration
    except OSError as error:
        raise OrientError(
            f"the libraries of WeasyPrint cannot be loaded: {error}", "Install Pango, or write HTML."
        ) from None
    fonts = FontConfiguration()
    faces = CSS(string=_faces(), font_config=fonts, url_fetcher=_only_fonts)
    document = HTML(string=page.decode("utf-8"), url_fetcher=_nothing)
    identifier = hashlib.sha256(page).hexdigest()[:32].encode("ascii")
    with _without_clock():
        content = document.write_pdf(stylesheets=[faces], font_config=fonts, pdf_identifier=identifier)
    return bytes(content)


@contextmanager
def _without_clock() -> Iterator[None]:
    """Where HarfBuzz cannot take the letters out of a font, fontTools does, and writes the time into it."""
    before = os.environ.get(CLOCK)
    os.environ[CLOCK] = "0"
    try:
        yield
    finally:
        os.environ.pop(CLOCK)
        if before is not None:
            os.environ[CLOCK] = before


def _faces() -> str:
    return "\n".join(FACE.format(weight=weight, address=_font(name).as_uri()) for weight, name in FONTS.items())


def _font(name: str) -> Path:
    import matplotlib

    return Path(matplotlib.get_data_path(), "fonts", "ttf", name)


def _only_fonts(url: str, *_: Any, **__: Any) -> dict[str, Any]:
    for name in FONTS.values():
        if url == _font(name).as_uri():
            return {"string": _font(name).read_bytes(), "mime_type": "font/ttf"}
    return _nothing(url)


def _nothing(url: str, *_: Any, **__: Any) -> dict[str, Any]:
    """The report needs nothing from outside."""
    raise ValueError(f"{url} is not part of the report")
