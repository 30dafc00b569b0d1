"""The whole reproduction: simulate and compare."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from ridedown.paper import cases
from ridedown.paper.cases import Responses
from ridedown.paper.numbers import Headline, headlines
from ridedown.paper.trends import Trend, trends

STEPS = len(cases.ALL)
"""How many simulations a reproduction takes."""


@dataclass(frozen=True, slots=True)
class Reproduction:
    """The paper's numbers beside ours, its trends, and the responses that they come from."""

    headlines: tuple[Headline, ...]
    trends: tuple[Trend, ...]
    responses: Responses

    def to_dict(self) -> dict[str, list[dict[str, object]]]:
        """Numbers and trends, ready for JSON."""
        return {"numbers": [h.to_dict() for h in self.headlines], "trends": [t.to_dict() for t in self.trends]}


def reproduce(progress: Callable[[str], None] | None = None) -> Reproduction:
    """Simulate the paper's crashes and compare; `progress` is told the title of each one done."""
    responses = cases.run(progress)
    return Reproduction(headlines(responses), trends(responses), responses)
