"""What the paper says of its figures, put to the test on our simulations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ridedown.paper import cases
from ridedown.paper.cases import Case, G, Responses
from ridedown.response import Response

_GRID = 4001  # times at which a curve is read where its peak is not enough

INFLUENCE = 0.2
"""Velocity curves that part by less than this fraction of the initial speed "hardly" differ (fig 12); by more,
"significantly" (fig 15). The bound is ours: the paper prints none."""


@dataclass(frozen=True, slots=True)
class Trend:
    """A statement about a figure, whether it holds, and the values that say so."""

    figure: int
    trend: str
    holds: bool
    evidence: str

    def to_dict(self) -> dict[str, object]:
        """Ready for JSON."""
        return {"figure": self.figure, "trend": self.trend, "holds": self.holds}


def trends(responses: Responses) -> tuple[Trend, ...]:
    """Every trend of the paper's section 4, in the order of its figures."""
    found = [
        *_forcing(responses),
        *_offset_against_full("adult", cases.ADULT_FULL, cases.ADULT_OFFSET, (8, 9, 10), responses),
        *_damping(responses),
        *_stiffness(responses),
        *_offset_against_full("child", cases.CHILD_FULL, cases.CHILD_OFFSET, (17, 18, 19), responses),
    ]
    return tuple(sorted(found, key=lambda trend: trend.figure))


def pulse_length(response: Response, body: str) -> float:
    """For how long a body is slowed by more than half of its own peak [s]."""
    times = np.linspace(0.0, response.end_time, _GRID)
    braking = np.abs(response.at(f"{body}.acceleration", times))
    above = braking > 0.5 * abs(response.peak(f"{body}.acceleration").value)
    return float(np.count_nonzero(above) * response.end_time / (_GRID - 1))


def _forcing(responses: Responses) -> list[Trend]:
    """Figures 6 and 7: the paper says no more of them than that the offset vehicle stops later (of fig 9)."""
    found = []
    for figure, channel, full, offset in (
        (6, "adult.forcing", cases.ADULT_FULL, cases.ADULT_OFFSET),
        (7, "child.seat.forcing", cases.CHILD_FULL, cases.CHILD_OFFSET),
    ):
        name = "f(t)" if figure == 6 else "f₂(t)"
        times = [1e3 * responses[case.scenario].peak(channel).time for case in (full, offset)]
        found.append(
            Trend(
                figure,
                f"{name} peaks later in the offset collision than in the full one",
                times[1] > times[0],
                f"full {times[0]:.1f} ms, offset {times[1]:.1f} ms",
            )
        )
    return found


def _offset_against_full(
    body: str, full: Case, offset: Case, figures: tuple[int, int, int], responses: Responses
) -> list[Trend]:
    one, other = responses[full.scenario], responses[offset.scenario]
    displacement = [_displacement(r, body) for r in (one, other)]
    stop = [_time_to_rest(r, body) for r in (one, other)]
    acceleration = [_acceleration(r, body) for r in (one, other)]
    return [
        Trend(
            figures[0],
            f"the {body} moves less in the offset collision than in the full one",
            displacement[1] < displacement[0],
            f"full {displacement[0]:.3f} m, offset {displacement[1]:.3f} m",
        ),
        Trend(
            figures[1],
            f"the {body} takes longer to stop in the offset collision than in the full one",
            stop[1] > stop[0],
            f"full {1e3 * stop[0]:.1f} ms, offset {1e3 * stop[1]:.1f} ms",
        ),
        Trend(
            figures[2],
            f"the {body} is slowed less hard in the offset collision than in the full one",
            acceleration[1] < acceleration[0],
            f"full {acceleration[0]:.1f} g, offset {acceleration[1]:.1f} g",
        ),
    ]


def _damping(responses: Responses) -> list[Trend]:
    runs = [responses[case.scenario] for case in cases.DAMPING]
    displacement = [_displacement(r, "adult") for r in runs]
    acceleration = [_acceleration(r, "adult") for r in runs]
    spread = _velocity_spread(runs, "adult")
    return [
        Trend(11, "more damping, less displacement (10, 20, 50 %)", _falls(displacement), _listed(displacement, "m", 3)),
        Trend(
            12,
            f"damping hardly changes the velocity (by less than {INFLUENCE:.0%} of the initial one until all stop)",
            spread < INFLUENCE,
            f"at most {spread:.0%}",
        ),
        Trend(13, "more damping, less acceleration (10, 20, 50 %)", _falls(acceleration), _listed(acceleration, "g", 1)),
    ]


def _stiffness(responses: Responses) -> list[Trend]:
    runs = [responses[case.scenario] for case in cases.STIFFNESS]
    displacement = [_displacement(r, "adult") for r in runs]
    acceleration = [_acceleration(r, "adult") for r in runs]
    length = [1e3 * pulse_length(r, "adult") for r in runs]
    spread = _velocity_spread(runs, "adult")
    series = "19.62, 39.24, 98.1 kN/m"
    return [
        Trend(14, f"more stiffness, less displacement ({series})", _falls(displacement), _listed(displacement, "m", 3)),
        Trend(
            15,
            f"stiffness changes the velocity (by more than {INFLUENCE:.0%} of the initial one until all stop)",
            spread > INFLUENCE,
            f"at most {spread:.0%}",
        ),
        Trend(
            16,
            f"more stiffness, more acceleration ({series})",
            _falls(acceleration[::-1]),
            _listed(acceleration, "g", 1),
        ),
        Trend(
            16,
            f"more stiffness, a shorter pulse, counted above half of its own peak ({series})",
            _falls(length),
            _listed(length, "ms", 0),
        ),
    ]


def _displacement(response: Response, body: str) -> float:
    return response.maximum(f"{body}.relative_displacement").value


def _acceleration(response: Response, body: str) -> float:
    return abs(response.peak(f"{body}.acceleration").value) / G


def _time_to_rest(response: Response, body: str) -> float:
    """When a body stops [s]; the end of the simulation if it does not."""
    time = response.time_to_rest(body)
    return response.end_time if time is None else time


def _velocity_spread(runs: Sequence[Response], body: str) -> float:
    """How far the velocities part until the last one is zero, as a fraction of the initial velocity."""
    times = np.linspace(0.0, max(_time_to_rest(r, body) for r in runs), _GRID)
    curves: NDArray[np.float64] = np.array([r.at(f"{body}.velocity", times) for r in runs])
    return float(np.ptp(curves, axis=0).max() / curves[0, 0])


def _falls(values: Sequence[float]) -> bool:
    return all(later < earlier for earlier, later in pairwise(values))


def _listed(values: Sequence[float], unit: str, digits: int) -> str:
    return ", ".join(f"{value:.{digits}f}" for value in values) + f" {unit}"
