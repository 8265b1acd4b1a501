"""Ready-made questions to a project file, and answers as table, CSV or JSON."""

import math
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from orient.errors import UsageError
from orient.report.audit_questions import AUDIT_QUESTIONS
from orient.report.csv_text import csv_pieces
from orient.report.question import Question, filled, filled_sql
from orient.report.text import console, print_answer, print_json, print_table
from orient.values import Scalar

if TYPE_CHECKING:
    from orient.store.asking import Answer
    from orient.store.project import Project

MAX_TABLE_ROWS = 100_000
PLAIN_NAME = re.compile(r"[\w-]*")


def _current(view: str) -> str:
    return f"SELECT * FROM {view} WHERE is_current"


QUESTIONS = (
    Question("orientation", "The elements with their standard deviations?", _current("v_orientation")),
    Question(
        "iterations",
        "Approximation and correction of each element in each iteration?",
        "SELECT iteration, unknown, unit, approximation, correction, adjusted FROM v_iteration "
        "WHERE is_current AND point = ''",
    ),
    Question(
        "starts",
        "Which start values were tried by the last resection, and where did they lead?",
        "SELECT candidate, method, is_reversed, points, rms_mm, in_front, height_above_m, solution, termination, "
        "end_vPv, is_as_good FROM v_start WHERE is_latest",
    ),
    Question(
        "solutions",
        "In which orientations did the last resection end, and which of them were refused?",
        "SELECT solution, termination, is_as_good, X_S_m, Y_S_m, Z_S_m, vPv, n_in_front, n_points, height_above_m "
        "FROM resection_solution WHERE run_id = (SELECT max(run_id) FROM stage_run WHERE stage = 'resection')",
    ),
    Question(
        "residuals",
        "Image residuals, the largest first?",
        "SELECT point, role, vx_mm, vy_mm, redundancy_x, redundancy_y FROM v_residual WHERE is_current "
        "ORDER BY vx_mm * vx_mm + vy_mm * vy_mm DESC",
    ),
    Question(
        "suspects",
        "Which observations contradict the others, or are not checked by them?",
        "SELECT stage, kind, part, point, axis, verdict, w, critical, share, rho, rho_with FROM v_reliability "
        "WHERE is_current AND verdict <> 'good' ORDER BY verdict = 'suspect' DESC, abs(w) - critical DESC",
    ),
    Question(
        "reliability",
        "Which error in a reading would not be found, and what would it do on the ground?",
        "SELECT stage, kind, part, point, axis, share, smallest_error, unit, bias_to_noise, ground_shift_m, "
        "ground_shift_point FROM v_reliability WHERE is_current ORDER BY ground_shift_m DESC",
    ),
    Question("excluded", "Which points were left out, by whom and why?", "SELECT * FROM v_exclusion WHERE is_current"),
    Question(
        "global-test", "Do the adjustments fit the sigmas given?", "SELECT * FROM v_adjustment_test WHERE is_current"
    ),
    Question("ground-accuracy", "How sure is a ground point read on the photo?", _current("v_ground_accuracy")),
    Question("ground-map", "How sure is a new ground point over the frame?", _current("v_ground_map")),
    Question("pairs", "How do the errors of two ground points hang together?", _current("v_ground_pair")),
    Question("error-budget", "Where does the ground error of each point come from?", _current("v_error_budget")),
    Question("corrections", "What was corrected on each image point?", _current("v_correction")),
    Question("fiducials", "Residuals at the fiducial marks?", _current("v_fiducial_residual")),
    Question("crosses", "Residuals of the map's crosses?", _current("v_cross_residual")),
    Question("control", "The points on the ground and where they come from?", _current("v_control")),
    Question("absolute", "The orientation of each zone of the model?", _current("v_absolute_orientation")),
    Question(
        "absolute-elements",
        "The seven elements of each zone, in every paper's form?",
        "SELECT zone, view, element, value, sigma, unit FROM v_absolute_element WHERE is_current",
    ),
    Question(
        "absolute-iterations",
        "Approximation and correction of each element of each zone?",
        "SELECT zone, iteration, unknown, unit, approximation, correction, adjusted FROM v_absolute_iteration "
        "WHERE is_current",
    ),
    Question(
        "absolute-equations",
        "The correction equations of each zone, in every paper's form?",
        _current("v_absolute_equation"),
    ),
    Question(
        "absolute-residuals",
        "Residuals of the control of each zone, the largest first?",
        "SELECT zone, point, role, known, vX_m, vY_m, vZ_m, v_m FROM v_absolute_residual WHERE is_current "
        "ORDER BY v_m DESC",
    ),
    Question(
        "model-points",
        "Where are the points of the model on the ground, and how sure?",
        "SELECT zone, point, role, X_m, Y_m, Z_m, sigma_X_m, sigma_Y_m, sigma_Z_m FROM v_model_ground_point "
        "WHERE is_current",
    ),
    Question("current", "Which version of each stage is current?", "SELECT * FROM v_current"),
    Question("stale", "What is stale, and why?", "SELECT * FROM v_stale WHERE is_stale"),
    Question("audit", "Who did what, when and why?", "SELECT * FROM v_audit"),
    Question("verification", "Which results were verified, and what was found?", "SELECT * FROM v_verification"),
    Question("events", "All remarks, warnings and errors?", "SELECT * FROM v_event"),
    *AUDIT_QUESTIONS,
)
BY_NAME = {question.name: question for question in QUESTIONS}


def list_questions() -> None:
    """Names and texts of the questions."""
    rows = [[question.name, _asks(question)] for question in QUESTIONS]
    print_table(["name", "question"], rows, [False, False])
    console().print('Ask one by its name, or write SQL: orient sql PROJECT "SELECT * FROM v_residual"')


def _asks(question: Question) -> str:
    """The text of a question and what can be filled in."""
    sets = "".join(f" --set {one.name}={one.default or '...'}" for one in question.parameters)
    return question.asks + (f" [{sets.strip()}]" if sets else "")


def answered(project: "Project", question: str, given: Mapping[str, str]) -> "Answer":
    """Columns and rows of a named question or of SQL, with its parameters filled in."""
    if question in BY_NAME:
        named = BY_NAME[question]
        return project.query(named.sql, filled(named, given))
    if PLAIN_NAME.fullmatch(question.strip()):
        raise UsageError(f'there is no question "{question}"', f"Questions are {', '.join(BY_NAME)}.")
    return project.query(question, filled_sql(question, given))


def answer(path: Path, question: str, as_csv: bool, as_json: bool, raw: bool, given: Mapping[str, str]) -> None:
    """The answer to a named question or to SQL."""
    from orient.store.project import open_project

    if as_csv and as_json:
        raise UsageError("--csv and --json exclude each other")
    with open_project(path, "read") as project:
        columns, rows = answered(project, question, given)
    if as_json:
        objects = [dict(zip(columns, map(_for_json, row), strict=True)) for row in rows]
        print_json(objects)
    elif as_csv:
        sys.stdout.writelines(csv_pieces(columns, rows, raw))
    elif not rows:
        console().print("no rows")
    else:
        print_answer(columns, rows[:MAX_TABLE_ROWS])


def _for_json(value: Scalar | bytes) -> Scalar:
    """JSON knows neither infinity nor bytes; a question can compute both, the tables hold none."""
    if isinstance(value, bytes):
        return value.hex()
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value
