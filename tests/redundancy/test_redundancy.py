"""The mathematics of redundancy against its axioms, NumPy, the closed-form arm and finite differences."""

from itertools import combinations
from math import comb

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from aspect_control.redundancy import (
    aspect_signature,
    homogeneous_acceleration,
    homogeneous_velocity,
    manipulability,
    minimum_torque,
    minor_columns,
    minor_measure,
    minor_measure_gradient,
    minors,
    null_space_basis,
    null_space_projector,
    pseudoinverse,
    pseudoinverse_torque,
    task_acceleration,
)
from oracles import planar_reference as reference
from oracles.literal import least_acceleration_torque, null_space_terms

EPS = np.finfo(np.float64).eps

# Small whole numbers: products are exact, so that a rank is what it is meant to be.
digits = st.integers(-4, 4).map(float)


@st.composite
def matrices(draw, min_rows=2, max_rows=5):
    """Matrices of every shape and rank."""
    m, n = draw(st.integers(min_rows, max_rows)), draw(st.integers(2, 7))
    rank = draw(st.integers(0, min(m, n)))
    return draw(arrays(np.float64, (m, rank), elements=digits)) @ draw(arrays(np.float64, (rank, n), elements=digits))


@st.composite
def wide_matrices(draw, redundancy=None):
    m = draw(st.integers(1, 5))
    n = m + (draw(st.integers(0, 3)) if redundancy is None else redundancy)
    return draw(arrays(np.float64, (m, n), elements=digits))


def reference_pinv(A):
    # Singular values of these matrices are either above 1e-6 of the largest or zero.
    return np.linalg.pinv(A, rcond=1e-9)


def rank_of(A):
    return np.linalg.matrix_rank(A, tol=1e-9)


def tolerance(A):
    """Rounding of a pseudoinverse of A, relative to its norm: the condition number of what is not zero."""
    return 200.0 * EPS * max(1.0, np.linalg.norm(A, 2) * np.linalg.norm(reference_pinv(A), 2))


def random_states(arm, count, seed):
    rng = np.random.default_rng(seed)
    for q, v in zip(rng.uniform(-np.pi, np.pi, (count, arm.nv)), rng.normal(0.0, 3.0, (count, arm.nv)), strict=True):
        state = arm.state(q, v)
        # Away from singularities: the literal equations compute I − J⁺J, whose rounding grows with cond J. At most one
        # state in a hundred is left out.
        if np.linalg.cond(state.J) < 100.0:
            yield state, rng.normal(0.0, 10.0, arm.task_dim)


# Pseudoinverse and null space


@given(A=matrices())
def test_pseudoinverse_meets_the_moore_penrose_conditions(A):
    X = pseudoinverse(A)
    rounding = tolerance(A)
    np.testing.assert_allclose(A @ X @ A, A, rtol=0, atol=rounding * (1.0 + np.linalg.norm(A, 2)))
    np.testing.assert_allclose(X @ A @ X, X, rtol=0, atol=rounding * (1.0 + np.linalg.norm(X, 2)))
    np.testing.assert_allclose(A @ X, (A @ X).T, rtol=0, atol=rounding)
    np.testing.assert_allclose(X @ A, (X @ A).T, rtol=0, atol=rounding)


@given(A=matrices())
def test_pseudoinverse_equals_that_of_numpy(A):
    expected = reference_pinv(A)
    np.testing.assert_allclose(
        pseudoinverse(A), expected, rtol=0, atol=tolerance(A) * (1.0 + np.linalg.norm(expected, 2))
    )


@pytest.mark.parametrize("shape", [(1, 2), (1, 7), (2, 1), (1, 1)])
def test_pseudoinverse_of_a_row_or_column_is_a_matrix(shape):
    A = np.arange(1.0, 1.0 + np.prod(shape)).reshape(shape)
    assert pseudoinverse(A).shape == shape[::-1]
    np.testing.assert_allclose(pseudoinverse(A), np.linalg.pinv(A), rtol=1e-14)


def test_pseudoinverse_takes_any_memory_layout():
    A = np.random.default_rng(1).normal(size=(6, 14))
    plain = np.ascontiguousarray(A[::2, ::2])
    for layout in (A[::2, ::2], np.asfortranarray(plain), plain[::-1][::-1], np.ascontiguousarray(plain.T).T):
        np.testing.assert_allclose(pseudoinverse(layout), np.linalg.pinv(plain), rtol=0, atol=1e-14)


