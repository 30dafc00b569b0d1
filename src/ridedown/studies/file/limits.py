"""The limits of a study file, read in the units of its outcomes."""

from __future__ import annotations

from typing import Protocol

from ridedown.errors import InvalidInput, UnknownName
from ridedown.scenario.quantities import Refused, read
from ridedown.studies.analysis.evaluation import Limit
from ridedown.studies.file.study import Study
from ridedown.units import FRACTION, dimension

_SIDES = ("most", "least")


class Bounds(Protocol):
    """What an outcome may be at most, at least, or both, as a file has it."""

    @property
    def most(self) -> float | str | None:
        """Largest value allowed."""
        ...

    @property
    def least(self) -> float | str | None:
        """Smallest value allowed."""
        ...


def limits_of(study: Study, units: dict[str, str]) -> tuple[Limit, ...]:
    """The limits of a study in SI: each on one outcome, for every scenario that has it, from one side.

    Raises: UnknownName for an outcome that the study does not keep; InvalidInput for a value of another dimension.
    """
    found: list[Limit] = []
    for i, limit in enumerate(study.limits):
        names = [name for name in units if name == limit.outcome]
        names = names or [name for name in units if name.partition(".")[2] == limit.outcome]
        if not names:
            raise UnknownName.among(f"limits.{i}.outcome", limit.outcome, units)
        bounds = bounds_of(f"limits.{i}", limit, units[names[0]])
        found += [Limit(name, **{side: value}) for side, value in bounds.items() for name in names]
    return tuple(found)


def bounds_of(where: str, given: Bounds, unit: str) -> dict[str, float]:
    """The sides that are given, `most`, `least` or both, in SI.

    Raises: InvalidInput for a value of another dimension, or sides that nothing can hold at once.
    """
    sides = {side: value_of(f"{where}.{side}", value, unit) for side in _SIDES if (value := getattr(given, side)) is not None}
    if len(sides) == 2 and sides["least"] > sides["most"]:
        raise InvalidInput(
            f"{where}.least: got {given.least}, above most, {given.most}; need least <= most. No design could hold both."
        )
    return sides


def value_of(where: str, given: float | str, unit: str) -> float:
    """A value of an outcome with this SI unit, bare SI or with a unit, in SI. Raises: InvalidInput."""
    if not isinstance(given, str):
        return float(given)
    try:
        return read(given, dimension(unit) if unit else FRACTION)
    except Refused as refused:
        bare = f'got "{given}"; need a bare number, or one with %. This outcome has no unit.'
        raise InvalidInput(f"{where}: {refused if unit else bare}") from None
