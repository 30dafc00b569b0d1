"""The figures of a run: motion, forces, crush and energy against time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ridedown.report.lines import ACCELERATION, Kind, Line, against_time, bodies, elements
from ridedown.report.style import Plot, draw_line, finish, mark_times, new_axes
from ridedown.response import Response
from ridedown.scenario import SledScenario

Floats = NDArray[np.float64]

MAX_LINES = 7  # one for each colour; a figure with more is not read


def plots(response: Response) -> tuple[Plot, ...]:
    """Every figure that the run has something to show in."""
    return tuple(_plots(response))


def acceleration_plot(response: Response, *, mark_events: bool = True) -> Plot:
    """Acceleration of vehicles and occupants against time: the figure to show first."""
    return _against_time(response, ACCELERATION, bodies(response.scenario, "acceleration"), mark_events=mark_events)


def _plots(response: Response) -> Iterator[Plot]:
    for kind, lines in against_time(response):
        yield _against_time(response, kind, lines)
    if crushing := elements(response.scenario, response.network, crushing=True):
        yield _force_against_crush(response, crushing)
    yield _energy(response)


def _against_time(response: Response, kind: Kind, lines: Sequence[Line], *, mark_events: bool = True) -> Plot:
    axes = new_axes(kind.title, xlabel="time, ms", ylabel=kind.ylabel)
    axes.set_xlim(0.0, 1e3 * response.end_time)
    times = response.drawing_times()
    shown = _largest(response, lines)
    said = []
    for line in shown:
        values = kind.scale * response.at(line.channel, times)
        draw_line(axes, 1e3 * times, values, label=line.label, index=line.index, dash=line.dash)
        peak = response.peak(line.channel)
        said.append(f"{line.label} {_brief(kind.scale * peak.value)} {kind.unit} at {1e3 * peak.time:.1f} ms")
    if mark_events:
        mark_times(axes, [1e3 * event.time for event in response.events])
    what = f"{kind.ylabel[0].upper()}{kind.ylabel[1:]}. "
    if len(shown) < len(lines):
        what += f"The {len(shown)} of {len(lines)} with the largest peaks. "
    return Plot(kind.name, kind.title, f"{what}Peaks: {'; '.join(said)}.", finish(axes))


def _largest(response: Response, lines: Sequence[Line]) -> list[Line]:
    """The lines, or as many of those with the largest peaks as there are colours."""
    if len(lines) <= MAX_LINES:
        return list(lines)
    by_peak = sorted(lines, key=lambda line: -abs(response.peak(line.channel).value))[:MAX_LINES]
    return [replace(line, index=i) for i, line in enumerate(line for line in lines if line in by_peak)]


def _force_against_crush(response: Response, lines: Sequence[Line]) -> Plot:
    title = "Force against crush"
    axes = new_axes(title, xlabel="deflection, mm", ylabel="force, kN")
    times = response.drawing_times(2e-4)
    for line in _largest(response, lines):
        deflection = 1e3 * response.at(line.channel.removesuffix("force") + "deflection", times)
        force = 1e-3 * response.at(line.channel, times)
        pressed = np.where(deflection >= 0.0, force, np.nan)
        draw_line(axes, deflection, pressed, label=line.label, index=line.index)
    return Plot("force-crush", title, "Force of each member against its deflection, as it went.", finish(axes))


def _energy(response: Response) -> Plot:
    title = "Energy"
    axes = new_axes(title, xlabel="time, ms", ylabel="energy, kJ")
    times = response.drawing_times(2e-4)
    kinetic = _kinetic(response, times)
    draw_line(axes, 1e3 * times, 1e-3 * kinetic, label="kinetic energy", index=6, dash=0)
    for i, (label, names) in enumerate(_energy_groups(response).items()):
        taken = 1e-3 * sum(_work(response, name, times) for name in names)
        draw_line(axes, 1e3 * times, taken, label=label, index=i)
    axes.set_xlim(0.0, 1e3 * response.end_time)
    mark_times(axes, [1e3 * event.time for event in response.events])
    what = "Kinetic energy of all bodies, and the work done so far on what crushes, ties and restrains."
    return Plot("energy", title, what, finish(axes))


def _energy_groups(response: Response) -> dict[str, list[str]]:
    """Elements that are shown as one line: a vehicle's members, all restraints; of a network, those that took most."""
    elements = response.network.elements
    if not response.vehicles:
        took = {name: abs(energy.absorbed) for name, energy in response.energy.elements.items()}
        return {name: [name] for name in sorted(elements, key=lambda name: -took[name])[: MAX_LINES - 1]}
    crushed = {} if isinstance(response.scenario, SledScenario) else response.vehicles
    groups = {f"{vehicle}'s members": [f"{vehicle}.right", f"{vehicle}.left"] for vehicle in crushed}
    if restraints := [name for name in elements if name in response.restraints]:
        groups["restraints"] = restraints
    members = {name for group in groups.values() for name in group}
    if joints := [name for name in elements if name not in members]:
        groups["between an occupant's bodies"] = joints
    return groups


def _kinetic(response: Response, times: Floats) -> Floats:
    network = response.network
    total = np.zeros_like(times)
    for i, body in enumerate(network.coordinates):
        rate = f"{body}_rate" if network.is_rotation[i] else f"{body}.velocity"
        total += 0.5 * float(network.inertia[i, 0]) * response.at(rate, times) ** 2
    return total


def _work(response: Response, element: str, times: Floats) -> Floats:
    """Work done on an element so far [J], to the accuracy of a drawing; the balance in the tables is exact."""
    power = response.at(f"{element}.force", times) * response.at(f"{element}.deflection_rate", times)
    steps = 0.5 * (power[1:] + power[:-1]) * np.diff(times)
    return np.concatenate(([0.0], np.cumsum(steps)))


def _brief(value: float) -> str:
    return f"{value:.3g}".replace("-", "\u2212")
