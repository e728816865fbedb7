"""Wrong values: objects for arguments of Python, tables for job files, words for command lines."""

import datetime
import math
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

import hardlimit as hl
from conftest import law_of

# --- objects ------------------------------------------------------------------------------------------------


class Refuses:
    """An object whose methods all raise."""

    def __float__(self):
        raise RuntimeError("no")

    def __array__(self, *args, **options):
        raise ZeroDivisionError("no")

    def __repr__(self):
        raise OSError("no")


class Quantity:
    """A number with a unit, as in unit libraries."""

    units = "mm"

    def __array__(self, *args, **options):
        return np.array(3.0)


ITSELF: list[Any] = []
ITSELF.append(ITSELF)

BALL, LAW = hl.Ball(0.05, density=840.0), law_of("linear", 0.7)

#: Label → function that makes the value; a new one for each call, because a generator can be exhausted.
BAD: dict[str, Callable[[], Any]] = {
    "None": lambda: None,
    "True": lambda: True,
    "False": lambda: False,
    "text": lambda: "1",
    "empty text": lambda: "",
    "bytes": lambda: b"1",
    "bytearray": lambda: bytearray(b"1"),
    "memoryview": lambda: memoryview(b"1"),
    "NaN": lambda: math.nan,
    "infinity": lambda: math.inf,
    "-infinity": lambda: -math.inf,
    "-1": lambda: -1,
    "0": lambda: 0,
    "400 digits": lambda: 10**400,
    "-400 digits": lambda: -(10**400),
    "5000 digits": lambda: 10**5000,
    "largest float + 1": lambda: 2**1024 - 1,
    "complex": lambda: 1 + 2j,
    "complex without imaginary part": lambda: 1 + 0j,
    "NumPy complex": lambda: np.complex128(1.0),
    "Decimal NaN": lambda: Decimal("NaN"),
    "Decimal signalling NaN": lambda: Decimal("sNaN"),
    "Decimal infinity": lambda: Decimal("Infinity"),
    "Decimal of 400 digits": lambda: Decimal("1e400"),
    "Fraction of 400 digits": lambda: Fraction(10**400),
    "NumPy bool": lambda: np.True_,
    "NumPy text": lambda: np.str_("1"),
    "NumPy bytes": lambda: np.bytes_(b"1"),
    "NumPy NaN": lambda: np.float32("nan"),
    "long double": lambda: np.longdouble("1e4000"),
    "date": lambda: np.datetime64("2011-04-01"),
    "duration": lambda: np.timedelta64(1, "s"),
    "structured": lambda: np.zeros(1, dtype=[("a", float)])[0],
    "masked": lambda: np.ma.masked,
    "array with a masked entry": lambda: np.ma.array([1.0, 2.0], mask=[False, True]),
    "array without dimensions, masked": lambda: np.ma.array(1.0, mask=True),
    "two dimensions": lambda: np.ones((2, 2)),
    "array of NaN": lambda: np.array([1.0, math.nan]),
    "array of objects": lambda: np.array([1.0, None], dtype=object),
    "array of numbers as objects": lambda: np.array([1.0, 2.0], dtype=object),
    "array of text": lambda: np.array(["1", "2"]),
    "array of bools": lambda: np.array([True, False]),
    "array of dates": lambda: np.array(["2011-04-01"], dtype="M8[D]"),
    "array of durations": lambda: np.array([1, 2], dtype="m8[s]"),
    "array of complex": lambda: np.array([1.0 + 0.0j, 2.0]),
    "empty list": lambda: [],
    "empty tuple": lambda: (),
    "empty array": lambda: np.array([]),
    "empty range": lambda: range(0),
    "generator": lambda: (x for x in (1.0, 2.0)),
    "iterator": lambda: iter([1.0]),
    "dict": lambda: {1.0: 2.0},
    "set": lambda: {1.0},
    "list of text": lambda: ["1", "2"],
    "list with a bool": lambda: [1.0, True],
    "list with None": lambda: [1.0, None],
    "list with NaN": lambda: [1.0, math.nan],
    "list with 400 digits": lambda: [1, 10**400],
    "list with a complex": lambda: [1.0, 1j],
    "nested list": lambda: [[1.0, 2.0], [3.0, 4.0]],
    "ragged list": lambda: [[1.0], [2.0, 3.0]],
    "list that holds itself": lambda: ITSELF,
    "DataArray of text": lambda: xr.DataArray(["a"]),
    "DataArray of two dimensions": lambda: xr.DataArray(np.ones((2, 2))),
    "Dataset": lambda: xr.Dataset({"a": 1.0}),
    "pandas NA": lambda: pd.NA,
    "pandas NaT": lambda: pd.NaT,
    "pandas Timestamp": lambda: pd.Timestamp("2011-04-01"),
    "Series with NA": lambda: pd.Series([1, None], dtype="Int64"),
    "DataFrame": lambda: pd.DataFrame({"a": [1.0, 2.0]}),
    "quantity": Quantity,
    "list of quantities": lambda: [Quantity(), Quantity()],
    "Ball": lambda: BALL,
    "list of a Ball and a number": lambda: [BALL, 1.0],
    "FLOOR": lambda: hl.FLOOR,
    "law": lambda: LAW,
    "class Ball": lambda: hl.Ball,
    "class of a law": lambda: hl.LinearDashpot,
    "class float": lambda: float,
    "function": lambda: math.sqrt,
    "module": lambda: math,
    "object": object,
    "Ellipsis": lambda: ...,
    "raises when converted": Refuses,
    "list of what raises": lambda: [Refuses()],
}  # fmt: skip

