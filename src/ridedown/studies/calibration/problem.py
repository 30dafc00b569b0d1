"""A calibration made ready to run: scenarios loaded, tests read, targets and free parameters resolved."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ridedown import units
from ridedown.errors import InvalidInput, UnknownName
from ridedown.network import Channel, Network, channels
from ridedown.network.channels import find
from ridedown.outcomes import Outcomes, wanted
from ridedown.scenario import Scenario, load, lower, substitute
from ridedown.scenario.channels import total_forces
from ridedown.scenario.reading import SUFFIXES, anchored
from ridedown.signals import TimeHistory, filtered, mean, read
from ridedown.signals.record import TestRecord
from ridedown.simulation import simulate_many
from ridedown.studies.calibration.file import Calibration, Case, Prediction, Target
from ridedown.studies.calibration.sampling import Samples
from ridedown.studies.calibration.targets import ChannelTarget, Evaluation, NumberTarget, residuals
from ridedown.studies.calibration.unknowns import Setting, Unknown, number, resolve, table_of, values_of

Floats = NDArray[np.float64]

EXPECTED_MISFIT = 0.05
"""What a channel is expected to be off by, over its peak, where the file does not say."""

_ALONG_X = ("m/s2", "m/s")
"""Units of what a measured channel has to be along x for: bodies move along it, forces and deflections may point elsewhere."""

_STEPS_PER_CLASS = 40  # samples in 1/class: 24 in a period of the corner, so that peaks between samples lose little
_FINEST, _MOST_STEPS, _FEWEST_STEPS = 5e-5, 1000, 150
_CORNER = 5.0 / 3.0  # where two passes of a class are 3 dB down, over the class


@dataclass(frozen=True, slots=True, eq=False)
class ResolvedCase:
    """A case or a prediction: its scenario, the fields that are free in it, its targets."""

    name: str
    scenario: Scenario
    settings: tuple[Setting, ...]
    channels: tuple[ChannelTarget, ...]
    numbers: tuple[NumberTarget, ...]
    weight: float
    fitted: bool

    def with_values(self, values: Floats) -> Scenario:
        """The scenario with the free parameters (n,) put in."""
        table = {path: float(column[0]) for path, column in table_of(self.settings, values[None]).items()}
        return substitute(self.scenario, table)

    def evaluate(self, values: Floats, channels: Sequence[ChannelTarget] | None = None) -> Evaluation:
        """What candidates (R, n) come to. A candidate that breaks a rule of the scenario, or fails, is NaN throughout."""
        channels = self.channels if channels is None else channels
        table = table_of(self.settings, values)
        rows = len(values)
        possible = _possible(self.scenario, table, np.arange(rows))
        found = {target.name: np.full(rows, np.nan) for target in self.numbers}
        curves = {target.name: np.full((rows, target.samples.times.size), np.nan) for target in channels}
        if possible.size:
            many = self._simulated({path: column[possible] for path, column in table.items()}, possible.size, channels)
            for name, column in found.items():
                column[possible] = np.where(many.completed, many[name], np.nan)
            times = _all_times(channels)
            for target in channels:
                read = many.samples[target.name][:, np.searchsorted(times, target.samples.read_at)]
                curves[target.name][possible] = np.where(many.completed[:, None], target.samples.of(read), np.nan)
        return Evaluation(curves, found)

    def _simulated(self, table: Mapping[str, Floats], rows: int, channels: Sequence[ChannelTarget]) -> Outcomes:
        # a case in which nothing is free is simulated as often as the others all the same
        columns = table or {"duration": np.full(rows, float(self.scenario.duration))}
        names = list(dict.fromkeys(target.name for target in self.numbers))
        if not channels:
            return simulate_many(self.scenario, columns, outcomes=names, threads=1)
        sampled = [target.name for target in channels]
        return simulate_many(self.scenario, columns, outcomes=names, samples=sampled, times=_all_times(channels), threads=1)


def _all_times(channels: Sequence[ChannelTarget]) -> Floats:
    """The times at which any of them is read."""
    return np.unique(np.concatenate([np.zeros(0), *(target.samples.read_at for target in channels)]))


def _possible(scenario: Scenario, table: Mapping[str, Floats], rows: NDArray[np.intp]) -> NDArray[np.intp]:
    """The rows of a table that the scenario's rules allow: halved until all of a part are allowed, or one is not."""
    try:
        substitute(scenario, {path: column[rows] for path, column in table.items()})
    except InvalidInput:
        if rows.size <= 1:
            return rows[:0]
        middle = rows.size // 2
        return np.concatenate([_possible(scenario, table, part) for part in (rows[:middle], rows[middle:])])
    return rows


