"""Similarity of a photogrammetric model and the ground: X_G = q/H + X0, q = R x, R = ground_from_model.

Both systems right-handed. The papers write the matrix for row vectors, r = R', q_j = X r0j + Y r1j + Z r2j. Two angle
triples view the same R, and both are called xi, eta, theta by their authors, so they have names here:

* `fixed_axes` (seed 000): R = A_theta(Z) A_eta(Y) A_xi(X), xi about X, then eta about Y, then theta about Z of the
  ground; A_eta turns X towards Z;
* `tilts` (seed 002): R = A_xi(Y) A_eta(X) A_theta(Z), longitudinal tilt, transverse tilt, turn: the same cosines as
  alpha, omega, kappa of a photo, so `matrix_from_aok` and `aok_from_matrix` serve them.

H is the homothety coefficient (model units per metre), t = 1/H the scale denominator. Angles in radians, ground in
metres, the model in its own unit. Partials are of the COMPUTED ground coordinates.
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from orient.geometry.rotation import BLIND_COSINE, matrix_from_aok

Array = NDArray[np.float64]


def matrix_from_fixed_axes(xi: float, eta: float, theta: float) -> Array:
    """R = A_theta A_eta A_xi (3, 3); its transpose is r of seed 000, equation (3), with r02 = +sin(eta) and r21 mended.

    xi turns Y towards Z, eta turns X towards Z (not Z towards X), theta turns X towards Y; angles in radians.
    """
    sx, cx = math.sin(xi), math.cos(xi)
    se, ce = math.sin(eta), math.cos(eta)
    st, ct = math.sin(theta), math.cos(theta)
    return np.array(
        [
            [ce * ct, -cx * st - sx * se * ct, sx * st - cx * se * ct],
            [ce * st, cx * ct - sx * se * st, -sx * ct - cx * se * st],
            [se, sx * ce, cx * ce],
        ]
    )


def fixed_axes_from_matrix(rotation: ArrayLike) -> Array:
    """xi = atan2(r12, r22), eta = asin(r02), theta = atan2(r01, r00): (3,) radians, eta in [-pi/2, pi/2].

    In the blind view (eta = +-pi/2, the model's X axis vertical) only xi -+ theta is determined; theta is then taken
    with the xi found, so that the triple still gives back the matrix. Source: seed 000, EQUATIONS 1.1.
    """
    R = np.asarray(rotation, dtype=np.float64)
    xi = math.atan2(R[2, 1], R[2, 2])
    eta = math.atan2(R[2, 0], math.hypot(R[0, 0], R[1, 0]))
    # column 2 of R A_xi' is (-sin theta, cos theta, 0): never weaker than r00, r01, and defined in the blind view
    minus_sine, cosine, _ = R[:, 1] * math.cos(xi) - R[:, 2] * math.sin(xi)
    return np.array([xi, eta, math.atan2(-minus_sine, cosine)])


def fixed_axes_by_rotation(rotation: ArrayLike) -> Array:
    """d(xi, eta, theta)/dr (3, 3) for R_new = exp([r]x) R, at r = 0.

        d xi    = (cos(th) r1 + sin(th) r2) / cos(eta)
        d eta   =  sin(th) r1 - cos(th) r2
        d theta = r3 - tan(eta) (cos(th) r1 + sin(th) r2)

    Inverse of r = d_theta e_Z - d_eta A_theta e_Y + d_xi A_theta A_eta e_X. Not finite in the blind view
    (cos eta = 0): ask `near_blind_fixed_axes` first.
    """
    _, eta, theta = fixed_axes_from_matrix(rotation)
    s, c = math.sin(theta), math.cos(theta)
    ce, te = math.cos(eta), math.tan(eta)
    return np.array([[c / ce, s / ce, 0.0], [s, -c, 0.0], [-te * c, -te * s, 1.0]])


def near_blind_fixed_axes(rotation: ArrayLike) -> bool:
    """True if cos(eta) < 0.1: the model's X axis is within 6 degrees of the vertical; xi and theta are weak."""
    R = np.asarray(rotation, dtype=np.float64)
    return math.hypot(R[0, 0], R[1, 0]) < BLIND_COSINE


def ground_by_homothety(model: ArrayLike, rotation: ArrayLike, H: float, X0: ArrayLike) -> Array:
    """X_G = q/H + X0, q = R x: (n, 3) [m] of model points (n, 3). Source: seed 000, (2) as corrected in (2').

    X0 (3,) is the ground position of the model's origin. Undefined for H = 0.
    """
    q: Array = np.asarray(model, dtype=np.float64) @ np.asarray(rotation, dtype=np.float64).T
    result: Array = q / H + np.asarray(X0, dtype=np.float64)
    return result


def ground_by_joint_homothety(model: ArrayLike, rotation: ArrayLike, H: float, T: ArrayLike) -> Array:
    """X_G = (q + T)/H, q = R x: (n, 3) [m]. Source: seed 000, (4) as corrected in (4').

    T = H X0 (3,) is in MODEL units and is no ground coordinate: the other parametrisation of the same similarity.
    """
    q: Array = np.asarray(model, dtype=np.float64) @ np.asarray(rotation, dtype=np.float64).T
    result: Array = (q + np.asarray(T, dtype=np.float64)) / H
    return result


def ground_by_scale(model: ArrayLike, rotation: ArrayLike, t: float, X0: ArrayLike) -> Array:
    """X_G = X0 + t u, Y_G = Y0 + t v, Z_G = Z0 + t w, (u, v, w) = R x: (n, 3) [m]. Source: seed 002, (108)."""
    u: Array = np.asarray(model, dtype=np.float64) @ np.asarray(rotation, dtype=np.float64).T
    result: Array = np.asarray(X0, dtype=np.float64) + t * u
    return result


def partials_homothety(model: ArrayLike, angles: ArrayLike, H: float) -> Array:
    """d(X, Y, Z)/d(xi, eta, theta, H, X0, Y0, Z0) of (2'): (n, 3, 7).

        dX/dxi  = (r20 Y - r10 Z)/H   dY/dxi  = (r21 Y - r11 Z)/H   dZ/dxi  = (r22 Y - r12 Z)/H
        dX/deta = -cos(th) q2/H       dY/deta = -sin(th) q2/H       dZ/deta = (cos(th) q0 + sin(th) q1)/H
        dX/dth  = -q1/H               dY/dth  = q0/H                dZ/dth  = 0
        dX/dH   = -q0/H^2  ...        d/dX0   = 1

    `angles` (3,) are the fixed-axes triple. Source: seed 000, (7) as corrected in EQUATIONS 1.2.
    """
    xi, eta, theta = np.asarray(angles, dtype=np.float64)
    x = np.asarray(model, dtype=np.float64)
    R = matrix_from_fixed_axes(xi, eta, theta)
    q = x @ R.T
    by_xi = x[:, 1:2] * R[:, 2] - x[:, 2:3] * R[:, 1]
    s, c = math.sin(theta), math.cos(theta)
    by_eta = np.column_stack([-c * q[:, 2], -s * q[:, 2], c * q[:, 0] + s * q[:, 1]])
    by_theta = np.column_stack([-q[:, 1], q[:, 0], np.zeros(len(x))])
    return _with_translation(np.stack([by_xi, by_eta, by_theta, -q / H], axis=-1) / H, 1.0)


def partials_joint_homothety(model: ArrayLike, angles: ArrayLike, H: float, T: ArrayLike) -> Array:
    """d(X, Y, Z)/d(xi, eta, theta, H, T_X, T_Y, T_Z) of (4'): (n, 3, 7).

    As `partials_homothety`, but d/dH = -(q + T)/H^2 = -X_G/H and d/dT = 1/H. Source: seed 000, (7), EQUATIONS 1.2.
    """
    partials = partials_homothety(model, angles, H)
    partials[:, :, 3] -= np.asarray(T, dtype=np.float64) / H**2
    partials[:, :, 4:] /= H
    return partials


def partials_scale(model: ArrayLike, angles: ArrayLike, t: float) -> Array:
    """d(X, Y, Z)/d(X0, Y0, Z0, t, xi, eta, theta) of (108): (n, 3, 7), the order of (109).

        dX/dt = u   dX/dxi = -t w   dX/deta = -t v sin(xi)               dX/dth = t (a2 X - a1 Y)
        dY/dt = v   dY/dxi = 0      dY/deta = -t (w cos(xi) - u sin(xi)) dY/dth = t (b2 X - b1 Y)
        dZ/dt = w   dZ/dxi = t u    dZ/deta = t v cos(xi)                dZ/dth = t (c2 X - c1 Y)

    `angles` (3,) are the tilts triple. Source: seed 002, (109), (110), reconstructed in EQUATIONS 2.
    """
    xi, eta, theta = np.asarray(angles, dtype=np.float64)
    x = np.asarray(model, dtype=np.float64)
    R = matrix_from_aok(xi, eta, theta)
    u, v, w = (x @ R.T).T
    s, c = math.sin(xi), math.cos(xi)
    by_t = np.column_stack([u, v, w])
    by_xi = t * np.column_stack([-w, np.zeros(len(x)), u])
    by_eta = t * np.column_stack([-v * s, u * s - w * c, v * c])
    by_theta = t * (x[:, 0:1] * R[:, 1] - x[:, 1:2] * R[:, 0])
    return np.roll(_with_translation(np.stack([by_t, by_xi, by_eta, by_theta], axis=-1), 1.0), 3, axis=2)


def partials_rotation(model: ArrayLike, rotation: ArrayLike, t: float) -> Array:
    """d(X, Y, Z)/d(r1, r2, r3, ln H, X0, Y0, Z0): (n, 3, 7), for R_new = exp([r]x) R at r = 0.

        d/dr = -[t q]x,  d/d ln H = -t q,  d/dX0 = 1

    Free of blind views and of the sign of H: what the solver uses. For t = 1/H; `model` (n, 3).
    """
    arms = t * (np.asarray(model, dtype=np.float64) @ np.asarray(rotation, dtype=np.float64).T)
    X, Y, Z = arms.T
    partials = np.zeros((len(arms), 3, 7))
    partials[:, 0, 1], partials[:, 0, 2] = Z, -Y
    partials[:, 1, 0], partials[:, 1, 2] = -Z, X
    partials[:, 2, 0], partials[:, 2, 1] = Y, -X
    partials[:, :, 3] = -arms
    partials[:, :, 4:] = np.eye(3)
    return partials


def ground_by_small_angles(model: ArrayLike, dt: float, angles: ArrayLike, X0: ArrayLike) -> Array:
    """X_G = X + X0 + X dt - Y th - Z xi, Y_G = Y + Y0 + Y dt + X th - Z eta, Z_G = Z + Z0 + Z dt + X xi + Y eta.

    First order of (108) for t = 1 + dt and small tilts: it errs by squares of dt and of the angles times the model's
    size. `angles` (3,) = xi, eta, theta of the tilts triple. Returns (n, 3). Source: seed 002, (111).
    """
    x = np.asarray(model, dtype=np.float64)
    elements = np.concatenate([np.asarray(X0, dtype=np.float64), [dt], np.asarray(angles, dtype=np.float64)])
    result: Array = x + partials_small_angles(x) @ elements
    return result


def partials_small_angles(model: ArrayLike) -> Array:
    """d(X, Y, Z)/d(X0, Y0, Z0, dt, xi, eta, theta) of (111): (n, 3, 7), linear, so the same everywhere."""
    return partials_scale(model, np.zeros(3), 1.0)


def _with_translation(partials: Array, by_translation: float) -> Array:
    """Appends d/dX0, d/dY0, d/dZ0 to (n, 3, 4) partials."""
    translation = np.broadcast_to(by_translation * np.eye(3), (len(partials), 3, 3))
    return np.concatenate([partials, translation], axis=2)
