"""The values of ISO-MME channels: one a line under the descriptors, at an even interval or at times of another channel."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ridedown import units
from ridedown.errors import InvalidInput
from ridedown.signals import isomme_extras as extras
from ridedown.signals.codes import CLASSES
from ridedown.signals.files import Tree
from ridedown.signals.history import Filter, TimeHistory
from ridedown.signals.isomme_text import NO_VALUE, Descriptors, read_descriptors
from ridedown.signals.numerals import Floats, lines_of, numbers_of
from ridedown.signals.record import ChannelInfo, Load

_CLASS = re.compile(r"(?:CFC *)?([0-9]{1,5})", re.ASCII | re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class Channel:
    """A channel, its file, empty where there is none, and the descriptors in it."""

    info: ChannelInfo
    file: str
    head: Descriptors | None


def explicit(head: Descriptors) -> bool:
    """Whether a channel's times stand in another channel."""
    return head.text("Reference channel").lower() == "explicit"


def loader(tree: Tree, channels: Mapping[str, Channel]) -> Load:
    """What reads a channel of the test when it is asked for."""

    def load(info: ChannelInfo) -> TimeHistory:
        channel = channels[info.key]
        head, values, remarks = _read(tree, channel)
        start, interval, stamps = head.number("Time of first sample"), head.number("Sampling interval"), None
        if explicit(head):
            start, interval, stamps = 0.0, None, _stamps(tree, channels, head, values.size)
        elif interval is None or not interval > 0.0:
            raise InvalidInput(
                f"{head.where}:{head.line('Sampling interval')}: got no sampling interval above 0 s; need one, or an explicit "
                "reference channel. Correct the file."
            )
        elif start is None:
            remarks += (f"{head.where}: names no time of the first sample; 0 s is taken",)
        return TimeHistory(
            values,
            info.unit,
            start=start or 0.0,
            interval=interval,
            stamps=stamps,
            name=info.name,
            code=info.code,
            filtered=_filter(info.code, head),
            remarks=remarks,
        )

    return load


def _read(tree: Tree, channel: Channel) -> tuple[Descriptors, Floats, tuple[str, ...]]:
    """The descriptors and values of a channel's file, and remarks on their number."""
    if not channel.file:
        raise InvalidInput(
            f"channel {channel.info.key}: got no file for {channel.info.name!r}; need one. Ask for the test again, whole."
        )
    lines = lines_of(tree.read_text(channel.file).rstrip())
    head, first = read_descriptors(lines, channel.file)
    data = lines[first:]
    count = len(data)
    # A value may be missing at the end, where a sensor was lost; anywhere else there is nothing to put in its place.
    while data and data[-1].strip().upper() in {NO_VALUE, ""}:
        data.pop()
    if not data:
        raise InvalidInput(f"{channel.file}:{first + 1}: got no value; need one a line. Ask for the test again, whole.")
    values = numbers_of(data, channel.file, first + 1)
    told = head.whole("Number of samples")
    remarks: tuple[str, ...] = ()
    if values.size < (count if told is None else told):
        remarks = (
            f"{channel.file}: ends early, {values.size} samples of the {count if told is None else told} that it should have",
        )
    elif told is not None and values.size > told:
        remarks = (f"{channel.file}: holds {values.size} samples; its descriptors give {told}",)
    return head, values, remarks


def _stamps(tree: Tree, channels: Mapping[str, Channel], head: Descriptors, count: int) -> Floats:
    """The times of a channel whose reference channel holds them [s], (n,)."""
    name = head.text("Reference channel name")
    line = head.line("Reference channel name")
    matches = [c for c in channels.values() if name and name.upper() in {(c.info.code or "").upper(), c.info.name.upper()}]
    if len(matches) != 1:
        raise InvalidInput(
            f"{head.where}:{line}: got reference channel {name[:40]!r}, which is {len(matches)} channels; need one, with the "
            "times. Correct the name."
        )
    times = units.convert(_read(tree, matches[0])[1], matches[0].info.unit or "s", "s")
    if times.size < count:
        raise InvalidInput(
            f"{matches[0].file}: got {times.size} times for the {count} samples of {head.where}; need one for each. "
            "Correct the file."
        )
    times = times[:count]
    falls = np.flatnonzero(np.diff(times) < 0.0)
    if falls.size:
        raise InvalidInput(
            f"{matches[0].file}: got time {times[falls[0] + 1]:g} s after {times[falls[0]]:g} s; need times that never fall. "
            "Correct the file."
        )
    return times


def _filter(code: str | None, head: Descriptors) -> Filter | None:
    """What the channel was filtered with: see the top of the file."""
    letter = code[-1] if code else "?"
    size: float | None = CLASSES.get(letter)
    if size is None and letter in {"?", "S"}:
        match = _CLASS.fullmatch(head.text("Channel frequency class"))
        size = float(match[1]) if match else None
    if not size:
        return None
    stated = extras.filter_of(head.text(".Filter"))
    return stated if stated and stated.frequency_class == size else Filter(size)
