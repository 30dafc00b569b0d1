"""Signals over time, and the crash tests they come from: reading, writing, filtering, processing.

The formats of files are loaded when a file is first read or written: most crashes have none.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

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
from ridedown.signals.record import ChannelInfo, TestRecord

if TYPE_CHECKING:
    from ridedown.signals.formats import HEADERS, holds_laboratory_test, read, read_bytes, write

__all__ = [
    "HEADERS",
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

_OF_FORMATS = {"HEADERS", "holds_laboratory_test", "read", "read_bytes", "write"}


def __getattr__(name: str) -> object:
    if name in _OF_FORMATS:
        value: object = getattr(importlib.import_module("ridedown.signals.formats"), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'ridedown.signals' has no attribute {name!r}")
