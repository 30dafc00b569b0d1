"""Measured pulses: channels of a crash test, filtered, averaged, and reduced to few straight lines."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field, StrictBool, WithJsonSchema

from ridedown import network, signals
from ridedown.errors import InvalidInput, UnknownName
from ridedown.scenario.base import Check
from ridedown.scenario.pulse import OwnPulse, brakes, one_of, same_in_all
from ridedown.scenario.pulse_reduction import reduced
from ridedown.scenario.pulse_shapes import Floats, through
from ridedown.scenario.quantities import Duration, Factor, Number, RecordTime, Refused
from ridedown.signals import filtered, mean, reversed_sign, trimmed, zeroed
from ridedown.signals.filters import Standard
from ridedown.signals.history import TimeHistory
from ridedown.signals.record import TestRecord

_KEPT = 32  # pulses kept in memory; a study varies the restraint on one or a few
_JOIN = " and "


def _as_list(value: object) -> object:
    """One channel, or several, as a list of text."""
    given = value if isinstance(value, list | tuple) else [value]
    return [str(item) if isinstance(item, int) and not isinstance(item, bool) else item for item in given]


def _class(value: object) -> object:
    if value == "none" or (isinstance(value, int | float) and not isinstance(value, bool) and 0.0 < value < np.inf):
        return value
    shown = f'"{value}"' if isinstance(value, str) else str(value).lower()
    raise Refused(shown, 'a channel frequency class > 0 such as 60, or "none"', "Vehicles' pulses are filtered with class 60.")


Channels = Annotated[
    tuple[str, ...],
    BeforeValidator(_as_list),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": ["string", "integer"]},
                {"type": "array", "items": {"type": ["string", "integer"]}, "minItems": 1},
            ]
        }
    ),
]
FrequencyClass = Annotated[
    float | Literal["none"],
    BeforeValidator(_class),
    WithJsonSchema({"anyOf": [{"type": "number", "exclusiveMinimum": 0}, {"const": "none"}]}),
]


@dataclass(frozen=True, slots=True, eq=False)
class Recorded:
    """A measured pulse, read and reduced: knots' times [s] and accelerations [m/s2].

    samples: how many values it stands for. speed [m/s]: the vehicle's at contact, None where the record does not say. channels:
    which were used. gone: velocity taken from the vehicle at the end of the window [m/s]. apart: how far the velocity of one of
    several sensors comes away from their mean, at most [m/s].
    """

    time: Floats
    value: Floats
    samples: int
    speed: float | None
    channels: tuple[str, ...]
    gone: float
    apart: float


class MeasuredPulse(OwnPulse):
    """Channels of a test, in the signs of SAE J211; several are averaged as sensors of one and the same motion.

    Built once, the file is read; from then on its pulse is kept until the file changes.
    """

    kind: Literal["measured"]
    file: str = Field(description="a test: EV5, ISO-MME, CSV or Parquet; a folder, a zip or a file, from the scenario's folder")
    channels: Channels = Field(
        description="number, name or ISO-MME code of one channel, or a list of redundant ones to average"
    )
    cfc: FrequencyClass = Field(60.0, description='channel frequency class, or "none"')
    standard: Standard = Field("SAE J211", description="whose filter")
    time_zero: RecordTime = Field(0.0, description="time in the record at which the pulse begins")
    zero_offset: StrictBool = Field(default=False, description="whether the mean before time zero is taken off")
    reversed: StrictBool = Field(default=False, description="whether the sensor was mounted the other way round")
    window: Duration | None = Field(None, description="how much of the record to take from time zero on; all if left out")
    scale: Factor = Field(1.0, description="factor on every acceleration, and on the speed that the record tells")

    def complete(self) -> None:
        """Let the path stand for itself, wherever one works from later."""
        if self.file and "\0" not in self.file:
            self._fill(file=str(Path(self.file).absolute()))

    def recorded(self) -> Recorded:
        """The pulse in the file, reduced. Raises: Refused, naming the field."""
        path = Path(self.file)
        window = None if self.window is None else one_of(self.window)
        options = (self.channels, self.cfc, self.standard, one_of(self.time_zero), window)
        return _recorded(path, _stamp(path), *options, offset=self.zero_offset, turned=self.reversed)

    def lowered(self) -> network.Pulse:
        """The acceleration as the network takes it."""
        found = self.recorded()
        return network.Pulse(*through(found.time, found.value), amplitude=self.scale)

    def change(self) -> Number | None:
        """The speed at contact that the record tells [m/s]."""
        speed = self.recorded().speed
        return None if speed is None else self.scale * speed

    def end(self) -> Number:
        """When the pulse is over [s]."""
        return float(self.recorded().time[-1])

    def whole(self) -> float:
        """How long the record is, or the window of it [s]."""
        return float(self.recorded().time[-1])

    def checks(self) -> Iterator[Check]:
        """Rules between the fields, and whether the file holds what they ask for."""
        yield Check("file", bool(self.file) and "\0" not in self.file, f'"{self.file!r}"', "the path of a test", "Give one.")
        yield Check("channels", bool(self.channels), "an empty list", "one channel at least", 'Give its number, as in "94".')
        for field in ("time_zero", "window"):
            if isinstance(given := getattr(self, field), np.ndarray):
                yield same_in_all(field, given)._replace(fix="All rows share the shape of the pulse: vary its size with scale.")
        try:
            found = self.recorded()
        except Refused as refused:
            yield Check(refused.field, False, refused.got, refused.need, refused.fix)  # noqa: FBT003  a rule that is broken
        else:
            yield brakes("channels", found.gone)


@lru_cache(_KEPT)
def _recorded(
    path: Path,
    _stamp: object,
    channels: tuple[str, ...],
    cfc: float | Literal["none"],
    standard: Standard,
    time_zero: float,
    window: float | None,
    *,
    offset: bool,
    turned: bool,
) -> Recorded:
    record = _record(path)
    histories = [_history(record, key) for key in channels]
    if offset:
        histories = [_tried("zero_offset", "true", lambda h=h: zeroed(h, end=time_zero)) for h in histories]
    if cfc != "none":
        histories = [_tried("cfc", f"{cfc:g}", lambda h=h: filtered(h, cfc, standard=standard)) for h in histories]
    whole = histories[0] if len(histories) == 1 else _tried("channels", _JOIN.join(channels), lambda: mean(*histories))
    part = _window(reversed_sign(whole) if turned else whole, time_zero, window)
    time, value = part.time - time_zero, part.values
    apart = max(_apart(_window(history, time_zero, window), _window(whole, time_zero, window)) for history in histories)
    knots, values = reduced(time, value)
    knots[0], knots[-1] = 0.0, time[-1]
    gone = -float(np.trapezoid(value, time))
    return Recorded(knots, values, len(part), _speed(record, channels[0]), channels, gone, apart)


def _apart(one: TimeHistory, other: TimeHistory) -> float:
    """How far two velocities come apart, from two accelerations at the same times [m/s]."""
    between = one.values - other.values
    return float(np.abs(np.cumsum(0.5 * (between[1:] + between[:-1]) * np.diff(one.time))).max())


def _stamp(path: Path) -> tuple[tuple[str, int, int], ...]:
    """What changes when a test's files do: their names, sizes and times."""
    try:
        if path.is_dir():
            return tuple(sorted(_files(path, deep=True)))
        if path.suffix.lower() in signals.HEADERS:  # its curves are beside it
            return tuple(sorted(_files(path.parent, deep=False)))
        found = path.stat()
        return ((str(path), found.st_mtime_ns, found.st_size),)
    except OSError:
        return ()  # reading it says what is wrong


