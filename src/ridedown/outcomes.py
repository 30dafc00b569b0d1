"""What a table of crashes gives back: named columns of outcomes.

<channel>.peak          largest magnitude                      <channel>.peak_time   and when [s]
<channel>.max, .min     largest and smallest value             <channel>.max_time, .min_time
<body>.displacement.final, <body>.velocity.final               at the end
<body>.velocity.change                                         velocity at the end less that at the start
<element>.absorbed      work done on an element [J]            <element>.residual    permanent set of a plastic curve [m]
<element>.paid_out      belt that a load limiter let out [m]
energy.initial, energy.final                                   kinetic energy of all bodies [J]

Channels can be sampled at given times besides.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ridedown.errors import InvalidInput, UnknownName
from ridedown.network import Channel, Family, Law, Network, channels
from ridedown.network.channels import find
from ridedown.network.model import Floats, Ints
from ridedown.solver.solve import Solved, tracked
from ridedown.solver.workspace import Tracked
from ridedown.status import Status

_SENSES = {"peak": 0, "max": 1, "min": -1}
_ENERGIES = ("energy.initial", "energy.final")


@dataclass(frozen=True, slots=True)
class Wanted:
    """Which outcomes are asked for, and what the solver must keep for them."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    tracked: Tracked
    tracked_names: tuple[str, ...]  # "<channel>.<sense>" of each tracked quantity
    channels: Mapping[str, Channel]
    needs_work: bool
    sampled: tuple[str, ...]
    sample_time: Floats  # (T,) s


@dataclass(frozen=True, slots=True, eq=False)
class Outcomes(Mapping[str, Floats]):
    """Outcomes of R crashes: a mapping of names to columns of shape (R,), SI units."""

    columns: dict[str, Floats]
    units: dict[str, str]
    status: Ints
    """Shape (R,): the value of a `Status`; 0 is completed."""
    time: Floats
    """Shape (R,): time reached [s]; the duration, where completed."""
    steps: Ints
    """Shape (R,): steps that the solver took."""
    samples: dict[str, Floats]
    """Channels to their values, shape (R, T), at the times asked for; NaN after a row's own `duration`, completed or
    not, and from where a crash stopped. One row may stand for all, where all are the same."""

    @classmethod
    def empty(cls, plan: Wanted, rows: int) -> Outcomes:
        """Room for the outcomes of so many crashes."""
        return cls(
            {name: np.empty(rows) for name in plan.names},
            dict(zip(plan.names, plan.units, strict=True)),
            np.full(rows, -1, dtype=np.int64),
            np.zeros(rows),
            np.zeros(rows, dtype=np.int64),
            {name: np.empty((rows, plan.sample_time.size)) for name in plan.sampled},
        )

    def fill(self, rows: slice, plan: Wanted, network: Network, solved: Solved) -> None:
        """Put in the rows that were solved."""
        for name in plan.names:
            self.columns[name][rows] = _value(name, plan, network, solved)
        self.status[rows] = solved.stop
        self.time[rows] = solved.time
        self.steps[rows] = solved.steps
        for name, values in zip(plan.sampled, solved.samples, strict=True):
            if rows == slice(0, self.status.size):
                self.samples[name] = values
            else:
                self.samples[name][rows] = values

    @property
    def completed(self) -> NDArray[np.bool_]:
        """Shape (R,): which crashes were solved to their end."""
        completed: NDArray[np.bool_] = self.status == Status.COMPLETED.value
        return completed

    def failures(self) -> dict[str, int]:
        """How many crashes stopped early, by the sentence that says why."""
        codes, counts = np.unique(self.status[~self.completed], return_counts=True)
        return {Status.of(int(code)).sentence: int(count) for code, count in zip(codes, counts, strict=True)}

    def __getitem__(self, name: str) -> Floats:
        """The column of that name. Raises: UnknownName."""
        if name not in self.columns:
            raise UnknownName.among("outcome", name, self.columns)
        return self.columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __len__(self) -> int:
        return len(self.columns)


def wanted(
    network: Network,
    names: Sequence[str] | None,
    sampled: Sequence[str] = (),
    times: ArrayLike | None = None,
    *,
    further: Mapping[str, Channel] | None = None,
) -> Wanted:
    """What the solver must keep for the outcomes of these names, and for channels sampled at `times` [s].

    further: channels that the network itself has not.

    Raises: UnknownName, with the nearest; InvalidInput for times that do not rise, or lie outside the crash.
    """
    every = {**channels(network), **(further or {})}
    if names is None:
        names = _usual(network, every)
    known = dict(_known(network, every))
    for name in names:
        if name not in known:
            raise UnknownName.among("outcome", name, known)
    keys = dict.fromkeys(key for key in (_tracked_key(name) for name in names) if key is not None)
    quantities = [(every[key.rsplit(".", 1)[0]], _SENSES[key.rsplit(".", 1)[1]]) for key in keys]
    grid = _sample_times(network, sampled, times)
    return Wanted(
        names=tuple(names),
        units=tuple(known[name] for name in names),
        tracked=tracked(quantities, [find(every, name) for name in sampled], grid),
        tracked_names=tuple(keys),
        channels=every,
        needs_work=any(name.endswith(".absorbed") for name in names),
        sampled=tuple(sampled),
        sample_time=grid,
    )


