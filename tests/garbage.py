"""Values that a caller may hand in by mistake."""

from contextlib import suppress
from fractions import Fraction

import numpy as np
from hypothesis import strategies as st

import aspect_control as ac

BEYOND_FLOATS = [10**400, -(10**400), 10**5000, Fraction(10**400, 3)]
ODD_TEXTS = ["", "\0", "a\0b", "\ud800", "a\udcff", "\n", "no/such/thing", "x" * 5000, "../..", "{}", "%s"]


class Unprintable:
    """An object that cannot be shown, compared or hashed."""

    __hash__ = None

    def __repr__(self):
        raise RuntimeError("no text of this")

    def __eq__(self, other):
        raise RuntimeError("no comparison with this")


def nested(levels):
    value = []
    for _ in range(levels):
        value = [value]
    return value


plain = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.complex_numbers(),
    st.binary(max_size=5),
    st.text(st.characters(), max_size=5),  # with surrogates
    st.sampled_from(ODD_TEXTS),
    st.sampled_from(BEYOND_FLOATS),
)
anything = st.one_of(
    plain,
    st.lists(plain, max_size=3),
    st.tuples(plain, plain),
    st.dictionaries(st.text(max_size=3), plain, max_size=2),
    st.builds(set),
    st.builds(object),
    st.builds(Unprintable),
    st.just(print),
    st.just(int),
    st.just(np.zeros(2)),
    st.just(np.array(["x", None], dtype=object)),
    st.just(np.float64("nan")),
    st.integers(1, 3000).map(nested),
)
"""Anything at all."""


def assert_works_or_is_refused(call, value):
    """Call with a value: what comes of it is a result or an error of ours."""
    with suppress(ac.AspectControlError):
        call(value)
