"""Limiting performance: the least peak deceleration that any restraint could give, and how far a restraint is from it.

The vehicle moves as it does. An occupant may get `excursion` ahead of its place in it, and `rearward` behind, where the seat
is; a restraint only brakes, as hard as it likes at any time, knows what is to come, and takes hold once the occupant has moved
`slack`. What is asked for is the least A such that some history of deceleration, never above A, keeps the occupant there during
the pulse, and after it, when the vehicle goes on at the velocity it has left. docs/bound.md derives the solution.

References: E. Sevin, W. D. Pilkey, "Optimum Shock and Vibration Isolation", Shock and Vibration Information Center, 1971;
D. V. Balandin, N. N. Bolotnik, W. D. Pilkey, "Optimal Protection from Impact, Shock and Vibration", Gordon and Breach, 2001.
Both from memory, for the problem; the solution is our own.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ridedown.criteria import STANDARD_GRAVITY, olc
from ridedown.criteria.checks import number
from ridedown.errors import InvalidInput, UnknownName
from ridedown.motion import Source, motion_of
from ridedown.response import Response
from ridedown.scenario.pulse_motion import PulseMotion
from ridedown.studies.bound.lead import Floats, Lead, Unrestrained, crossing
from ridedown.studies.bound.least_peak import How, Least, Proof, Room, Stage, least_peak

_NOT_BELOW_ZERO = math.nextafter(0.0, -1.0)
_PLACE = 1e-9  # m, and parts of a way: what counts as within


@dataclass(frozen=True, eq=False)
class Bound:
    """The least peak deceleration on a pulse within an excursion [m/s2], and the ideal history that has it.

    excursion, rearward, slack [m] and horizon [s]: what was allowed. stages: what the ideal restraint does, and when. proof:
    the instants at which an occupant's place alone shows that nothing does better; None where no restraint is needed. Of
    several ideal histories this is the one that keeps the occupant as far forward as possible.
    """

    peak: float
    excursion: float
    rearward: float
    slack: float
    horizon: float
    stages: tuple[Stage, ...]
    proof: Proof | None
    lead: Lead
    free: Unrestrained

    @property
    def peak_g(self) -> float:
        """The bound [g]."""
        return self.peak / STANDARD_GRAVITY

    @property
    def end(self) -> float:
        """When the ideal history is over [s]: the occupant has the vehicle's velocity, and the pulse has ended."""
        return max([self.lead.end, *(stage.end for stage in self.stages if math.isfinite(stage.end))])

    def deceleration(self, times: ArrayLike) -> Floats:
        """The ideal deceleration [m/s2] at times [s], (n,); at a change of stage, just after it. Times the mass: the force."""
        time = np.atleast_1d(np.asarray(times, dtype=np.float64))
        found = np.zeros(time.size)
        for stage in self.stages:
            here = (time >= stage.start) & (time < stage.end)
            if stage.how is How.HELD:
                found[here] = self.peak
            elif stage.how is How.CARRIED:
                found[here] = self.lead.braking(time[here])
            else:
                found[here] = np.where(self.free.follows_seat(time[here]), self.lead.braking(time[here]), 0.0)
        return found

    def excursion_at(self, times: ArrayLike) -> Floats:
        """The excursion of an ideally restrained occupant [m] at times [s], (n,)."""
        time = np.atleast_1d(np.asarray(times, dtype=np.float64))
        return self.lead.at(time) - self._braked(time)

    def _braked(self, time: Floats) -> Floats:
        """The way behind a free occupant [m]: as far forward as may be, or a parabola from one such place to another."""
        way = np.zeros(time.size)
        for stage in self.stages:
            here = (time >= stage.start) & (time <= stage.end)
            if stage.how is How.HELD:
                ends = np.array([stage.start, stage.end])
                first, last = self._floor(ends)
                since, left = time[here] - stage.start, stage.end - time[here]
                share = since / (stage.end - stage.start)
                way[here] = (1.0 - share) * first + share * last - 0.5 * self.peak * since * left
            else:
                way[here] = self._floor(time[here])
        return way

    def _floor(self, time: Floats) -> Floats:
        floor: Floats = np.maximum(self.free.values(time), self.lead.at(time) - self.excursion)
        return floor

    def as_json(self) -> dict[str, Any]:
        """Plain data for JSON, SI."""
        return {
            "peak_m_s2": self.peak,
            "excursion_m": self.excursion,
            "rearward_m": self.rearward,
            "slack_m": self.slack,
            "horizon_s": self.horizon,
            "stages": [{"does": str(s.how), "start_s": s.start, "end_s": s.end} for s in self.stages],
            "proof_s": None if self.proof is None else [self.proof.start, self.proof.rear, self.proof.front],
        }


