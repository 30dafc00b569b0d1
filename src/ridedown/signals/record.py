"""A crash test as its laboratory recorded it: what was tested, who sat in it, and every channel, whatever the file's format.

What the header says is known at once; the curve of a channel is read when it is asked for and not kept. What is wrong with
a channel does not stop the others: it is said in `problems`, in the channel's `status`, or when that channel is asked for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from datetime import date
from types import MappingProxyType

from ridedown.errors import InvalidInput, UnknownName
from ridedown.signals.codes import ChannelCode
from ridedown.signals.history import TimeHistory

_NOTHING: Mapping[str, str] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class ChannelInfo:
    """What the header says of a channel.

    key: what `record.history` finds it by, one of a kind in its record: the curve's number, or its name.
    sensor: type of the transducer. location: where it sits, in plain words wherever they are certain (head, chest, pelvis,
    femur_left, seat_crossmember_right, engine_top, belt_shoulder, ...), else the raw code. attachment: the raw code of what
    it is fixed to. quantity: acceleration, force, displacement, ... axis: x, y, z or resultant. start, interval [s] and
    samples: where evenly sampled and the header says so. status: as the laboratory or the reader judges it, empty where
    all is well. vehicle: its number, 0 for the barrier. occupant: the seat (01 driver, 02 front passenger, ...). code: ISO-MME
    channel code. redundant: a second sensor for the same place. readable: whether there is a curve to read at all.
    """

    key: str
    number: int | None = None
    name: str = ""
    sensor: str = ""
    location: str = ""
    attachment: str = ""
    quantity: str = ""
    axis: str = ""
    unit: str = ""
    start: float | None = None
    interval: float | None = None
    samples: int | None = None
    status: str = ""
    vehicle: int | None = None
    occupant: str | None = None
    code: str | None = None
    redundant: bool = False
    readable: bool = True
    fields: Mapping[str, str] = field(default_factory=lambda: _NOTHING)

    @property
    def off_x(self) -> str:
        """How it is known not to be along x, in words; empty where it is along x, or nothing is known.

        >>> ChannelInfo("13", axis="x").off_x, ChannelInfo("14", axis="y").off_x, ChannelInfo("16", axis="resultant").off_x
        ('', 'along y', 'a resultant')
        """
        if self.axis in {"", "x"}:
            return ""
        return "a resultant" if self.axis == "resultant" else f"along {self.axis}"


@dataclass(frozen=True, slots=True)
class OfficialResult:
    """A result that the laboratory published, in its own unit, with the interval [s] it was found over, where given."""

    value: float
    unit: str
    start: float | None = None
    end: float | None = None


@dataclass(frozen=True, slots=True)
class Vehicle:
    """A vehicle of the test: mass [kg] and speed [m/s] as tested, None where not given; `fields` holds the header's rest."""

    number: int
    name: str = ""
    mass: float | None = None
    speed: float | None = None
    fields: Mapping[str, str] = field(default_factory=lambda: _NOTHING)


@dataclass(frozen=True, slots=True)
class Occupant:
    """An occupant: seat (01 driver, 02 front passenger, ...), dummy and its percentile, and the laboratory's own results."""

    seat: str
    vehicle: int = 1
    dummy: str = ""
    percentile: str = ""
    official: Mapping[str, OfficialResult] = field(default_factory=dict)
    fields: Mapping[str, str] = field(default_factory=lambda: _NOTHING)


@dataclass(frozen=True, slots=True)
class Restraint:
    """A restraint of an occupant: its kind, where it is mounted, whether it deployed, as the header words it."""

    seat: str
    vehicle: int = 1
    kind: str = ""
    mount: str = ""
    deployment: str = ""
    comment: str = ""
    fields: Mapping[str, str] = field(default_factory=lambda: _NOTHING)


@dataclass(frozen=True, slots=True)
class Barrier:
    """What was driven against: rigid or deformable, shape, mass [kg], None for one that cannot move or is not weighed."""

    kind: str = ""
    shape: str = ""
    mass: float | None = None
    fields: Mapping[str, str] = field(default_factory=lambda: _NOTHING)


Load = Callable[[ChannelInfo], TimeHistory]
"""Reads one channel's curve. Raises InvalidInput, naming file and line, where there is none or it cannot be read."""


