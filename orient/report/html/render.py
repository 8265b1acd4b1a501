"""A page as one HTML file: everything inside, nothing from outside, no script; its style is allowed by its hash."""

import base64
import hashlib
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path

from orient.errors import NotInstalled
from orient.report.html.page import Page, build_page
from orient.report.language import speaking, tr

NEEDED = ("jinja2", "babel", "matplotlib")
FOLDER = "orient.report.html"


def make_report(path: Path, language: str, for_print: bool = False) -> bytes:
    """The report as UTF-8; the same project gives the same bytes."""
    require_libraries(NEEDED, "report")
    with speaking(language):
        return render(build_page(path), for_print).encode("utf-8")


def require_libraries(names: tuple[str, ...], extra: str) -> None:
    """One sentence that says what to install."""
    missing = [name for name in names if find_spec(name) is None]
    if missing:
        raise NotInstalled("the report needs", missing, extra)


def render(page: Page, for_print: bool = False) -> str:
    """The page laid out by the template; every text is escaped there, the figures are elements already."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("orient.report.html", "."),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    style = files(FOLDER).joinpath("report.css").read_text("utf-8")
    digest = base64.b64encode(hashlib.sha256(style.encode("utf-8")).digest()).decode("ascii")
    policy = f"default-src 'none'; style-src 'sha256-{digest}'; base-uri 'none'; form-action 'none'"
    template = environment.get_template("report.html.j2")
    return template.render(page=page, style=style, policy=policy, tr=tr, for_print=for_print)