@dataclass(eq=False)
class Problem:
    """Cases, predictions and unknowns of a calibration. `tried` counts candidates, `best` is the best point seen so far.

    candidates: all that were tried, points (R, n) and their misfits (R,), batch by batch.
    """

    calibration: Calibration
    unknowns: tuple[Unknown, ...]
    cases: tuple[ResolvedCase, ...]
    predictions: tuple[ResolvedCase, ...]
    tried: int = 0
    candidates: list[tuple[Floats, Floats]] = field(default_factory=list)
    best: Floats | None = None
    best_value: float = np.inf
    on_try: Callable[[], None] = field(default=lambda: None)

    @classmethod
    def of(cls, calibration: Calibration, folder: Path) -> Problem:
        """Load scenarios and tests, and resolve names and units. Raises: InvalidInput, UnknownName."""
        entries = [*calibration.cases, *calibration.predict]
        scenarios = {entry.name: _scenario(entry, folder) for entry in entries}
        unknowns, settings = resolve(calibration.parameters, scenarios, [case.name for case in calibration.cases])
        resolved = tuple(
            _resolved(entry, scenarios[entry.name], settings[entry.name], folder, f"{kind}.{i}")
            for kind, group in (("cases", calibration.cases), ("predict", calibration.predict))
            for i, entry in enumerate(group)
        )
        split = len(calibration.cases)
        return cls(calibration, unknowns, resolved[:split], resolved[split:])

    def residuals(self, points: Floats) -> Floats:
        """Weighted residuals (R, m) of points of the unit cube (R, n); NaN in rows that cannot be."""
        values = values_of(self.unknowns, points)
        blocks = [block for found in self._each_case(values) for block in found]
        for i, unknown in enumerate(self.unknowns):
            if unknown.prior is not None:
                middle, sigma = unknown.prior
                blocks.append(((values[:, i] - middle) / sigma)[:, None])
        found = np.concatenate(blocks, axis=1)
        self._remember(points, found)
        return found

    def _each_case(self, values: Floats) -> list[list[Floats]]:
        """Residuals of each case: side by side, for a solver at work lets others go on."""

        def of(case: ResolvedCase) -> list[Floats]:
            return residuals(case.channels, case.numbers, case.evaluate(values), case.weight)

        if len(self.cases) == 1:
            return [of(self.cases[0])]
        with ThreadPoolExecutor(min(len(self.cases), os.cpu_count() or 1)) as pool:
            return list(pool.map(of, self.cases))

    def misfit(self, points: Floats) -> Floats:
        """Sum of squares of the residuals, (R,); infinite where a candidate cannot be."""
        total = (self.residuals(points) ** 2).sum(axis=1)
        return np.where(np.isnan(total), np.inf, total)

    def _remember(self, points: Floats, found: Floats) -> None:
        self.tried += len(points)
        total = (found**2).sum(axis=1)
        self.candidates.append((points.copy(), total))
        if not np.isnan(total).all():
            row = int(np.nanargmin(total))
            if total[row] < self.best_value:
                self.best, self.best_value = points[row].copy(), float(total[row])
        self.on_try()


def _scenario(entry: Prediction, folder: Path) -> Scenario:
    source = entry.scenario
    if isinstance(source, Scenario):
        return source
    if isinstance(source, str) and (Path(source).suffix.lower() in SUFFIXES or "/" in source or os.sep in source):
        source = folder / source
    if isinstance(source, Mapping):
        source = anchored(dict(source), folder)
    try:
        return load(source)
    except InvalidInput as problem:
        raise InvalidInput(f"{entry.name}.scenario: {problem}") from None


def _record(entry: Prediction, folder: Path) -> TestRecord | None:
    if entry.record is None or isinstance(entry.record, TestRecord):
        return entry.record
    with _said_of(f"{entry.name}.record"):
        return read(folder / entry.record)


def _resolved(entry: Prediction, scenario: Scenario, settings: tuple[Setting, ...], folder: Path, where: str) -> ResolvedCase:
    network = lower(scenario)
    known = known_channels(scenario, network)
    record = _record(entry, folder)
    curves: list[ChannelTarget] = []
    numbers: list[NumberTarget] = []
    for i, target in enumerate(entry.targets):
        at = f"{where}.targets.{i}"
        if target.channel:
            curves.append(_channel(target, known, network, record, at))
        else:
            numbers.append(_number(target, known, network, at))
    for names in ([c.name for c in curves], [n.name for n in numbers if n.value is not None]):
        for name in names:
            if names.count(name) > 1:
                raise InvalidInput(f"{where}.targets: got {name!r} twice; need each once. Take one out.")
    weight = entry.weight if isinstance(entry, Case) else 1.0
    return ResolvedCase(entry.name, scenario, settings, tuple(curves), tuple(numbers), weight, isinstance(entry, Case))