class Limiting:
    """The bounds of one pulse, for any excursion.

    source: a sled, a response, a measured acceleration (SAE J211: braking is negative), or a pulse (see `motion_of`); vehicle:
    which, in a response. rearward [m]: room behind the occupant; infinite where no seat is behind it. slack [m]: that the
    occupant moves before a restraint can act. horizon [s]: until when it must be kept; for ever if left out.

    Raises: InvalidInput for a pulse that takes no speed away, or a negative number; UnknownName for a vehicle there is not.

    >>> from ridedown import load
    >>> bound = Limiting(load("sled-half-sine")).bound(0.3)  # 50 km/h in 100 ms
    >>> f"{bound.peak_g:.2f} g, held from {1e3 * bound.proof.start:.1f} to {1e3 * bound.proof.front:.1f} ms"
    '10.99 g, held from 7.2 to 136.0 ms'
    """

    def __init__(
        self,
        source: Source,
        *,
        vehicle: str = "vehicle1",
        rearward: float = 0.0,
        slack: float = 0.0,
        horizon: float | None = None,
    ) -> None:
        self.motion = motion_of(source, vehicle)
        self.lead = Lead.of(self.motion)
        self.rearward = math.inf if rearward == math.inf else number(rearward, "rearward", "m", above=_NOT_BELOW_ZERO)
        self.slack = number(slack, "slack", "m", above=_NOT_BELOW_ZERO)
        self.horizon = math.inf if horizon is None else number(horizon, "horizon", "s", above=0.0)
        if not max(self.lead.taken, float(self.lead.rate(self.lead.cells).max())) > 0.0:
            raise InvalidInput(
                f"pulse: got one that takes {self.lead.taken:.3g} m/s from the vehicle; need one that brakes it. "
                "A braking car has negative acceleration (SAE J211): turn the signs round."
            )

    @cached_property
    def free(self) -> Unrestrained:
        """The occupant that nothing holds."""
        return Unrestrained.of(self.lead, self.rearward)

    def begin(self, excursion: float) -> float | None:
        """When a restraint first matters [s]; None where the occupant never moves as far as the slack.

        Without slack that is when the occupant last was on its seat, whatever held it, before it can have come too far.
        """
        if self.slack > 0.0:
            return self.lead.first_reach(self.slack, self.free)
        if excursion == 0.0 or (reached := self.lead.first_reach(excursion, self.free)) is None:
            return 0.0
        return self.free.last_contact(reached)

    def bound(self, excursion: float) -> Bound:
        """The bound within an excursion [m], which is more than the slack, if there is one."""
        forward = number(excursion, "excursion", "m", above=_NOT_BELOW_ZERO)
        if self.slack > 0.0 and forward <= self.slack:
            raise InvalidInput(
                f"excursion: got {forward:g} m; need > {self.slack:g} m, the slack. A restraint does nothing before it."
            )
        least = Least(0.0, (Stage(How.FREE, 0.0, self.horizon),), None)
        begin = self.begin(forward)
        if begin is not None and begin < self.horizon:
            least = least_peak(Room(self.lead, self.free, forward, self.rearward, begin, self.horizon))
        return Bound(
            least.level, forward, self.rearward, self.slack, self.horizon, least.stages, least.proof, self.lead, self.free
        )

    def peaks(self, excursions: ArrayLike) -> Floats:
        """The bounds [m/s2] within excursions [m], (n,): the whole curve."""
        return np.array([self.bound(float(excursion)).peak for excursion in np.asarray(excursions, dtype=np.float64)])

    def least_excursion(self, peak: float) -> float:
        """The least excursion [m] within which a peak deceleration [m/s2] is possible; the slack, where it is possible at once.

        Bounds fall with the excursion, and ever more slowly: the one is found from the other.

        Raises: InvalidInput for a peak that is not above 0.
        """
        level = number(peak, "peak", "m/s2", above=0.0)

        def over(excursion: float) -> float:
            return self.bound(excursion).peak - level

        low, high = self.slack, max(2.0 * self.slack, 0.05)
        if self.slack == 0.0 and over(0.0) <= 0.0:
            return 0.0
        while over(high) > 0.0:
            low, high = high, 2.0 * high
        while low == self.slack > 0.0 and over(middle := 0.5 * (low + high)) <= 0.0:
            high = middle
        low = 0.5 * (low + high) if low == self.slack > 0.0 else low
        return crossing(over, low, high)