def test_pseudoinverse_is_that_of_equation_26_at_full_rank(arm):
    for state, _ in random_states(arm, 50, seed=2):
        J = state.J
        # J Jᵀ has the square of J's condition number.
        rounding = 1e-15 * np.linalg.cond(J) ** 2
        np.testing.assert_allclose(pseudoinverse(J), J.T @ np.linalg.inv(J @ J.T), rtol=0, atol=rounding)


def test_pseudoinverse_of_zero_is_zero():
    np.testing.assert_array_equal(pseudoinverse(np.zeros((2, 3))), np.zeros((3, 2)))


@given(J=matrices())
def test_projector_is_the_orthogonal_projector_onto_the_null_space(J):
    P, rounding = null_space_projector(J), tolerance(J)
    np.testing.assert_allclose(P, P.T, rtol=0, atol=rounding)
    np.testing.assert_allclose(P @ P, P, rtol=0, atol=rounding)
    np.testing.assert_allclose(J @ P, 0.0, rtol=0, atol=rounding * (1.0 + np.linalg.norm(J, 2)))
    assert np.trace(P) == pytest.approx(J.shape[1] - rank_of(J), abs=J.shape[1] * rounding)


@given(J=matrices(min_rows=1))
def test_null_space_basis_is_orthonormal_and_complete(J):
    Z = null_space_basis(J)
    assert Z.shape == (J.shape[1], J.shape[1] - rank_of(J))
    np.testing.assert_allclose(Z.T @ Z, np.eye(Z.shape[1]), rtol=0, atol=1e-14)
    np.testing.assert_allclose(J @ Z, 0.0, rtol=0, atol=100.0 * EPS * (1.0 + np.linalg.norm(J, 2)))


@given(J=matrices())
def test_basis_and_projector_describe_one_null_space(J):
    Z = null_space_basis(J)
    np.testing.assert_allclose(Z @ Z.T, null_space_projector(J), rtol=0, atol=tolerance(J))


# Minors


@given(n=st.integers(1, 9), data=st.data())
def test_minor_columns_hold_every_subset_once(n, data):
    m = data.draw(st.integers(1, n))
    columns = minor_columns(n, m)
    assert columns.shape == (comb(n, m), m)
    assert {frozenset(row) for row in columns.tolist()} == {frozenset(s) for s in combinations(range(n), m)}


def test_minor_columns_stand_as_in_equations_22_to_24():
    assert minor_columns(3, 2).tolist() == [[0, 1], [1, 2], [2, 0]]


def test_minor_columns_list_one_subset_after_another_with_its_rotations():
    assert minor_columns(4, 2).tolist() == [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2], [1, 3]]


def test_minor_columns_cannot_be_changed():
    with pytest.raises(ValueError, match="read-only"):
        minor_columns(3, 2)[0, 0] = 1


def test_minors_are_those_of_equations_22_to_24(planar):
    for q in np.random.default_rng(3).uniform(-np.pi, np.pi, (500, 3)):
        np.testing.assert_allclose(minors(planar.jacobian(q)), reference.minors(q), rtol=0, atol=1e-14)


def exact_determinant(A):
    """Laplace's expansion: exact on whole numbers."""
    if len(A) == 0:
        return 1.0
    return sum((-1.0) ** j * A[0, j] * exact_determinant(np.delete(A[1:], j, axis=1)) for j in range(len(A)) if A[0, j])


@given(J=wide_matrices())
def test_minors_are_the_determinants_of_their_columns(J):
    expected = [exact_determinant(J[:, columns]) for columns in minor_columns(J.shape[1], J.shape[0])]
    # LU rounds relative to the product of the rows it eliminates, not to the determinant.
    rounding = 20.0 * EPS * (1.0 + np.linalg.norm(J)) ** J.shape[0]
    np.testing.assert_allclose(minors(J), expected, rtol=0, atol=rounding)


@given(stack=arrays(np.float64, (2, 3, 2, 4), elements=digits))
def test_minors_of_a_stack_are_the_minors_of_each(stack):
    assert minors(stack).shape == (2, 3, 6)
    for i, j in np.ndindex(2, 3):
        np.testing.assert_array_equal(minors(stack)[i, j], minors(stack[i, j]))
        np.testing.assert_array_equal(aspect_signature(stack)[i, j], aspect_signature(stack[i, j]))
        np.testing.assert_allclose(manipulability(stack)[i, j], manipulability(stack[i, j]), rtol=1e-14)
        np.testing.assert_array_equal(minor_measure(stack)[i, j], minor_measure(stack[i, j]))


