"""The distributions that there are, by the kind that a study file names."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator, Discriminator, Tag

from ridedown.scenario.base import of_known_kind
from ridedown.studies.distributions.bounded import Triangular, Uniform
from ridedown.studies.distributions.discrete import Discrete
from ridedown.studies.distributions.distribution import Distribution
from ridedown.studies.distributions.normal import LogNormal, Normal, TruncatedNormal

KINDS: dict[str, type[Distribution]] = {
    "normal": Normal,
    "truncated-normal": TruncatedNormal,
    "lognormal": LogNormal,
    "uniform": Uniform,
    "triangular": Triangular,
    "discrete": Discrete,
}


def _known(value: object) -> object:
    """A distribution, or a table with a kind that there is."""
    return of_known_kind(value, Distribution, KINDS, "a table with the kind of distribution")


def _which(value: Any) -> str:
    kind = type(value) if isinstance(value, Distribution) else KINDS[value["kind"]]
    return f"({kind.__name__.lower()})"


AnyDistribution = Annotated[
    Annotated[Normal, Tag("(normal)")]
    | Annotated[TruncatedNormal, Tag("(truncatednormal)")]
    | Annotated[LogNormal, Tag("(lognormal)")]
    | Annotated[Uniform, Tag("(uniform)")]
    | Annotated[Triangular, Tag("(triangular)")]
    | Annotated[Discrete, Tag("(discrete)")],
    Discriminator(_which),
    BeforeValidator(_known),
]
"""A field of a study file that holds a distribution of any kind."""
