"""A plot of the current results: shown by a notebook, or saved."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from orient.door.paths import PathLike, path_of
from orient.report.output_file import ending_of, output_path, write_output
from orient.report.plots import ENDINGS, make_plot


@dataclass(frozen=True)
class Picture:
    """One plot of a project. It is drawn when it is asked for, with the results that are current then."""

    project: Path
    kind: str

    @cached_property
    def svg(self) -> str:
        """The picture as SVG."""
        return make_plot(self.project, self.kind, "svg").decode("utf-8")

    @cached_property
    def png(self) -> bytes:
        """The picture as PNG."""
        return make_plot(self.project, self.kind, "png")

    def save(self, path: PathLike, force: bool = False) -> Path:
        """Write FILE.svg or FILE.png; an existing file only with `force`."""
        name = str(path_of(path, "the picture"))
        ending = ending_of(name, ENDINGS, "picture")
        target = output_path(name, self.project, force)
        content = self.png if ending == ".png" else self.svg.encode("utf-8")
        write_output(target, content, self.project, force)
        return target

    def __repr__(self) -> str:
        return f"Picture({self.kind!r} of {self.project.name!r})"

    def _repr_png_(self) -> bytes:
        return self.png
