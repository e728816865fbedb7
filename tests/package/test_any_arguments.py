"""Fuzz test of the public functions: any object as any argument is accepted, or refused with a one-line ValueError.

No other exception, no warning (an error here), no crash and no hang may occur.
"""

import math
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from test_arguments import ARGUMENTS, BAD, Argument

numbers = st.one_of(
    st.floats(),
    st.floats(min_value=0.0, max_value=1e-300),
    st.sampled_from(
        [5e-324, 2.2250738585072014e-308, 1e154, 1.7976931348623157e308, -0.0, math.inf, math.nan]
    ),
    st.integers(),
    st.sampled_from([2**63, 2**64, -(2**63) - 1, 10**30, 10**400]),
    st.fractions(),
    st.decimals(),
    st.complex_numbers(),
)
arrays_of_any_kind = arrays.arrays(
    st.one_of(arrays.floating_dtypes(), arrays.integer_dtypes(), arrays.boolean_dtypes()),
    arrays.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=3),
)
leaves = st.one_of(
    st.none(), st.booleans(), numbers, st.text(max_size=8), st.binary(max_size=4), arrays_of_any_kind
)
anything = st.one_of(
    leaves,
    st.recursive(
        leaves,
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner, max_size=2),
    ),
    st.sampled_from(sorted(BAD)).map(lambda label: BAD[label]()),
)


def check(argument: Argument, value: object) -> None:
    try:
        argument(value)
    except ValueError as error:
        assert "\n" not in str(error) and len(str(error)) < 300
        # The message names the parameter, or one that it makes invalid, such as the height for a ball's radius.
        assert re.match(r"[^:\n]+: \S", str(error)), (argument, str(error))


@pytest.mark.slow
@settings(max_examples=200)
@given(st.sampled_from(ARGUMENTS), anything)
def test_any_object_is_taken_or_refused_in_one_line(argument: Argument, value: object) -> None:
    check(argument, value)
