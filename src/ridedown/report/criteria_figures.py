"""The figures of a crash's criteria: pulse, velocity, crush, what the occupants bore, and the intervals that count."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb

from ridedown.criteria import STANDARD_GRAVITY
from ridedown.criteria.checks import Floats
from ridedown.criteria.moving import integral
from ridedown.errors import InvalidInput
from ridedown.limits import CRITERIA, Evidence, OccupantCriteria, Person, Pulse, Signals, VehicleCriteria
from ridedown.limits.evidence import MEASURES, CannotJudge
from ridedown.limits.findings import in_field
from ridedown.limits.measured import INTEGRAL_CLASS, SHAPE_CLASS
from ridedown.report.style import PALETTE, Plot, draw_line, finish, mark_point, new_axes
from ridedown.report.tables import number

_MS = 1e3
_BEFORE = -0.02
"""s: as much of a record as is drawn before the first contact."""

_LOADS = {
    "chest deflection": ("Chest deflection", "deflection, mm", 1e3, "mm"),
    "neck axial force": ("Axial force of the upper neck", "force, kN", 1e-3, "kN"),
    "neck moment": ("Moment of the upper neck", "moment, N m", 1.0, "N m"),
}
"""Measures drawn by themselves: title, axis, factor from SI, unit."""


def vehicle_plots(have: Evidence, vehicle: VehicleCriteria) -> tuple[Plot, ...]:
    """Pulse, velocity and crush of a vehicle; none where it has no pulse, no crush where its speed is not known."""
    if not vehicle.used:
        return ()
    return tuple(_vehicle_plots(have, vehicle))


def occupant_plots(have: Evidence, occupant: OccupantCriteria, called: str) -> tuple[Plot, ...]:
    """Head and chest of an occupant, so called, with the intervals of HIC and 3 ms clip, and its other loads, if measured."""
    person = next(one for one in have.people if (one.name, one.vehicle) == (occupant.seat, occupant.vehicle))
    return tuple(_occupant_plots(have, person, occupant, called))


# vehicles


def _vehicle_plots(have: Evidence, vehicle: VehicleCriteria) -> Iterator[Plot]:
    pulse = have.pulse(vehicle.vehicle)
    which = f"vehicle {vehicle.vehicle}" if vehicle.vehicle.isdecimal() else vehicle.vehicle or "vehicle"
    channels = f"Mean of channels {' and '.join(vehicle.used)}" if len(vehicle.used) > 1 else f"Channel {vehicle.used[0]}"
    yield _pulse_plot(vehicle, pulse, which, channels)

    since = pulse.time >= max(0.0, float(pulse.time[0]))
    time = pulse.time[since]
    if time.size < 2:
        return
    velocity = (vehicle.speed or 0.0) + integral(time, pulse.acceleration[since])
    yield _velocity_plot(vehicle, which, channels, time, velocity)
    if vehicle.speed is not None and vehicle.crush is not None:
        yield _crush_plot(vehicle, which, time, velocity)


def _pulse_plot(vehicle: VehicleCriteria, pulse: Pulse, which: str, channels: str) -> Plot:
    axes = _axes(f"Pulse of {which}", "acceleration, g", pulse.time)
    draw_line(axes, _MS * pulse.time, pulse.shape / STANDARD_GRAVITY, label=which, index=0)
    said = f"{channels}, channel class {SHAPE_CLASS}."
    if vehicle.peak is not None:
        peak_g = vehicle.peak.value / STANDARD_GRAVITY
        mark_point(axes, _MS * vehicle.peak.time, peak_g, index=0)
        said += f" Peak {number(peak_g)} g at {_MS * vehicle.peak.time:.1f} ms."
    olc = vehicle.findings.get("olc")
    if olc is not None and olc.start is not None and olc.end is not None:
        olc_g = olc.value / STANDARD_GRAVITY
        braking = float(np.sign(pulse.acceleration[np.argmax(np.abs(pulse.acceleration))]))
        _level(axes, olc.start, olc.end, braking * olc_g, 1, f"OLC {olc_g:.1f} g")
        said += f" OLC {olc_g:.2f} g, from {_MS * olc.start:.1f} to {_MS * olc.end:.1f} ms."
    return Plot(f"{_stem(which)}-pulse", f"Pulse of {which}", said, finish(axes))


def _velocity_plot(vehicle: VehicleCriteria, which: str, channels: str, time: Floats, velocity: Floats) -> Plot:
    title = f"Velocity of {which}" if vehicle.speed is not None else f"Change of velocity of {which}"
    axes = _axes(title, "velocity, km/h", time)
    draw_line(axes, _MS * time, 3.6 * velocity, label=which, index=0)
    said = f"{channels}, channel class {INTEGRAL_CLASS}, integrated from the first contact."
    if vehicle.time_to_zero_velocity is not None:
        mark_point(axes, _MS * vehicle.time_to_zero_velocity, 0.0, index=0)
        said += f" It stands still at {_MS * vehicle.time_to_zero_velocity:.1f} ms."
    if vehicle.delta_v is not None:
        said += f" Delta-v {3.6 * vehicle.delta_v:.1f} km/h."
    return Plot(f"{_stem(which)}-velocity", title, said, finish(axes))


def _crush_plot(vehicle: VehicleCriteria, which: str, time: Floats, velocity: Floats) -> Plot:
    assert vehicle.crush is not None
    crush, at = vehicle.crush
    title = f"Crush of {which}"
    axes = _axes(title, "displacement since contact, mm", time)
    draw_line(axes, _MS * time, 1e3 * integral(time, velocity), label=which, index=0)
    mark_point(axes, _MS * at, 1e3 * crush, index=0)
    said = "Way of the compartment since the first contact, integrated twice."
    said += f" Dynamic crush {1e3 * crush:.0f} mm at {_MS * at:.1f} ms."
    return Plot(f"{_stem(which)}-crush", title, said, finish(axes))


# occupants


def _occupant_plots(have: Evidence, person: Person, occupant: OccupantCriteria, who: str) -> Iterator[Plot]:
    stem = _stem(who)
    if (head := _signals(have, person, "head")) is not None:
        yield _resultant_plot(head, occupant, ("hic15", "hic36"), f"{stem}-head", f"Head of {who}")
    if (chest := _signals(have, person, "chest")) is not None:
        yield _resultant_plot(chest, occupant, ("chest_3ms",), f"{stem}-chest", f"Chest of {who}")
    femurs = {side: found for side in ("left", "right") if (found := _signals(have, person, f"{side} femur")) is not None}
    if femurs:
        axes = _axes(f"Femurs of {who}", "force, kN", next(iter(femurs.values())).time)
        said = []
        for index, (side, signals) in enumerate(femurs.items()):
            draw_line(axes, _MS * signals.time, 1e-3 * signals.values[0], label=side, index=index)
            finding = occupant.findings.get(f"femur_{side}")
            if finding is not None and finding.start is not None:
                mark_point(axes, _MS * finding.start, -1e-3 * finding.value, index=index)
                said.append(f"{side} {1e-3 * finding.value:.2f} kN at {_MS * finding.start:.1f} ms")
        text = f"Axial force, compression negative, channel class 600. Largest compression: {'; '.join(said)}."
        yield Plot(f"{stem}-femurs", f"Femurs of {who}", text, finish(axes))
    for measure, (title, ylabel, scale, unit) in _LOADS.items():
        if (load := _signals(have, person, measure)) is not None:
            yield _load_plot(load, measure, f"{title} of {who}", ylabel, scale, unit, f"{stem}-{_stem(measure)}")


def _resultant_plot(signals: Signals, occupant: OccupantCriteria, keys: tuple[str, ...], name: str, title: str) -> Plot:
    """A resultant with the intervals of its criteria shaded, HIC as a window, a clip at its level."""
    resultant = np.sqrt((signals.values**2).sum(axis=0)) / STANDARD_GRAVITY
    axes = _axes(title, "resultant acceleration, g", signals.time)
    draw_line(axes, _MS * signals.time, resultant, label="resultant" if signals.values.shape[0] > 1 else "magnitude", index=0)
    said = f"{'Resultant' if signals.values.shape[0] > 1 else 'Magnitude'} of channels {', '.join(signals.used)}."
    index = 1
    for key in keys:
        finding = occupant.findings.get(key)
        if finding is None or finding.start is None or finding.end is None:
            continue
        value = in_field(finding.value, CRITERIA[key].unit)
        label = f"{CRITERIA[key].label.split(', ')[-1]} {value:.1f} {CRITERIA[key].unit}".rstrip()
        if CRITERIA[key].unit:
            _held(axes, signals.time, resultant, (finding.start, finding.end, value), index, label)
        else:
            _shade(axes, finding.start, finding.end, index, label)
        said += f" {CRITERIA[key].label} {value:.1f} {CRITERIA[key].unit}".rstrip()
        said += f", {_MS * finding.start:.1f} to {_MS * finding.end:.1f} ms."
        index += 1
    return Plot(name, title, said, finish(axes))


def _load_plot(signals: Signals, measure: str, title: str, ylabel: str, scale: float, unit: str, name: str) -> Plot:
    values = scale * signals.values[0]
    axes = _axes(title, ylabel, signals.time)
    draw_line(axes, _MS * signals.time, values, label=measure, index=0)
    at = int(np.argmax(np.abs(values)))
    mark_point(axes, _MS * float(signals.time[at]), float(values[at]), index=0)
    said = f"Channel {signals.used[0]}, channel class {MEASURES[measure].frequency_class}."
    return Plot(
        name, title, f"{said} Peak {number(float(values[at]), 2)} {unit} at {_MS * signals.time[at]:.1f} ms.", finish(axes)
    )


def _signals(have: Evidence, person: Person, measure: str) -> Signals | None:
    try:
        return have.signals(person, measure)
    except (CannotJudge, InvalidInput):
        return None


# drawing


def _axes(title: str, ylabel: str, time: Floats) -> Axes:
    axes = new_axes(title, xlabel="time, ms", ylabel=ylabel)
    axes.set_xlim(_MS * max(_BEFORE, float(time[0])), _MS * float(time[-1]))
    return axes


def _shade(axes: Axes, start: float, end: float, index: int, label: str) -> None:
    """An interval as a band over the height of the axes, its edges in dashes of its own, so that it shows without colours."""
    colour = PALETTE[index % len(PALETTE)]
    # opaque and pale, the shorter window above the longer: where they overlap its colour is still that of the legend
    axes.axvspan(_MS * start, _MS * end, facecolor=_pale(colour), label=label, zorder=0.4 - 0.1 * index)
    for edge in (start, end):
        axes.axvline(
            _MS * edge, color=colour, linewidth=0.9, linestyle=("-", (0, (5, 3)), (0, (1.5, 1.5)))[index % 3], zorder=1
        )


def _level(axes: Axes, start: float, end: float, level: float, index: int, label: str) -> None:
    """An interval shaded from zero to a level, and the level as a line."""
    colour = PALETTE[index % len(PALETTE)]
    between = [_MS * start, _MS * end]
    axes.fill_between(between, 0.0, level, facecolor=colour, alpha=0.22, zorder=0.5)
    axes.plot(between, [level, level], color=colour, linewidth=1.6, label=label, zorder=3)


def _held(axes: Axes, time: Floats, values: Floats, clip: tuple[float, float, float], index: int, label: str) -> None:
    """The level of a clip over its interval, and what lies above it shaded: the time that counts, in one stretch or several."""
    start, end, level = clip
    colour = PALETTE[index % len(PALETTE)]
    counts = (values >= level) & (time >= start) & (time <= end)
    axes.fill_between(_MS * time, 0.0, values, where=counts.tolist(), facecolor=colour, alpha=0.3, zorder=0.5)
    axes.plot([_MS * start, _MS * end], [level, level], color=colour, linewidth=1.6, label=label, zorder=3)


def _pale(colour: str) -> tuple[float, float, float]:
    """A colour on its way to white, for areas behind lines."""
    red, green, blue = (1.0 - 0.22 * (1.0 - part) for part in to_rgb(colour))
    return red, green, blue


def _stem(text: str) -> str:
    """A name as file names and anchors may have it."""
    return re.sub(r"[^a-z0-9]+", "-", text.casefold()).strip("-") or "unnamed"