@dataclass(frozen=True, slots=True)
class Design:
    """A restraint by what it did: name, peak deceleration [m/s2], and excursions forward and, before that, rearward [m]."""

    name: str
    peak: float
    excursion: float
    rearward: float = 0.0


@dataclass(frozen=True, eq=False)
class Gap:
    """How far a design is from the bound.

    least_excursion [m]: within which its peak would be possible. holds: whether the design itself kept to what the proof asks,
    so that its peak cannot be below the bound; None where only its numbers are known.
    """

    design: Design
    bound: Bound
    least_excursion: float
    holds: bool | None = None

    @property
    def ratio(self) -> float:
        """The bound over the design's peak: 1 for an ideal restraint."""
        return self.bound.peak / self.design.peak

    @property
    def excess(self) -> float:
        """What the design's peak is above the bound [m/s2]."""
        return self.design.peak - self.bound.peak


def limiting_performance(source: Source, excursion: float, **options: Any) -> Bound:
    """The least peak deceleration that any restraint could give on a pulse within an excursion [m]. options: as `Limiting`.

    >>> from ridedown import load
    >>> limiting_performance(load("sled-half-sine"), 0.3).stages[1].how
    <How.HELD: 'held'>
    """
    return Limiting(source, **options).bound(excursion)


def gap(limiting: Limiting, design: Design) -> Gap:
    """How far a design, known by its numbers, is from the bound of its pulse."""
    return Gap(design, limiting.bound(design.excursion), limiting.least_excursion(design.peak))


def gap_of(response: Response, body: str | None = None, *, name: str = "") -> Gap:
    """How far the restraint of a body in a simulation is from the bound of its vehicle's pulse, within its own excursion.

    body: an occupant, the first if left out (of several masses, its centre of mass), or one of its masses, as
    `driver.chest`. The room is what the body itself used, forward and, until it was farthest forward, rearward; the horizon is
    what was simulated.

    Raises: UnknownName for a body that is no occupant's; InvalidInput where there is no occupant, or nothing braked it.

    >>> from ridedown import load, simulate
    >>> found = gap_of(simulate(load("sled-half-sine")))
    >>> f"{found.bound.peak_g:.1f} of {found.design.peak / STANDARD_GRAVITY:.1f} g: {found.ratio:.2f}"
    '12.7 of 26.7 g: 0.48'
    """
    occupants = list(response.occupants)
    if not occupants:
        raise InvalidInput("body: got a scenario without occupants; need one. Bounds are those of an occupant's deceleration.")
    body = occupants[0] if body is None else body
    known = [channel.removesuffix(".excursion") for channel in response.channels if channel.endswith(".excursion")]
    if body not in known:
        raise UnknownName.among("body", body, known)
    vehicle = response.occupants[body.partition(".")[0]].vehicle
    motion = motion_of(response, vehicle)
    peak = -response.minimum(f"{body}.acceleration").value
    if not peak > 0.0:
        raise InvalidInput(f"body: got {body}, which nothing brakes; need an occupant that is restrained. Take another.")
    channel = f"{body}.excursion"
    farthest = response.maximum(channel)
    time, place = response.history(channel).si
    before = max(0.0, -float(place[time <= farthest.time].min()))
    for rearward in (before, max(before, -response.minimum(channel).value)):
        limiting = Limiting(motion, rearward=rearward, horizon=response.end_time)
        bound = limiting.bound(max(0.0, farthest.value))
        holds = _holds(response, channel, bound)
        if holds:
            break
    design = Design(name or body, peak, bound.excursion, limiting.rearward)
    return Gap(design, bound, limiting.least_excursion(peak), holds)


