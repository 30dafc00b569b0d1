"""A crash before a regulation: value, limit, margin and verdict of every criterion, and what could not be judged, and why."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from enum import Enum
from functools import partial
from typing import TYPE_CHECKING

from ridedown.errors import InvalidInput
from ridedown.limits.evidence import CannotJudge, Evidence, Person, evidence
from ridedown.limits.findings import CRITERIA, OF_OCCUPANTS, OF_VEHICLES, Finding, in_field
from ridedown.limits.regulations import Limit, Regulation, regulation

if TYPE_CHECKING:
    from ridedown.response import Response
    from ridedown.signals.record import TestRecord


_Compute = Mapping[str, Callable[[Evidence, Person], Finding]]
"""What computes each criterion of an occupant, as OF_OCCUPANTS does."""


class Verdict(Enum):
    """What a regulation says to a value."""

    PASSED = "passed"
    FAILED = "failed"
    NOT_JUDGED = "not judged"


@dataclass(frozen=True, slots=True)
class Judgement:
    """One criterion of one occupant or vehicle against one limit, in SI; `unit` is the field's, which `shown` prints in.

    subject: an occupant, a vehicle, or the test. A seat names its vehicle too where more than one has occupants: "01 of vehicle
    2". vehicle: which one the subject is or sits in; empty where none is meant, or none is known.
    criterion: a key of CRITERIA; empty for what a regulation asks besides, which no channel holds.
    margin: what is left to the limit, negative where it is exceeded; value and margin None where there is no value.
    start, end: when [s]. used: the channels. reason: why it was not judged. remarks: what to know about the value.
    """

    subject: str
    criterion: str
    verdict: Verdict
    limit: float | None = None
    unit: str = ""
    level: str = ""
    clause: str = ""
    value: float | None = None
    margin: float | None = None
    start: float | None = None
    end: float | None = None
    used: tuple[str, ...] = ()
    reason: str = ""
    remarks: tuple[str, ...] = ()
    vehicle: str = ""

    def shown(self, number: float | None) -> float | None:
        """A value, limit or margin of this judgement in the field's unit."""
        return None if number is None else in_field(number, self.unit)

    def __str__(self) -> str:
        said = [self.subject]
        if self.criterion:
            said.append(CRITERIA[self.criterion].label + (f" ({self.level})" if self.level else ""))
        value, limit = self.shown(self.value), self.shown(self.limit)
        numbers = [] if value is None else [f"{value:.4g} {self.unit}".rstrip()]
        numbers += [] if limit is None else [f"limit {limit:.6g} {self.unit}".rstrip()]
        outcome = self.verdict.value + (f", {self.reason}" if self.reason else "")
        return ": ".join((*said, ", ".join((*numbers, outcome))))


@dataclass(frozen=True, slots=True)
class Assessment:
    """All judgements of a crash before a regulation."""

    title: str
    regulation: Regulation
    judgements: tuple[Judgement, ...]

    @property
    def passed(self) -> tuple[Judgement, ...]:
        """Those within their limit."""
        return self._with(Verdict.PASSED)

    @property
    def failed(self) -> tuple[Judgement, ...]:
        """Those beyond their limit."""
        return self._with(Verdict.FAILED)

    @property
    def not_judged(self) -> tuple[Judgement, ...]:
        """Those that could not be judged, each with its reason."""
        return self._with(Verdict.NOT_JUDGED)

    def _with(self, verdict: Verdict) -> tuple[Judgement, ...]:
        return tuple(judgement for judgement in self.judgements if judgement.verdict is verdict)

    def __str__(self) -> str:
        return "\n".join((f"{self.title}: {self.regulation.title}", *map(str, self.judgements)))


def assess(source: TestRecord | Response | Evidence, regulation_name: str) -> Assessment:
    """Judge a measured test or a simulated crash by a regulation.

    Measured channels are filtered to the class that SAE J211 names for their place. Where an axis was not measured that would
    only add, the value can fail the limit but not pass it. A simulated occupant is one mass: its chest is judged by the mass's
    acceleration; it has no head, neck, ribs or legs, and those are not judged.

    >>> import numpy as np
    >>> from ridedown.signals.history import TimeHistory
    >>> from ridedown.signals.record import ChannelInfo, Occupant, TestRecord
    >>> t = np.arange(-500, 3000) * 1e-4
    >>> axial = -2500.0 * np.exp(-(((t - 0.07) / 0.02) ** 2))  # N
    >>> history = TimeHistory(axial, "N", start=-0.05, interval=1e-4, name="left femur")
    >>> info = ChannelInfo("1", location="femur_left", quantity="force", axis="z", vehicle=1, occupant="01")
    >>> driver = Occupant("01", 1, "Hybrid III", "50")
    >>> record = TestRecord("sled 7", occupants=(driver,), channels={"1": info}, load=lambda _: history)
    >>> print(assess(record, "FMVSS 208").passed[0])
    01: left femur compression: 2500 N, limit 10008 N, passed

    Raises: UnknownName for a regulation that is not known (see `regulations`).
    """
    return _assess(evidence(source), regulation(regulation_name), OF_OCCUPANTS)


