"""What a pulse comes to: change of velocity, peak, way, OLC and square waves; and the pulse as files for other programs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ridedown import criteria, signals
from ridedown.errors import InvalidInput
from ridedown.report.tables import Column, Table, number
from ridedown.scenario import Scenario, SledScenario
from ridedown.scenario.pulse_measured import MeasuredPulse, Recorded
from ridedown.scenario.pulse_motion import PulseMotion
from ridedown.signals.history import Floats, TimeHistory
from ridedown.signals.keyword import SUFFIXES, define_curve, write_keyword
from ridedown.signals.record import TestRecord

_KMH, _MS = 3.6, 1e3
_SLED = "Vehicle, as prescribed"
_ONE_MOTION = 0.05  # of the velocity taken away: how far sensors of one motion may come from their mean
_BESIDE = 1e-9  # of a step: to either side of a jump that lies on it to rounding
_AT_REST = 1e-9  # of the speed at the start
_TOLERANCE = 1e-4  # of the peak: how straight a curve is between the points that are written of it
_FINE = 1e-6  # of the peak: the same, for what is measured on it


@dataclass(frozen=True, slots=True)
class PulseMeasures:
    """A vehicle's pulse in numbers, SI; None where the vehicle does not do such a thing.

    delta_v: of all changes of velocity since the start, the one of largest magnitude, with its sign. final_delta_v: velocity at
    the end less that at the start. peak, peak_time: the acceleration of largest magnitude. last: when the last acceleration
    ends. displacement, displacement_time: the farthest forward. time_to_rest: of the vehicle. olc: occupant load criterion.
    esw: equivalent square wave, from the way to standstill. points: of a curve, between which the acceleration is straight to a
    ten-thousandth of its peak. duration: of all this.
    """

    speed: float
    delta_v: float
    final_delta_v: float
    peak: float
    peak_time: float
    last: float
    displacement: float
    displacement_time: float
    time_to_rest: float | None
    olc: float | None
    esw: float | None
    points: int
    duration: float

    def as_json(self) -> dict[str, Any]:
        """Plain data for JSON, SI."""
        return {name: getattr(self, name) for name in self.__slots__}


def measure(motion: PulseMotion) -> PulseMeasures:
    """The numbers of a pulse."""
    time, acceleration, velocity, displacement = motion.knots(_FINE)
    speed = motion.speed
    peak = int(np.argmax(np.abs(acceleration)))
    acting = np.flatnonzero(acceleration)
    rest = _rest(motion, time, velocity)
    farthest = float(displacement.max()), float(time[np.argmax(displacement)])
    way = None if rest is None else float(motion.at(rest)[2])
    if rest is not None and way is not None and way >= farthest[0] * (1.0 - _AT_REST):
        farthest = way, rest
    return PulseMeasures(
        speed=speed,
        delta_v=criteria.delta_v(time, acceleration, start=0.0).value,
        final_delta_v=float(velocity[-1] - speed),
        peak=float(acceleration[peak]),
        peak_time=float(time[peak]),
        last=float(time[min(acting[-1] + 1, time.size - 1)]) if acting.size else 0.0,
        displacement=farthest[0],
        displacement_time=farthest[1],
        time_to_rest=rest,
        olc=criteria.olc(time, acceleration, start=0.0).value,
        esw=None if way is None else speed * speed / (2.0 * way),
        points=int(motion.knots(_TOLERANCE)[0].size),
        duration=motion.end,
    )


def _rest(motion: PulseMotion, time: Floats, velocity: Floats) -> float | None:
    """When a vehicle that moves forward first stands still [s]; one that a pulse just stops does, whatever rounding leaves."""
    level = _AT_REST * motion.speed
    stands = np.flatnonzero(velocity <= level)
    if not motion.speed > 0.0 or stands.size == 0:
        return None
    before, after = float(time[stands[0] - 1]), float(time[stands[0]])
    while (middle := 0.5 * (before + after)) not in {before, after}:
        before, after = (before, middle) if float(motion.at(middle)[1]) <= level else (middle, after)
    return after


def pulse_table(measured: Sequence[PulseMeasures], *, vehicle: str = "vehicle1", caption: str = _SLED) -> Table:
    """Pulses as a table, one a row."""
    return Table(
        caption,
        (
            Column("Vehicle", numeric=False),
            Column("Speed", "km/h"),
            Column("Delta-v", "km/h"),
            Column("Peak acceleration", "g"),
            Column("at", "ms"),
            Column("Ends", "ms"),
            Column("Largest displacement", "mm"),
            Column("at", "ms"),
            Column("Time to rest", "ms"),
            Column("OLC", "g"),
            Column("Equivalent square wave", "g"),
            Column("Curve points"),
        ),
        tuple(
            (
                vehicle,
                number(m.speed, scale=_KMH),
                number(m.delta_v, scale=_KMH),
                number(m.peak / criteria.STANDARD_GRAVITY),
                number(m.peak_time, scale=_MS),
                number(m.last, scale=_MS),
                number(m.displacement, 0, scale=1e3),
                number(m.displacement_time, scale=_MS),
                number(m.time_to_rest, scale=_MS),
                number(None if m.olc is None else m.olc / criteria.STANDARD_GRAVITY),
                number(None if m.esw is None else m.esw / criteria.STANDARD_GRAVITY),
                str(m.points),
            )
            for m in measured
        ),
    )


def about(scenario: Scenario) -> tuple[str, ...]:
    """What there is to say of where a sled's pulse comes from."""
    if not isinstance(scenario, SledScenario) or not isinstance(scenario.pulse, MeasuredPulse):
        return ()
    pulse = scenario.pulse
    found = pulse.recorded()
    state = "unfiltered" if pulse.cfc == "none" else f"CFC {pulse.cfc:g} ({pulse.standard})"
    channels_used = (
        f"channel {found.channels[0]}" if len(found.channels) == 1 else f"mean of channels {', '.join(found.channels)}"
    )
    knots = f"{found.time.size} knots for {found.samples} values"
    return (f"Measured pulse: {channels_used} of {Path(pulse.file).name}, {state}; {knots}{_apart(found)}.",)


