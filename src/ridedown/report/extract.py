"""An extraction to look at: tables, figures of measured against model, one page, a folder of files."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ridedown.criteria import STANDARD_GRAVITY
from ridedown.criteria.checks import Floats
from ridedown.report.jsontext import json_text
from ridedown.report.page import render
from ridedown.report.pdf import Document, Part
from ridedown.report.pdf import pdf as set_on_paper
from ridedown.report.style import Plot, draw_line, finish, mark_point, new_axes
from ridedown.report.tables import NONE, Column, Table, number
from ridedown.scenario.networks import Tie
from ridedown.studies.extraction.extract import Extraction, Front, reached
from ridedown.studies.extraction.fit import measured_curve

_KMH, _MS = 3.6, 1e3
_MEASURED, _ONE, _TWO = 6, 1, 0  # colours of the palette
_NAMES = {"front": "front, one mass", "rails": "rails", "block": "engine block", "firewall": "firewall"}
_TO = {"front": "wall to car", "rails": "wall to cabin", "block": "wall to engine", "firewall": "engine to cabin"}


def fronts(found: Extraction) -> tuple[tuple[str, Front], ...]:
    """The fronts found, each with what it is called."""
    one = (("one mass", found.one),)
    return one if found.two is None else (*one, ("cabin and engine", found.two))


def outcome_table(found: Extraction) -> Table:
    """What was measured, and what each front reaches."""
    test = found.test
    columns = (
        Column("", numeric=False),
        Column("crush", "mm"),
        Column("at", "ms"),
        Column("rebound", "km/h"),
        Column("restitution"),
        Column("peak", "g"),
        Column("cabin rating"),
        Column("wall force rating"),
    )
    measured = (
        "measured",
        number(test.crush, 1, scale=1e3),
        number(test.stop, 1, scale=_MS),
        number(test.rebound, 2, scale=_KMH),
        number(None if test.rebound is None else test.rebound / test.speed, 3),
        number(test.peak / STANDARD_GRAVITY, 1),
        NONE,
        NONE,
    )
    rows = tuple(
        (
            name,
            number(front.simulated.crush, 1, scale=1e3),
            number(front.simulated.stop, 1, scale=_MS),
            number(front.simulated.rebound, 2, scale=_KMH),
            number(front.simulated.rebound / test.speed, 3),
            number(-float(front.simulated.acceleration.min()) / STANDARD_GRAVITY, 1),
            number(front.cabin.value, 3),
            number(None if front.barrier is None else front.barrier.value, 3),
        )
        for name, front in fronts(found)
    )
    return Table("Measured and reached; ratings by ISO/TS 18571", columns, (measured, *rows))


def structure_table(found: Extraction) -> Table:
    """The curves of the best front, point by point."""
    rows = []
    for name, curve in found.best.curves.items():
        unloading = number(curve.unloading_stiffness, 2, scale=1e-6)
        for i, (deflection, force) in enumerate(curve.points or ()):
            first = i == 0
            called = (_NAMES.get(name, name), _TO.get(name, ""), unloading) if first else ("", "", "")
            rows.append((called[0], called[1], number(deflection, 1, scale=1e3), number(force, 1, scale=1e-3), called[2]))
    columns = (Column("element", numeric=False), Column("between", numeric=False), Column("deflection", "mm"))
    return Table(
        "The structure: force against deflection, straight between the points",
        (*columns, Column("force", "kN"), Column("unloading", "MN/m")),
        tuple(rows),
    )


def masses_table(found: Extraction) -> Table:
    """Cabin and engine, and the mounts between them; no row for one mass."""
    scenario = found.best.scenario
    columns = (Column("", numeric=False), Column("mass", "kg"), Column("stiffness", "kN/m"), Column("damping", "kN s/m"))
    masses = getattr(scenario, "masses", ())
    ties = [element for element in getattr(scenario, "elements", ()) if isinstance(element, Tie)]
    rows = [(body.name, number(body.mass, 1), NONE, NONE) for body in masses]
    rows += [(tie.name, NONE, number(tie.stiffness, 1, scale=1e-3), number(tie.damping, 2, scale=1e-3)) for tie in ties]
    return Table("Masses and mounts", columns, tuple(rows))


def tables(found: Extraction) -> tuple[Table, ...]:
    """All tables that have rows."""
    return tuple(table for table in (outcome_table(found), masses_table(found), structure_table(found)) if table.rows)


def notes(found: Extraction) -> tuple[str, ...]:
    """What was reached and how the channels were chosen, in sentences."""
    used = (
        f"Cabin: mean of channels {', '.join(found.test.used)}; {found.test.mass:.6g} kg at {3.6 * found.test.speed:.4g} km/h."
    )
    said = (f"{text[:1].upper()}{text[1:]}".rstrip(".") + "." for text in found.test.notes)
    return (*reached(found), used, *said)


# figures


def plots(found: Extraction) -> tuple[Plot, ...]:
    """Measured against model over time, and force against deflection."""
    return tuple(_plots(found))


def _plots(found: Extraction) -> Iterator[Plot]:
    test = found.test
    yield _against_time(
        found,
        "cabin-acceleration",
        "Acceleration of the cabin",
        "acceleration, g",
        test.acceleration / STANDARD_GRAVITY,
        [front.simulated.acceleration / STANDARD_GRAVITY for _, front in fronts(found)],
        "Channel class 60, the model filtered as the test is.",
    )
    if test.barrier is not None:
        yield _against_time(
            found,
            "barrier-force",
            "Force on the wall",
            "force, kN",
            1e-3 * test.barrier,
            [1e-3 * front.simulated.barrier for _, front in fronts(found)],
            "Channel class 60. One mass can only press with its own mass times its deceleration.",
        )
    since = test.time >= 0.0
    times = test.time[since]
    bodies = ["vehicle1" if front.engine_mass is None else "cabin" for _, front in fronts(found)]
    for stem, title, label, scale, measured in (
        ("velocity", "Velocity of the cabin", "velocity, km/h", _KMH, test.velocity),
        ("displacement", "Crush: way of the cabin", "displacement, mm", 1e3, test.displacement),
    ):
        models = [
            scale * front.response.at(f"{body}.{stem}", np.minimum(times, front.response.end_time))
            for body, (_, front) in zip(bodies, fronts(found), strict=True)
        ]
        yield _against_time(
            found, stem, title, label, scale * measured[since], models, "Integrated from contact, class 180.", times
        )
    if test.engine is not None and found.two is not None and found.two.simulated.engine is not None:
        yield _engine_plot(found, test.engine, found.two.simulated.engine)
    yield _deflection_plot(found)
    if found.two is not None:
        yield _elements_plot(found.two)


def _against_time(
    found: Extraction,
    stem: str,
    title: str,
    label: str,
    measured: Floats,
    models: list[Floats],
    said: str,
    times: Floats | None = None,
) -> Plot:
    times = found.test.time if times is None else times
    shown = times >= -0.01
    axes = new_axes(title, xlabel="time, ms", ylabel=label)
    draw_line(axes, _MS * times[shown], measured[shown], label="measured", index=_MEASURED, dash=0)
    for (name, _), model, index in zip(fronts(found), models, (_ONE, _TWO), strict=False):
        draw_line(axes, _MS * times[shown], model[shown], label=name, index=index, dash=1 if index == _ONE else 0)
    return Plot(stem, title, said, finish(axes))


def _engine_plot(found: Extraction, measured: Floats, model: Floats) -> Plot:
    title = "Velocity of the engine"
    times, known = found.test.time, np.isfinite(measured)
    shown = times >= -0.01
    axes = new_axes(title, xlabel="time, ms", ylabel="velocity, km/h")
    draw_line(axes, _MS * times[known], _KMH * measured[known], label="measured", index=_MEASURED, dash=0)
    draw_line(axes, _MS * times[shown], _KMH * model[shown], label="cabin and engine", index=_TWO, dash=0)
    return Plot("engine-velocity", title, "Mean of the engine's sensors, as far as they are believed.", finish(axes))


def _deflection_plot(found: Extraction) -> Plot:
    title = "Force against crush"
    test = found.test
    axes = new_axes(title, xlabel="way of the cabin, mm", ylabel="force, kN")
    deflections, forces = measured_curve(test)
    draw_line(axes, 1e3 * deflections, 1e-3 * forces, label="measured: mass x deceleration", index=_MEASURED, dash=0)
    said = "Up to standstill."
    if test.barrier is not None:
        loading = (test.time >= 0.0) & (test.time <= test.stop)
        draw_line(
            axes, 1e3 * test.displacement[loading], 1e-3 * test.barrier[loading], label="measured: on the wall", index=2, dash=2
        )
        said += " What the wall feels beyond the cabin's mass times its deceleration is the engine."
    curve = found.one.curves["front"]
    points = np.array(curve.points)
    unloaded = points[-1, 0] - points[-1, 1] / float(curve.unloading_stiffness or np.inf)
    path = np.vstack((points, [unloaded, 0.0]))
    draw_line(axes, 1e3 * path[:, 0], 1e-3 * path[:, 1], label="one mass, with unloading", index=_ONE, dash=1)
    for d, f in points:
        mark_point(axes, 1e3 * d, 1e-3 * f, index=_ONE)
    return Plot("force-crush", title, said, finish(axes))


def _elements_plot(front: Front) -> Plot:
    title = "Elements of cabin and engine"
    axes = new_axes(title, xlabel="deflection of the element, mm", ylabel="force, kN")
    for index, (name, curve) in enumerate(front.curves.items()):
        points = np.array(curve.points)
        permanent = points[-1, 0] - points[-1, 1] / float(curve.unloading_stiffness or np.inf)
        path = np.vstack((points, [permanent, 0.0]))
        draw_line(
            axes, 1e3 * path[:, 0], 1e-3 * path[:, 1], label=f"{_NAMES.get(name, name)}, {_TO.get(name, '')}", index=index
        )
        for d, f in points:
            mark_point(axes, 1e3 * d, 1e-3 * f, index=index)
    said = "Each up to the deflection that it reached, then back along its unloading line."
    return Plot("elements", title, said, finish(axes))


# files


def html(found: Extraction, drawn: tuple[Plot, ...]) -> str:
    """The page of an extraction."""
    test = found.test
    return render(
        "ridedown.report",
        "extract.html",
        title=_title(found),
        description=test.title,
        warnings=_warnings(found),
        notes=notes(found),
        tables=tables(found),
        plots=drawn,
        scenario=found.toml,
    )


def pdf(found: Extraction, drawn: tuple[Plot, ...]) -> bytes:
    """The same on paper, A4."""
    parts = (
        Part("Results", tables=tables(found)),
        Part("Figures", plots=drawn),
        Part("Notes", words=notes(found)),
        Part("Scenario", text=found.toml),
    )
    return set_on_paper(Document(_title(found), found.test.title, "", _warnings(found), parts))


def _title(found: Extraction) -> str:
    return f"Front structure from wall test {found.test.identifier}"


def _warnings(found: Extraction) -> tuple[str, ...]:
    return tuple(f"Warning: {text}." for text in found.warnings)


def write(found: Extraction, folder: Path) -> None:
    """Write the page, the same as PDF, each figure, `extract.json` and `scenario.toml` into an existing folder."""
    drawn = plots(found)
    for plot in drawn:
        (folder / f"{plot.name}.svg").write_bytes(plot.svg)
    (folder / "index.html").write_text(html(found, drawn), encoding="utf-8")
    (folder / "report.pdf").write_bytes(pdf(found, drawn))
    (folder / "extract.json").write_text(json_text(found.as_json()) + "\n", encoding="utf-8")
    (folder / "scenario.toml").write_text(found.toml, encoding="utf-8")
