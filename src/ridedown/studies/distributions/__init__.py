"""What a parameter of a study may be distributed like."""

from __future__ import annotations

from ridedown.studies.distributions.bounded import Triangular, Uniform
from ridedown.studies.distributions.discrete import Discrete
from ridedown.studies.distributions.distribution import Distribution
from ridedown.studies.distributions.kinds import KINDS, AnyDistribution
from ridedown.studies.distributions.normal import LogNormal, Normal, TruncatedNormal

__all__ = [
    "KINDS",
    "AnyDistribution",
    "Discrete",
    "Distribution",
    "LogNormal",
    "Normal",
    "Triangular",
    "TruncatedNormal",
    "Uniform",
]
