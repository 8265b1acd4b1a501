"""The report as PDF, laid out for A4 by WeasyPrint; the letters come with matplotlib, so every machine has them."""

import hashlib
from pathlib import Path
from typing import Any

from orient.errors import OrientError
from orient.report.html.render import NEEDED, make_report, require_libraries

FONTS = {"normal": "DejaVuSans.ttf", "bold": "DejaVuSans-Bold.ttf"}
FACE = '@font-face {{ font-family: "DejaVu Sans"; font-weight: {weight}; src: url("{address}"); }}'


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
    content = document.write_pdf(stylesheets=[faces], font_config=fonts, pdf_identifier=identifier)
    return bytes(content)


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