def known_channels(scenario: Scenario, network: Network) -> dict[str, Channel]:
    """Every channel that `simulate_many` can sample of a scenario."""
    return {**channels(network), **total_forces(getattr(scenario, "occupants", ()), network)}


@contextmanager
def _said_of(field: str) -> Iterator[None]:
    """Have what is refused within say of which field of the file it is."""
    try:
        yield
    except UnknownName as unknown:
        raise UnknownName(f"{field}: {unknown}") from None
    except InvalidInput as problem:
        raise InvalidInput(f"{field}: {problem}") from None


def _channel(
    target: Target, known: dict[str, Channel], network: Network, record: TestRecord | None, where: str
) -> ChannelTarget:
    with _said_of(f"{where}.channel"):
        channel = find(known, target.channel)
    duration = float(network.duration.max())
    measured = None
    if target.measured:
        assert record is not None, "checked when the file was read"
        measured = _measured(target, record, channel.unit, where)
    start, end = target.window or (0.0, duration)
    last = duration if measured is None else min(duration, measured.end)
    if target.window is None:
        end = last
    if end > last + 1e-12 or (measured is not None and measured.start > start):
        what = "the simulation" if last == duration else "the recording"
        raise InvalidInput(
            f"{where}.window: got {1e3 * start:g} to {1e3 * end:g} ms; need times within {what}, up to {1e3 * last:g} ms."
        )
    recorded = 0.0 if measured is None or measured.interval is None else measured.interval
    step = max(recorded, (end - start) / _MOST_STEPS) if target.cfc is None else 1.0 / (_STEPS_PER_CLASS * target.cfc)
    step = max(min(step, (end - start) / _FEWEST_STEPS), _FINEST)
    samples = Samples.over(channel, start, end, step, target.cfc, duration)
    values = None if measured is None else np.interp(samples.times, *measured.si)
    independent = float(samples.times.size)
    if target.cfc is not None:
        independent = min(independent, 2.0 * _CORNER * target.cfc * (end - start))
    sigma = np.nan if values is None else EXPECTED_MISFIT * float(np.abs(values).max())
    if target.sigma is not None:
        sigma = number(target.sigma, channel.unit, f"{where}.sigma")
    if values is not None and not sigma > 0.0:
        raise InvalidInput(f"{where}.sigma: got {sigma:g} {channel.unit}; need > 0. Give the channel's standard deviation.")
    peak = np.inf if target.peak is None else number(target.peak, channel.unit, f"{where}.peak")
    if not peak > 0.0:
        raise InvalidInput(f"{where}.peak: got {peak:g} {channel.unit}; need > 0. Give the standard deviation of the peak.")
    return ChannelTarget(target.channel, channel.unit, samples, values, sigma, target.weight, max(independent, 1.0), peak)


def _measured(target: Target, record: TestRecord, unit: str, where: str) -> TimeHistory:
    """The measured channel, or the mean of several, in SI, filtered."""
    with _said_of(f"{where}.measured"):
        histories = [record.history(key) for key in target.measured]
        one = histories[0] if len(histories) == 1 else mean(*histories)
    if units.dimension(one.unit) is not units.dimension(unit):
        raise InvalidInput(
            f"{where}.measured: got a channel in {one.unit!r}; need {units.dimension(unit).called}, as {target.channel!r} is. "
            "Name another channel."
        )
    for key in target.measured if unit in _ALONG_X else ():
        if off := record.channel(key).off_x:
            raise InvalidInput(
                f"{where}.measured: got {key!r}, {off}; need a channel along x, as the model moves. Name that one."
            )
    si = one.converted(unit)
    return si if target.cfc is None else filtered(si, target.cfc)


def _number(target: Target, known: dict[str, Channel], network: Network, where: str) -> NumberTarget:
    with _said_of(f"{where}.outcome"):
        unit = wanted(network, [target.outcome], further=known).units[0]

    def si(field: str) -> Any:
        value = getattr(target, field)
        return None if value is None else number(value, unit, f"{where}.{field}")

    sigma, within, least, most = si("sigma"), si("within"), si("min"), si("max")
    spread = within if sigma is None else sigma
    if spread is not None and not spread > 0.0:
        raise InvalidInput(f"{where}.{'within' if sigma is None else 'sigma'}: got {spread:g} {unit}; need > 0.")
    return NumberTarget(
        name=target.outcome,
        unit=unit,
        value=si("value"),
        sigma=np.nan if spread is None else spread,
        weight=target.weight,
        rounded=within is not None,
        least=-np.inf if least is None else least,
        most=np.inf if most is None else most,
    )