@given(J=wide_matrices())
def test_squares_of_the_minors_add_up_to_the_gram_determinant(J):
    # Rounding in the singular values, the determinants and J Jᵀ is relative to ‖J‖ in each of the m factors.
    scale = (1.0 + np.linalg.norm(J)) ** (2 * J.shape[0])
    squares = (minors(J) ** 2).sum()
    assert squares == pytest.approx(np.linalg.det(J @ J.T), rel=0, abs=100.0 * EPS * scale)
    assert squares == pytest.approx(manipulability(J) ** 2, rel=0, abs=100.0 * EPS * scale)


@given(J=wide_matrices(redundancy=1).filter(lambda J: rank_of(J) == J.shape[0]))
def test_minors_at_one_spare_joint_are_the_entries_of_the_null_vector(J):
    m, n = J.shape
    null_vector = null_space_basis(J)[:, 0]
    left_out = [(set(range(n)) - set(columns)).pop() for columns in minor_columns(n, m).tolist()]
    expected = manipulability(J) * np.abs(null_vector[left_out])
    np.testing.assert_allclose(
        np.abs(minors(J)), expected, rtol=0, atol=100.0 * EPS * np.linalg.cond(J) * manipulability(J)
    )


# θ with one of δ₁, δ₂, δ₃ at zero and the others away from it
BORDERS = {
    "delta_1": (0, (0.4, -0.6, 1.2)),
    "delta_2": (1, (0.4, 0.9, 0.0)),
    "delta_2, folded": (1, (0.4, 0.9, np.pi)),
    "delta_3": (2, (0.4, -1.4, 0.7)),
}


@pytest.mark.parametrize("side", [-1e-6, 1e-6])
@pytest.mark.parametrize(("index", "q"), BORDERS.values(), ids=BORDERS)
def test_aspect_signature_tells_the_sides_of_a_border_apart(planar, index, q, side):
    step = np.array([0.0, 0.0, side])
    q = np.array(q) + step
    signature = aspect_signature(planar.jacobian(q))
    assert signature.dtype == np.int8
    assert signature.tolist() == np.sign(reference.minors(q)).tolist()
    other_side = aspect_signature(planar.jacobian(q - 2.0 * step))
    assert other_side[index] == -signature[index]


@pytest.mark.parametrize(("index", "q"), BORDERS.values(), ids=BORDERS)
def test_aspect_signature_is_zero_on_a_border(planar, index, q):
    bases = np.linspace(-3.0, 3.0, 101)
    assert [base for base in bases if aspect_signature(planar.jacobian([base, *q[1:]]))[index] != 0] == []


def test_aspect_signature_is_zero_at_the_stretched_arm(planar):
    assert aspect_signature(planar.jacobian(np.zeros(3))).tolist() == [0, 0, 0]


def test_minor_measure_is_that_of_the_closed_form_arm(planar):
    for q in np.random.default_rng(4).uniform(-np.pi, np.pi, (500, 3)):
        # The cube root stretches the rounding of the smallest minor: dH / H = Σ dδ / 3δ.
        rounding = 1e-15 * (1.0 / np.abs(reference.minors(q))).sum() * reference.minor_measure(q)
        assert minor_measure(planar.jacobian(q)) == pytest.approx(reference.minor_measure(q), rel=0, abs=rounding)


def test_minor_measure_is_zero_where_a_minor_is():
    assert minor_measure(np.array([[1.0, 0.0, 1.0], [0.0, 1.0, 0.0]])) == 0.0


def test_minor_measure_does_not_overflow_with_the_product_of_the_minors():
    J = 1e100 * np.random.default_rng(5).normal(size=(3, 7))
    assert minor_measure(J) == pytest.approx(1e300 * minor_measure(J / 1e100), rel=1e-12)


# The gradient of the minor measure


def measure_by_determinants(J):
    m, n = J.shape
    determinants = [np.linalg.det(J[:, columns]) for columns in combinations(range(n), m)]
    return np.exp(np.mean(np.log(np.abs(determinants))))


