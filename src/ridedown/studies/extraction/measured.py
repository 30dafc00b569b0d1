"""A wall test as the extraction of a front sees it: the cabin's motion, and where measured the wall's force and the engine.

Everything stands on one even grid with time zero at the first contact. What cannot be used is left out with the reason.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ridedown.criteria.checks import Floats
from ridedown.criteria.motion import Motion
from ridedown.errors import InvalidInput, RidedownError
from ridedown.limits.evidence import CannotJudge
from ridedown.limits.measured import INTEGRAL_CLASS, SHAPE_CLASS, RecordEvidence, levelled, through
from ridedown.limits.redundant import DOUBTFUL
from ridedown.signals.record import ChannelInfo, TestRecord
from ridedown.units import convert

INTERVAL = 1e-4
"""s, of the grid."""
SETTLED = 0.15
"""s, of the test that a structure is fitted to, or twice the time to standstill if that is longer: later the car rolls and
brakes on the ground, and accelerometers drift."""
LATEST_START = 0.002
"""s after time zero by which a record must have begun: what came before is not known."""
FITS_TOGETHER = 0.10
"""How far the wall's impulse and the change of momentum may be apart for the wall's force to be used [1]."""
DOUBTFUL_MOMENTUM = 0.05
"""How far they may be apart without a warning [1]."""
IN_CONTACT = 0.2
"""Part of the peak deceleration: a record that ends with more has no whole rebound in it."""
ASSUMED_RESTITUTION = 0.15
"""Where the rebound was not recorded: about that of wall tests near 50 km/h (0.13 and 0.17 for the pair of NHTSA 4429)."""

_OTHER = 0.05  # how far what is asked for may be from what the record says without a warning
_ENGINE_BACK, _ENGINE_AHEAD = -0.6, 1.05  # parts of the test speed between which an engine's velocity is believed
_ENGINE_LEAST = 0.7  # part of the time to standstill for which it must be
_UNUSABLE = ("meaningless", "no data", "no file", "failed", "cannot be read")
_WORDS = ("offset", "overlap", "pole", "oblique", "side impact", "deformable")


@dataclass(frozen=True, slots=True, eq=False)
class Momentum:
    """The wall's impulse beside the loss of momentum m dv of a car that moves as its cabin does [N s].

    stop, rebound: up to standstill, and up to the fastest rebound, at `rebound_time` [s]: impulse and loss. A ratio of 1 says
    that wall, accelerometers and mass belong together. At standstill the engine rests too; on the way back it may be slower
    than the cabin, and the second ratio then tells less. implied_mass [kg]: the mass for which the first ratio is 1.
    """

    stop: tuple[float, float]
    rebound: tuple[float, float]
    rebound_time: float
    mass: float

    @property
    def ratio(self) -> float:
        """Impulse over loss of momentum up to standstill [1]."""
        return self.stop[0] / self.stop[1]

    @property
    def rebound_ratio(self) -> float:
        """The same up to the fastest rebound [1]."""
        return self.rebound[0] / self.rebound[1]

    @property
    def implied_mass(self) -> float:
        """The mass that the wall stopped [kg]."""
        return self.mass * self.ratio


@dataclass(frozen=True, slots=True, eq=False)
class WallTest:
    """One vehicle against a rigid wall. SI; arrays are (n,), on the grid `time`.

    acceleration: of the cabin, class 60, negative when braking; velocity, displacement: of it, integrated in class 180; those
    before time zero are those of a free run. barrier: force on the wall, positive, class 60; None if not measured or not
    believed. engine: its velocity, NaN where it is not believed; None if not measured. crush: the largest displacement, at
    `stop`. rebound: the fastest speed backwards, None if the record does not hold it whole. momentum: None without a barrier.
    """

    title: str
    identifier: str
    laboratory: str
    year: int | None
    mass: float
    speed: float
    time: Floats
    acceleration: Floats
    velocity: Floats
    displacement: Floats
    barrier: Floats | None
    engine: Floats | None
    crush: float
    stop: float
    rebound: float | None
    momentum: Momentum | None
    used: tuple[str, ...]
    notes: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def end(self) -> float:
        """Where the fitted part of the test ends [s]."""
        return float(self.time[-1])

    @property
    def peak(self) -> float:
        """The largest deceleration [m/s2]."""
        return float(-self.acceleration.min())


def wall_test(
    record: TestRecord,
    *,
    mass: float | None = None,
    speed: float | None = None,
    channels: Sequence[str | int] = (),
    engine: Sequence[str | int] | None = None,
    barrier: TestRecord | None = None,
) -> WallTest:
    """What a record of a wall test tells.

    mass [kg], speed [m/s]: the header's if left out. channels: those of the cabin along x, averaged; if left out, the mean of
    the two sensors that agree best in velocity (see `ridedown.limits.redundant`). engine: its channels along x; those the
    record names so if None. barrier: a record with the force on the wall, where the test's own has none.

    Raises: InvalidInput for a test that is none against a rigid wall, for a record that does not hold the time from contact to
    standstill, and for what is missing: mass, speed, channels.
    """
    warnings, notes = list(_refusals_and_warnings(record)), list[str]()
    evidence = RecordEvidence(record)
    vehicle = evidence.vehicles[0]
    known = {str(one.number): one for one in record.vehicles}.get(vehicle)
    kilograms = _asked(mass, known.mass if known else None, "mass", "kg", warnings)
    metres_a_second = _asked(speed, _speed(evidence, vehicle), "speed", "m/s", warnings)

    raw_time, shape, smooth, used = _cabin(record, evidence, vehicle, channels, notes, warnings)
    if raw_time[0] > LATEST_START or raw_time[-1] <= 0.0:
        raise InvalidInput(
            f"record: got the pulse from {1e3 * raw_time[0]:.4g} to {1e3 * raw_time[-1]:.4g} ms; need it from the first "
            "contact, time zero, to standstill. Shift its times, or use a longer record."
        )
    first = int(np.ceil(max(raw_time[0], -0.05) / INTERVAL - 1e-6))
    last = int(np.floor(raw_time[-1] / INTERVAL + 1e-6))
    time: Floats = INTERVAL * np.arange(min(first, 0), last + 1, dtype=np.float64)
    motion = _from_contact(time, np.interp(time, raw_time, smooth), metres_a_second)
    stop = motion.first_stop()
    if stop is None:
        raise InvalidInput(_never_stops(motion))
    kept = time <= min(time[-1], max(SETTLED, 2.0 * stop)) + 1e-9
    time = time[kept]
    acceleration = np.interp(time, raw_time, shape)
    after = motion.time <= time[-1] + 1e-9
    before = np.minimum(time, 0.0)
    velocity = np.concatenate((np.full(int((before < 0.0).sum()), metres_a_second), motion.velocity[after]))
    displacement = np.concatenate((metres_a_second * before[before < 0.0], motion.displacement[after]))
    rebound = _rebound(time, acceleration, velocity, stop, warnings)
    early = -float(acceleration[int(np.searchsorted(time, 0.0))])
    if early > 0.25 * float(-acceleration.min()):
        warnings.append(f"the car already brakes at {early / 9.80665:.0f} g at time zero: is that the first contact?")

    force, momentum = _barrier(record, barrier, time, velocity, stop, kilograms, notes, warnings)
    return WallTest(
        title=record.title,
        identifier=record.identifier,
        laboratory=record.laboratory,
        year=record.date.year if record.date else None,
        mass=kilograms,
        speed=metres_a_second,
        time=time,
        acceleration=acceleration,
        velocity=velocity,
        displacement=displacement,
        barrier=force,
        engine=_engine(record, vehicle, engine, time, stop, metres_a_second, notes),
        crush=motion.at(stop)[2],
        stop=stop,
        rebound=rebound,
        momentum=momentum,
        used=used,
        notes=tuple(dict.fromkeys(notes)),
        warnings=tuple(dict.fromkeys(warnings)),
    )


# what kind of test


def _refusals_and_warnings(record: TestRecord) -> list[str]:
    """Sentences on what makes the front found that of this test only. Raises: InvalidInput for a test that gives none."""
    kind = record.fields.get("TSTCNF", "").strip().upper()
    numbers = {vehicle.number for vehicle in record.vehicles if vehicle.number}
    numbers |= {info.vehicle for info in record.channels.values() if info.vehicle}
    if len(numbers) > 1 or kind not in {"", "VTB"}:
        got = f"two vehicles ({kind or 'by its channels'})" if kind in {"", "VTV"} else f"a test of kind {kind}"
        raise InvalidInput(
            f"test: got {got}; need one vehicle against a fixed rigid wall, where the way of the cabin is the crush. "
            "Use a wall test of the vehicle."
        )
    found = record.barrier
    if found is not None and (found.kind.strip().upper().startswith("D") or found.mass is not None):
        what = "a barrier that can move" if found.mass is not None else "a deformable barrier"
        raise InvalidInput(
            f"test: got {what}; need a fixed rigid wall: what the barrier gives way is not the vehicle's crush. "
            "Use another test."
        )
    said = []
    angle, offset = _number(record.fields.get("IMPANG", "")), _number(record.fields.get("OFFSET", ""))
    angle = (angle + 180.0) % 360.0 - 180.0
    if abs(angle) > 45.0:
        raise InvalidInput(f"test: got an impact at {angle:g} degrees; need a frontal one. Use a frontal test of the vehicle.")
    if angle:
        said.append(f"the wall was met at {angle:g} degrees: the structure found is that of this angle")
    if offset:
        said.append(f"an offset of {offset:g} mm: the structure found is that of the part of the front that was struck")
    text = " ".join((record.title, record.fields.get("Type of the test", ""), record.fields.get("Subtype of the test", "")))
    words = [word for word in _WORDS if word in text.casefold()]
    if words and not (angle or offset):
        said.append(f"the header says {words[0]!r}: the structure found is that of what was struck")
    return said


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return 0.0


def _positive(value: float | None, field: str, unit: str) -> float:
    if value is None:
        raise InvalidInput(f"{field}: got nothing, and the header has none; need the vehicle's {field}. Give it: --{field}.")
    if not (np.isfinite(value) and value > 0.0):
        raise InvalidInput(f"{field}: got {value:g} {unit}; need > 0 {unit}. Correct it, or leave it out to take the header's.")
    return float(value)


def _asked(asked: float | None, recorded: float | None, name: str, unit: str, warnings: list[str]) -> float:
    """What was asked for, else what the record says; where both are there and far apart, a warning.

    Raises: InvalidInput for one that is not above zero, or where there is none.
    """
    value = _positive(recorded if asked is None else asked, name, unit)
    if recorded and abs(value / recorded - 1.0) > _OTHER:
        warnings.append(f"{name}: {value:.5g} {unit} is taken, as asked, though the record says {recorded:.5g} {unit}")
    return value


def _speed(evidence: RecordEvidence, vehicle: str) -> float | None:
    try:
        return evidence.speed(vehicle)
    except CannotJudge:
        return None


# the cabin


def _cabin(
    record: TestRecord,
    evidence: RecordEvidence,
    vehicle: str,
    channels: Sequence[str | int],
    notes: list[str],
    warnings: list[str],
) -> tuple[Floats, Floats, Floats, tuple[str, ...]]:
    """Times and the acceleration in the classes for shape and for integrals, and the channels it is the mean of."""
    if not channels:
        try:
            pulse = evidence.pulse(vehicle)
        except CannotJudge as why:
            raise InvalidInput(
                f"channels: got none that can be used ({why}); need the cabin's acceleration along x. "
                "Name them with --channels."
            ) from None
        notes += [f"not used: {reason}" for reason in pulse.rejected]
        for remark in pulse.remarks:
            (warnings if "doubtful" in remark or "only sensor" in remark else notes).append(remark)
        return pulse.time, pulse.shape, pulse.acceleration, pulse.used
    infos = [_along_x(record, key, "channels") for key in channels]
    parts = [_accelerations(record, info) for info in infos]
    time = parts[0][0]
    begin, end = max(part[0][0] for part in parts), min(part[0][-1] for part in parts)
    time = time[(time >= begin) & (time <= end)]
    if time.size < 2:
        raise InvalidInput("channels: got channels that share no time; need ones recorded together. Name others.")
    shapes, smooths = (np.array([np.interp(time, part[0], part[which]) for part in parts]) for which in (1, 2))
    velocities = np.array([Motion.of(time, smooth).velocity for smooth in smooths])
    spread = float(np.sqrt(np.mean((velocities - velocities.mean(axis=0)) ** 2)))
    if spread > 0.5 * DOUBTFUL:  # of two that differ by d, each is d/2 from the mean
        warnings.append(f"the channels differ by {2.0 * spread:.2f} m/s root mean square in velocity: does one drift?")
    return time, shapes.mean(axis=0), smooths.mean(axis=0), tuple(info.key for info in infos)


def _along_x(record: TestRecord, key: str | int, field: str) -> ChannelInfo:
    """A channel that was named. Raises: InvalidInput for one that is known to be along another axis."""
    info = record.channel(key)
    if off := info.off_x:
        raise InvalidInput(f"{field}: got {str(key)!r}, {off}; need an acceleration along x. Name that one.")
    return info


def _accelerations(record: TestRecord, info: ChannelInfo) -> tuple[Floats, Floats, Floats]:
    history = record.history(info)
    time = history.time
    shape, smooth = (convert(through(history, size)[0].values, history.unit, "m/s2") for size in (SHAPE_CLASS, INTEGRAL_CLASS))
    return time, levelled(time, shape), levelled(time, smooth)


def _from_contact(time: Floats, acceleration: Floats, speed: float) -> Motion:
    since = time >= -0.5 * INTERVAL
    return Motion.of(np.maximum(time[since], 0.0), acceleration[since], speed)


def _never_stops(motion: Motion) -> str:
    end, speed = motion.time[-1], motion.velocity[-1]
    if speed > 1.1 * motion.velocity[0]:
        return (
            f"channels: got a speed that grows from {motion.velocity[0]:.2f} to {speed:.2f} m/s; need a braking car to have "
            "negative acceleration, x forward. Turn the sign of the channel, or name others."
        )
    return (
        f"record: got {1e3 * end:.4g} ms, at the end of which the car still moves at {speed:.2f} m/s; need it up to "
        "standstill. Use a longer record, or check speed and channels."
    )


def _rebound(time: Floats, acceleration: Floats, velocity: Floats, stop: float, warnings: list[str]) -> float | None:
    """The fastest speed backwards, where the record goes on until the car has left the wall."""
    at_end = -acceleration[time >= time[-1] - 0.001].mean()
    if time[-1] - stop < 0.01 or at_end > IN_CONTACT * -acceleration.min():
        warnings.append(
            f"the record ends at {1e3 * time[-1]:.4g} ms, before the rebound is over: a coefficient of restitution of "
            f"{ASSUMED_RESTITUTION} is assumed"
        )
        return None
    return max(0.0, -float(velocity.min()))


# the wall


def _barrier(
    record: TestRecord,
    other: TestRecord | None,
    time: Floats,
    velocity: Floats,
    stop: float,
    mass: float,
    notes: list[str],
    warnings: list[str],
) -> tuple[Floats | None, Momentum | None]:
    """The wall's force on the grid, and the balance of momentum; None where there is none, or it does not belong."""
    found = _total_force(record if other is None else other, notes, apart=other is not None)
    if found is None:
        return None, None
    raw_time, raw = found
    if raw_time[0] > LATEST_START or raw_time[-1] < time[-1] - 0.5 * INTERVAL:
        notes.append(
            f"barrier force not used: it covers {1e3 * raw_time[0]:.4g} to {1e3 * raw_time[-1]:.4g} ms, "
            f"not 0 to {1e3 * time[-1]:.4g} ms"
        )
        return None, None
    force = np.interp(time, raw_time, raw)
    since = time >= -0.5 * INTERVAL
    impulse = np.concatenate(([0.0], np.cumsum(0.5 * INTERVAL * (force[since][1:] + force[since][:-1]))))
    sign = (
        1.0 if impulse[int(np.argmax(np.abs(impulse)))] >= 0.0 else -1.0
    )  # a wall pushes back, whatever the sign it is kept in
    change = mass * (velocity[since][0] - velocity[since])
    still, back = (int(np.argmin(np.abs(time[since] - stop))), int(np.argmin(velocity[since])))
    at_stop, at_rebound = ((float(sign * impulse[i]), float(change[i])) for i in (still, back))
    balance = Momentum(at_stop, at_rebound, float(time[since][back]), mass)
    apart = abs(balance.ratio - 1.0)
    if apart > DOUBTFUL_MOMENTUM:
        warnings.append(
            f"the wall's impulse up to standstill is {balance.ratio:.3f} of the loss of momentum: mass, barrier or speed is "
            f"wrong (a mass of {balance.implied_mass:.0f} kg would agree)"
        )
    if apart > FITS_TOGETHER:
        warnings.append("the barrier force is not used: it does not belong to this mass and motion")
        return None, balance
    return sign * force, balance


