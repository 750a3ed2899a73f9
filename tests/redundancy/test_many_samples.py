"""Rates of minors and the self-motion at many samples at once, against each sample by itself."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aspect_control.redundancy import (
    maciejewski_product,
    minor_columns,
    minor_rates,
    null_space_part,
    null_space_projector,
    null_space_rows,
)
from example_arms import example_arm


@settings(max_examples=60, deadline=None)
@given(m=st.integers(1, 6), more=st.integers(0, 2), seed=st.integers(0, 10_000))
def test_rates_of_minors_are_those_of_the_columns_one_after_another(m, more, seed):
    random = np.random.default_rng(seed)
    J, dJ = random.normal(size=(2, 5, m, m + more))
    columns = minor_columns(m + more, m)[random.permutation(len(minor_columns(m + more, m)))]
    columns = np.array([random.permutation(each) for each in columns])
    expected = np.zeros((5, len(columns)))
    for i, chosen in enumerate(columns):
        for place, column in enumerate(chosen):
            exchanged = J[:, :, chosen].copy()
            exchanged[:, :, place] = dJ[:, :, column]
            expected[:, i] += np.linalg.det(exchanged)
    found = minor_rates(J, dJ, columns)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11 * max(1.0, np.abs(expected).max()))


@settings(max_examples=60, deadline=None)
@given(
    m=st.integers(1, 4),
    more=st.integers(0, 3),
    lost=st.lists(st.integers(0, 4), min_size=3, max_size=3),
    seed=st.integers(0, 10_000),
)
def test_the_null_space_of_many_jacobians_is_that_of_each_also_where_rank_is_lost(m, more, lost, seed):
    random = np.random.default_rng(seed)
    J = random.normal(size=(3, m, m + more))
    for each, rank_lost in zip(J, lost, strict=True):
        each[: min(rank_lost, m)] = 0.0
    values = random.normal(size=(3, m + more))
    Z = null_space_rows(J)
    for i in range(3):
        expected = null_space_projector(J[i]) @ values[i]
        np.testing.assert_allclose(null_space_part(Z, values)[i], expected, rtol=0, atol=1e-12)
        np.testing.assert_allclose(J[i] @ Z[i].T, 0.0, atol=1e-12)


@pytest.mark.parametrize("name", ["planar", "panda", "straight"])
def test_maciejewski_s_product_of_many_states_is_that_of_the_literal_equations(name):
    arm = example_arm("panda" if name == "panda" else "planar3r", "xyz" if name == "panda" else "xy")
    random = np.random.default_rng(4)
    q = random.uniform(-2.0, 2.0, (20, arm.nv)) * (name != "straight")
    v, tau = random.normal(size=(2, 20, arm.nv))
    samples = arm.kinematics.state_samples(q, v)
    acceleration = np.array([np.linalg.solve(M, t - n) for M, t, n in zip(samples.M, tau, samples.nle, strict=True)])
    found = maciejewski_product(null_space_rows(samples.J), samples.M, v, tau, acceleration)
    for i in range(20):
        s = arm.state(q[i], v[i])
        b = s.J @ np.linalg.solve(s.M, tau[i] - s.nle)
        tau_tilde = s.M @ np.linalg.pinv(s.J, 1e-12) @ b + s.nle
        A = s.J @ np.linalg.inv(s.M)
        theta_ddot_H = np.linalg.solve(s.M, np.linalg.pinv(A, 1e-12) @ (b + A @ s.nle) - tau_tilde)
        theta_dot_H = v[i] - np.linalg.pinv(s.J, 1e-12) @ s.J @ v[i]
        scale = np.linalg.norm(theta_dot_H) * np.linalg.norm(theta_ddot_H)
        assert abs(found[i] - theta_dot_H @ theta_ddot_H) <= 1e-9 * scale
