"""Evidence of a measured test: its channels found by meaning, the second sensor taken where the first is no good, filtered."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from ridedown.criteria.checks import Floats
from ridedown.criteria.moving import integral
from ridedown.errors import InvalidInput
from ridedown.limits.evidence import MEASURES, CannotJudge, Person, Pulse, Signals
from ridedown.limits.redundant import Sensor, choose
from ridedown.signals.filters import filtered
from ridedown.signals.history import TimeHistory
from ridedown.signals.record import ChannelInfo, Occupant, TestRecord

_UNFIT = ("questionable", "meaningless", "no data", "no file", "failed", "cannot be read")
"""Words of a status that say not to judge by a channel, as EV5 headers and ISO-MME files have them."""

COMPARTMENT = ("seat_crossmember", "vehicle", "b_pillar", "sill", "floor", "sled")
"""Where a vehicle's pulse is taken, the first that the record has: structure that does not crush, near the occupants."""

SHAPE_CLASS, INTEGRAL_CLASS = 60, 180
"""Channel frequency classes of a vehicle's acceleration: to compare and to read peaks; to integrate (SAE J211-1)."""

QUIET = 0.010
"""s, of record before time zero from which its mean is taken off as the sensor's offset before integrating."""

_CHILDREN = ("Q", "P", "CRABI", "Hybrid III 3 year", "Hybrid III 6 year", "Hybrid III 10 year")


class RecordEvidence:
    """The channels of a test record by their meaning."""

    simulated = False

    def __init__(self, record: TestRecord) -> None:
        self.record = record
        self.title = " ".join(filter(None, (record.identifier, record.title)))
        seats = {(occupant.seat, occupant.vehicle) for occupant in record.occupants}
        unlisted = dict.fromkeys(
            (info.occupant, info.vehicle or 1) for info in record.channels.values() if info.occupant and info.readable
        )
        self.people = tuple(_person(occupant) for occupant in record.occupants) + tuple(
            Person(seat, str(number)) for seat, number in unlisted if (seat, number) not in seats
        )
        self._pulses: dict[str, Pulse] = {}
        numbers = {vehicle.number for vehicle in record.vehicles if vehicle.number}
        measured = {info.vehicle for info in record.channels.values() if info.vehicle}
        self.vehicles = tuple(str(number) for number in sorted(numbers | measured)) or ("",)

    # occupants

    def signals(self, person: Person, measure: str) -> Signals:
        """The channels of one of MEASURES on an occupant, filtered and in SI. Raises: CannotJudge."""
        wanted = MEASURES[measure]
        found = []
        for axis in wanted.axes:
            here = [
                info
                for info in self.record.channels.values()
                if info.occupant == person.name
                and _same(info.vehicle, person.vehicle)
                and info.location == wanted.location
                and (info.quantity, info.axis) == (wanted.quantity, axis)
            ]
            found.append(self._first_fit(here, f"{wanted.location} {wanted.quantity} {axis}", wanted.frequency_class))
        return _together(found)

    def _first_fit(self, infos: Iterable[ChannelInfo], what: str, frequency_class: int) -> Signals:
        """The first channel, the primary sensor before the second, that can be read and filtered."""
        reasons = []
        for info in sorted(infos, key=lambda info: info.redundant):
            if _unfit(info):
                reasons.append(f"channel {info.key} {info.name}: {info.status or 'no curve'}")
                continue
            try:
                history, remarks = through(self.record.history(info), frequency_class)
                time, values = history.si
            except InvalidInput as problem:
                reasons.append(f"channel {info.key} {info.name}: {problem}")
                continue
            if info.redundant:
                remarks = (*remarks, f"{what} from the second sensor, channel {info.key}")
            return Signals(time, values[np.newaxis, :], (info.key,), (*reasons, *history.remarks, *remarks))
        raise CannotJudge("; ".join(reasons) if reasons else f"no channel for {what}")

    # vehicles

    def speed(self, vehicle: str) -> float:
        """A vehicle's speed at contact [m/s]: the header's own, or the closing speed where there is one vehicle only."""
        for known in self.record.vehicles:
            if str(known.number) == vehicle and known.speed is not None:
                return known.speed
        if len(self.vehicles) == 1 and self.record.closing_speed is not None:
            return self.record.closing_speed
        raise CannotJudge(f"the header gives no speed of vehicle {vehicle}".rstrip())

    def crush(self, vehicle: str) -> None:  # noqa: ARG002  of the protocol
        """Not known beforehand: it is integrated from the pulse."""
        return

    def pulse(self, vehicle: str) -> Pulse:
        """The mean of the two sensors of the compartment that agree best in velocity. Raises: CannotJudge."""
        if vehicle not in self._pulses:
            self._pulses[vehicle] = self._found_pulse(vehicle)
        return self._pulses[vehicle]

    def _found_pulse(self, vehicle: str) -> Pulse:
        infos = self._compartment(vehicle, "acceleration", "x")
        reasons, fit = [], []
        for info in infos:
            name = f"channel {info.key} {info.name}".rstrip()
            if _unfit(info):
                reasons.append(f"{name}: {info.status or 'no curve'}")
                continue
            try:
                raw = self.record.history(info)
                shape, class_remarks = through(raw, SHAPE_CLASS)
                smooth, _ = through(raw, INTEGRAL_CLASS)
                fit.append((info, name, shape.si, smooth.si, (*raw.remarks, *class_remarks)))
            except InvalidInput as problem:
                reasons.append(f"{name}: {problem}")
        if not fit:
            raise CannotJudge("; ".join(reasons) if reasons else "no acceleration along x in the occupant compartment")
        longest = max(float(smooth[0][-1]) for _, _, _, smooth, _ in fit)
        whole = [one for one in fit if float(one[3][0][-1]) >= longest - 1e-3 and _same_times(one[3][0], fit[0][3][0])]
        kept = {info.key for info, *_ in whole}
        reasons += [f"{name}: ends early, or is sampled otherwise" for info, name, *_ in fit if info.key not in kept]
        if not whole:
            raise CannotJudge("the sensors of the compartment are sampled differently")
        time = whole[0][3][0]
        level = [(levelled(time, shape[1]), levelled(time, smooth[1])) for _, _, shape, smooth, _ in whole]
        begin = int(np.searchsorted(time, 0.0))
        sensors = [
            Sensor(name, _side(info), integral(time, a)[begin:] - integral(time, a)[begin])
            for (info, name, *_), (_, a) in zip(whole, level, strict=True)
        ]
        choice = choose(sensors)
        shape = np.mean([level[i][0] for i in choice.chosen], axis=0)
        acceleration = np.mean([level[i][1] for i in choice.chosen], axis=0)
        remarks = (*choice.remarks, *(remark for i in choice.chosen for remark in whole[i][4]))
        used = tuple(whole[i][0].key for i in choice.chosen)
        return Pulse(time, shape, acceleration, used, (*reasons, *choice.rejected), tuple(dict.fromkeys(remarks)))

    def across(self, vehicle: str, what: str) -> Signals:
        """`lateral` or `vertical` acceleration, or `yaw rate`, filtered to class 180. Raises: CannotJudge."""
        quantity, axis = {"lateral": ("acceleration", "y"), "vertical": ("acceleration", "z")}.get(
            what, ("angular velocity", "z")
        )
        infos = self._compartment(vehicle, quantity, axis)
        return self._first_fit(infos, f"{what} of the vehicle", INTEGRAL_CLASS)

    def _compartment(self, vehicle: str, quantity: str, axis: str) -> list[ChannelInfo]:
        for place in COMPARTMENT:
            found = [
                info
                for info in self.record.channels.values()
                if not info.occupant
                and (info.quantity, info.axis) == (quantity, axis)
                and (info.location == place or info.location.startswith(f"{place}_"))
                and _same(info.vehicle, vehicle)
            ]
            if any(info.readable for info in found):
                return found
        return []


