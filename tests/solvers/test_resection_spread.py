"""10 000 simulated photos: the spread of elements, new and adjusted ground points agrees with Q within 3 %.

Fixed and weighted control here; control that shares the errors of a map sheet in test_resection_common.
"""

from dataclasses import replace

import numpy as np
import pytest

from orient.solvers import functional_iteration
from orient.solvers.functional_iteration import Termination, cofactor_matrix
from orient.solvers.ground_covariance import ground_covariance, ray_at_height, ray_at_height_jacobians
from orient.solvers.ground_points import ground_knowledge
from orient.solvers.resection_problem import Orientation, ResectionProblem
from tests.solvers.resection_scenes import FloatArray, generator, looking, scene

SIGMA_MM, GROUND_M, HEIGHT_M = 0.005, 0.08, 0.05
NEW = np.array([[55.0, -40.0], [-20.0, 70.0]])
UP = np.array([0.0, 0.0, 1.0])


def problem_of(kind: str) -> tuple[ResectionProblem, Orientation, FloatArray]:
    """Nine points of an oblique photo without errors, its true orientation, and the covariance C of the control."""
    s = scene(generator("spread"), n=9, rotation=looking(0.7, 0.4, 1.1), distance=1500.0, relief=0.1)
    variances = [GROUND_M**2, GROUND_M**2, HEIGHT_M**2]
    C = np.tile(np.diag(variances) + 0.3 * GROUND_M**2 * (np.eye(3)[[1, 0, 2]] * [1, 1, 0]), (9, 1, 1))
    is_weighted = kind == "weighted"
    known = ground_knowledge(
        s.ground,
        np.tile(np.eye(3), (9, 1, 1)) if is_weighted else None,
        SIGMA_MM**2 * np.linalg.inv(C) if is_weighted else None,
    )
    truth = Orientation(s.rotation, s.station, s.ground)
    return ResectionProblem(s.image, s.unit, known, s.f_mm), truth, C if is_weighted else 0 * C


def adjusted(problem: ResectionProblem, truth: Orientation, image: FloatArray, ground: FloatArray) -> Orientation:
    simulated = replace(problem, image=image, known=replace(problem.known, given=ground))
    end = functional_iteration.iterate(simulated, replace(truth, ground=ground), tolerance=1e-9)
    assert end.termination is Termination.CONVERGED
    return end.state


def read_points(problem: ResectionProblem, state: Orientation, image: FloatArray, heights: FloatArray) -> FloatArray:
    level = np.column_stack([np.zeros((len(NEW), 2)), heights])
    return ray_at_height(image, state.station, state.rotation, problem.f_mm, level, np.tile(UP, (len(NEW), 1)))


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["fixed", "weighted"])
def test_spread_of_10_000_runs_agrees_with_Q(kind: str) -> None:
    problem, truth, C = problem_of(kind)
    random = generator(f"spread {kind}")
    root = np.linalg.cholesky(C) if C.any() else C
    heights = np.full(len(NEW), truth.ground[:, 2].mean())
    elements, control, new = [], [], []
    for _ in range(10_000):
        ground = truth.ground + (root @ random.normal(size=(9, 3, 1)))[:, :, 0]
        state = adjusted(problem, truth, problem.image + SIGMA_MM * random.normal(size=(9, 2)), ground)
        turned = state.rotation @ truth.rotation.T
        elements.append([turned[2, 1], turned[0, 2], turned[1, 0], *(state.station - truth.station)])
        control.append(state.ground)
        readings = NEW + SIGMA_MM * random.normal(size=NEW.shape)
        new.append(read_points(problem, state, readings, heights + HEIGHT_M * random.normal(size=len(NEW))))
    linear = problem.linearise(truth)
    Q = SIGMA_MM**2 * cofactor_matrix(linear)
    np.testing.assert_allclose(np.std(elements, axis=0), np.sqrt(np.diag(Q)), rtol=0.03)
    places = read_points(problem, truth, NEW, heights)
    jacobians = ray_at_height_jacobians(places, truth.station, truth.rotation, problem.f_mm, np.tile(UP, (len(NEW), 1)))
    unit = np.tile(SIGMA_MM**2 * np.eye(2), (len(NEW), 1, 1))
    predicted = ground_covariance(jacobians, Q, unit, np.full(len(NEW), HEIGHT_M**2)).total
    sigma = np.sqrt(np.diagonal(predicted, axis1=1, axis2=2))
    np.testing.assert_allclose(np.std(new, axis=0), sigma, rtol=0.03)
    if C.any():
        Q_P = SIGMA_MM**2 * problem.quality(truth, linear, cofactor_matrix(linear)).Q_P
        np.testing.assert_allclose(np.std(control, axis=0), np.sqrt(np.diagonal(Q_P, axis1=1, axis2=2)), rtol=0.03)
