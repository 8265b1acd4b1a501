"""`orient.open` and `orient.new`: one project as a `Photo`."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from orient.door.arguments import covariances_of, for_each, sigmas_of, system_of
from orient.door.arrays import points_of
from orient.door.of_project import in_mm, reading_covariance, stored_frame, version_of
from orient.door.orientation import Orientation, orientation_from
from orient.door.paths import PathLike, path_of
from orient.door.picture import Picture
from orient.door.places import NO_GROUND, GroundPlaces, ImagePlaces
from orient.door.status import Done, Finding, Stage, Status
from orient.door.table import Table
from orient.errors import OrientError, UsageError, require_numba
from orient.pipeline.frames import Frame
from orient.pipeline.new_points import in_image, on_ground
from orient.pipeline.photo_model import STAGES, PhotoModel, photo_model
from orient.pipeline.registry import BY_NAME, INPUT_STAGES, is_optional
from orient.report.findings import findings
from orient.report.plots import plot_named
from orient.report.questions import answered
from orient.report.status import Standing, standing
from orient.store.project import Project, RunInfo, open_project
from orient.units import DEGREES_PER_RADIAN, RADIANS_PER_DEGREE
from orient.values import Scalar, Tables

if TYPE_CHECKING:
    from orient.pipeline.runner import Result

Array = NDArray[np.float64]
TO_DEGREES = np.array([DEGREES_PER_RADIAN, DEGREES_PER_RADIAN, 1.0])


class Photo:
    """One project: a photo, its lists, all versions of its results.

    Nothing is kept open between two calls, and nothing is written but by `run`, `add` and `select`, each of which
    appends a version. Every error is an `OrientError` with a `message` and a `hint`.
    """

    def __init__(self, path: PathLike) -> None:
        self.path = path_of(path, "the project")
        self._read: dict[tuple[int, str], Tables] = {}
        with open_project(self.path):
            pass  # says at once what is wrong with the file

    def __repr__(self) -> str:
        return f"Photo({self.path.name!r}: {self.status.sentence})"

    # ------------------------------------------------------------------------------------------ the ledger

    @property
    def status(self) -> Status:
        """The verdict, and the state of each stage."""
        now = self._standing()
        stages = {
            str(entry["stage"]): Stage(_version(entry["version"]), str(entry["state"]), str(entry["told"]))
            for entry in now.stages
        }
        return Status(now.verdict.word, now.verdict.sentence, stages)

    @property
    def findings(self) -> list[Finding]:
        """What to know before using a number: problems of all that is current, the grave ones first, then notes."""
        return self._standing().findings

    def _standing(self) -> Standing:
        with open_project(self.path) as project:
            return standing(project)

    def run(
        self, stage: str | None = None, *, reason: str = "run", again: bool = False, **settings: Scalar
    ) -> list[Done]:
        """Compute what is missing or stale; or one stage, with its settings (`orient STAGE --help` explains them).

        `photo.run()`, `photo.run("resection", exclude="P7", exclude_reason="wrong house")`. Settings hold for the next
        versions too. A stage that fails raises OrientError; its version, with iterations and events, is kept.
        """
        from orient.pipeline.runner import run_stage, run_stale

        if stage is None:
            if settings or again:
                raise UsageError("settings belong to a stage", 'For example: photo.run("resection", robust=True)')
            results = run_stale(self.path, {}, reason, lambda _: None, lambda _: None)
        else:
            if stage not in BY_NAME:
                raise UsageError(f'there is no computed stage "{stage}"', f"Stages are {', '.join(BY_NAME)}.")
            plain = {name: value.item() if isinstance(value, np.generic) else value for name, value in settings.items()}
            results = [run_stage(self.path, stage, plain, reason, again)]
        for result in results:
            if result.run is not None and result.failed:
                kept = f"{result.stage}: {result.run.error} (kept as version {result.run.version})"
                raise OrientError(kept, result.hint)
        return [_done(one) for one in results if not (one.waits_for and is_optional(one.stage, one.waits_for))]

    def add(self, what: str, *files: PathLike, reason: str, decimal: str = "point", encoding: str = "utf-8") -> Done:
        """A new version of one list - photo, readings, sheet, control, model - from its CSV and TOML files."""
        from orient.intake.project_folder import read_input
        from orient.intake.text_file import read_options
        from orient.pipeline.runner import add_input, photo_facts

        if what not in INPUT_STAGES:
            raise UsageError(f'there is no list "{what}"', f"Lists are {', '.join(INPUT_STAGES)}.")
        given = read_input(
            what, [path_of(file, "a file") for file in files], read_options(decimal, encoding), photo_facts(self.path)
        )
        return _done(add_input(self.path, given, reason))

    def select(self, stage: str, version: int | None, *, reason: str) -> None:
        """Make another version of a stage or list current; what read the other one becomes stale.

        None: it has no current version from now on, nor has what cannot be computed without it.
        """
        from orient.pipeline.runner import select_version, withdraw

        if version is None:
            withdraw(self.path, stage, reason)
        else:
            select_version(self.path, stage, version, reason)

    # ------------------------------------------------------------------------------------------ results

    @property
    def orientation(self) -> Orientation:
        """The current exterior orientation."""
        return self.orientation_of(None)

    def orientation_of(self, version: int | None) -> Orientation:
        """The exterior orientation of one version of `resection`; None: the current one."""
        with open_project(self.path) as project, project.snapshot():
            run = version_of(project, "resection", version)
            if run.status != "succeeded":
                raise OrientError(f"resection version {run.version} failed: {run.error}", "Ask for another version.")
            by_id = {one.run_id: one for one in project.runs()}
            read = {name: self._tables(project, by_id[run_id]) for name, run_id in run.inputs.items()}
            resection = self._tables(project, run)
        return orientation_from(run.version, resection, stored_frame(read).partner)

    def residuals(self) -> Table:
        """Image residuals of the current orientation, v = adjusted minus measured [mm], the largest first."""
        return self.ask("residuals")

    def ask(self, question: str, **parameters: object) -> Table:
        """The answer to a ready-made question by its name (`orient sql --list`), or to any SELECT.

        `photo.ask("control")`, `photo.ask("who-excluded", point="P7")`.
        """
        given = {name: str(value) for name, value in parameters.items()}
        with open_project(self.path) as project:
            return Table(*answered(project, question, given))

    def table(self, name: str, stage: str, version: int | None = None) -> Table:
        """The rows that one version of a stage has in a table of docs/schema.md; None: the current version."""
        with open_project(self.path) as project, project.snapshot():
            run = version_of(project, stage, version)
            rows = self._tables(project, run).get(name, ())
        if not rows:
            raise UsageError(f"{stage} version {run.version} has no rows in {name}")
        return Table(list(rows[0]), [list(row.values()) for row in rows])

    def plot(self, kind: str) -> Picture:
        """A picture of the current results, by the names of `orient plot`. Needs orient[plot]."""
        return Picture(self.path, plot_named(kind).name)

    # ------------------------------------------------------------------------------------------ image and ground

    def image_to_ground(
        self,
        xy: ArrayLike,
        H: ArrayLike,
        sigma: ArrayLike | None = None,
        sigma_H: ArrayLike = 0.0,
        system: str | None = None,
    ) -> GroundPlaces:
        """Where image points meet the height H: (n, 3) points and (n, 3, 3) covariances, and their parts.

        `xy` (n, 2), by default as in the project's readings, before any correction; `system` says otherwise:
        px (column, row), comparator (mm of the reading), image (mm, corrected, from the principal point).
        `H` [m] one or (n,): ellipsoidal height; of local ground Z. `sigma` of a coordinate of xy in its unit, one or
        (n,); None: the one a priori of photo.toml. `sigma_H` [m]. The covariance has the whole of the orientation,
        of an estimated camera and interior orientation with all correlations, scaled as the stage `covariance` does.
        """
        model = self._model()
        system = system_of(system, model)
        values = points_of("xy", xy, 2, or_one=True)
        heights = for_each(H, len(values), "H")
        variances = sigmas_of(sigma_H, len(values), "sigma_H") ** 2
        sigmas = None if sigma is None else sigmas_of(sigma, len(values), "sigma")
        if not len(values):
            return NO_GROUND
        readings = in_mm(model, values, system)
        own = reading_covariance(model, sigmas, readings, system)
        found = on_ground(model, readings, heights, own, variances)
        parts = found.covariance
        plan = found.horizon @ parts.total @ found.horizon.transpose(0, 2, 1)
        return GroundPlaces(found.points, parts.total, parts.orientation, parts.reading, parts.height, plan)

    def ground_to_image(
        self, points: ArrayLike, covariances: ArrayLike | None = None, system: str | None = None
    ) -> ImagePlaces:
        """Where ground points are seen: (n, 2) xy and (n, 2, 2) covariances.

        `points` (n, 3) [m] as `image_to_ground` gives them; `covariances` (n, 3, 3) or (3, 3) [m^2] of their own,
        None: without error; `system` as there. NaN for a point behind the camera or outside the frame.
        """
        model = self._model()
        system = system_of(system, model)
        ground = points_of("points", points, 3, or_one=True)
        own = covariances_of(covariances, len(ground), "covariances")
        found = in_image(model, ground, own, as_reading=system != "image")
        if system != "px":
            return ImagePlaces(found.xy, found.covariance)
        step = model.pixel_step
        return ImagePlaces(model.pixels_from_mm(found.xy), found.covariance / np.outer(step, step))

    def ground_from_geographic(self, geographic: ArrayLike, *, compiled: bool = False) -> Array:
        """(n, 3) [m] of T' from latitude, longitude [deg] and ellipsoidal height [m] (n, 3) on the photo's datum.

        `compiled`: by numba (`orient[fast]`), the same numbers, for millions of points.
        """
        require_numba(compiled)
        frame = self._earth()
        B, L, H = points_of("geographic", geographic, 3, or_one=True).T
        return frame.from_geographic(B * RADIANS_PER_DEGREE, L * RADIANS_PER_DEGREE, H, compiled=compiled)

    def geographic_from_ground(self, points: ArrayLike) -> Array:
        """(n, 3) latitude, longitude [deg] and ellipsoidal height [m] of points (n, 3) [m] of T'."""
        return np.asarray(self._earth().geographic(points_of("points", points, 3, or_one=True)) * TO_DEGREES)

    # ------------------------------------------------------------------------------------------ within

    def _model(self) -> PhotoModel:
        """The photo as it is oriented now; refused where the result is out of date."""
        with open_project(self.path) as project, project.snapshot():
            heads = {stage: version_of(project, stage, None) for stage in STAGES}
            stale = [str(row[0]) for row in project.query("SELECT stage FROM v_stale WHERE is_stale")[1]]
            old = [stage for stage in stale if stage in heads]
            if old:
                raise OrientError(f"the orientation is out of date ({', '.join(old)})", "Compute it: photo.run()")
            return photo_model({stage: self._tables(project, run) for stage, run in heads.items()})

    def _earth(self) -> Frame:
        with open_project(self.path) as project, project.snapshot():
            heads = {stage: version_of(project, stage, None) for stage in ("photo", "topocentric")}
            frame = stored_frame({stage: self._tables(project, run) for stage, run in heads.items()})
        if frame.is_local:
            raise UsageError("the ground of this photo is local: it has no latitude and longitude")
        return frame

    def _tables(self, project: Project, run: RunInfo) -> Tables:
        """Rows of a sealed run never change: they are read once."""
        key = (run.run_id, run.output_digest)
        if key not in self._read:
            self._read[key] = project.read_tables(run.run_id)
        return self._read[key]


def open(path: PathLike) -> Photo:
    """An existing project; a file that is none, too old, damaged or altered is refused with its own ProjectError."""
    return Photo(path)


def new(
    path: PathLike, folder: PathLike, *, reason: str = "new project", decimal: str = "point", encoding: str = "utf-8"
) -> Photo:
    """Make a project from a folder with photo.toml and the lists (docs/input.md); one mistake, and none is made."""
    from orient.intake.project_folder import read_project
    from orient.intake.text_file import read_options
    from orient.pipeline.runner import create

    target, source = path_of(path, "the project"), path_of(folder, "the folder")
    create(target, read_project(source, read_options(decimal, encoding)), reason)
    return Photo(target)


def _done(result: "Result") -> Done:
    told = tuple(findings(result.stage, result.events))
    run = result.run
    if run is None:
        return Done(result.stage, None, False, "", told, {}, result.waits_for)
    return Done(result.stage, run.version, result.computed, run.summary, told, dict(run.settings))


def _version(value: object) -> int | None:
    return value if isinstance(value, int) else None