def assess_all(source: TestRecord | Response | Evidence, names: Iterable[str]) -> tuple[Assessment, ...]:
    """Judge a crash by several regulations, as `assess` by each; a criterion that several ask for is computed once.

    Raises: UnknownName for a regulation that is not known.
    """
    have = evidence(source)
    found: dict[tuple[str, str, str], Finding | Exception] = {}

    def once(key: str, have: Evidence, person: Person) -> Finding:
        place = (key, person.vehicle, person.name)
        if place not in found:
            try:
                found[place] = OF_OCCUPANTS[key](have, person)
            except (CannotJudge, InvalidInput) as why:
                found[place] = why
        result = found[place]
        if isinstance(result, Exception):
            raise result
        return result

    compute = {key: partial(once, key) for key in OF_OCCUPANTS}
    return tuple(_assess(have, regulation(name), compute) for name in names)


def _assess(have: Evidence, rule: Regulation, of_occupants: _Compute) -> Assessment:
    judgements: list[Judgement] = []
    if rule.occupants != "none":
        for person in have.people:
            subject = _called(person, have)
            own = _occupant(have, person, rule, of_occupants)
            judgements += [replace(one, subject=subject, vehicle=person.vehicle) for one in own]
        if not have.people:
            judgements.append(Judgement("occupants", "", Verdict.NOT_JUDGED, reason="no occupants in this crash"))
    for limit in rule.limits:
        if limit.of_vehicle:
            judgements += [replace(_vehicle(have, vehicle, limit, rule), vehicle=vehicle) for vehicle in have.vehicles]
    judgements += [Judgement("test", "", Verdict.NOT_JUDGED, reason=f"not in the channels: {words}") for words in rule.unjudged]
    return Assessment(have.title, rule, tuple(judgements))


def _called(person: Person, have: Evidence) -> str:
    """An occupant's name; a seat names its vehicle too where more than one has occupants. A simulation's names are unique."""
    if have.simulated or len({one.vehicle for one in have.people}) < 2:
        return person.name
    return f"{person.name} of vehicle {person.vehicle}"


def _occupant(have: Evidence, person: Person, rule: Regulation, compute: _Compute) -> list[Judgement]:
    against = rule.refuses(person)
    if against:
        return [Judgement(person.name, "", Verdict.NOT_JUDGED, reason=against)]
    limits = rule.limits_of(person)
    if not limits:
        called = person.dummy or ("a lumped child" if person.child else "an occupant without a dummy")
        return [Judgement(person.name, "", Verdict.NOT_JUDGED, reason=f"{rule.name} has no limits here for {called}")]
    found = []
    for limit in limits:
        try:
            finding = compute[limit.criterion](have, person)
        except (CannotJudge, InvalidInput) as why:
            found.append(_without(person.name, limit, str(why)))
            continue
        found.append(_compared(person.name, limit, finding, rule))
    return found


def _vehicle(have: Evidence, vehicle: str, limit: Limit, rule: Regulation) -> Judgement:
    subject = vehicle if not vehicle.isdecimal() else f"vehicle {vehicle}"
    try:
        finding = OF_VEHICLES[limit.criterion](have, vehicle)
    except (CannotJudge, InvalidInput) as why:
        return _without(subject, limit, str(why))
    return _compared(subject, limit, finding, rule)


def _without(subject: str, limit: Limit, reason: str) -> Judgement:
    unit = CRITERIA[limit.criterion].unit
    return Judgement(
        subject, limit.criterion, Verdict.NOT_JUDGED, limit.at_most, unit, limit.level, limit.clause, reason=reason
    )


def _compared(subject: str, limit: Limit, finding: Finding, rule: Regulation) -> Judgement:
    """The judgement: at the limit passes, as all of these regulations say `shall not exceed`."""
    verdict, reason = (Verdict.PASSED, "") if finding.value <= limit.at_most else (Verdict.FAILED, "")
    if finding.indicator:
        verdict, reason = Verdict.NOT_JUDGED, finding.remarks[-1]
    elif finding.at_least and verdict is Verdict.PASSED:
        verdict, reason = Verdict.NOT_JUDGED, "only a lower bound: not every axis is there"
    return Judgement(
        subject,
        limit.criterion,
        verdict,
        limit.at_most,
        CRITERIA[limit.criterion].unit,
        limit.level,
        limit.clause,
        finding.value,
        limit.at_most - finding.value,
        finding.start,
        finding.end,
        finding.used,
        reason,
        finding.remarks + ((rule.remark,) if rule.remark else ()),
    )
