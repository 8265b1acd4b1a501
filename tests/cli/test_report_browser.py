"""The report in Debian's chromium, at desktop and phone width: no error, no sideways scroll, nothing cut off.

These tests need the package `chromium`; without it they are skipped.
"""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.cli.commands import orient
from tests.cli.report_page import hostile_project

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed (Debian: apt install chromium)")
WIDTHS = {"desktop": 1280, "phone": 500}
"""A window of chromium is never narrower than 500; the phone itself is a frame of 390 in it."""
PHONE = 390
MEASURE = """
<script>
  const wide = document.documentElement.scrollWidth > window.innerWidth;
  const outside = [...document.querySelectorAll("h1,h2,h3,p,dl,figure,.scroll")].filter(
    e => e.getBoundingClientRect().right > window.innerWidth + 0.5).length;
  const flat = [...document.querySelectorAll("svg.plot")].filter(e => e.getBoundingClientRect().height < 150).length;
  document.title = JSON.stringify({wide, outside, flat, plots: document.querySelectorAll("svg.plot").length});
</script>
"""


def browsed(page: Path, width: int, *options: str) -> "subprocess.CompletedProcess[str]":
    assert CHROMIUM
    command = [
        CHROMIUM, "--headless=new", "--no-sandbox", "--disable-gpu", f"--user-data-dir={page.parent / 'profile'}",
        "--enable-logging=stderr", "--no-proxy-server", f"--window-size={width},900", *options, page.as_uri(),
    ]  # fmt: skip
    environment = {**os.environ, "DBUS_SESSION_BUS_ADDRESS": "disabled:"}
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False, env=environment)


def console(said: "subprocess.CompletedProcess[str]") -> list[str]:
    """What the page itself complained of: script errors, and everything that the policy refused."""
    return [line for line in said.stderr.splitlines() if ":CONSOLE" in line or "Refused to" in line]


def test_a_picture_is_made_and_nothing_is_complained_of(space: Path, tmp_path: Path) -> None:
    page, picture = tmp_path / "report.html", tmp_path / "page.png"
    assert orient("report", space, "-o", page).code == 0
    said = browsed(page, WIDTHS["desktop"], f"--screenshot={picture}")
    assert console(said) == []
    assert picture.stat().st_size > 20_000


def test_the_browser_sees_the_policy(space: Path, tmp_path: Path) -> None:
    """The same page with a script in it: the browser refuses to run it. So the policy is in force."""
    page = tmp_path / "report.html"
    assert orient("report", space, "-o", page).code == 0
    page.write_text(page.read_text("utf-8").replace("</main>", "</main><script>document.title='ran'</script>"), "utf-8")
    said = browsed(page, WIDTHS["desktop"], "--dump-dom")
    assert "<title>ran</title>" not in said.stdout
    assert console(said) != []


def test_names_that_are_markup_do_nothing(tmp_path: Path) -> None:
    page = tmp_path / "report.html"
    assert orient("report", hostile_project(tmp_path), "-o", page).code == 0
    assert console(browsed(page, WIDTHS["desktop"], "--dump-dom")) == []


@pytest.mark.parametrize("project", ["aerial", "space", "model"])
@pytest.mark.parametrize("width", WIDTHS.values(), ids=WIDTHS)
def test_nothing_runs_out_of_the_window(
    request: pytest.FixtureRequest, tmp_path: Path, project: str, width: int
) -> None:
    """The page is measured by a script of the test, in a copy without the policy; wide tables scroll in their box."""
    page = tmp_path / "report.html"
    assert orient("report", request.getfixturevalue(project), "-o", page).code == 0
    text = re.sub(r'<meta http-equiv="Content-Security-Policy"[^>]*>', "", page.read_text("utf-8"))
    page.write_text(text.replace("</body>", f"{MEASURE}</body>"), "utf-8")
    if width != WIDTHS["desktop"]:
        frame = f'<iframe src="report.html" width="{PHONE}" height="800"></iframe>'
        frame += "<script>onload = () => document.title = frames[0].document.title</script>"
        page = tmp_path / "phone.html"
        page.write_text(f"<!DOCTYPE html><title></title>{frame}", "utf-8")
    said = browsed(page, width, "--dump-dom", "--allow-file-access-from-files")
    found = re.search(r"<title>(.*?)</title>", said.stdout)
    assert found
    assert found[1].startswith('{"wide":false,"outside":0,"flat":0,"plots":'), found[1]
    assert not found[1].endswith(":0}")