def known_outcomes(network: Network, further: Mapping[str, Channel] | None = None) -> dict[str, str]:
    """Every outcome that a network has, with its unit; `further`: channels that the network itself has not."""
    return dict(_known(network, {**channels(network), **(further or {})}))


def _sample_times(network: Network, sampled: Sequence[str], times: ArrayLike | None) -> Floats:
    grid = np.zeros(0) if times is None else np.asarray(times, dtype=np.float64)
    if (times is None) != (not sampled):
        got, need = ("samples without times", "times") if times is None else ("times without samples", "samples")
        raise InvalidInput(f"{need}: got {got}; need both or neither. Name the channels, and say when.")
    end = float(network.duration.min())
    if grid.ndim != 1 or not (np.diff(grid) > 0.0).all() or (grid.size and not 0.0 <= grid[0] <= grid[-1] <= end):
        raise InvalidInput(f"times: got {times!r}; need rising times from 0 to {end:g} s. Sample within the crash.")
    return grid


def _tracked_key(name: str) -> str | None:
    """`channel.sense` of an outcome that is an extreme, or None."""
    stem, kind = name.rsplit(".", 1)
    sense = kind.removesuffix("_time")
    return f"{stem}.{sense}" if sense in _SENSES else None


def _known(network: Network, every: Mapping[str, Channel]) -> Iterator[tuple[str, str]]:
    """Every outcome that a network has, with its unit."""
    for name, channel in every.items():
        for sense in _SENSES:
            yield f"{name}.{sense}", channel.unit
            yield f"{name}.{sense}_time", "s"
        if all(family in {Family.POSITION, Family.RATE} for family, _, _ in channel.terms):
            yield f"{name}.final", channel.unit
        if name.endswith(".velocity"):
            yield f"{name}.change", channel.unit
    for e, element in enumerate(network.elements):
        yield f"{element}.absorbed", "J"
        if _keeps_a_set(network, e):
            yield f"{element}.residual", "m"
        if np.isfinite(network.limit[0, e]).any():
            yield f"{element}.paid_out", "m"
    for name in _ENERGIES:
        yield name, "J"


def _usual(network: Network, every: Mapping[str, Channel]) -> list[str]:
    """The outcomes given where none are asked for: peaks, their times, final speeds, energies."""
    names: list[str] = []
    for i, body in enumerate(network.coordinates):
        if network.is_rotation[i]:
            names.append(f"{body}.peak")
            continue
        names += [f"{body}.acceleration.peak", f"{body}.acceleration.peak_time", f"{body}.displacement.max"]
        names += [n for n in (f"{body}.excursion.max", f"{body}.relative_displacement.max") if n[:-4] in every]
        names.append(f"{body}.velocity.final")
    for e, element in enumerate(network.elements):
        names += [f"{element}.deflection.max", f"{element}.force.max", f"{element}.absorbed"]
        if _keeps_a_set(network, e):
            names.append(f"{element}.residual")
        if np.isfinite(network.limit[0, e]).any():
            names.append(f"{element}.paid_out")
    return [*names, *_ENERGIES]


def _keeps_a_set(network: Network, e: int) -> bool:
    """Whether an element unloads to a permanent set."""
    return bool(network.law[e] == Law.PLASTIC or (network.law[e] == Law.RESTRAINT and (network.stiffness[e] > 0.0).any()))


def _value(name: str, plan: Wanted, network: Network, solved: Solved) -> Floats:
    key = _tracked_key(name)
    if key is not None:
        source = solved.best_time if name.endswith("_time") else solved.best
        return source[plan.tracked_names.index(key)]
    if name == "energy.initial":
        return kinetic_energy(network, network.rate)
    if name == "energy.final":
        return kinetic_energy(network, solved.rate)
    stem, kind = name.rsplit(".", 1)
    if kind == "final":
        state = {Family.POSITION: solved.position, Family.RATE: solved.rate}
        terms = plan.channels[stem].terms
        total: Floats = np.sum([weight * state[family][index] for family, index, weight in terms], axis=0)
        return total
    if kind == "change":
        change: Floats = sum(
            weight * (solved.rate[index] - network.rate[index]) for _, index, weight in plan.channels[stem].terms
        )
        return change
    element = network.elements.index(stem)
    column: Floats = {"absorbed": solved.work, "residual": solved.set, "paid_out": solved.payout}[kind][element]
    return np.maximum(column, 0.0) if kind == "residual" else column


def kinetic_energy(network: Network, rate: Sequence[Floats] | Floats) -> Floats:
    """Kinetic energy of all bodies and bars at these rates of the coordinates, n columns (R,), shape (R,) [J]."""
    absolute = np.array([np.sum([rate[link] for link in network.chain(i)], axis=0) for i in range(len(network.coordinates))])
    energy: Floats = 0.5 * (network.inertia * absolute**2).sum(axis=0)
    return energy
