"""The criteria of many signals are those of each, to the last bit."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from ridedown import criteria
from ridedown.criteria import many
from ridedown.criteria.checks import magnitude
from ridedown.criteria.many import Many
from ridedown.criteria.strung import Strung
from ridedown.errors import InvalidInput

TIME = np.linspace(0.0, 0.2, 801)
Single = Callable[[np.ndarray, np.ndarray], float | None]


def from_rest(measure: Single) -> Single:
    """Of a vehicle's pulse: one that begins with a jump begins at zero."""

    def measured(time: np.ndarray, a: np.ndarray) -> float | None:
        if a[0] != 0.0:
            time, a = np.concatenate((time[:1], time)), np.concatenate(([0.0], a))
        return measure(time, a)

    return measured


def ridedown_acceleration(time: np.ndarray, a: np.ndarray) -> float | None:
    return criteria.occupant_ridedown_acceleration(time, a, np.zeros_like(a)).value


PAIRS: dict[str, tuple[Callable[[Many], np.ndarray], Single]] = {
    "hic15": (lambda m: many.hic(m, 0.015), lambda t, a: criteria.hic(t, a).value),
    "hic36": (lambda m: many.hic(m, 0.036), lambda t, a: criteria.hic(t, a, max_window=0.036).value),
    "clip": (many.clip, lambda t, a: criteria.clip(t, a).value),
    "cumulative": (lambda m: many.clip(m, cumulative=True), lambda t, a: criteria.clip(t, a, cumulative=True).value),
    "severity": (many.severity_index, criteria.severity_index),
    "olc": (many.olc, from_rest(lambda t, a: criteria.olc(t, a).value)),
    "vpi": (many.vpi, from_rest(lambda t, a: criteria.vpi(t, a).value)),
    "asi": (many.asi, from_rest(lambda t, a: criteria.asi(t, a).value)),
    "asi 1998": (many.asi_1998, from_rest(lambda t, a: criteria.asi(t, a, edition="EN 1317-1:1998").value)),
    "thiv": (many.thiv, from_rest(lambda t, a: criteria.thiv(t, a).value)),
    "phd": (many.phd, from_rest(lambda t, a: criteria.phd(t, a).value)),
    "oiv": (many.occupant_impact_velocity, from_rest(lambda t, a: criteria.occupant_impact_velocity(t, a).value)),
    "ridedown": (many.phd, from_rest(ridedown_acceleration)),
}


def pulses(rng: np.random.Generator) -> np.ndarray:
    """Thirty of all sorts: braking, rebounding, beginning with a jump, none at all, too weak for some criteria, noisy."""
    rows = [np.zeros(TIME.size)]
    for k in range(29):
        width, size = rng.uniform(0.04, 0.15), rng.uniform(20.0, 600.0)
        row = -size * np.sin(np.pi * np.minimum(TIME / width, rng.uniform(0.9, 1.4)))
        row *= 1.0 + rng.uniform(-0.3, 0.3) * np.cos(rng.uniform(100.0, 900.0) * TIME)
        rows.append(row + (rng.normal(0.0, 30.0, TIME.size) if k % 3 == 0 else 0.0))
    return np.array(rows) * np.where(np.arange(30) % 2, 1.0, -1.0)[:, np.newaxis]


@pytest.mark.parametrize("name", PAIRS)
def test_many_are_each(name: str) -> None:
    table = pulses(np.random.default_rng(7))
    of_all, of_one = PAIRS[name]
    found = of_all(Many(TIME, table))
    expected = np.array([np.nan if (value := of_one(TIME, row)) is None else value for row in table])
    np.testing.assert_array_equal(found, expected)
    assert np.isfinite(found).sum() >= 10  # an occupant that the car is driven away from meets nothing


def test_with_steps_that_the_low_pass_and_the_flight_must_refine() -> None:
    time = np.linspace(0.0, 0.3, 61)
    table = -150.0 * np.sin(np.pi * time / 0.3) * np.array([[1.0], [2.5]])
    for name in ("asi", "thiv", "phd"):
        of_all, of_one = PAIRS[name]
        np.testing.assert_array_equal(of_all(Many(time, table)), [of_one(time, row) for row in table])


def test_magnitudes_are_those_of_each() -> None:
    table = pulses(np.random.default_rng(3))
    found = Strung.rows(TIME, table).magnitudes()
    for r, row in enumerate(table):
        part = slice(found.starts[r], found.starts[r + 1])
        times, size = magnitude(TIME, row)
        np.testing.assert_array_equal(found.time[part], times)
        np.testing.assert_array_equal(found.values[part], size)


def test_what_is_no_signal_is_refused() -> None:
    table = np.ones((3, TIME.size))
    table[1, 5] = np.inf
    with pytest.raises(InvalidInput, match="acceleration: got inf at sample 5"):
        Many(TIME, table)
    with pytest.raises(InvalidInput, match=r"0\.003 s"):
        many.clip(Many(np.array([0.0, 0.002]), np.ones((2, 2))))
    with pytest.raises(InvalidInput, match=r"0\.05 s"):
        many.asi_1998(Many(np.array([0.0, 0.04]), np.ones((2, 2))))
    with pytest.raises(InvalidInput, match="a head can have"):
        many.hic(Many(np.array([0.0, 0.04]), np.full((2, 2), 1e300)), 0.015)
