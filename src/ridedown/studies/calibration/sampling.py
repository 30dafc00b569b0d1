"""Channels of a model at given times, filtered as measured ones are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ridedown.network import Channel, Family
from ridedown.signals import TimeHistory, filtered

Floats = NDArray[np.float64]

_NOTHING = 1e-9  # weights that count for nothing in a sum of values of one size
_REACH = 0.7  # how far a filter reaches, in parts of 1/class: what lies further away counts for nothing


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """A channel wanted at even times (T,) [s], through a channel frequency class or none.

    read_at: the times (P,) at which the model is read for that: to the same step, and further at both ends for the filter's
    sake, but not before 0. operator: (T, P), sparse, what a filter makes of those values; None where there is no filter.
    """

    channel: Channel
    times: Floats
    cfc: float | None
    read_at: Floats
    operator: Any

    @classmethod
    def over(cls, channel: Channel, start: float, end: float, step: float, cfc: float | None, duration: float) -> Samples:
        """From `start` to `end`, `step` apart at most, of a crash of that duration."""
        count = max(2, int(np.ceil((end - start) / step - 1e-9)) + 1)
        times = np.linspace(start, end, count)
        if cfc is None:
            return cls(channel, times, None, times, None)
        from scipy.sparse import csr_array  # noqa: PLC0415  slow to import

        step = (end - start) / (count - 1)
        before = int(np.ceil((start + _REACH / cfc) / step))
        after = int((min(duration, end + _REACH / cfc) - end) / step + 1e-9)
        grid = np.concatenate(
            [start + step * np.arange(-before, 0), times, np.minimum(end + step * np.arange(1, after + 1), duration)]
        )
        earlier = int(np.count_nonzero(grid < -1e-9 * step))
        read_at = np.maximum(grid[earlier:], 0.0)
        carried = _carried_back(channel, grid, earlier)
        smooth = np.stack([filtered(TimeHistory(column, "", interval=step), cfc).values for column in carried.T], axis=1)
        wanted = smooth[before : before + count]
        return cls(channel, times, cfc, read_at, csr_array(np.where(np.abs(wanted) > _NOTHING, wanted, 0.0)))

    def of(self, values: Floats) -> Floats:
        """The channel (R, T) from its values (R, P) at `read_at`."""
        if self.operator is None:
            return values
        smooth: Floats = (self.operator @ values.T).T
        return smooth


def _carried_back(channel: Channel, grid: Floats, earlier: int) -> Floats:
    """What gives a channel at all times of a grid (G,) from those not before 0: (G, P).

    Before time 0 nothing pushes yet, and all move on evenly.
    """
    later = np.eye(grid.size - earlier)
    families = {family for family, _, _ in channel.terms}
    first = np.zeros((earlier, later.shape[1]))
    if not families <= {Family.ACCELERATION, Family.FORCE}:
        first[:, 0] = 1.0
        if not families <= {Family.RATE, Family.DEFLECTION_RATE}:
            steps = (grid[:earlier] - grid[earlier]) / (grid[earlier + 1] - grid[earlier])
            first[:, 0] -= steps
            first[:, 1] += steps
    return np.concatenate([first, later])
