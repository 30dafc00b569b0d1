"""A calibration as a folder of files: one HTML page, the same as PDF, figures, fitted scenarios, parameters."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from ridedown.report import calibration_tables
from ridedown.report.jsontext import json_text
from ridedown.report.page import render
from ridedown.report.pdf import Document, Part
from ridedown.report.pdf import pdf as set_on_paper
from ridedown.report.style import PALETTE, Plot, draw_line, finish, new_axes
from ridedown.studies import Calibrated
from ridedown.studies.calibration.fitted import FittedChannel
from ridedown.studies.calibration.wording import SHOWN, in_case, in_words

Floats = NDArray[np.float64]

_MODEL, _MEASURED, _RESIDUAL = 1, 6, 0
_LONGEST_LABEL = 26
_UNTITLED = "A calibration"


def write(found: Calibrated, folder: Path) -> None:
    """Write page, PDF, figures (SVG), results and parameters (JSON) and fitted scenarios (TOML) into an existing folder."""
    drawn = plots(found)
    for plot in drawn:
        (folder / f"{plot.name}.svg").write_bytes(plot.svg)
    (folder / "index.html").write_text(html(found, drawn), encoding="utf-8")
    (folder / "report.pdf").write_bytes(pdf(found, drawn))
    (folder / "calibration.json").write_text(json_text(found.as_json()) + "\n", encoding="utf-8")
    (folder / "parameters.json").write_text(json_text(found.parameters_json()) + "\n", encoding="utf-8")
    scenarios = folder / "scenarios"
    scenarios.mkdir()
    for name, file in scenario_files(found).items():
        (scenarios / file).write_text(found.toml(name), encoding="utf-8")


def scenario_files(found: Calibrated) -> dict[str, str]:
    """The file name of each fitted scenario, by its case."""
    files: dict[str, str] = {}
    for name in found.scenarios:
        stem = slug(name)
        while f"{stem}.toml" in files.values():
            stem += "-2"
        files[name] = f"{stem}.toml"
    return files


def slug(text: str) -> str:
    """A name as part of a file's name.

    >>> slug("Driver, 0-90 ms")
    'driver-0-90-ms'
    """
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-") or "case"


def html(found: Calibrated, drawn: tuple[Plot, ...]) -> str:
    """The page of a calibration."""
    by_name = {plot.name: plot for plot in drawn}
    fitted, predicted = ([by_name[_name(c)] for c in found.channels if c.fitted is kind] for kind in (True, False))
    made = {table.caption: table for table in calibration_tables.tables(found)}
    parameters, *others = made.values()
    return render(
        "ridedown.report",
        "calibration.html",
        title=found.calibration.title or _UNTITLED,
        description=found.calibration.description,
        warnings=found.warnings,
        parameters=parameters,
        fits=[t for t in others if not t.caption.startswith("Predicted")],
        predictions=[t for t in others if t.caption.startswith("Predicted")],
        fitted=fitted,
        predicted=predicted,
        residuals=[plot for plot in drawn if plot.name.startswith("residuals-")],
        correlations=by_name.get("correlations"),
        correlation_table=calibration_tables.correlations(found),
        posterior=by_name.get("posterior"),
        scenarios=[(name, found.toml(name)) for name in found.scenarios],
    )


def pdf(found: Calibrated, drawn: tuple[Plot, ...]) -> bytes:
    """The same on paper, A4."""
    by_name = {plot.name: plot for plot in drawn}
    fitted, predicted = (tuple(by_name[_name(c)] for c in found.channels if c.fitted is kind) for kind in (True, False))
    parameters, *others = calibration_tables.tables(found)
    fits = tuple(table for table in others if not table.caption.startswith("Predicted"))
    predictions = tuple(table for table in others if table.caption.startswith("Predicted"))
    residuals = tuple(plot for plot in drawn if plot.name.startswith("residuals-"))
    last = tuple(by_name[name] for name in ("correlations", "posterior") if name in by_name)
    parts = (
        Part("Parameters", tables=(parameters,)),
        Part("Model against measured", tables=fits, plots=fitted),
        Part("Predictions", tables=predictions, plots=predicted),
        Part("Residuals", plots=residuals),
        Part("Correlations", tables=(calibration_tables.correlations(found),), plots=last),
        *(Part(f"Fitted scenario: {name}", text=found.toml(name)) for name in found.scenarios),
    )
    made, agreed = found.starts
    status = f"{found.tried:,} candidates; {agreed} of {made} searches ended here"
    title, description = found.calibration.title or _UNTITLED, found.calibration.description
    shown = tuple(part for part in parts if part.tables or part.plots or part.text)
    return set_on_paper(Document(title, description, status, found.warnings, shown))


def plots(found: Calibrated) -> tuple[Plot, ...]:
    """Every figure: each channel, what each fitted one leaves, the correlations, the posterior."""
    return tuple(_plots(found))


def _plots(found: Calibrated) -> Iterator[Plot]:
    several = len({channel.case for channel in found.channels}) > 1
    for channel in found.channels:
        yield _curve(channel, in_case(channel.name, channel.case, several=several))
    for channel in found.channels:
        if channel.fitted and channel.measured is not None:
            yield _residual(channel, in_case(channel.name, channel.case, several=several))
    if len(found.parameters) > 1:
        yield _correlations(found)
    if found.posterior is not None:
        yield _posterior(found)


def _name(channel: FittedChannel, kind: str = "channel") -> str:
    return f"{kind}-{slug(channel.case)}-{slug(channel.name)}"


def _scaled(channel: FittedChannel) -> tuple[str, float]:
    return SHOWN.get(channel.unit, (channel.unit, 1.0))


def _curve(channel: FittedChannel, named: str) -> Plot:
    unit, scale = _scaled(channel)
    title = named + ("" if channel.fitted else " (predicted)")
    axes = new_axes(title, xlabel="time, ms", ylabel=f"{_quantity(channel)}, {unit}")
    times = 1e3 * channel.times
    wide = bool(np.any(channel.wide_high > channel.high))
    if wide:
        _shade(axes, times, scale * channel.wide_low, scale * channel.wide_high, 0.13, "95 %, with the scatter of the fit")
    _shade(axes, times, scale * channel.low, scale * channel.high, 0.38, "95 %, of the parameters")
    if channel.measured is not None:
        draw_line(axes, times, scale * channel.measured, label="measured", index=_MEASURED, dash=0)
    draw_line(axes, times, scale * channel.model, label="model", index=_MODEL, dash=1)
    axes.set_xlim(times[0], times[-1])
    what = f"Model, with the 95 % bands shaded; peak {in_words(channel.peak.value, channel.unit)} at "
    what += f"{1e3 * channel.peak.time:.1f} ms."
    measured = channel.measured_peak
    if measured is not None:
        what += f" Measured: {in_words(measured.value, channel.unit)} at {1e3 * measured.time:.1f} ms."
    if channel.rating is not None:
        what += f" ISO/TS 18571: {channel.rating.value:.3f}, {channel.rating.grade}."
    return Plot(_name(channel), title, what, finish(axes))


def _shade(axes: Axes, times: Floats, low: Floats, high: Floats, alpha: float, label: str) -> None:
    axes.fill_between(times, low, high, color=PALETTE[_MODEL], alpha=alpha, linewidth=0.0, label=label)


def _residual(channel: FittedChannel, named: str) -> Plot:
    unit, scale = _scaled(channel)
    title = f"{named}, model less measured"
    axes = new_axes(title, xlabel="time, ms", ylabel=f"difference, {unit}")
    assert channel.measured is not None
    assert channel.rms is not None
    draw_line(
        axes, 1e3 * channel.times, scale * (channel.model - channel.measured), label="difference", index=_RESIDUAL, dash=0
    )
    axes.set_xlim(1e3 * channel.times[0], 1e3 * channel.times[-1])
    what = f"What the fit leaves: {in_words(channel.rms, channel.unit)} root mean square."
    return Plot(_name(channel, "residuals"), title, what, finish(axes))


def _correlations(found: Calibrated) -> Plot:
    names = [p.name for p in found.parameters]
    title = "Correlations of the parameters"
    axes = new_axes(title, xlabel="", ylabel="")
    axes.set_position((0.34, 0.12, 0.5, 0.76))
    axes.grid(visible=False)
    drawn = axes.pcolormesh(found.correlation, cmap="RdBu_r", vmin=-1.0, vmax=1.0, edgecolors="white", linewidth=1.0)
    places = np.arange(len(names)) + 0.5
    axes.set_yticks(places, [f"{_short(name)}  {i}" for i, name in enumerate(names, 1)])
    axes.set_xticks(places, [str(i) for i in range(1, len(names) + 1)])
    axes.set_ylim(len(names), 0)
    size = max(5.0, min(9.0, 80.0 / len(names)))
    for i, row in enumerate(found.correlation):
        for j, value in enumerate(row):
            colour = "white" if abs(value) > 0.6 else "black"
            text = f"{value:.2f}".replace("-", "\u2212")
            axes.text(j + 0.5, i + 0.5, text, ha="center", va="center", fontsize=size, color=colour)
    figure = axes.get_figure()
    assert figure is not None
    figure.colorbar(drawn, cax=figure.add_axes((0.87, 0.12, 0.02, 0.76)))
    what = "Correlation of each two parameters: near 1 or \u22121, what is measured tells only a combination of the two."
    return Plot("correlations", title, what, figure)  # type: ignore[arg-type]


def _short(name: str) -> str:
    """A name that fits beside the axes; the table below has it in full."""
    return name if len(name) <= _LONGEST_LABEL else f"{name[: _LONGEST_LABEL - 1]}…"


def _posterior(found: Calibrated) -> Plot:
    title = "Posterior of the parameters"
    axes = new_axes(title, xlabel="in parts of the band from the derivatives (0 and 1 its ends)", ylabel="density")
    for i, p in enumerate(found.parameters[:7]):
        draws = found.posterior.draws[:, i]
        span = p.high - p.low if p.high > p.low else 1.0
        density, edges = np.histogram((draws - p.low) / span, bins=60, range=(-1.0, 2.0), density=True)
        draw_line(axes, 0.5 * (edges[1:] + edges[:-1]), density, label=p.name, index=i)
    what = (
        "Where the chains were, each parameter on the scale of its band from the derivatives; a band that is right holds 95 %."
    )
    return Plot("posterior", title, what, finish(axes))


def _quantity(channel: FittedChannel) -> str:
    return channel.name.rsplit(".", 1)[-1].replace("_", " ")