def _total_force(record: TestRecord, notes: list[str], *, apart: bool) -> tuple[Floats, Floats] | None:
    """Times and the sum of the forces along x on the wall, class 60; None where the record has no total.

    apart: the record is one of the barrier by itself, in which a lone force needs no further meaning.
    """
    listed = [info for info in record.channels.values() if _is_force(info) and _on_the_wall(info, apart=apart)]
    coded = [info for info in listed if info.axis == "x"]
    infos = coded or (listed if apart else [])
    readable = [info for info in infos if info.readable and not any(word in info.status.casefold() for word in _UNUSABLE)]
    if apart and (not readable or len(readable) < len(infos) or (len(infos) > 1 and not coded)):
        names = ", ".join(info.name or info.key for info in listed[:5]) or "none"
        raise InvalidInput(
            f"barrier: got the force channels {names}; need one with the total, in a unit of force, or the load cells by their "
            "codes. Put the total into a file of its own."
        )
    if not infos:
        return None
    if len(readable) < len(infos):
        notes.append(f"barrier force: {len(readable)} of {len(infos)} load cells have a curve: no total")
        return None
    parts = []
    for info in readable:
        history = record.history(info)
        smooth = through(history, SHAPE_CLASS)[0]
        parts.append((history.time, levelled(history.time, convert(smooth.values, history.unit, "N"))))
    time = parts[0][0]
    if any(part[0].shape != time.shape or not np.allclose(part[0], time, rtol=0.0, atol=1e-9) for part in parts):
        notes.append("barrier force: the load cells are not sampled at the same times: no total")
        return None
    notes.append(f"barrier force: {'sum of ' if len(parts) > 1 else ''}{len(parts)} channel{'s' if len(parts) > 1 else ''}")
    return time, np.sum([part[1] for part in parts], axis=0)


