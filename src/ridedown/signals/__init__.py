"""Signals over time, and the crash tests they come from: reading, writing, filtering, processing."""

from ridedown.signals.filters import filtered
from ridedown.signals.history import Filter, TimeHistory
from ridedown.signals.processing import (
    aligned,
    differentiated,
    integrated,
    mean,
    resampled,
    resultant,
    reversed_sign,
    trimmed,
    zeroed,
)
from ridedown.signals.read import holds_laboratory_test, read, read_bytes, write
from ridedown.signals.record import ChannelInfo, TestRecord

__all__ = [
    "ChannelInfo",
    "Filter",
    "TestRecord",
    "TimeHistory",
    "aligned",
    "differentiated",
    "filtered",
    "holds_laboratory_test",
    "integrated",
    "mean",
    "read",
    "read_bytes",
    "resampled",
    "resultant",
    "reversed_sign",
    "trimmed",
    "write",
    "zeroed",
]