def _holds(response: Response, channel: str, bound: Bound) -> bool:
    """Whether a body was where the proof needs it to be."""
    if bound.proof is None:
        return True
    start, rear = bound.proof.start, bound.proof.rear
    way = float(bound.lead.at(start)) - float(response.at(channel, start))
    floor = min(bound.free.at(start), float(bound.lead.at(start)) - bound.excursion)
    not_ahead = way >= floor - _PLACE * (1.0 + abs(floor))
    return not_ahead and (rear is None or float(response.at(channel, rear)) >= -bound.rearward - _PLACE)


@dataclass(frozen=True, eq=False)
class BoundStudy:
    """What a study of kind `bound` finds.

    excursions [m] and peaks [m/s2], (n,): the curve. unlimited (n,): the same with no seat behind the occupant. ideal: the
    bound at one excursion, with its history. gaps: the designs beside it. olc [m/s2]: of the pulse, or None.
    """

    name: str
    motion: PulseMotion
    excursions: Floats
    peaks: Floats
    unlimited: Floats
    ideal: Bound
    gaps: tuple[Gap, ...]
    olc: float | None

    def as_json(self) -> dict[str, Any]:
        """Plain data for JSON, SI."""
        return {
            "name": self.name,
            "excursions_m": self.excursions.tolist(),
            "peaks_m_s2": self.peaks.tolist(),
            "peaks_without_seat_m_s2": self.unlimited.tolist(),
            "ideal": self.ideal.as_json(),
            "olc_m_s2": self.olc,
            "designs": [
                {
                    "name": one.design.name,
                    "peak_m_s2": one.design.peak,
                    "excursion_m": one.design.excursion,
                    "bound_m_s2": one.bound.peak,
                    "ratio": one.ratio,
                    "least_excursion_m": one.least_excursion,
                }
                for one in self.gaps
            ],
        }


def bound_study(
    source: Source,
    excursions: ArrayLike,
    *,
    designs: Sequence[Design | Gap] = (),
    excursion: float | None = None,
    name: str = "",
    vehicle: str = "vehicle1",
    rearward: float = 0.0,
    slack: float = 0.0,
    horizon: float | None = None,
) -> BoundStudy:
    """The curve of the least peak against the excursion, one ideal history, and designs beside them.

    excursions [m]: rising, (n,). designs: by their numbers, or as `gap_of` finds them. excursion [m]: of the ideal history; of
    the first design, or the middle of the excursions, if left out. Others: as `Limiting`.

    >>> from ridedown import load
    >>> study = bound_study(load("sled-half-sine"), [0.1, 0.2, 0.3], designs=[Design("belt", 300.0, 0.25)])
    >>> (study.peaks / STANDARD_GRAVITY).round(2), round(study.gaps[0].ratio, 3), round(study.gaps[0].least_excursion, 3)
    (array([15.01, 12.62, 10.99]), 0.384, 0.0)
    """
    limiting = Limiting(source, vehicle=vehicle, rearward=rearward, slack=slack, horizon=horizon)
    grid = np.asarray(excursions, dtype=np.float64)
    if grid.ndim != 1 or grid.size < 2 or not (np.diff(grid) > 0.0).all():
        raise InvalidInput(f"excursions: got {excursions!r}; need two or more that rise [m]. Sort them.")
    gaps = tuple(design if isinstance(design, Gap) else gap(limiting, design) for design in designs)
    if excursion is None:
        excursion = gaps[0].design.excursion if gaps else float(grid[grid.size // 2])
    open_behind = Limiting(limiting.motion, rearward=math.inf, slack=slack, horizon=horizon)
    time, acceleration, *_ = limiting.motion.knots(1e-6)
    return BoundStudy(
        name=name,
        motion=limiting.motion,
        excursions=grid,
        peaks=limiting.peaks(grid),
        unlimited=open_behind.peaks(grid),
        ideal=limiting.bound(excursion),
        gaps=gaps,
        olc=olc(time, acceleration, start=0.0).value,
    )
