"""Signals side by side in one table, a column each beside a column of times: what CSV and Parquet files have in common.

Times that are even to within what rounding in print leaves become a start and an interval; others stay as stamps. A column
that stops before the others ends early, and is said to; one with a gap, or with what is no number, cannot be read, and the
others can. What a plain table has no place for, the channel's code, filter state and meaning, goes along as a line of JSON.
"""

from __future__ import annotations

import json
import math
import re
import secrets
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ridedown import units
from ridedown.errors import InvalidInput
from ridedown.signals.history import LATEST, SHORTEST, Filter, Floats, TimeHistory, sample_times
from ridedown.signals.record import ChannelInfo, TestRecord, with_meaning

MAX_COLUMNS = 20_000
"""Columns of one table at most: more than any test has channels."""

TIME_NAMES = frozenset({"time", "t", "zeit", "temps", "tiempo", "times"})

_UNEVEN = 0.02  # parts of an interval that printed times may be off an even grid: 1 us in 20 kHz, 0.5 us in 30 kHz
_EXACT = 1e-6  # parts of an interval below which being off is not worth a remark
_LONGEST_NAME = 200
STAMPS = {"interval": None}  # a clock of times that are not even

_BRACKETED = re.compile(r"(.*?)\s*(?:\[([^\[\]]*)\]|\(([^()]*)\))\s*", re.DOTALL)
# `force_x_N`: only units that no word ends in. "_t", "_in", "_bar" and "_1" are parts of names.
_NOT_SUFFIXES = {"", "t", "in", "bar", "lb"}


Grid = tuple[float, float | None, Floats | None, tuple[str, ...]]
"""What `grid_of` gives."""


def name_and_unit(heading: str, *, suffixes: bool = True) -> tuple[str, str | None]:
    """A column's name and unit, of `name [unit]`, `name (unit)`, or, with `suffixes`, `name_unit`; None where it has none.

    >>> name_and_unit("head.x [m/s2]"), name_and_unit("Kopf X (g)"), name_and_unit("force_x_N"), name_and_unit("overlap []")
    (('head.x', 'm/s2'), ('Kopf X', 'g'), ('force_x', 'N'), ('overlap', ''))
    >>> name_and_unit("seat_x"), name_and_unit("HIC (15)")
    (('seat_x', None), ('HIC (15)', None))
    """
    match = _BRACKETED.fullmatch(heading)
    if match is not None:
        name, square, round_ = match.groups()
        if square is not None:
            return name, units.recognised(square)
        if units.is_known(round_):
            return name, units.spelled(round_)
    name, _, suffix = heading.strip().rpartition("_")
    if suffixes and name and units.is_known(suffix):
        unit = units.spelled(suffix)
        if suffix == unit and unit not in _NOT_SUFFIXES:
            return name, unit
    return heading.strip(), None


def column_of_times(headings: Sequence[tuple[str, str | None]], where: str) -> int:
    """Which column holds the times: the one that is called so, else the first, if its unit is one of time.

    Raises: InvalidInput where there is none, or it has no unit of time.
    """
    called = [i for i, (name, _) in enumerate(headings) if name.casefold() in TIME_NAMES]
    candidates = called or [0]
    for i in candidates:
        unit = headings[i][1]
        if unit is not None and units.is_known(unit) and units.dimension(unit) is units.TIME:
            return i
    name = headings[candidates[0]][0][:60]
    if called:
        raise InvalidInput(
            f"{where}: got a column {name[:60]!r} without a unit of time; need one. Write time [s] or time [ms]."
        )
    raise InvalidInput(f"{where}: got no column of times; need one. Give the first column the heading time [s].")


