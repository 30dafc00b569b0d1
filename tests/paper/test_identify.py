"""The paper's vehicles are found again, by a search whose seed counts."""

from __future__ import annotations

import pytest

from ridedown.errors import InvalidInput
from ridedown.paper.identify import NEAR, identify
from ridedown.paper.numbers import PRINTED
from ridedown.paper.search import Effort

LITTLE = Effort(restarts=1, sample=64, population=16, generations=6, patience=6)


def test_the_same_seed_finds_the_same_vehicles_on_any_number_of_threads():
    assert identify(seed=0, effort=LITTLE, threads=1).values == identify(seed=0, effort=LITTLE, threads=2).values


def test_nought_is_a_seed_like_another():
    assert identify(seed=0, effort=LITTLE).values != identify(seed=1, effort=LITTLE).values


def test_the_papers_ten_numbers_are_met():
    found = identify(seed=0)
    assert found.worst <= NEAR
    assert found.within >= 9
    assert found.trends_hold
    assert "reconstruction" in found.toml


@pytest.mark.parametrize("target", [[0.27] * 9, [0.0] * 10, [float("nan")] * len(PRINTED)])
def test_a_target_that_is_no_target_is_refused(target):
    with pytest.raises(InvalidInput, match="target"):
        identify(target)