def assert_gradient_is_the_slope(jacobian, jacobian_derivative, count, seed):
    rng = np.random.default_rng(seed)
    step, checked = 1e-6, 0
    while checked < count:
        q = rng.uniform(-np.pi, np.pi, jacobian(np.zeros(7)).shape[1])
        J = jacobian(q)
        # A step of 1e-6 is small only beside the way to the nearest border, where H has a cusp: the truncation error
        # of a central difference of |δ|^(1/p) is of the order (step / δ)², 4e-8 at most here.
        if np.abs(minors(J)).min() < 0.005 * np.abs(minors(J)).max():
            continue
        shifts = step * np.eye(q.size)
        slope = [
            (measure_by_determinants(jacobian(q + s)) - measure_by_determinants(jacobian(q - s))) / (2.0 * step)
            for s in shifts
        ]
        gradient = minor_measure_gradient(J, jacobian_derivative(q))
        np.testing.assert_allclose(gradient, slope, rtol=0, atol=1e-6 * np.abs(slope).max())
        checked += 1


def test_gradient_is_the_closed_form_gradient(planar):
    for q in np.random.default_rng(6).uniform(-np.pi, np.pi, (500, 3)):
        gradient = minor_measure_gradient(planar.jacobian(q), planar.jacobian_derivative(q))
        # ∇δ / δ is as exact as the smallest minor is.
        rounding = 1e-14 * reference.minor_measure(q) * (1.0 / reference.minors(q) ** 2).sum()
        np.testing.assert_allclose(gradient, reference.minor_measure_gradient(q), rtol=0, atol=rounding)


def test_gradient_is_the_slope_of_the_minor_measure_of_the_planar_arm(planar):
    assert_gradient_is_the_slope(lambda q: planar.jacobian(q[:3]), planar.jacobian_derivative, 50, seed=7)


@pytest.mark.parametrize("rows", [[0, 1], [0, 2], [1, 2], [0, 1, 2]])
def test_gradient_is_the_slope_of_the_minor_measure_of_the_seven_joint_arm(seven, rows):
    assert_gradient_is_the_slope(
        lambda q: seven.jacobian(q)[rows], lambda q: seven.jacobian_derivative(q)[rows], 20, seed=8
    )


@pytest.mark.parametrize(("m", "n"), [(1, 3), (2, 3), (2, 5), (3, 7)])
def test_gradient_is_the_slope_along_any_derivative_of_the_jacobian(m, n):
    rng = np.random.default_rng(18)
    # A Jacobian with minors well away from zero, and derivatives without the symmetry of a position's.
    J = next(J for J in rng.normal(size=(1000, m, n)) if np.abs(minors(J)).min() > 0.01)
    dJ, step = rng.normal(size=(m, n, n)), 1e-6
    slope = [
        (minor_measure(J + step * dJ[..., k]) - minor_measure(J - step * dJ[..., k])) / (2.0 * step) for k in range(n)
    ]
    np.testing.assert_allclose(minor_measure_gradient(J, dJ), slope, rtol=0, atol=1e-6 * np.abs(slope).max())


@pytest.mark.parametrize("q", [q for _, q in BORDERS.values()], ids=BORDERS)
def test_gradient_is_zero_on_a_border(planar, q):
    on_border = [np.array([base, *q[1:]]) for base in np.linspace(-3.0, 3.0, 101)]
    gradients = [minor_measure_gradient(planar.jacobian(q), planar.jacobian_derivative(q)) for q in on_border]
    np.testing.assert_array_equal(gradients, 0.0)


@given(J=wide_matrices(), seed=st.integers(0, 2**32 - 1))
def test_gradient_is_finite_for_every_jacobian(J, seed):
    m, n = J.shape
    gradient = minor_measure_gradient(J, np.random.default_rng(seed).normal(size=(m, n, n)))
    assert gradient.shape == (n,)
    assert np.isfinite(gradient).all()


# Torques


def test_pseudoinverse_torque_is_equation_7(arm):
    for state, b in random_states(arm, 300, seed=9):
        expected = least_acceleration_torque(state, b)
        actual = pseudoinverse_torque(state.M, state.nle, state.J, b)
        np.testing.assert_allclose(actual, expected, rtol=0, atol=1e-12 * np.linalg.norm(expected))


def test_minimum_torque_is_equation_11(arm):
    for state, b in random_states(arm, 1100, seed=10):
        tau_tilde, _, theta_ddot_H = null_space_terms(state, b)
        expected = tau_tilde + state.M @ theta_ddot_H
        actual = minimum_torque(state.M, state.nle, state.J, b)
        # Equation (11) is a difference of torques as large as τ̃, and rounds like one.
        np.testing.assert_allclose(actual, expected, rtol=0, atol=1e-10 * np.linalg.norm(tau_tilde))


