"""Figures of a bound: the curve with designs beside it, and the ideal history over the pulse."""

from __future__ import annotations

import numpy as np

from ridedown.criteria.occupant_load import FREE_FLIGHT, RESTRAINED
from ridedown.report.study_axes import LIMIT, Quantity, done, note
from ridedown.report.style import FAINT, INK, PALETTE, Plot, draw_line, new_axes, title_of
from ridedown.report.tables import Column, Table, number
from ridedown.report.tags import Tag, place_tags
from ridedown.studies.bound import Bound, BoundStudy
from ridedown.studies.bound.least_peak import Stage

_MS, _MM = 1e3, 1e3
_PEAK, _WAY = Quantity("peak deceleration", "m/s2"), Quantity("excursion", "m")
_LEAST_TOLD = 1e-4  # s
_BUILT = ("o", "s", "^", "v", "P", "X")


def plots(study: BoundStudy) -> tuple[Plot, ...]:
    """The figures of a study of kind `bound`."""
    return curve_plot(study), history_plot(study), excursion_plot(study)


def curve_plot(study: BoundStudy) -> Plot:
    """The least peak against the excursion, with the designs above it."""
    axes = new_axes("The least peak that any restraint could give", xlabel="excursion, mm", ylabel="peak deceleration, g")
    across = _WAY.shown(study.excursions)
    draw_line(axes, across, _PEAK.shown(study.peaks), label="least possible", index=0)
    axes.fill_between(across, 0.0, _PEAK.shown(study.peaks), color=PALETTE[0], alpha=0.08, linewidth=0.0)
    if not np.array_equal(study.unlimited, study.peaks):
        draw_line(axes, across, _PEAK.shown(study.unlimited), label="the same with no seat behind", index=5, dash=1)
    said = "The least peak deceleration that any restraint could give on this pulse, against the excursion."
    tags: list[Tag] = []
    for k, one in enumerate(study.gaps):
        x, y, least = (
            float(v) for v in (_WAY.shown(one.design.excursion), _PEAK.shown(one.design.peak), _PEAK.shown(one.bound.peak))
        )
        axes.annotate("", (x, least), (x, y), arrowprops={"arrowstyle": "->", "color": FAINT, "linewidth": 1.0})
        axes.plot([x], [y], _BUILT[k % len(_BUILT)], color=PALETTE[1 + k % 4], markersize=8.0, label=one.design.name, zorder=4)
        tags.append(Tag(f"{y:.1f} g; least {least:.1f} g", np.array([x, x]), np.array([least, y]), INK))
        said += f" {one.design.name}: {y:.1f} g within {x:.0f} mm, where {least:.1f} g are possible, {100.0 * one.ratio:.0f} %."
    if study.olc is not None:
        axes.plot(
            [_MM * (FREE_FLIGHT + RESTRAINED)], [_PEAK.shown(study.olc)], "*", color=INK, markersize=10.0, label="OLC", zorder=4
        )
        room = f"{_MM * FREE_FLIGHT:.0f} mm of slack, within {_MM * (FREE_FLIGHT + RESTRAINED):.0f} mm"
        said += f" OLC {_PEAK.text(study.olc)}: the least after {room}."
    axes.set_ylim(0.0, 1.08 * axes.get_ylim()[1])
    axes.set_xlim(left=max(0.0, min(axes.get_xlim()[0], across[0])))
    figure = done(axes)
    # below the curve, where no design can be and none is marked
    axes.legend(loc="lower left", ncols=2, fontsize=9.0, frameon=True, framealpha=0.85, edgecolor="none")
    place_tags(axes, [tags])  # one without a place is in the words and in the table
    return Plot("bound-curve", title_of(axes), said, figure)


def history_plot(study: BoundStudy) -> Plot:
    """Deceleration of the vehicle and of an ideally restrained occupant, against time."""
    ideal = study.ideal
    times = _times(study)
    axes = new_axes(f"Ideal restraint within {_WAY.text(ideal.excursion)}", xlabel="time, ms", ylabel="deceleration, g")
    draw_line(axes, _MS * times, _PEAK.shown(ideal.lead.braking(times)), label="vehicle", index=6, dash=1)
    draw_line(axes, _MS * times, _PEAK.shown(ideal.deceleration(times)), label="occupant", index=0)
    for stage in ideal.stages[1:]:
        axes.axvline(_MS * stage.start, color=FAINT, linewidth=0.6, linestyle=(0, (1, 2)))
    axes.set_xlim(0.0, _MS * times[-1])
    parts = history_in_words(ideal)
    said = f"Peak {ideal.peak_g:.2f} g. {parts[0].upper()}{parts[1:]}. Times a mass it is the ideal force."
    return Plot("bound-history", title_of(axes), said, done(axes))


