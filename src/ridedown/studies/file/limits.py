"""The limits of a study file, read in the units of its outcomes."""

from __future__ import annotations

from ridedown.errors import InvalidInput, UnknownName
from ridedown.scenario.quantities import Refused, read
from ridedown.studies.analysis.evaluation import Limit
from ridedown.studies.file.study import Study
from ridedown.units import dimension


def limits_of(study: Study, units: dict[str, str]) -> tuple[Limit, ...]:
    """The limits of a study in SI: each on one outcome, for every scenario that has it, from one side.

    Raises: UnknownName for an outcome that the study does not keep; InvalidInput for a value of another dimension.
    """
    found: list[Limit] = []
    for i, limit in enumerate(study.limits):
        names = [name for name in units if name == limit.outcome]
        names = names or [name for name in units if name.partition(".")[2] == limit.outcome]
        if not names:
            raise UnknownName(f"limits.{i}.{UnknownName.among('outcome', limit.outcome, units)} List it under outcomes too.")
        for side in ("most", "least"):
            given = getattr(limit, side)
            if given is not None:
                value = value_of(f"limits.{i}.{side}", given, units[names[0]])
                found += [Limit(name, **{side: value}) for name in names]
    return tuple(found)


def value_of(where: str, given: float | str, unit: str) -> float:
    """A value of an outcome with this SI unit, bare SI or with a unit, in SI. Raises: InvalidInput."""
    if isinstance(given, str) and unit:
        try:
            return read(given, dimension(unit))
        except Refused as refused:
            raise InvalidInput(f"{where}: {refused}") from None
    if isinstance(given, str):
        raise InvalidInput(f'{where}: got "{given}"; need a bare number. This outcome has no unit.')
    return float(given)
