"""The tables of a summary: one row per photo and batch, and what belongs to it. Names are lower case, never quoted.

Not in `orient.models`: the summary is another database than a project, on SQLite or a server, and its rows may be
deleted; the proof stays in the projects.
"""

from sqlalchemy import Column, Double, ForeignKey, Integer, MetaData, String, Table, Text, UniqueConstraint

SUMMARY_VERSION = 1
METADATA = MetaData()


def _words(name: str, comment: str, nullable: bool = True) -> Column[str]:
    return Column(name, Text, nullable=nullable, comment=comment)


def _real(name: str, comment: str) -> Column[float]:
    return Column(name, Double, comment=comment)


def _whole(name: str, comment: str, nullable: bool = True) -> Column[int]:
    return Column(name, Integer, nullable=nullable, comment=comment)


def _of_photo() -> Column[int]:
    target = ForeignKey("orient_photo.photo_id", ondelete="CASCADE")
    return Column("photo_id", Integer, target, primary_key=True, comment="row of orient_photo")


FORMAT = Table(
    "orient_summary",
    METADATA,
    _whole("version", "format of these tables", nullable=False),
    comment="One row: which tables these are.",
)

BATCH = Table(
    "orient_batch",
    METADATA,
    Column("batch_id", Integer, primary_key=True, comment="1, 2, ... in the order they were begun"),
    _words("state", "running | finished | stopped; running without a living program: it was killed", nullable=False),
    _words("started_at", "UTC", nullable=False),
    _words("ended_at", "UTC; NULL while running, or killed"),
    _words("actor", "who", nullable=False),
    _words("host", "machine of the coordinator", nullable=False),
    _words("workers", "what worked: a number of local workers, or the address of the scheduler", nullable=False),
    _words("reason", "why, in the words of the actor; kept with every version too", nullable=False),
    _words("settings", "settings that were asked for (JSON)", nullable=False),
    _words("tool_version", "version of orient", nullable=False),
    _whole("n_photos", "photos on the list", nullable=False),
    _whole("n_done_before", "photos whose file had not changed since an earlier batch: not done again", nullable=False),
    comment="One call of `orient batch`.",
)

PHOTO = Table(
    "orient_photo",
    METADATA,
    Column("photo_id", Integer, primary_key=True, comment="key"),
    Column(
        "batch_id", Integer, ForeignKey("orient_batch.batch_id"), nullable=False, comment="batch that has done the work"
    ),
    Column("path_digest", String(64), nullable=False, index=True, comment="sha256 of path: the identity of the photo"),
    _words("path", "the project file, absolute, links followed", nullable=False),
    _words("photo", "name of the photo, from photo.toml"),
    _words("platform", "space | aerial | terrestrial"),
    _words("ended_at", "when the row was written (UTC)", nullable=False),
    _whole("exit_code", "0 oriented, 1 refused by the data or not oriented, 2, 3, 70: as `orient run`", nullable=False),
    _words("error", "why there is no result; empty if there is one", nullable=False),
    _words("hint", "what to do about it", nullable=False),
    _words("verdict", "good | doubtful | stale | failed | incomplete; NULL if the project could not be read"),
    _words("sentence", "the verdict in words"),
    _whole("n_computed", "stages that were computed in this batch; 0: everything was up to date"),
    _words("host", "machine of the worker"),
    _real("duration_s", "time the photo took there"),
    _words("file_stamp", "size, times and number of the file after the work"),
    _whole("resection_version", "version of the orientation; NULL here and below without a current one"),
    _words("frame", "topocentric | local_right | local_left: frame of x_s_m, y_s_m, z_s_m"),
    *(_real(f"{name}_s_m", f"projection centre {name.upper()}_S") for name in "xyz"),
    *(_real(f"sigma_{name}_s_m", "its standard deviation") for name in "xyz"),
    _real("b_s_deg", "projection centre, latitude; NULL for a local frame"),
    _real("l_s_deg", "projection centre, longitude"),
    _real("h_s_m", "projection centre, ellipsoidal height"),
    *(_real(f"{name}_deg", f"angle {name} of the papers, in the ground frame") for name in ("alpha", "omega", "kappa")),
    *(_real(f"sigma_{name}_deg", "its standard deviation; NULL near the blind view")
      for name in ("alpha", "omega", "kappa")),
    *(_real(f"q_{name}", "unit quaternion image -> right-handed ground, w >= 0") for name in "wxyz"),
    _real("f_mm", "focal length; the adjusted one if it was estimated"),
    _whole("n_control", "control points"),
    _whole("n_equations", "n"),
    _whole("n_unknowns", "u"),
    _whole("redundancy", "r = n - u"),
    _real("sigma0_mm", "standard deviation of unit weight a posteriori; NULL without redundancy"),
    _real("sigma0_apriori_mm", "standard deviation of unit weight a priori"),
    _words("variance_basis", "a posteriori | a priori: which sigma0 scales the covariances"),
    _real("variance_scale", "mm^2; factor on the cofactors"),
    _real("rms_x_mm", "sqrt(sum vx^2 / number of control points)"),
    _real("rms_y_mm", "sqrt(sum vy^2 / number of control points)"),
    _whole("iterations", "iterations of the adjustment"),
    _words("termination", "CONVERGED, ..."),
    _whole("n_errors", "findings of severity error"),
    _whole("n_warnings", "findings of severity warning"),
    _whole("n_notes", "findings of severity info"),
    UniqueConstraint("batch_id", "path_digest", name="orient_photo_once"),
    comment="How each photo of a batch ended: exactly one row per photo and batch.",
)  # fmt: skip