@dataclass(frozen=True, slots=True, eq=False)
class TestRecord:
    """A test: what its header says, and its channels by key.

    format: what it was read from (NHTSA EV5, ISO-MME 1.6, CSV, Parquet). closing_speed [m/s]. problems: what was found
    wrong with the header and the files beside it, in full sentences. fields: the header's rest, by its own names.

    >>> pulse = TimeHistory([0.0, -196.0], "m/s2", interval=0.001, name="crossmember x")
    >>> record = TestRecord.of([pulse], identifier="sled 7")
    >>> record.channels["crossmember x"].samples, record.history("crossmember x").unit
    (2, 'm/s2')
    """

    __test__ = False  # for pytest: no test case

    identifier: str
    title: str = ""
    date: date | None = None
    laboratory: str = ""
    format: str = ""
    closing_speed: float | None = None
    vehicles: tuple[Vehicle, ...] = ()
    occupants: tuple[Occupant, ...] = ()
    restraints: tuple[Restraint, ...] = ()
    barrier: Barrier | None = None
    channels: Mapping[str, ChannelInfo] = field(default_factory=dict)
    problems: tuple[str, ...] = ()
    fields: Mapping[str, str] = field(default_factory=lambda: _NOTHING)
    load: Load | None = None

    def __repr__(self) -> str:
        return f"<TestRecord {self.identifier!r} {self.title!r}: {len(self.channels)} channels, {self.format}>"

    @classmethod
    def of(cls, histories: Iterator[TimeHistory] | list[TimeHistory], *, identifier: str, **header: object) -> TestRecord:
        """A record of signals at hand, each under its name; `header` as the other fields of a record.

        Raises: InvalidInput where two have the same name, or one has none.
        """
        curves: dict[str, TimeHistory] = {}
        for history in histories:
            if not history.name or history.name in curves:
                raise InvalidInput(f"channels: got {history.name!r} twice or empty; need a name for each. Rename one.")
            curves[history.name] = history
        infos = {name: info_of(history, number=i) for i, (name, history) in enumerate(curves.items(), start=1)}
        unknown = set(header) - {f.name for f in fields(cls)}
        if unknown:
            raise UnknownName.among("field of a record", min(unknown), [f.name for f in fields(cls)])
        return cls(identifier, channels=MappingProxyType(infos), load=lambda info: curves[info.key], **header)  # type: ignore[arg-type]

    # channels

    def history(self, key: str | int | ChannelInfo) -> TimeHistory:
        """The curve of a channel, read now: by its key, its number, its ISO-MME code or its name.

        Raises: UnknownName, with the nearest; InvalidInput, naming file and line, for a curve that is not there or damaged.
        """
        info = self.channel(key)
        if self.load is None:
            raise InvalidInput(f"{info.key}: got a record without curves; need one with. Read the test again.")
        return self.load(info)

    def channel(self, key: str | int | ChannelInfo) -> ChannelInfo:
        """What the header says of a channel: by its key, its number, its ISO-MME code or its name.

        A code or a name that several channels have finds the first that can be read.

        Raises: UnknownName, with the nearest.
        """
        if isinstance(key, ChannelInfo):
            key = key.key
        wanted = str(key)
        if wanted in self.channels:
            return self.channels[wanted]
        infos = list(self.channels.values())
        found = (
            [info for info in infos if wanted.isdecimal() and info.number == int(wanted)]
            or [info for info in infos if info.code is not None and info.code.upper() == wanted.upper()]
            or [info for info in infos if info.name and info.name.casefold() == wanted.casefold()]
        )
        if found:
            return next((info for info in found if info.readable), found[0])
        known = [*self.channels, *(info.code for info in infos if info.code), *(info.name for info in infos if info.name)]
        raise UnknownName.among("channel", wanted[:200], dict.fromkeys(known))

    def find(
        self,
        *,
        location: str | None = None,
        occupant: str | None = None,
        vehicle: int | None = None,
        quantity: str | None = None,
        axis: str | None = None,
        redundant: bool | None = None,
    ) -> tuple[ChannelInfo, ...]:
        """The channels with this meaning, in the record's order; what is left out may be anything.

        A location finds its sides and ends too: `engine` finds engine_top, `femur` both femurs. Channels without a curve to
        read are left out. None found is no error: laboratories measure what they choose.

        >>> pulse = TimeHistory([0.0, -1.0], "g", interval=0.001, name="pulse")
        >>> TestRecord.of([pulse], identifier="sled 7").find(location="head")
        ()
        """
        return tuple(
            info
            for info in self.channels.values()
            if info.readable
            and (location is None or info.location == location or info.location.startswith(f"{location}_"))
            and (occupant is None or info.occupant == occupant)
            and (vehicle is None or info.vehicle == vehicle)
            and (quantity is None or info.quantity == quantity)
            and (axis is None or info.axis == axis)
            and (redundant is None or info.redundant == redundant)
        )

    def occupant(self, seat: str, vehicle: int | None = None) -> Occupant:
        """The occupant in a seat.

        Raises: UnknownName, with the seats that are taken.
        """
        for occupant in self.occupants:
            if occupant.seat == seat and vehicle in {None, occupant.vehicle}:
                return occupant
        raise UnknownName.among("seat", seat, [occupant.seat for occupant in self.occupants])

    def readable(self) -> Iterator[tuple[ChannelInfo, TimeHistory]]:
        """Each channel whose curve can be read, with the curve; the others are passed over (`faults` tells of them)."""
        for info in self.channels.values():
            if info.readable:
                try:
                    history = self.history(info)
                except InvalidInput:
                    continue
                yield info, history

    def faults(self) -> tuple[str, ...]:
        """Everything found wrong: the header's problems, and those of each curve, all of which this reads."""
        found = list(self.problems)
        for info in self.channels.values():
            if info.readable:
                try:
                    found += self.history(info).remarks
                except InvalidInput as problem:
                    found.append(str(problem))
        return tuple(dict.fromkeys(found))


def info_of(history: TimeHistory, *, key: str = "", number: int | None = None) -> ChannelInfo:
    """What there is to say of a signal at hand: its name, unit, sampling and code, and what the code means."""
    return with_meaning(
        ChannelInfo(
            key=key or history.name,
            number=number,
            name=history.name,
            unit=history.unit,
            start=history.start,
            interval=history.interval,
            samples=len(history),
            code=history.code,
        )
    )


def with_meaning(info: ChannelInfo) -> ChannelInfo:
    """A channel of which nothing is known but its code, with what the code says; any other as it is."""
    if not info.code or info.location or info.quantity:
        return info
    try:
        code = ChannelCode.parse(info.code)
    except InvalidInput:
        return info
    return replace(
        info,
        location=code.place,
        quantity=code.kind,
        axis=code.axis,
        vehicle=code.vehicle if code.object != "B" else 0,
        occupant=code.seat,
        redundant=code.redundant,
    )