numbers = st.one_of(
    st.floats(),
    st.integers(),
    st.sampled_from(
        [0, -1, 1, -0.0, 5e-324, 2.2250738585072014e-308, 1e154, 1e200, -1e308, 1.7976931348623157e308, math.inf,
         math.nan, 1e16, 10**30, 2**63, 2**64, -(2**63) - 1, 10**400, -(10**400), True, False]
    ),
)  # fmt: skip
arrays_of_any_kind = arrays.arrays(
    st.one_of(arrays.floating_dtypes(), arrays.integer_dtypes(), arrays.boolean_dtypes()),
    arrays.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=3),
)
of_python = st.one_of(st.fractions(), st.decimals(), st.complex_numbers(), st.none(), st.binary(max_size=4))
objects = st.one_of(numbers, of_python, st.text(max_size=8), arrays_of_any_kind)
anything = st.one_of(
    objects,
    st.recursive(
        objects,
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner, max_size=2),
    ),
    st.sampled_from(sorted(BAD)).map(lambda label: BAD[label]()),
)

# --- job files ----------------------------------------------------------------------------------------------

WORDS = [
    *("", "self", "name", "radius", "mass", "law", "laws", "balls", "axes", "sweep", "cradle"),
    *("gap", "a.b", "`", "ü"),
]
TEXTS = [
    *("1 mm", "10 us", "1 s", "3.2e9Pa", "linear", "viscoelastic", "0:1:3", "1:2", "1:2:0:log"),
    *("1mm:1cm:3:log", "a,b"),
]
texts = st.one_of(st.text(max_size=20), st.sampled_from(TEXTS))
keys = st.one_of(st.sampled_from(WORDS), st.text(max_size=8))
tables = st.recursive(
    st.one_of(numbers, texts, st.just(datetime.date(1979, 5, 27)), st.just(datetime.time(7, 32))),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(keys, inner, max_size=3)),
    max_leaves=5,
)

# --- command lines ------------------------------------------------------------------------------------------

#: Words for any option.
TYPED = [
    *("0", "-1", "1", "0.5", "1e-4", "nan", "inf", "-inf", "1e308", "1e-320", "1e400", "1_0"),
    *("1mm", "10us", "0x10", "½", "--", "-", "[1]", "9" * 400, "", " ", "1 mm", "3 kg", "7 g/cm^3"),
    *("1e999999 mm", "9**9**9 m", "\0", "\udcff", "0.5:0.9:3", "1:2:3:log", "1::3", ":::"),
    *("0:1:1e3", "1mm:2mm:3", "1,2", "1,,2", "1:2:99999999999", "-1e308:1e308:3", "linear"),
    *("viscoelastic", "newton", "independent", "cpu", "dask", "t_end", "outcome", "no/a.nc"),
    *("/dev/full", "a.zarr"),
]
#: Words that no option for a quantity takes.
NO_QUANTITY = ("much", "nan")
