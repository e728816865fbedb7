"""Engagement of a slack pair in free flight: the search for any law agrees with the closed form."""

import pytest

from conftest import output_of


@pytest.mark.slow
def test_the_search_agrees_with_the_closed_form(tmp_path):
    """Differences up to 1e-8 follow from the condition of the problem: two nearly equal zeros."""
    compared, worst, only_one = output_of("contact/engagement.cpp", tmp_path).split()
    assert int(compared) > 20_000 and int(only_one) == 0
    assert float(worst) < 1e-7
