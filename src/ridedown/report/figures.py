"""The figures of a run: motion, forces, crush and energy against time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ridedown.network import Law
from ridedown.report.style import Plot, draw_line, finish, mark_times, new_axes
from ridedown.report.summary import G
from ridedown.response import Response
from ridedown.scenario import NetworkScenario, SledScenario

Floats = NDArray[np.float64]

MAX_LINES = 7  # one for each colour; a figure with more is not read


@dataclass(frozen=True, slots=True)
class _Line:
    label: str
    channel: str
    index: int  # colour and dashes: the same body looks the same in every figure
    dash: int | None = None


@dataclass(frozen=True, slots=True)
class _Kind:
    """A figure against time: file name, title, quantity with unit, factor from SI, and what to say of its peaks."""

    name: str
    title: str
    ylabel: str
    scale: float
    unit: str


_DISPLACEMENT = _Kind("displacement", "Displacement", "displacement, m", 1.0, "m")
_VELOCITY = _Kind("velocity", "Velocity", "velocity, m/s", 1.0, "m/s")
_ACCELERATION = _Kind("acceleration", "Acceleration", "acceleration, g", 1.0 / G, "g")
_EXCURSION = _Kind("excursion", "Excursion of the occupants", "displacement, mm", 1e3, "mm")
_MEMBERS = _Kind("crush-force", "Crush forces", "force, kN", 1e-3, "kN")
_RESTRAINTS = _Kind("restraint-force", "Restraint forces", "force, kN", 1e-3, "kN")
_TIES = _Kind("force", "Forces of springs and dampers", "force, kN", 1e-3, "kN")
_ROTATION = _Kind("bar-rotation", "Rotation of the bumper bar", "angle, degrees", 180.0 / np.pi, "degrees")


def plots(response: Response) -> tuple[Plot, ...]:
    """Every figure that the run has something to show in."""
    return tuple(_plots(response))


def acceleration_plot(response: Response, *, mark_events: bool = True) -> Plot:
    """Acceleration of vehicles and occupants against time: the figure to show first."""
    return _against_time(response, _ACCELERATION, _bodies(response, "acceleration"), mark_events=mark_events)


def _plots(response: Response) -> Iterator[Plot]:
    yield acceleration_plot(response)
    yield _against_time(response, _VELOCITY, _bodies(response, "velocity"))
    yield _against_time(response, _DISPLACEMENT, _bodies(response, "displacement"))
    if excursions := _excursions(response):
        yield _against_time(response, _EXCURSION, excursions)
    crushing, restraining = _elements(response, crushing=True), _elements(response, crushing=False)
    if restraining:
        yield _against_time(response, _RESTRAINTS if response.vehicles else _TIES, restraining)
    if crushing:
        yield _against_time(response, _MEMBERS, crushing)
        yield _force_against_crush(response, crushing)
    yield _energy(response)
    if "bar.rotation" in response.channels:
        yield _against_time(response, _ROTATION, [_Line("bar", "bar.rotation", 6, dash=0)])


def _bodies(response: Response, quantity: str) -> list[_Line]:
    scenario = response.scenario
    if not isinstance(scenario, NetworkScenario):
        vehicles = [name for name in ("vehicle1", "vehicle2") if name in response.vehicles]
        names = {name: i for i, name in enumerate(vehicles)} | _occupant_index(response)
    else:
        names = {body.name: i for i, body in enumerate(scenario.masses)}
    return [_Line(name, f"{name}.{quantity}", i) for name, i in names.items()]


def _occupant_index(response: Response) -> dict[str, int]:
    """The masses of the occupants, each with the number of its colour."""
    names = [f"{name}.{body}" for name, result in response.occupants.items() for body in result.bodies or ("",)]
    return {name.removesuffix("."): 2 + i for i, name in enumerate(names)}


def _excursions(response: Response) -> list[_Line]:
    lines = []
    index = _occupant_index(response)
    for name, i in index.items():
        lines.append(_Line(f"{name}, to the vehicle", f"{name}.excursion", i))
        if response.occupants[name.partition(".")[0]].kind == "child":
            lines.append(_Line(f"{name}, to the seat", f"{name}.relative_displacement", i + len(index)))
    return lines


def _elements(response: Response, *, crushing: bool) -> list[_Line]:
    network = response.network
    curves = {Law.ELASTIC, Law.PLASTIC}
    names = [name for name, law in zip(network.elements, network.law, strict=True) if (law in curves) == crushing]
    indices = range(2, 2 + len(names)) if response.occupants and not crushing else range(len(names))
    return [_Line(name, f"{name}.force", i) for i, name in zip(indices, names, strict=True)]


def _against_time(response: Response, kind: _Kind, lines: Sequence[_Line], *, mark_events: bool = True) -> Plot:
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


def _largest(response: Response, lines: Sequence[_Line]) -> list[_Line]:
    """The lines, or as many of those with the largest peaks as there are colours."""
    if len(lines) <= MAX_LINES:
        return list(lines)
    by_peak = sorted(lines, key=lambda line: -abs(response.peak(line.channel).value))[:MAX_LINES]
    return [replace(line, index=i) for i, line in enumerate(line for line in lines if line in by_peak)]


def _force_against_crush(response: Response, lines: Sequence[_Line]) -> Plot:
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