def _person(occupant: Occupant) -> Person:
    dummy = f"{occupant.dummy} {occupant.percentile}".strip()
    child = None if not dummy else any(dummy.startswith(kind) for kind in _CHILDREN)
    return Person(occupant.seat, str(occupant.vehicle), dummy, child, official=occupant.official)


def _same(number: int | None, vehicle: str) -> bool:
    """Whether a channel belongs to a vehicle; one that names none belongs to any."""
    return number is None or not vehicle or str(number) == vehicle


def _unfit(info: ChannelInfo) -> bool:
    return not info.readable or any(word in info.status.casefold() for word in _UNFIT)


def _side(info: ChannelInfo) -> str:
    words = info.location.split("_")
    return next((side for side in ("left", "right") if side in words), "")


def through(history: TimeHistory, frequency_class: int) -> tuple[TimeHistory, tuple[str, ...]]:
    """The history in a channel class, and what to remark where it was filtered before."""
    before = history.filtered
    if before is None:
        return filtered(history, frequency_class), ()
    if math.isclose(before.frequency_class, frequency_class):
        return history, ()
    if before.frequency_class < frequency_class:
        return history, (f"{history.name}: recorded in class {before.frequency_class:g}, needs {frequency_class}",)
    return filtered(history, frequency_class), ()


def _together(parts: list[Signals]) -> Signals:
    first = parts[0]
    for part in parts[1:]:
        if not _same_times(part.time, first.time):
            raise CannotJudge(f"channels {first.used[0]} and {part.used[0]} are not sampled at the same times")
    return Signals(
        first.time,
        np.concatenate([part.values for part in parts]),
        tuple(name for part in parts for name in part.used),
        tuple(remark for part in parts for remark in part.remarks),
    )


def _same_times(one: Floats, other: Floats) -> bool:
    return one.shape == other.shape and bool(np.allclose(one, other, rtol=0.0, atol=1e-9))


def levelled(time: Floats, values: Floats) -> Floats:
    """The values less their mean before time zero, where enough was recorded then."""
    before = time < 0.0
    if not before.any() or -time[0] < QUIET:
        return values
    level: Floats = values - values[before].mean()
    return level
