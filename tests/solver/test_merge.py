"""A vehicle's motion in as few polynomials as keep it, against its phases."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ridedown import load
from ridedown.network.model import Floats
from ridedown.scenario import lower
from ridedown.solver import merge, solve
from ridedown.solver.merge import merged
from ridedown.solver.phases import Phases


def vehicle(name: str, body: str = "vehicle1") -> tuple[Phases, Floats]:
    """The phases of a crash, and the coefficients of a vehicle's acceleration on each."""
    network = lower(load(name))
    phases, _ = solve.solve_one(network)
    orders = np.arange(2, phases.position.shape[1])
    return phases, phases.position[:, 2:, network.coordinates.index(body)] * (orders * (orders - 1))


def value(start: Floats, series: Floats, times: Floats) -> Floats:
    """What the polynomials are, each from its start to that of the next."""
    piece = np.searchsorted(start, times, side="right") - 1
    since = times - start[piece]
    total: Floats = np.sum(series[piece] * since[:, np.newaxis] ** np.arange(series.shape[1]), axis=1)
    return total


@pytest.mark.parametrize("name", ["p1", "example-offset", "paper-adult-offset", "paper-adult-full"])
def test_the_same_motion_in_fewer_pieces(name: str) -> None:
    phases, series = vehicle(name)
    start, end, fewer = merged(phases, series, phases.event_time)
    assert start.size < phases.start.size
    assert end[-1] == np.inf
    largest = np.abs(series[:, 0]).max()
    for low, high, part in zip(start, np.minimum(end, phases.end), fewer, strict=True):
        times = np.linspace(low, high, 2001)[:-1]
        own = value(np.array([low]), part[np.newaxis], times)
        # what a phase leaves out at its end is a step there; a polynomial over several takes the middle
        np.testing.assert_allclose(own, value(phases.start, series, times), rtol=0.0, atol=1e-9 * largest)
    gained = [np.sum(part * np.diff(np.append(at, phases.end))[:, None] ** orders / orders)
              for at, part in ((start, fewer), (phases.start, series))
              for orders in [np.arange(1, part.shape[1] + 1)]]  # fmt: skip
    assert gained[0] == pytest.approx(gained[1], abs=1e-12 * largest * phases.end)


def test_pieces_overlap_wherever_nothing_changes() -> None:
    phases, series = vehicle("p1")
    start, end, _ = merged(phases, series, phases.event_time)
    changes = np.append(phases.event_time, phases.end)
    for before, after, following in zip(start[:-1], end[:-1], start[1:], strict=True):
        if np.abs(following - changes).min() > 1e-11:  # in the middle of the piece before, up to round-off
            assert following == pytest.approx(0.5 * (before + after), abs=1e-12)
        else:
            assert after == following


def test_a_piece_starts_wherever_something_changes() -> None:
    phases, series = vehicle("p1")
    start, _, _ = merged(phases, series, phases.event_time)
    changes = np.unique(np.round(phases.event_time, 12))
    assert changes.size > 3
    assert all(np.abs(start - time).min() < 1e-11 for time in changes if time < phases.end)


def test_what_no_polynomial_serves_stays_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    phases, series = vehicle("p1")
    monkeypatch.setattr(merge, "ERROR", 0.0)
    start, end, same = merged(phases, series, phases.event_time)
    np.testing.assert_array_equal(start, phases.start)
    np.testing.assert_array_equal(end, [*phases.start[1:], np.inf])
    np.testing.assert_array_equal(same, series)


def test_a_single_phase_and_no_motion() -> None:
    phases, series = vehicle("p1")
    first = replace(phases, start=phases.start[:1], length=phases.length[:1])
    start, end, one = merged(first, series[:1], phases.event_time)
    assert (start.tolist(), end.tolist()) == ([0.0], [np.inf])
    times = np.linspace(0.0, first.end, 101)
    np.testing.assert_allclose(value(start, one, times), value(start, series[:1], times), rtol=0.0, atol=1e-9)
    start, _, still = merged(phases, np.zeros_like(series), phases.event_time)
    assert not still.any()
    assert start.size <= 1 + np.unique(phases.event_time).size
