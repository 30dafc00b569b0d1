"""The solver against the independent simulator, on crashes and networks of every kind drawn at random.

Where a rounding error grows (a light bar between members that soften falls to one side), no method can do better than that:
what a change of one mass by 1e-13 of itself makes is allowed for.
"""

from __future__ import annotations

import numpy as np
import pytest

from ridedown import Response, simulate
from ridedown.scenario import CrashScenario, NetworkScenario, substitute
from tests import independent, samples
from tests.compare import continuous

CLOSE = 1e-8  # of each channel's peak, but not less than:
SMALLEST = {"m": 0.01, "m/s": 0.3, "rad": 0.01, "rad/s": 0.3, "N": 100.0, "m/s2": 3.0}


def nudged(scenario: CrashScenario | NetworkScenario) -> Response:
    """The crash with one mass a trace heavier."""
    if isinstance(scenario, NetworkScenario):
        path, mass = f"{scenario.masses[-1].name}.mass", scenario.masses[-1].mass
    elif scenario.vehicle2 is not None:
        path, mass = "vehicle2.mass", scenario.vehicle2.mass
    else:
        path, mass = "vehicle1.mass", scenario.vehicle1.mass
    return simulate(substitute(scenario, {path: mass * (1.0 + 1e-13)}), throw=False)


def assert_agree(scenario: CrashScenario | NetworkScenario) -> None:
    ours, theirs, other = simulate(scenario, throw=False), independent.simulate(scenario), nudged(scenario)
    end = min(ours.end_time, theirs.end_time, other.end_time)
    times = np.linspace(0.0, end, 173)[:-1]
    for channel in continuous(ours):
        exact = theirs.at(channel, times)
        size = max(np.abs(exact).max(), SMALLEST[ours.unit(channel)])
        doubt = 100.0 * np.abs(other.at(channel, times) - ours.at(channel, times)).max()
        assert np.abs(ours.at(channel, times) - exact).max() <= CLOSE * size + doubt, channel
    if not ours.completed:  # the two do not stop a turned bar at the same angle
        return
    for channel in theirs.channels:
        for find in ("maximum", "minimum"):
            found, exact = getattr(ours, find)(channel).value, getattr(theirs, find)(channel)[0]
            size = max(abs(exact), SMALLEST[ours.unit(channel)])
            doubt = 100.0 * abs(getattr(other, find)(channel).value - found)
            assert abs(found - exact) <= CLOSE * size + doubt, (channel, find)


@pytest.mark.parametrize("seed", [3, 23, 33, 36, 39])
def test_crashes(seed: int) -> None:
    assert_agree(samples.crash(seed))


@pytest.mark.parametrize("seed", [3, 9, 10, 11])
def test_networks(seed: int) -> None:
    assert_agree(samples.network(seed))