def _files(folder: str | Path, *, deep: bool) -> Iterator[tuple[str, int, int]]:
    """Files in a folder and, where not `deep`, in folders of it that may hold channels. Asked for every batch of crashes."""
    with os.scandir(folder) as entries:
        for entry in entries:
            if entry.is_dir():
                if deep or entry.name[:1] in {"c", "C"}:
                    yield from _files(entry.path, deep=deep)
            elif entry.is_file():
                found = entry.stat()
                yield entry.path, found.st_mtime_ns, found.st_size


def _record(path: Path) -> TestRecord:
    try:
        return signals.read(path)
    except InvalidInput as problem:
        if not path.exists():
            raise Refused(
                f'"{path}", which does not exist', "a crash test", "Paths count from the scenario's folder.", field="file"
            ) from None
        raise Refused(f'"{path}"', "a crash test that can be read", str(problem), field="file") from None


def _history(record: TestRecord, key: str) -> TimeHistory:
    try:
        history = record.history(key)
    except UnknownName as unknown:
        near = str(unknown).split(". ", 1)[-1]
        raise Refused(f'"{key}"', f"a channel of {record.identifier}", near, field="channels") from None
    except InvalidInput as problem:
        raise Refused(f'"{key}"', "a channel that can be read", str(problem), field="channels") from None
    fix = "A pulse is the acceleration of the vehicle along x."
    info = record.channel(key)
    if info.off_x and info.axis != "-x":  # a sensor the other way round may be turned
        raise Refused(f'"{key}", {info.off_x}', "an acceleration along x", fix, field="channels")
    try:
        return history.converted("m/s2")
    except InvalidInput:
        raise Refused(f'"{key}", in "{history.unit}"', "an acceleration", fix, field="channels") from None


def _window(history: TimeHistory, time_zero: float, window: float | None) -> TimeHistory:
    span = f"{history.start:g} .. {history.end:g} s, where it was recorded"
    if not history.start <= time_zero < history.end:
        raise Refused(f"{time_zero:g} s", span, field="time_zero")
    end = history.end if window is None else time_zero + window
    if end > history.end * (1.0 + 1e-12):
        longest = f"{history.end - time_zero:g} s at most, what was recorded after time zero"
        raise Refused(f"{window:g} s", longest, field="window")
    return _tried("time_zero", f"{time_zero:g} s", lambda: trimmed(history, time_zero, min(end, history.end)))


def _speed(record: TestRecord, channel: str) -> float | None:
    """The speed of the vehicle that the channel is on, where the record tells it."""
    number = record.channel(channel).vehicle
    of_vehicle = [v.speed for v in record.vehicles if v.speed is not None and (number is None or v.number == number)]
    if len(of_vehicle) == 1:
        return of_vehicle[0]
    return record.closing_speed if len(record.vehicles) <= 1 else None


def _tried(field: str, got: str, make: Any) -> TimeHistory:
    try:
        history: TimeHistory = make()
    except InvalidInput as problem:
        raise Refused(got, "what its signal allows", str(problem), field=field) from None
    return history
