"""Numbers and lists as text."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conftest import draws
from hardlimit.support.formatting import digits, listed, percent, percent_with_error, quantity, rate, size


@draws(100)
@given(st.floats(-1e4, 1e4), st.floats(0.0, 1e4))
def test_percentages_keep_value_and_error(value: float, error: float) -> None:
    text = percent_with_error(0.01 * value, 0.01 * error)
    assert "e" not in text.replace("less", "")
    if text.startswith("less than"):
        assert max(abs(value), error) <= 0.001 * 1.0001
        return
    shown, bar = text.removesuffix(" %").replace("−", "-").split(" ± ")
    assert shown.strip("-0.") or not shown.startswith("-")
    assert len(shown.strip("-").lstrip("0.").replace(".", "").rstrip("0")) <= 3
    unit = 10.0 ** -(len(shown.partition(".")[2]))
    if bar.startswith("<"):
        assert error <= 0.51 * float(bar[1:])
    else:
        assert abs(float(bar) - error) <= max(0.26 * error, 0.51 * unit, 0.0051 * abs(value))
    assert abs(float(shown) - value) <= max(0.51 * error, 0.0051 * abs(value), 0.00051)


@draws(100)
@given(st.floats(0.0, 1e4))
def test_shares_keep_two_digits_and_have_no_exponent(share: float) -> None:
    text = percent(share)
    assert "e" not in text.replace("less", "")
    if text.startswith("less than"):
        assert 0.0 < share < 1e-5
    else:
        assert float(text.removesuffix(" %")) == pytest.approx(100.0 * share, rel=0.051)


def test_percentages() -> None:
    shown = {(0.0412, 0.0031): "4.1 ± 0.3 %", (-0.041, 0.0014): "−4.10 ± 0.14 %", (1.234, 0.37): "120 ± 40 %",
             (-0.00001, 0.02): "0 ± 2 %", (0.0412, math.nan): "4.1 %", (math.nan, math.nan): "–",
             (0.0, 0.0): "less than 0.001 %", (0.0412, 0.0096): "4 ± 1 %", (1e-9, 1e-9): "less than 0.001 %",
             (12.345, 0.0001): "1230 ± <10 %", (1.0, math.nan): "100 %", (0.0996, 0.00012): "9.96 ± 0.01 %",
             (1870.0, 36.0): "187000 ± 4000 %"}  # fmt: skip
    for given_numbers, text in shown.items():
        assert percent_with_error(*given_numbers) == text
    without = {
        0.0: "0 %",
        1.0: "100 %",
        0.997: "99.7 %",
        0.0002: "0.02 %",
        1e-6: "less than 0.001 %",
        0.01: "1 %",
        2.17e28: "2.17e30 %",
    }
    assert {fraction: percent(fraction) for fraction in without} == without


def test_prefixes_and_lists() -> None:
    assert [quantity(x, "m") for x in (0.0, 1e-4, -2.5e3, 1e-12)] == ["0 m", "100 µm", "−2.5 km", "1e-12 m"]
    assert [quantity(x, "s", 2) for x in (7.46e-4, 9.96e-4, 0.0124)] == ["750 µs", "1000 µs", "12 ms"]
    assert [size(x) for x in (999, 999.9999999, 4.2e9, 3e15)] == ["999 B", "1 kB", "4.2 GB", "3 PB"]
    assert [rate(x, "points") for x in (0.25, 1.2e6)] == ["0.25 points/s", "1.2 Mpoints/s"]
    assert [digits(x, 3) for x in (-1e-5, 1e20, math.nan)] == ["−1e-5", "1e20", "–"]
    assert [listed(names) for names in (["a"], ["a", "b"], ["a", "b", "c"])] == ["a", "a and b", "a, b and c"]
