"""The paper's planar 3R arm in closed form, written from Lagrange's equations and sharing nothing with the package.

Three thin uniform rods (1 m, 10 kg) in a vertical plane if `gravity` is given (m/s², along −y), else a horizontal one.
"""

import numpy as np

LENGTH = 1.0
MASS = 10.0
HALF = LENGTH / 2.0
INERTIA = MASS * LENGTH**2 / 12.0

# M(q) = CONSTANT + cos θ2 · ELBOW + cos θ3 · WRIST + cos(θ2 + θ3) · REACH
_TIP = INERTIA + MASS * HALF**2
_MIDDLE = _TIP + INERTIA + MASS * (HALF**2 + LENGTH**2)
_BASE = _MIDDLE + INERTIA + MASS * (HALF**2 + 2.0 * LENGTH**2)
CONSTANT = np.array([[_BASE, _MIDDLE, _TIP], [_MIDDLE, _MIDDLE, _TIP], [_TIP, _TIP, _TIP]])
ELBOW = MASS * LENGTH * (HALF + LENGTH) * np.array([[2.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
WRIST = MASS * LENGTH * HALF * np.array([[2.0, 2.0, 1.0], [2.0, 2.0, 1.0], [1.0, 1.0, 0.0]])
REACH = MASS * LENGTH * HALF * np.array([[2.0, 1.0, 1.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])


def inertia(q):
    """M(θ)."""
    return CONSTANT + np.cos(q[1]) * ELBOW + np.cos(q[2]) * WRIST + np.cos(q[1] + q[2]) * REACH


def inertia_derivative(q):
    """∂M[i, j] / ∂θ_k as [i, j, k]."""
    reach = -np.sin(q[1] + q[2]) * REACH
    return np.stack([np.zeros((3, 3)), reach - np.sin(q[1]) * ELBOW, reach - np.sin(q[2]) * WRIST], axis=-1)


def nonlinear_effects(q, v, gravity=0.0):
    """N(θ, θ̇) by the Christoffel symbols of M, and the gradient of the potential energy."""
    dM = inertia_derivative(q)
    christoffel = (dM + dM.transpose(0, 2, 1) - dM.transpose(2, 1, 0)) / 2.0
    level = np.cos(np.cumsum(q))
    moments = MASS * gravity * LENGTH * np.array([2.5, 1.5, 0.5]) * level
    return np.einsum("ijk,j,k->i", christoffel, v, v) + np.cumsum(moments[::-1])[::-1]


def position(q):
    """Tip position x(θ)."""
    angles = np.cumsum(q)
    return LENGTH * np.array([np.cos(angles).sum(), np.sin(angles).sum()])


def jacobian(q):
    """J(θ)."""
    angles = np.cumsum(q)
    links = LENGTH * np.array([-np.sin(angles), np.cos(angles)])
    return np.cumsum(links[:, ::-1], axis=1)[:, ::-1]


def drift(q, v):
    """J̇θ̇: every link's centripetal acceleration."""
    angles, rates = np.cumsum(q), np.cumsum(v)
    return -LENGTH * np.array([np.cos(angles) @ rates**2, np.sin(angles) @ rates**2])


def minors(q):
    """δ₁, δ₂, δ₃ of Eqs. (22)–(24)."""
    s2, s3, s23 = np.sin(q[1]), np.sin(q[2]), np.sin(q[1] + q[2])
    return LENGTH**2 * np.array([s2 + s23, s3, -s3 - s23])


def minor_measure(q):
    """H = |δ₁ δ₂ δ₃|^(1/3), Eq. (18)."""
    return np.abs(np.prod(minors(q))) ** (1.0 / 3.0)


def minor_measure_gradient(q):
    """∇H = H/3 Σ ∇δ_i / δ_i."""
    c2, c3, c23 = np.cos(q[1]), np.cos(q[2]), np.cos(q[1] + q[2])
    gradients = LENGTH**2 * np.array([[0.0, c2 + c23, c23], [0.0, 0.0, c3], [0.0, -c23, -c3 - c23]])
    return minor_measure(q) / 3.0 * (1.0 / minors(q)) @ gradients


def postures(x, first):
    """Both postures with the tip at x and the first angle given; none where links 2 and 3 are too short."""
    wrist = (x - LENGTH * np.array([np.cos(first), np.sin(first)])) / LENGTH
    cosine = (wrist @ wrist - 2.0) / 2.0
    if abs(cosine) > 1.0:
        return []
    found = []
    for third in (np.arccos(cosine), -np.arccos(cosine)):
        direction = np.arctan2(wrist[1], wrist[0]) - np.arctan2(np.sin(third), 1.0 + np.cos(third))
        found.append(np.array([first, direction - first, third]))
    return found