def history_in_words(ideal: Bound) -> str:
    """What the ideal restraint does, and from when; of stages of a tenth of a millisecond or more, the first six."""
    told: list[Stage] = []
    for stage in ideal.stages:
        if stage.end - stage.start >= _LEAST_TOLD and not (told and told[-1].how is stage.how):
            told.append(stage)
    return "; ".join(f"{stage.how} from {_MS * stage.start:.1f} ms" for stage in told[:6])


def beside_in_words(study: BoundStudy) -> str:
    """What has to be said of designs that are judged by another bound than the curve's; empty where there is none."""
    names = ", ".join(one.design.name for one in study.gaps if one.bound.slack < study.ideal.slack)
    if not names:
        return ""
    return (
        f"The least peak beside {names} is without the slack, and so below the curve: what held a simulated occupant may have "
        "acted before."
    )


def excursion_plot(study: BoundStudy) -> Plot:
    """Where an ideally restrained occupant is in the vehicle, and where one without restraint would be."""
    ideal, times = study.ideal, _times(study)
    axes = new_axes("Where the occupant is", xlabel="time, ms", ylabel="excursion, mm")
    place = _WAY.shown(ideal.excursion_at(times))
    draw_line(axes, _MS * times, place, label="ideally restrained", index=0)
    loose = _WAY.shown(ideal.lead.at(times) - ideal.free.values(times))
    near = loose <= 1.35 * float(_WAY.shown(ideal.excursion)) + 1.0
    draw_line(axes, _MS * times[near], loose[near], label="unrestrained", index=6, dash=1)
    axes.set_xlim(0.0, _MS * times[-1])
    for edge, words, va in ((ideal.excursion, "room in front", "bottom"), (0.0 - ideal.rearward, "seat back", "top")):
        if np.isfinite(edge):
            at = float(_WAY.shown(edge))
            axes.axhline(at, color=LIMIT, linewidth=1.4)
            note(axes, f"{words}, {_WAY.text(edge)}", (_MS * times[-1], at), colour=LIMIT, ha="right", va=va)
    low, high = axes.get_ylim()
    axes.set_ylim(low - 0.1 * (high - low), high)  # for the words below
    said = f"Excursion against time; the room, up to {_WAY.text(ideal.excursion)}, is between the horizontal lines."
    return Plot("bound-excursion", title_of(axes), said, done(axes))


def table(study: BoundStudy) -> Table:
    """The designs beside the bound."""
    columns = (
        Column("Design", numeric=False), Column("Peak", "g"), Column("Excursion", "mm"), Column("Least peak there", "g"),
        Column("Least over peak", "%"), Column("Least excursion for its peak", "mm"),
    )  # fmt: skip
    rows = tuple(
        (
            one.design.name,
            number(float(_PEAK.shown(one.design.peak))),
            number(one.design.excursion, 0, scale=_MM),
            number(one.bound.peak_g),
            number(100.0 * one.ratio, 0),
            number(one.least_excursion, 0, scale=_MM),
        )
        for one in study.gaps
    )
    return Table("Designs beside the bound", columns, rows)


def curve_table(study: BoundStudy) -> Table:
    """The curve in numbers."""
    columns = (Column("Excursion", "mm"), Column("Least peak", "g"), Column("With no seat behind", "g"))
    rows = tuple(
        (number(x, 0, scale=_MM), number(float(_PEAK.shown(y)), 2), number(float(_PEAK.shown(z)), 2))
        for x, y, z in zip(study.excursions, study.peaks, study.unlimited, strict=True)
    )
    return Table("The curve", columns, rows)


def _times(study: BoundStudy) -> np.ndarray:
    ideal = study.ideal
    jumps = np.concatenate((ideal.lead.start, [stage.start for stage in ideal.stages]))
    jumps = jumps[(jumps > 0.0) & (jumps < 1.1 * ideal.end)]
    return np.unique(np.concatenate((np.linspace(0.0, 1.1 * ideal.end, 800), jumps, np.nextafter(jumps, 0.0))))