def test_both_torques_give_the_task_acceleration(arm):
    for state, b in random_states(arm, 300, seed=11):
        # What M⁻¹ makes of N is taken away again: rounding is relative to the larger of the two.
        size = np.linalg.norm(b) + np.linalg.norm(state.nle)
        rounding = 1e-13 * np.linalg.cond(state.J) * np.linalg.cond(state.M) * size
        for law in (pseudoinverse_torque, minimum_torque):
            tau = law(state.M, state.nle, state.J, b)
            actual = task_acceleration(state.M, state.nle, state.J, tau)
            np.testing.assert_allclose(actual, b, rtol=0, atol=rounding)


def test_no_torque_of_the_same_task_acceleration_is_shorter(arm):
    rng = np.random.default_rng(12)
    for state, b in random_states(arm, 200, seed=13):
        tau = minimum_torque(state.M, state.nle, state.J, b)
        Z = null_space_basis(state.J @ np.linalg.inv(state.M))
        for n in rng.normal(size=(5, Z.shape[1])) @ Z.T:
            other = tau + n * np.linalg.norm(tau) * 10.0 ** rng.uniform(-4.0, 1.0)
            actual = task_acceleration(state.M, state.nle, state.J, other)
            rounding = 1e-12 * np.linalg.cond(state.M) * np.linalg.cond(state.J)
            np.testing.assert_allclose(actual, b, rtol=0, atol=rounding * (np.linalg.norm(other) + np.linalg.norm(b)))
            assert np.linalg.norm(other) > np.linalg.norm(tau)


def test_minimum_torque_is_never_longer_than_that_of_the_pseudoinverse(arm):
    for state, b in random_states(arm, 300, seed=14):
        shortest = np.linalg.norm(minimum_torque(state.M, state.nle, state.J, b))
        assert shortest <= np.linalg.norm(pseudoinverse_torque(state.M, state.nle, state.J, b)) * (1.0 + 1e-12)


def test_torques_take_a_task_of_one_coordinate(planar):
    state = planar.state([0.3, 0.7, -1.1], [1.0, 2.0, 3.0])
    J, b = state.J[:1], np.array([2.0])
    for law in (pseudoinverse_torque, minimum_torque):
        tau = law(state.M, state.nle, J, b)
        np.testing.assert_allclose(task_acceleration(state.M, state.nle, J, tau), b, rtol=1e-11)


# Maciejewski's condition


def test_homogeneous_acceleration_is_equation_16(arm):
    for state, b in random_states(arm, 500, seed=15):
        tau_tilde, _, expected = null_space_terms(state, b)
        actual = homogeneous_acceleration(state.M, minimum_torque(state.M, state.nle, state.J, b), tau_tilde)
        # M⁻¹ is applied to a difference of torques as large as τ̃.
        rounding = 1e-10 * np.linalg.norm(np.linalg.inv(state.M), 2) * np.linalg.norm(tau_tilde)
        np.testing.assert_allclose(actual, expected, rtol=0, atol=rounding)


def test_homogeneous_acceleration_does_not_move_the_task(arm):
    for state, b in random_states(arm, 300, seed=16):
        tau_tilde = pseudoinverse_torque(state.M, state.nle, state.J, b)
        tau = minimum_torque(state.M, state.nle, state.J, b)
        acceleration = homogeneous_acceleration(state.M, tau, tau_tilde)
        rounding = 1e-13 * np.linalg.cond(state.J) * np.linalg.cond(state.M) * np.linalg.norm(tau_tilde)
        np.testing.assert_allclose(state.J @ acceleration, 0.0, rtol=0, atol=rounding)


def test_homogeneous_velocity_is_equation_15(arm):
    for state, _ in random_states(arm, 300, seed=17):
        expected = (np.eye(arm.nv) - np.linalg.pinv(state.J) @ state.J) @ state.v
        actual = homogeneous_velocity(state.J, state.v)
        rounding = 1e-14 * np.linalg.cond(state.J) * np.linalg.norm(state.v)
        np.testing.assert_allclose(actual, expected, rtol=0, atol=rounding)
        np.testing.assert_allclose(actual, null_space_projector(state.J) @ state.v, rtol=0, atol=rounding)


@given(J=matrices(), seed=st.integers(0, 2**32 - 1))
def test_homogeneous_velocity_does_not_move_the_task_at_any_rank(J, seed):
    v = np.random.default_rng(seed).normal(size=J.shape[1])
    atol = tolerance(J) * (1.0 + np.linalg.norm(J, 2)) * np.linalg.norm(v)
    np.testing.assert_allclose(J @ homogeneous_velocity(J, v), 0.0, rtol=0, atol=atol)