def grid_of(times: Floats, where: str, clock: Any = None) -> Grid:
    """Start [s], interval [s] or stamps (n,) [s], and remarks, of times (n,) [s] as they were printed or stored.

    clock: the interval that whoever wrote them said, as `{"interval": 0.0001}`, None in it for stamps; it counts wherever it
    agrees with the times. Without it, even times come back as the interval that they were made of, with as few digits as
    reproduce each of them, bit for bit if any does.

    >>> grid_of(np.array([-0.0001, 0.0, 0.0001]), "a.csv")
    (-0.0001, 0.0001, None, ())

    Raises: InvalidInput where a time is not finite, or falls.
    """
    if not np.isfinite(times).all():
        raise InvalidInput(f"{where}: got no time in row {int(np.argmin(np.isfinite(times))) + 1}; need one in each row.")
    if not np.abs(times).max() <= LATEST:
        raise InvalidInput(
            f"{where}: got a time of {times[int(np.argmax(np.abs(times)))]:g} s; need one near zero. Check its unit."
        )
    falls = np.flatnonzero(times[1:] < times[:-1])
    if falls.size:
        i = int(falls[0])
        raise InvalidInput(
            f"{where}: got time {times[i + 1]:g} s after {times[i]:g} s; need times that never fall. Sort the rows."
        )
    said = _said_interval(clock)
    if said is not None and np.array_equal(sample_times(float(times[0]), said, times.size), times):
        return float(times[0]), said, None, ()
    estimate, start = float(times[-1] - times[0]) / max(times.size - 1, 1), float(times[0])
    # As far from zero as that, a double holds no half of a thousandth of the interval: there is no telling whether it is even.
    if clock == STAMPS or estimate < max(SHORTEST, 1e3 * float(np.spacing(np.abs(times).max()))):
        return 0.0, None, times, ()
    candidates = _candidates(times, estimate)
    worst = [float(np.abs(sample_times(start, interval, times.size) - times).max()) / interval for interval in candidates]
    rounding = 4.0 * float(np.spacing(np.abs(times).max())) / estimate
    best = next((i for i, off in enumerate(worst) if off == 0.0), None)
    best = next((i for i, off in enumerate(worst) if off <= rounding), int(np.argmin(worst))) if best is None else best
    if worst[best] <= _EXACT:
        return start, candidates[best], None, ()
    if worst[best] > _UNEVEN:
        return 0.0, None, times, ()
    remark = f"{where}: its times are up to {worst[best]:.2g} of an interval off an even grid of {candidates[best]:.6g} s, "
    return start, candidates[best], None, (remark + "as which they are taken",)


def _candidates(times: Floats, estimate: float) -> list[float]:
    """Intervals to try: with few digits first, then the doubles next to the best estimates."""
    # Whole multiples of an interval tell it best by the one farthest from zero.
    far = float(times[int(np.argmax(np.abs(times)))])
    multiple = round(far / estimate)
    estimates = [estimate, far / multiple] if multiple else [estimate]
    tried = [float(f"{value:.{digits}g}") for digits in range(1, 17) for value in estimates]
    for value in estimates:
        above = below = value
        for _ in range(4):
            tried += [above, below]
            above, below = math.nextafter(above, math.inf), math.nextafter(below, 0.0)
    return [interval for interval in dict.fromkeys(tried) if interval >= SHORTEST]


def _said_interval(clock: Any) -> float | None:
    interval = clock.get("interval") if isinstance(clock, dict) else None
    return interval if isinstance(interval, float) and SHORTEST <= interval <= LATEST else None


def column(name: str, values: Floats, times: Floats, grid: Grid, unit: str, about: Any, where: str) -> TimeHistory:
    """One column (n,) as a signal; NaN where a cell is empty. about: what `about_of` wrote of it, None for nothing.

    Raises: InvalidInput where it has no value, or a gap.
    """
    present = ~np.isnan(values)
    if not present.any():
        raise InvalidInput(f"{where}: got no value in column {name[:60]!r}; need one at least. Leave the column out.")
    first, last = int(np.argmax(present)), len(values) - 1 - int(np.argmax(present[::-1]))
    if not present[first : last + 1].all():
        gap = first + int(np.argmin(present[first : last + 1]))
        raise InvalidInput(
            f"{where}: got no value in column {name[:60]!r} at {times[gap]:g} s; need one in each row. Fill the gap."
        )
    start, interval, stamps, remarks = grid
    if first > 0:
        remarks += (f"{where}: column {name[:60]!r} begins late, at {times[first]:g} s",)
    if last + 1 < len(values):
        remarks += (f"{where}: column {name[:60]!r} ends early, at {times[last]:g} s",)
    part = slice(first, last + 1)
    code, state = _about(about)
    return TimeHistory(
        values[part],
        unit,
        start=start if interval is None else float(sample_times(start, interval, len(times))[first]),
        interval=interval,
        stamps=None if stamps is None else stamps[part],
        name=name,
        code=code,
        filtered=state,
        remarks=remarks,
    )


def distinct(names: Sequence[str]) -> list[str]:
    """The names, each made one of a kind: empty ones numbered, repeated ones counted.

    >>> distinct(["time", "", "head x", "head x"])
    ['time', 'column 2', 'head x', 'head x (2)']
    """
    taken: set[str] = set()
    counts: Counter[str] = Counter()  # where to go on counting: a table may have 20,000 columns of one name
    result = []
    for i, name in enumerate(names, start=1):
        wanted = unique = name[:_LONGEST_NAME] or f"column {i}"
        while unique in taken:
            counts[wanted] += 1
            unique = f"{wanted} ({counts[wanted] + 1})"
        taken.add(unique)
        result.append(unique)
    return result


