"""Many signals end to end, as the kernels take them: one after another in long arrays, each with its own times.

One signal is a string of one. So a criterion of a measured test and the same criterion of a study's ten thousand crashes are
computed by the same kernel, to the last bit; the kernel goes from signal to signal without Python.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ridedown.compiled import kernel
from ridedown.criteria.checks import Floats

Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Strung:
    """R signals: times [s] and values, (N,) each; signal r is the samples from starts[r] up to starts[r + 1], (R + 1,)."""

    time: Floats
    values: Floats
    starts: Ints

    @classmethod
    def one(cls, time: Floats, values: Floats) -> Strung:
        """A single signal, (n,)."""
        return cls(time, values, np.array([0, time.size]))

    @classmethod
    def rows(cls, time: Floats, table: Floats) -> Strung:
        """The rows of a table (R, T), all at the times (T,) [s]."""
        count, size = table.shape
        return cls(np.tile(time, count), np.ascontiguousarray(table).ravel(), np.arange(count + 1) * size)

    @property
    def count(self) -> int:
        """How many signals."""
        return self.starts.size - 1

    @property
    def longest(self) -> int:
        """Samples of the longest signal."""
        return int(np.diff(self.starts).max())

    def from_rest(self) -> Strung:
        """Each with a sample of zero at its first time before it, where it begins with a jump: before a crash there is none."""
        begins = self.starts[:-1]
        jumps = np.flatnonzero(self.values[begins] != 0.0)
        if jumps.size == 0:
            return self
        at = begins[jumps]
        starts = self.starts + np.searchsorted(jumps, np.arange(self.starts.size))
        return Strung(np.insert(self.time, at, self.time[at]), np.insert(self.values, at, 0.0), starts)

    def magnitudes(self) -> Strung:
        """The magnitude of each, as `checks.magnitude` has it: a sample of 0 is put in where a line goes through zero."""
        most = 2 * self.values.size  # of which only what is used is ever touched
        times, sizes, starts = np.empty(most), np.empty(most), np.empty_like(self.starts)
        _magnitudes(self.time, self.values, self.starts, times, sizes, starts)
        return Strung(times[: starts[-1]], sizes[: starts[-1]], starts)


@kernel
def _magnitudes(time: Floats, values: Floats, starts: Ints, times: Floats, sizes: Floats, ends: Ints) -> None:
    """See `Strung.magnitudes`; ends: (R + 1,), what `starts` is afterwards."""
    at = 0
    for r in range(starts.size - 1):
        ends[r] = at
        for i in range(starts[r], starts[r + 1]):
            times[at], sizes[at] = time[i], abs(values[i])
            at += 1
            if i + 1 == starts[r + 1]:
                break
            length = time[i + 1] - time[i]
            if length > 0.0 and (values[i] < 0.0 < values[i + 1] or values[i + 1] < 0.0 < values[i]):
                share = abs(values[i]) / (abs(values[i]) + abs(values[i + 1]))
                # `min` changes nothing: it keeps the product from being fused with the sum, which numpy does not do
                times[at], sizes[at] = min(time[i] + min(share * length, length), time[i + 1]), 0.0
                at += 1
    ends[starts.size - 1] = at