COVARIANCE = Table(
    "orient_covariance",
    METADATA,
    _of_photo(),
    Column("unknowns", String(16), primary_key=True, comment="aok: alpha, omega, kappa | rotation: about the axes"),
    Column("i", Integer, primary_key=True, comment="row, 1 ... 6"),
    Column("j", Integer, primary_key=True, comment="column, i <= j <= 6"),
    _words("unknown_i", "unknown of the row", nullable=False),
    _words("unknown_j", "unknown of the column", nullable=False),
    _real("cofactor", "element of Q; rad, m"),
    _real("covariance", "variance_scale x Q; rad^2, rad m, m^2"),
    comment="The full 6 x 6 matrix of the orientation, upper triangle, as table `cofactor` of the project.",
)

STAGE = Table(
    "orient_stage",
    METADATA,
    _of_photo(),
    Column("stage", String(32), primary_key=True, comment="stage"),
    _whole("place", "order of computing", nullable=False),
    _words("state", "current | stale | to compute | waiting | failed", nullable=False),
    _whole("version", "current version, or the one that failed"),
    _whole("stage_version", "version of the computation"),
    _whole("is_computed", "1 if this batch computed it", nullable=False),
    _words("settings", "settings of the version (JSON)"),
    _words("input_digest", "sha256 of stage, stage version, settings and inputs"),
    _words("output_digest", "sha256 of the rows"),
    _words("tool_version", "program and libraries that made the version"),
    _words("told", "the result in one line, or why there is none", nullable=False),
    comment="Versions and digests of every stage of a photo.",
)

FINDING = Table(
    "orient_finding",
    METADATA,
    _of_photo(),
    Column("stage", String(32), primary_key=True, comment="stage"),
    Column("code", String(64), primary_key=True, comment="stable word for the kind"),
    Column("severity", String(16), primary_key=True, comment="error | warning | info"),
    _whole("n", "how many findings of this kind", nullable=False),
    _words("subject", "point, sheet or unknown of the first of them", nullable=False),
    _words("message", "the first of them in words", nullable=False),
    comment="Findings of the current versions by kind.",
)

LATEST = """
CREATE VIEW orient_latest AS
SELECT p.* FROM orient_photo p
WHERE p.batch_id = (SELECT max(q.batch_id) FROM orient_photo q WHERE q.path_digest = p.path_digest)
"""
"""Each photo once, as the last batch that worked on it has left it."""