# what a plain table has no place for


_WORDS = ("location", "attachment", "quantity", "axis", "occupant", "status")


def about_of(history: TimeHistory, info: ChannelInfo) -> dict[str, Any] | None:
    """The channel code, the filter state and the meaning as plain data, None where there is none of them."""
    about: dict[str, Any] = {}
    meaning: dict[str, Any] = {word: getattr(info, word) for word in _WORDS if getattr(info, word)}
    if info.vehicle is not None:
        meaning["vehicle"] = info.vehicle
    if info.redundant:
        meaning["redundant"] = True
    if meaning:
        about["meaning"] = meaning
    if history.code:
        about["code"] = history.code
    stages, state = [], history.filtered
    while state is not None:
        stages.append([state.frequency_class, state.standard])
        state = state.after
    if stages:
        about["filtered"] = stages
    return about or None


def with_meaning_of(info: ChannelInfo, about: Any) -> ChannelInfo:
    """A channel with the meaning that `about_of` wrote, or else that of its code."""
    meaning = about.get("meaning") if isinstance(about, dict) else None
    if not isinstance(meaning, dict):
        return with_meaning(info)
    words = {word: meaning[word][:60] for word in _WORDS if isinstance(meaning.get(word), str)}
    vehicle, redundant = meaning.get("vehicle"), meaning.get("redundant")
    return replace(
        info,
        **(words | {"status": info.status or words.get("status", "")}),
        vehicle=vehicle if type(vehicle) is int and 0 <= vehicle < 100 else None,
        redundant=redundant is True,
    )


def _about(about: Any) -> tuple[str | None, Filter | None]:
    """The code and the filter state that `about_of` wrote; what is not of that form counts as not stated."""
    if not isinstance(about, dict):
        return None, None
    code, stages = about.get("code"), about.get("filtered")
    state: Filter | None = None
    for stage in reversed(stages[:20]) if isinstance(stages, list) else ():
        match stage:
            case [int() | float() as size, str() as standard] if not isinstance(size, bool) and 0 < size < math.inf:
                state = Filter(size, standard[:40], after=state)
            case _:
                return (code if isinstance(code, str) else None), None
    return (code[:40] if isinstance(code, str) else None), state


def parsed(text: str) -> Any:
    """JSON as plain data, None where it is none: such lines are a convenience, and a foreign file may hold anything."""
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return None


@dataclass(frozen=True, slots=True)
class Table:
    """What a table will hold: times (n,) [s], their interval [s] if even, each channel by its name, and what was left out."""

    times: Floats
    interval: float | None
    histories: dict[str, TimeHistory]
    infos: dict[str, ChannelInfo]
    left_out: tuple[str, ...]


def side_by_side(record: TestRecord) -> Table:
    """The channels of a record beside the times that they share; shorter ones end early, unreadable ones are left out.

    Raises: InvalidInput where two channels were taken at different times, or none can be read.
    """
    read: list[tuple[ChannelInfo, TimeHistory]] = []
    left_out: list[str] = []
    for info in record.channels.values():
        try:
            read.append((info, record.history(info)))
        except InvalidInput as problem:
            left_out.append(f"{info.key}: left out, since it cannot be read: {problem}")
    if not read:
        raise InvalidInput("channels: got none that can be read; need one at least. Look at record.faults().")
    names = Counter(history.name for _, history in read)
    columns = {
        history.name if history.name and names[history.name] == 1 else f"{history.name} ({info.key})".strip(): (info, history)
        for info, history in read
    }
    histories = {name: history for name, (_, history) in columns.items()}
    infos = {name: info for name, (info, _) in columns.items()}
    longest = max(histories.values(), key=len)
    times = longest.time
    for name, history in histories.items():
        if not np.array_equal(history.time, times[: len(history)]):
            raise InvalidInput(
                f"{name[:60]}: got times other than those of {longest.name[:60] or 'the longest channel'!r}; a table has one "
                "column of them. Use ridedown.signals.aligned first, or write ISO-MME."
            )
    return Table(times, longest.interval, histories, infos, tuple(left_out))


@contextmanager
def written_aside(path: Path) -> Iterator[Path]:
    """A new file beside `path` that takes its place when all went well, and is gone when not: nothing is half written."""
    aside = path.with_name(f".{path.name[:100]}.{secrets.token_hex(8)}.part")
    try:
        yield aside
        aside.replace(path)
    finally:
        aside.unlink(missing_ok=True)
