"""What docs/conventions.md says about turns and signs is what the code does; no link of the docs is broken."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from orient.geometry.distortion import Distortion, distort
from orient.geometry.rotation import matrix_from_aok, matrix_from_opk

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
SMALL = 0.1
VIEWS = {
    "alpha": (matrix_from_aok(SMALL, 0, 0), (1, 0)),
    "omega of aok": (matrix_from_aok(0, SMALL, 0), (0, 1)),
    "omega of opk": (matrix_from_opk(SMALL, 0, 0), (0, 1)),
    "phi": (matrix_from_opk(0, SMALL, 0), (-1, 0)),
}


@pytest.mark.parametrize("turn", VIEWS)
def test_where_the_camera_looks(turn: str) -> None:
    rotation, direction = VIEWS[turn]
    view = -rotation[:, 2]
    assert view[:2] == pytest.approx(math.sin(SMALL) * np.array(direction), abs=1e-15)
    assert view[2] < 0


@pytest.mark.parametrize("matrix", [matrix_from_aok, matrix_from_opk])
def test_kappa_turns_x_towards_y(matrix) -> None:  # type: ignore[no-untyped-def]
    assert matrix(0, 0, SMALL)[:, 0] == pytest.approx([math.cos(SMALL), math.sin(SMALL), 0.0])


def test_a_single_phi_is_a_single_minus_alpha() -> None:
    assert matrix_from_opk(0, SMALL, 0) == pytest.approx(matrix_from_aok(-SMALL, 0, 0))


def test_the_opencv_formula_of_the_page() -> None:
    k1, k4, p1, p2, s1, s3, f = 0.02, 0.01, 1e-3, -2e-3, 3e-4, -1e-4, 100.0
    lens = Distortion(
        "opencv", "ideal_to_distorted", {"k1": k1, "k4": k4, "p1": p1, "p2": p2, "s1": s1, "s3": s3}, None, f
    )
    x, y = 23.0, 31.0
    u, w = x / f, -y / f
    r2 = u * u + w * w
    q = (1 + k1 * r2) / (1 + k4 * r2)
    u_distorted = u * q + 2 * p1 * u * w + p2 * (r2 + 2 * u * u) + s1 * r2
    w_distorted = w * q + p1 * (r2 + 2 * w * w) + 2 * p2 * u * w + s3 * r2
    assert distort(lens, [[x, y]])[0] == pytest.approx([f * u_distorted, -f * w_distorted], rel=1e-12)


PAGES = sorted([ROOT / "README.md", ROOT / "CHANGELOG.md", *DOCS.rglob("*.md"), *ROOT.glob("sample_projects/*/*.md")])


def linked_from(page: Path) -> dict[str, Path]:
    """Targets of the links of a page that are files here: as written, and where they lie."""
    targets = re.findall(r"\]\(([^)#]+)[^)]*\)", page.read_text("utf-8"))
    return {target: (page.parent / target).resolve() for target in targets if "://" not in target}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_no_link_is_broken(page: Path) -> None:
    assert [target for target, path in linked_from(page).items() if not path.exists()] == []


def test_every_page_is_linked_from_the_readme() -> None:
    assert set(DOCS.glob("*.md")) - set(linked_from(ROOT / "README.md").values()) == set()
