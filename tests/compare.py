"""Two responses held against each other, channel by channel."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
import pytest
from numpy.typing import NDArray

from ridedown import Response

STATE = ("displacement", "velocity", "rotation", "rotation_rate", "deflection")
"""Channels that are continuous, so that a crash solved in another way may be compared at any time."""

SMALLEST = {"m": 0.1, "m/s": 10.0, "rad": 0.1, "rad/s": 10.0, "m/s2": 10.0, "N": 100.0}
"""What counts as nothing, by unit: a part that only rounding moves has no relative accuracy."""


def continuous(response: Response) -> list[str]:
    """Its channels that are continuous in time."""
    return [name for name in response.channels if name.endswith(STATE)]


def assert_alike(
    one: Response,
    other: Response,
    *,
    rtol: float,
    channels: Iterable[str] | None = None,
    other_name: Callable[[str], str] = str,
    factor: Callable[[str], float] = lambda _: 1.0,
    times: NDArray[np.float64] | None = None,
) -> None:
    """Same continuous channels at all times, and same peaks, relative to each channel's peak.

    `other_name` and `factor` say which channel of `other` a channel of `one` equals, and how many times it.
    """
    assert one.status is other.status
    grid = np.linspace(0.0, min(one.end_time, other.end_time), 101) if times is None else times
    for name in continuous(one) if channels is None else channels:
        twin, times_it = other_name(name), factor(name)
        peak = one.peak(name).value
        size = max(abs(peak), SMALLEST[one.unit(name)])
        np.testing.assert_allclose(
            one.at(name, grid), times_it * other.at(twin, grid), atol=rtol * size, rtol=0.0, err_msg=name
        )
        if times is None:
            assert abs(other.peak(twin).value * times_it) == pytest.approx(abs(peak), abs=rtol * size), name
