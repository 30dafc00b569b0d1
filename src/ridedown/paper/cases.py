"""The crashes behind the paper's section 4, simulated once and shared by the numbers, the trends and the figures."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from ridedown.response import Response
from ridedown.scenario import load
from ridedown.simulation import simulate

G = 9.81
"""The paper's g [m/s2]; everywhere else ridedown uses the standard 9.80665."""


@dataclass(frozen=True, slots=True)
class Case:
    """One of the paper's crashes: what the paper calls it, how a legend does, and its name in the catalogue."""

    title: str
    label: str
    scenario: str


ADULT_FULL = Case("adult, full", "full", "paper-adult-full")
ADULT_OFFSET = Case("adult, offset", "offset", "paper-adult-offset")
CHILD_FULL = Case("child, full", "full", "paper-child-full")
CHILD_OFFSET = Case("child, offset", "offset", "paper-child-offset")
DAMPING = (
    Case("adult, full, damping 10 % of critical", "10 % of critical", "paper-adult-full-damping-10"),
    Case("adult, full, damping 20 % of critical", "20 % of critical", "paper-adult-full-damping-20"),
    Case("adult, full, damping 50 % of critical", "50 % of critical", "paper-adult-full-damping-50"),
)
STIFFNESS = (
    Case("adult, full, k = 19.62 kN/m, 50 % of its critical", "19.62 kN/m", "paper-adult-full-stiffness-19.62"),
    Case("adult, full, k = 39.24 kN/m, 50 % of its critical", "39.24 kN/m", "paper-adult-full-stiffness-39.24"),
    Case("adult, full, k = 98.1 kN/m, 50 % of its critical", "98.1 kN/m", "paper-adult-full-stiffness-98.1"),
)
ALL = (ADULT_FULL, ADULT_OFFSET, CHILD_FULL, CHILD_OFFSET, *DAMPING, *STIFFNESS)

Responses = Mapping[str, Response]
"""Responses by the catalogue name of their scenario."""


def run(progress: Callable[[str], None] | None = None) -> Responses:
    """Simulate every case; `progress`, if given, is told the title of each that is done."""
    responses = {}
    for case in ALL:
        responses[case.scenario] = simulate(load(case.scenario))
        if progress is not None:
            progress(case.title)
    return responses
