"""Tables that a client sent, CSV or Parquet, read in a process of their own: one that takes too long, too much memory, or
brings down what reads it, ends that process and nothing else.

A laboratory's files are plain text within bounds that their readers keep. A table is not: Parquet is unpacked by a library
that a damaged file can end, and a small file can stand for a large one.
"""

from __future__ import annotations

import os
import signal
from contextlib import suppress
from dataclasses import replace
from multiprocessing import get_context
from multiprocessing.connection import Connection
from types import MappingProxyType

from ridedown.errors import InvalidInput, RidedownError
from ridedown.signals.history import TimeHistory
from ridedown.signals.record import ChannelInfo, TestRecord

SECONDS = 60.0
"""One table at most: 48 MB of text take some ten, and longer where others are at work."""
MEMORY = 2**30
"""Bytes that reading one may take, beside the program itself."""
MOST_VALUES = 8_000_000
"""Numbers that one table may hold: 64 MB."""

_Read = tuple[TestRecord, list[tuple[ChannelInfo, TimeHistory | str]]]
"""A record without its curves, and each channel with its curve, or why there is none."""


def read_table(content: bytes, name: str, *, seconds: float = SECONDS, memory: int = MEMORY) -> TestRecord:
    """The table in these bytes (see `ridedown.signals.read_bytes`), all of its curves read.

    Raises: InvalidInput for what is no table of signals, or takes more than `seconds` or `memory` [bytes].
    """
    context = get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_read_and_send, args=(theirs, name, memory), daemon=True)
    process.start()
    theirs.close()
    try:
        ours.send_bytes(content)
        if not ours.poll(seconds):
            raise InvalidInput(
                f"file: got a table that takes more than {seconds:g} s to read; need a smaller one. Leave out channels."
            )
        found: _Read | str = ours.recv()
    except (EOFError, OSError):
        raise InvalidInput(
            f"file: got a table that cannot be read within {memory >> 20:,} MB; need a smaller, undamaged one. Write it again."
        ) from None
    finally:
        process.kill()
        process.join()
        ours.close()
    if isinstance(found, str):
        raise InvalidInput(found)
    return _whole(*found)


def size_of(record: TestRecord) -> int:
    """Bytes that the curves of a table take in memory."""
    return sum(8 * (info.samples or 0) for info in record.channels.values())


def _whole(header: TestRecord, channels: list[tuple[ChannelInfo, TimeHistory | str]]) -> TestRecord:
    curves = {info.key: curve for info, curve in channels}

    def load(info: ChannelInfo) -> TimeHistory:
        curve = curves[info.key]
        if isinstance(curve, str):
            raise InvalidInput(curve)
        return curve

    return replace(header, channels=MappingProxyType({info.key: info for info, _ in channels}), load=load)


# in the process of its own


def _read_and_send(answer: Connection, name: str, memory: int) -> None:
    """Read what is sent, and send the record, or the sentence that refuses it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the server's, which ends this
    os.environ["ARROW_DEFAULT_MEMORY_POOL"] = "system"  # the others set aside more addresses than are allowed here
    from ridedown.signals import delimited, parquet  # noqa: F401, PLC0415  before memory is bounded

    content = answer.recv_bytes()
    _bound(memory)
    found: _Read | str
    try:
        found = _read(content, name)
    except RidedownError as refused:
        found = str(refused)
    except MemoryError:
        return  # as if it had been ended
    answer.send(found)


def _read(content: bytes, name: str) -> _Read:
    from ridedown.signals import read_bytes  # noqa: PLC0415

    record = read_bytes(content, name)
    channels: list[tuple[ChannelInfo, TimeHistory | str]] = []
    values = 0
    for info in record.channels.values():
        curve: TimeHistory | str
        try:
            curve = record.history(info)
        except InvalidInput as why:
            curve = str(why)
        else:
            values += len(curve)
        if values > MOST_VALUES:
            raise InvalidInput(f"file: got more than {MOST_VALUES:,} numbers; need fewer. Leave out channels.")
        channels.append((replace(info, fields={}), curve))  # what its fields are by default cannot be sent
    return replace(record, channels={}, load=None, fields={}), channels


def _bound(memory: int) -> None:
    """Let this process take so many bytes more, where the system can be told so."""
    with suppress(ImportError, OSError, ValueError):  # not on every system
        import resource  # noqa: PLC0415
        from pathlib import Path  # noqa: PLC0415

        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        most = pages * resource.getpagesize() + memory
        resource.setrlimit(resource.RLIMIT_AS, (most, most))
