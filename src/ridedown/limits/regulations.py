"""Regulations as data: what each limits, by how much, for whom, in which clause, and where the numbers were read."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from ridedown import units
from ridedown.errors import InvalidInput, UnknownName
from ridedown.limits.evidence import Person
from ridedown.limits.findings import CRITERIA, OF_VEHICLES


@dataclass(frozen=True, slots=True)
class Limit:
    """One limit: a key of CRITERIA, the most it may be in SI, the dummies (none: any), the level, the clause."""

    criterion: str
    at_most: float
    dummies: tuple[str, ...] = ()
    level: str = ""
    clause: str = ""

    @property
    def of_vehicle(self) -> bool:
        """Whether it limits a vehicle's motion, not an occupant's load."""
        return self.criterion in OF_VEHICLES


@dataclass(frozen=True, slots=True)
class Regulation:
    """A regulation: for "any", "adults", "children" or no occupants ("none"); unjudged: what it asks besides, in words."""

    name: str
    title: str
    occupants: str
    read: str
    limits: tuple[Limit, ...]
    unjudged: tuple[str, ...] = ()
    remark: str = ""

    def refuses(self, person: Person) -> str:
        """Why the regulation does not apply to an occupant; empty if it does, or nothing is known against it."""
        if self.occupants == "children" and person.child is False:
            return f"{self.name} is for children"
        if self.occupants == "adults" and person.child:
            return f"{self.name} is for adults"
        return ""

    def limits_of(self, person: Person) -> tuple[Limit, ...]:
        """The limits for an occupant's dummy; a simulated adult counts as the dummy "lumped adult"."""
        dummy = "lumped adult" if (person.lumped or person.simulated) and not person.child else person.dummy
        return tuple(limit for limit in self.limits if not limit.of_vehicle and (not limit.dummies or dummy in limit.dummies))


def regulations() -> tuple[str, ...]:
    """Names of the regulations known.

    >>> "FMVSS 208" in regulations()
    True
    """
    return tuple(_all())


def regulation(name: str) -> Regulation:
    """A regulation by its name; letter case and spaces do not matter.

    >>> limit = regulation("fmvss208").limits[1]
    >>> limit.criterion, round(limit.at_most / 9.80665, 6), limit.clause
    ('chest_3ms', 60.0, 'S6.3')

    Raises: UnknownName, with the nearest.
    """
    known = {_plain(title): found for title, found in _all().items()}
    if _plain(name) not in known:
        raise UnknownName.among("regulation", name, _all())
    return known[_plain(name)]


def _plain(name: str) -> str:
    return "".join(name.split()).casefold()


@cache
def _all() -> Mapping[str, Regulation]:
    text = files("ridedown.limits").joinpath("regulations.toml").read_text(encoding="utf-8")
    found = [_regulation(table) for table in tomllib.loads(text)["regulation"]]
    return {one.name: one for one in found}


def _regulation(table: dict[str, Any]) -> Regulation:
    limits = tuple(_limit(entry, table["name"]) for entry in table.pop("limits"))
    unjudged = tuple(table.pop("unjudged", ()))
    return Regulation(limits=limits, unjudged=unjudged, **table)


def _limit(entry: dict[str, Any], name: str) -> Limit:
    criterion = entry["criterion"]
    number, _, unit = entry.pop("at_most").partition(" ")
    if criterion not in CRITERIA or unit != CRITERIA[criterion].unit:
        raise InvalidInput(f"{name}.{criterion}: got the unit {unit!r}; need a criterion of CRITERIA in its field unit.")
    at_most = float(units.convert([float(number)], unit)[0]) if unit else float(number)
    return Limit(at_most=at_most, dummies=tuple(entry.pop("dummies", ())), **entry)