def _apart(found: Recorded) -> str:
    """How far sensors that were averaged agree: whether they measured one motion, the user has to judge."""
    if len(found.channels) == 1:
        return ""
    odd = found.apart > _ONE_MOTION * abs(found.gone)
    words = "velocities disagree, coming" if odd else "velocities come"
    return f"; {words} up to {found.apart:.2f} m/s away from their mean"


def write_pulse(path: Path, motion: PulseMotion, *, name: str, vehicle: str, curve: int = 1) -> int:
    """Write a pulse: LS-DYNA keyword (*.k, *.key, *.dyn), or CSV, TSV or Parquet with its velocity and displacement.

    Keyword files hold the points between which the curve is straight to a ten-thousandth of its peak, tables a row every
    0.1 ms. Returns: the number of points.

    Raises: InvalidInput for another suffix, or a file of another kind that is there already.
    """
    suffix = path.suffix.lower()
    if suffix in SUFFIXES:
        return _write_keyword(path, motion, name, vehicle, curve)
    if suffix in {".csv", ".tsv", ".parquet"}:
        return _write_table(path, motion, name, vehicle)
    raise InvalidInput(f"--out: got {path.name}; need *.k (LS-DYNA), *.csv, *.tsv or *.parquet. Choose such a name.")


def _write_keyword(path: Path, motion: PulseMotion, name: str, vehicle: str, curve: int) -> int:
    time, acceleration, *_ = motion.knots(_TOLERANCE)
    about_speed = f"initial velocity {motion.speed:.9g} mm/ms; a braking car is negative (SAE J211)"
    title, remarks = f"{vehicle} acceleration x", (f"{name}, by ridedown", about_speed)
    write_keyword(path, define_curve(time, acceleration, curve=curve, title=title, remarks=remarks))
    return int(time.size)


def _write_table(path: Path, motion: PulseMotion, name: str, vehicle: str) -> int:
    steps = max(1, round(motion.end / 1e-4))
    step = motion.end / steps
    time: Floats = step * np.arange(steps + 1, dtype=np.float64)
    acceleration, velocity, displacement = motion.at(time)
    # At a jump the middle: straight lines through it keep the velocity. What comes after the end is not of it.
    aside = _BESIDE * step
    between = 0.5 * (motion.before(time[1:-1] - aside)[0] + motion.at(time[1:-1] + aside)[0])
    acceleration = np.concatenate((acceleration[:1], between, motion.before(time[-1:])[0]))
    made = (("acceleration", acceleration, "m/s2"), ("velocity", velocity, "m/s"), ("displacement", displacement, "m"))
    histories = [TimeHistory(values, unit, interval=step, name=f"{vehicle}.{what}") for what, values, unit in made]
    signals.write(TestRecord.of(histories, identifier=name, title=f"{name}, by ridedown", format="pulse"), path)
    return int(time.size)
