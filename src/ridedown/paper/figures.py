"""Figures 6 to 19 of the paper, redrawn from our simulations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ridedown.paper import cases, numbers
from ridedown.paper.cases import Case, G, Responses
from ridedown.report.style import Plot, draw_line, finish, mark_point, new_axes


@dataclass(frozen=True, slots=True)
class _Quantity:
    label: str
    scale: float  # multiplies SI


_FORCE = _Quantity("force, kN", 1e-3)
_DISPLACEMENT = _Quantity("relative displacement, m", 1.0)
_VELOCITY = _Quantity("velocity, m/s", 1.0)
_ACCELERATION = _Quantity("acceleration, g (negative: braking)", 1.0 / G)


@dataclass(frozen=True, slots=True)
class Figure:
    """One of the paper's figures: its number and caption, the channel it shows, and for which cases."""

    number: int
    title: str
    channel: str
    quantity: _Quantity
    cases: Sequence[Case]


_MOVED = "adult.relative_displacement"
_IN_SEAT = "child.relative_displacement"
_ADULT = (cases.ADULT_FULL, cases.ADULT_OFFSET)
_CHILD = (cases.CHILD_FULL, cases.CHILD_OFFSET)
_STIFFEST_FIRST = cases.STIFFNESS[::-1]

FIGURES = (
    Figure(6, "Impact force f(t), eq. 26, full and offset", "adult.forcing", _FORCE, _ADULT),
    Figure(7, "Impact force f₂(t), eq. 33, full and offset", "child.seat.forcing", _FORCE, _CHILD),
    Figure(8, "Adult, relative displacement, full and offset", _MOVED, _DISPLACEMENT, _ADULT),
    Figure(9, "Adult, velocity, full and offset", "adult.velocity", _VELOCITY, _ADULT),
    Figure(10, "Adult, acceleration, full and offset", "adult.acceleration", _ACCELERATION, _ADULT),
    Figure(11, "Adult, relative displacement, three dampings", _MOVED, _DISPLACEMENT, cases.DAMPING),
    Figure(12, "Adult, velocity, three dampings", "adult.velocity", _VELOCITY, cases.DAMPING),
    Figure(13, "Adult, acceleration, three dampings", "adult.acceleration", _ACCELERATION, cases.DAMPING),
    Figure(14, "Adult, relative displacement, three stiffnesses", _MOVED, _DISPLACEMENT, _STIFFEST_FIRST),
    Figure(15, "Adult, velocity, three stiffnesses", "adult.velocity", _VELOCITY, _STIFFEST_FIRST),
    Figure(16, "Adult, acceleration, three stiffnesses", "adult.acceleration", _ACCELERATION, _STIFFEST_FIRST),
    Figure(17, "Child, displacement in its seat, full and offset", _IN_SEAT, _DISPLACEMENT, _CHILD),
    Figure(18, "Child, velocity, full and offset", "child.velocity", _VELOCITY, _CHILD),
    Figure(19, "Child, acceleration, full and offset", "child.acceleration", _ACCELERATION, _CHILD),
)


def plots(responses: Responses) -> tuple[Plot, ...]:
    """Every figure, drawn from the responses of `cases.run()`."""
    return tuple(_plot(figure, responses) for figure in FIGURES)


def _plot(figure: Figure, responses: Responses) -> Plot:
    title = f"Figure {figure.number}. {figure.title}"
    axes = new_axes(title, xlabel="time, ms", ylabel=figure.quantity.label)
    said = []
    for index, case in enumerate(figure.cases):
        response = responses[case.scenario]
        times = response.drawing_times()
        values = figure.quantity.scale * response.at(figure.channel, times)
        printed = _printed(figure, case)
        peak = response.peak(figure.channel)
        ours = figure.quantity.scale * peak.value
        label = case.label
        if printed is not None:
            label += f": {_read(ours, printed)} (paper {printed.value:g})"
            mark_point(axes, 1e3 * peak.time, ours, index=index)
        said.append(f"{case.label} peaks at {ours:.3g} at {1e3 * peak.time:.0f} ms")
        draw_line(axes, 1e3 * times, values, label=label, index=index)
    axes.set_xlim(0.0, 1e3 * max(responses[case.scenario].end_time for case in figure.cases))
    what = f"{figure.title}; {figure.quantity.label}, against time in milliseconds. " + "; ".join(said) + "."
    return Plot(f"figure-{figure.number:02d}", title, what, finish(axes))


def _printed(figure: Figure, case: Case) -> numbers.Printed | None:
    """The number that the paper prints for this curve, if any."""
    for printed in numbers.PRINTED:
        if printed.figure == figure.number and printed.case.scenario == case.scenario:
            return printed
    return None


def _read(value: float, printed: numbers.Printed) -> str:
    return f"{abs(value):.3f}" if printed.quantity == numbers.DISPLACEMENT else f"{abs(value):.1f}"
