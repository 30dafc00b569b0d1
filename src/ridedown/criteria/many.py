"""The criteria of many signals that are sampled at the same times: what studies of very many crashes compute.

Each is the criterion of the same name, of one axis, by the same kernel and to the same bits, an array of R values for R
signals; NaN where that has none. The kernels go from signal to signal without Python, and without its lock.

>>> import numpy as np
>>> from ridedown import criteria
>>> time = np.linspace(0.0, 0.1, 1001)
>>> heads = 9.80665 * np.array([[50.0], [60.0]]) * np.sin(np.pi * np.clip((time - 0.02) / 0.06, 0.0, 1.0))
>>> found = hic(Many(time, heads), 0.015)
>>> [float(value) for value in found] == [criteria.hic(time, head).value for head in heads]
True
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ridedown.criteria import flail, roadside
from ridedown.criteria.checks import Floats, signal
from ridedown.criteria.head import clip_of, hic_of, severity_of
from ridedown.criteria.moving import first_largest_each, largest_means, lowpassed_each, refined
from ridedown.criteria.occupant_load import olc_of, vpi_of
from ridedown.criteria.strung import Strung


@dataclass(frozen=True, eq=False)
class Many:
    """R accelerations along x [m/s2], (R, T), at the same rising times (T,) [s] from 0 on.

    Raises: InvalidInput for what is no signal (see `checks.signal`).
    """

    time: Floats
    table: Floats

    def __post_init__(self) -> None:
        for row in self.table[~np.isfinite(self.table).all(axis=1)][:1]:  # which says what is wrong with it
            signal(self.time, row)

    @cached_property
    def magnitudes(self) -> Strung:
        """Of each the magnitude."""
        return Strung.rows(self.time, self.table).magnitudes()

    @cached_property
    def pulses(self) -> Strung:
        """Each as the pulse of a vehicle: with no acceleration before contact, should it begin with a jump."""
        return Strung.rows(self.time, self.table).from_rest()

    @cached_property
    def contacts(self) -> Floats:
        """Of each the contact of the flail space's occupant, (R, 5), see `flail.contacts`."""
        pulses = self.pulses
        inputs = np.zeros((3, pulses.values.size))
        inputs[0] = pulses.values
        ahead, aside = roadside.HEAD_AHEAD, roadside.HEAD_ASIDE
        return flail.contacts(pulses.time, inputs, pulses.starts, ahead, aside, (0.0, 0.0))


def hic(many: Many, max_window: float) -> Floats:
    """Head injury criterion of the magnitudes."""
    return hic_of(many.magnitudes, max_window)


def clip(many: Many, *, cumulative: bool = False) -> Floats:
    """3 ms clip of the magnitudes [m/s2]."""
    return clip_of(many.magnitudes, cumulative=cumulative)


def severity_index(many: Many) -> Floats:
    """Severity index of the magnitudes."""
    return severity_of(many.magnitudes)


def olc(many: Many) -> Floats:
    """Occupant load criterion [m/s2]."""
    return olc_of(many.pulses)[:, 2]


def vpi(many: Many) -> Floats:
    """Vehicle pulse index [m/s2]."""
    return vpi_of(many.pulses)[:, 0]


def asi(many: Many) -> Floats:
    """Acceleration severity index, EN 1317-1:2010."""
    fine, table = refined(many.time, many.table / roadside.THRESHOLDS[0], roadside.FINE)
    pulses = Strung.rows(fine, table).from_rest()
    through = lowpassed_each(pulses.time, pulses.values, pulses.starts, roadside.ASI_CUTOFF)
    return first_largest_each(np.sqrt(through**2), pulses.starts)


def asi_1998(many: Many) -> Floats:
    """Acceleration severity index, EN 1317-1:1998. Raises: InvalidInput for signals shorter than its window."""
    pulses = many.pulses
    scaled = pulses.values[np.newaxis] / roadside.THRESHOLDS[0]
    begins = np.full(pulses.count, -np.inf)
    found = largest_means(pulses.time, scaled, pulses.starts, roadside.ASI_WINDOW, begins)[:, 0]
    if np.isnan(found).any():
        raise roadside.too_short(many.time)
    return found


def thiv(many: Many) -> Floats:
    """Theoretical head impact velocity [m/s]."""
    return np.hypot(many.contacts[:, 3], many.contacts[:, 4])


def occupant_impact_velocity(many: Many) -> Floats:
    """Occupant impact velocity [m/s]."""
    return np.maximum(np.abs(many.contacts[:, 3]), np.abs(many.contacts[:, 4]))


def phd(many: Many) -> Floats:
    """Post-impact head deceleration [m/s2]; along x it is the occupant ridedown acceleration as well."""
    pulses = many.pulses
    window = roadside.AFTER_CONTACT_WINDOW
    return largest_means(pulses.time, pulses.values[np.newaxis], pulses.starts, window, many.contacts[:, 0].copy())[:, 0]