def _is_force(info: ChannelInfo) -> bool:
    try:
        convert(0.0, info.unit, "N")
    except RidedownError:
        return False
    return info.quantity in {"", "force"}


def _on_the_wall(info: ChannelInfo, *, apart: bool) -> bool:
    if info.occupant or info.axis not in {"", "x"}:
        return False
    return apart or info.vehicle == 0 or info.location.startswith("barrier")


# the engine


def _engine(
    record: TestRecord,
    vehicle: str,
    chosen: Sequence[str | int] | None,
    time: Floats,
    stop: float,
    speed: float,
    notes: list[str],
) -> Floats | None:
    """The engine's velocity, the mean of its sensors up to the first that is not believed any more, NaN from then on."""
    if chosen is None:
        infos = [
            info
            for info in record.find(location="engine", quantity="acceleration", axis="x")
            if info.vehicle is None or not vehicle or str(info.vehicle) == vehicle
        ]
    else:
        infos = [_along_x(record, key, "engine") for key in chosen]
    believed = []
    for info in infos:
        name = f"engine channel {info.key} {info.name}".rstrip()
        if any(word in info.status.casefold() for word in _UNUSABLE):
            notes.append(f"not used: {name}: {info.status}")
            continue
        try:
            raw_time, shape, _ = _accelerations(record, info)
        except RidedownError as problem:
            notes.append(f"not used: {name}: {problem}")
            continue
        if raw_time[0] > LATEST_START or raw_time[-1] <= 10.0 * INTERVAL:
            notes.append(f"not used: {name}: it does not cover the contact")
            continue
        motion = _from_contact(time, np.interp(time, raw_time, shape), speed)
        bad = (motion.velocity < _ENGINE_BACK * speed) | (motion.velocity > _ENGINE_AHEAD * speed)
        until = min(float(raw_time[-1]), stop, float(motion.time[bad][0]) if bad.any() else np.inf)
        if until < _ENGINE_LEAST * stop:
            why = "velocity impossible for an engine" if bad.any() and until < raw_time[-1] else "its end"
            notes.append(f"not used: {name}: good to {1e3 * until:.1f} ms only ({why})")
            continue
        notes.append(f"{name}: used to {1e3 * until:.1f} ms")
        believed.append((until, motion.velocity))
    if not believed:
        return None
    until = min(one[0] for one in believed)
    velocity = np.full(time.size, np.nan)
    since = time >= -0.5 * INTERVAL
    mean = np.mean([one[1] for one in believed], axis=0)
    velocity[since] = np.where(time[since] <= until, mean, np.nan)
    return velocity
