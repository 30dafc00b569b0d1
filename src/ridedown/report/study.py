"""A study as one page that stands alone, with its figures: written into the folder of its results."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ridedown.report import study_bound
from ridedown.report.jsontext import json_text
from ridedown.report.page import render
from ridedown.report.study_axes import Bar, Floats, Quantity
from ridedown.report.study_found import Found
from ridedown.report.study_optimise import front_plot, parallel_plot
from ridedown.report.study_sample import cumulative_plot, distribution_plot
from ridedown.report.study_search import search_plots
from ridedown.report.study_sensitivity import Interval, effect_plot, idle_sentence, index_plot, tornado_plot
from ridedown.report.study_sweep import carpet_plot, line_plot, map_plot
from ridedown.report.study_tables import failed_table, known_rows, number_tables, sensitivity_tables
from ridedown.report.style import Plot
from ridedown.report.tables import Column, Table
from ridedown.studies.bound import BoundStudy
from ridedown.studies.file.study import LoadedStudy
from ridedown.studies.results.findings import kept_bound
from ridedown.studies.results.sql import connect
from ridedown.studies.results.store import read_manifest
from ridedown.studies.results.summary import quoted, summary_of

_MOST_OUTCOMES = 8  # drawn; the table has all
_MOST_ROWS = 200_000  # that a figure is made of; of more, evenly many
_SHARES = {0.05, 0.5, 0.95}


@dataclass(frozen=True, slots=True)
class Section:
    """Part of the page: an anchor, a heading, tables, figures."""

    anchor: str
    title: str
    tables: tuple[Table, ...] = ()
    plots: tuple[Plot, ...] = ()


@dataclass(frozen=True, slots=True)
class Page:
    """What a page of a study has on it."""

    title: str
    description: str
    status: str
    sections: tuple[Section, ...]
    notes: tuple[str, ...] = ()
    study: str = ""

    def write(self, folder: Path) -> None:
        """Write the page, and each figure beside it, into an existing folder."""
        figures = folder / "figures"
        figures.mkdir(exist_ok=True)
        for section in self.sections:
            for plot in section.plots:
                (figures / f"{plot.name}.svg").write_bytes(plot.svg)
        (folder / "index.html").write_text(self.html(), encoding="utf-8")

    def html(self) -> str:
        """The page."""
        given = {name: getattr(self, name) for name in ("title", "description", "status", "sections", "notes", "study")}
        return render("ridedown.report", "study.html", **given)


def page_of(loaded: LoadedStudy, folder: Path, summary: dict[str, Any] | None = None) -> Page:
    """The page of a study whose results are in a folder: what its kind calls for, drawn from the rows that are kept.

    summary: what `summary_of` says of the folder, where that was asked already.

    Raises: InvalidInput for a folder without results.
    """
    if loaded.study.bound is not None:
        return bound_page(kept_bound(loaded, folder), description=loaded.study.description, source=loaded.text)
    kept = _Kept(loaded, folder, summary or summary_of(folder))
    if loaded.searches:
        return _found_page(kept, folder)
    kinds = {"sweep": _sweep, "sample": _sample, "sensitivity": _sensitivity}
    drawn = tuple(kinds[kept.kind](kept)) if kept.kind in kinds else ()
    tables = (*sensitivity_tables(kept.summary), *number_tables(kept.summary))
    sections = (*drawn, Section("outcomes", "Outcomes", tables))
    study = loaded.study
    rows = f"{kept.summary['done']:,} of {kept.summary['rows']:,} rows; kind {kept.kind}."
    return Page(study.name or "A study", study.description, rows, sections, tuple(kept.notes()), loaded.text)


def _found_page(kept: _Kept, folder: Path) -> Page:
    """The page of a study that searched."""
    found, study = Found(folder), kept.loaded.study
    tables = tuple(table for table in (*found.tables, failed_table(kept.summary)) if table.rows)
    sections = [Section("found", "What was found", tables)]
    if found.front is not None:
        parameters, goals, chosen = found.front
        sections.append(front_section(parameters, goals, chosen=chosen))
    plots = tuple(search_plots(kept.loaded, kept, found))
    if plots:
        sections.append(Section("figures", "Figures", plots=plots))
    rows = f"{kept.summary['done']:,} rows; kind {kept.kind}."
    notes = (*kept.summary["remarks"], *found.notes)
    return Page(study.name or "A study", study.description, rows, tuple(sections), notes, kept.loaded.text)


def bound_page(study: BoundStudy, *, description: str = "", source: str = "") -> Page:
    """The page of a study of kind `bound`; source: its file, shown at the end."""
    tables = tuple(table for table in (study_bound.table(study), study_bound.curve_table(study)) if table.rows)
    room = "no seat behind" if np.isinf(study.ideal.rearward) else f"{1e3 * study.ideal.rearward:.0f} mm of room behind"
    status = f"{1e3 * study.ideal.slack:.0f} mm of slack, {room}; g = 9.80665 m/s²."
    notes = (
        "A restraint only brakes, from first contact on, as hard as it likes, and knows what is to come: nothing does better.",
        *filter(None, [study_bound.beside_in_words(study)]),
    )
    sections = (
        Section("figures", "Limiting performance", plots=study_bound.plots(study)),
        Section("numbers", "Numbers", tables),
    )
    return Page(study.name or "Limiting performance", description, status, sections, notes, source)


def write_bound(study: BoundStudy, folder: Path, *, description: str = "") -> None:
    """Write page, figures and `bound.json` into an existing folder."""
    bound_page(study, description=description).write(folder)
    (folder / "bound.json").write_text(json_text(study.as_json()) + "\n", encoding="utf-8")


def front_section(
    parameters: Mapping[Quantity, Floats],
    goals: Mapping[Quantity, Floats],
    *,
    chosen: int | None = None,
    limits: Mapping[str, Sequence[Bar]] | None = None,
    beside: Mapping[str, Mapping[str, float]] | None = None,
) -> Section:
    """A Pareto front: every two goals against each other, all on parallel axes, and the designs as a table.

    parameters, goals: columns (R,), SI; chosen: the row that was chosen; limits: by the name of a goal; beside: other designs,
    by name, with a value for each goal's name.
    """
    bars, others = limits or {}, beside or {}
    names = list(goals)
    plots = []
    for i, x in enumerate(names):
        for y in names[i + 1 :]:
            near = {name: (of[x.name], of[y.name]) for name, of in others.items()}
            both = tuple(bars.get(x.name, ())), tuple(bars.get(y.name, ()))
            plots.append(front_plot(x, y, (goals[x], goals[y]), chosen=chosen, beside=near, limits=both))
    every = {**parameters, **goals}
    plots.append(parallel_plot(list(every), list(every.values()), chosen=chosen, title="The front, parameter by parameter"))
    columns = (Column("Design"), *(Column(quantity.name, quantity.read_in) for quantity in every))
    order = np.argsort(next(iter(goals.values())))
    rows = tuple(
        (f"{k + 1}{' (chosen)' if row == chosen else ''}", *(q.text(float(c[row]), unit=False) for q, c in every.items()))
        for k, row in enumerate(order)
    )
    return Section("front", "Pareto front", (Table("Designs of the front", columns, rows),), tuple(plots))


class _Kept:
    """The results in a folder, and how to get at them."""

    def __init__(self, loaded: LoadedStudy, folder: Path, summary: dict[str, Any]) -> None:
        self.loaded = loaded
        self.kind: str = loaded.study.kind
        self.summary = summary
        self.results: dict[str, Any] = self.summary.get("results") or {}
        self.connection = connect(folder)
        columns = read_manifest(folder)["columns"]
        self.parameters = [Quantity(c["name"], c["unit"] or "") for c in columns if c["role"] == "parameter"]
        self.outcomes = [Quantity(c["name"], c["unit"] or "") for c in columns if c["role"] == "outcome"]

    @property
    def drawn(self) -> list[Quantity]:
        """The outcomes that are drawn: those with a limit first."""
        limited = {limit["outcome"] for limit in self.results.get("limits", [])}
        order = sorted(self.outcomes, key=lambda outcome: outcome.name not in limited)
        return order[:_MOST_OUTCOMES]

    def bars(self, outcome: Quantity) -> tuple[list[Bar], list[str]]:
        """The limits on an outcome, and what there is to say of each."""
        bars, said = [], []
        for limit in self.results.get("limits", []):
            if limit["outcome"] == outcome.name:
                most = limit["most"] is not None
                bars.append(Bar(float(limit["most"] if most else limit["least"]), most=most))
                said.append(_probability(limit))
        return bars, said

    def columns(self, *quantities: Quantity, where: Mapping[str, float] | None = None) -> list[Floats]:
        """Columns in the order of the rows, (R,) each; NaN where a row has none. Of very many rows, evenly many."""
        if where:
            rules = " AND ".join(f"{quoted(name)} = ?" for name in where)
            return self._fetched(quantities, f"WHERE {rules}", list(where.values()))
        return [self._evenly[quantity.name] for quantity in quantities]

    @cached_property
    def _evenly(self) -> dict[str, Floats]:
        """Parameters and what is drawn, read at once, for they lie in the same files."""
        quantities = [*self.parameters, *self.drawn]
        every = max(1, -(-self.summary["rows"] // _MOST_ROWS))
        columns = self._fetched(quantities, f"WHERE row % {every} = 0", [])
        return {quantity.name: column for quantity, column in zip(quantities, columns, strict=True)}

    def every(self, *quantities: Quantity) -> list[Floats]:
        """The same of every row, however many."""
        return self._fetched(quantities, "", [])

    def _fetched(self, quantities: Sequence[Quantity], where: str, values: list[float]) -> list[Floats]:
        asked = ", ".join(f"CAST({quoted(quantity.name)} AS DOUBLE) AS c{k}" for k, quantity in enumerate(quantities))
        found = self.connection.execute(f"SELECT {asked} FROM results {where} ORDER BY row", values).fetchnumpy()
        return [np.ma.filled(found[f"c{k}"].astype(np.float64), np.nan) for k in range(len(quantities))]

    def levels(self, parameter: Quantity) -> Floats:
        """The values that a parameter takes, rising, (L,)."""
        name = quoted(parameter.name)
        rows = self.connection.execute(f"SELECT DISTINCT {name} FROM results ORDER BY 1").fetchall()
        return np.array([row[0] for row in rows], dtype=np.float64)

    def notes(self) -> Iterator[str]:
        """What a reader has to know."""
        yield from self.summary["remarks"]
        if len(self.outcomes) > len(self.drawn):
            yield (
                f"{len(self.drawn)} of {len(self.outcomes)} outcomes are drawn, those with a limit first; the table has all."
            )
        if self.kind != "sweep" and self.summary["rows"] > _MOST_ROWS:
            yield f"Figures are of {_MOST_ROWS:,} rows at most, evenly taken; the numbers are of all {self.summary['rows']:,}."


def _sweep(kept: _Kept) -> Iterator[Section]:
    levels = {parameter: kept.levels(parameter) for parameter in kept.parameters}
    varied = sorted((p for p in levels if levels[p].size > 1), key=lambda p: -levels[p].size)[:2]
    if not varied:
        return
    fixed = {p: float(levels[p][levels[p].size // 2]) for p in levels if p not in varied}
    where = {p.name: value for p, value in fixed.items()}
    held = f" Held: {', '.join(f'{p.name} {p.text(value)}' for p, value in fixed.items())}." if fixed else ""
    drawn = kept.drawn
    columns = kept.columns(*varied, *drawn, where=where or None)
    if len(varied) == 1:
        plots = [
            line_plot(varied[0], outcome, columns[0], column, limits=kept.bars(outcome)[0], held=held)
            for outcome, column in zip(drawn, columns[1:], strict=True)
        ]
        yield Section("figures", "Outcomes over the parameter", plots=tuple(plots))
        return
    x, y = varied
    i, j = np.searchsorted(levels[x], columns[0]), np.searchsorted(levels[y], columns[1])
    grids = {}
    for outcome, column in zip(drawn, columns[2:], strict=True):
        grid = np.full((levels[x].size, levels[y].size), np.nan)
        grid[i, j] = column
        grids[outcome] = grid
    known = [outcome for outcome in drawn if np.isfinite(grids[outcome]).any()]
    pairs = [(one, other) for k, one in enumerate(known) for other in known[k + 1 :] if _apart(grids[one], grids[other])][:2]
    carpets = [
        carpet_plot(x, y, one, other, (levels[x], levels[y]), (grids[one], grids[other]),
                    limits=(kept.bars(one)[0], kept.bars(other)[0]), held=held)
        for one, other in pairs
    ]  # fmt: skip
    if carpets:
        yield Section("carpets", "Outcomes against each other", plots=tuple(carpets))
    maps = [
        map_plot(x, y, outcome, levels[x], levels[y], grids[outcome].T, limits=kept.bars(outcome)[0], held=held)
        for outcome in known
    ]
    yield Section("maps", "Maps", plots=tuple(maps))


def _apart(one: Floats, other: Floats) -> bool:
    """Whether two outcomes both vary, and not as one: their carpet would be a thread."""
    good = np.isfinite(one) & np.isfinite(other)
    a, b = one[good], other[good]
    if a.size < 4 or np.ptp(a) <= 1e-9 * np.abs(a).max() or np.ptp(b) <= 1e-9 * np.abs(b).max():
        return False
    return bool(abs(np.corrcoef(a, b)[0, 1]) < 0.99)


def _sample(kept: _Kept) -> Iterator[Section]:
    spread, rare, level = [], [], []
    for outcome in kept.drawn:
        (values,) = kept.columns(outcome)
        known = values[np.isfinite(values)]
        if not known.size:
            continue
        if np.ptp(known) == 0.0:
            level.append(outcome.name)
            continue
        bars, said = kept.bars(outcome)
        found = kept.results.get("outcomes", {}).get(outcome.name, {}).get("quantiles", [])
        quantiles = {one["share"]: one["value"] for one in found if one["share"] in _SHARES and one["value"] is not None}
        spread.append(distribution_plot(outcome, values, limits=bars, said=said, quantiles=quantiles))
        if bars:
            rare.append(cumulative_plot(outcome, values, limits=bars, said=said))
    same = f". The same in every row: {', '.join(level)}" if level else ""
    yield Section("distributions", f"Distributions{same}", plots=tuple(spread))
    if rare:
        yield Section("exceeded", "How often a limit is exceeded", plots=tuple(rare))
    yield Section("tornado", "What the outcomes go with", plots=tuple(_tornados(kept)))


def _sensitivity(kept: _Kept) -> Iterator[Section]:
    plots = []
    units = {outcome.name: outcome for outcome in kept.outcomes}
    names = [outcome.name for outcome in kept.drawn]
    for name in names:
        found = kept.results.get("outcomes", {}).get(name, {})
        if found.get("indices"):
            first, total = ({i["parameter"]: _interval(i[which]) for i in found["indices"]} for which in ("first", "total"))
            if all(np.isfinite(one.value) for one in (*first.values(), *total.values())):
                plots.append(index_plot(name, first, total))
        if found.get("effects"):
            sizes = {effect["parameter"]: _interval(effect["mean_size"]) for effect in found["effects"]}
            deviations = {effect["parameter"]: float(effect["deviation"]) for effect in found["effects"]}
            plots.append(effect_plot(units[name], sizes, deviations))
    idle = idle_sentence(kept.results.get("idle", []))
    if plots:
        yield Section("indices", f"Sensitivities. {idle}" if idle else "Sensitivities", plots=tuple(plots))
    yield Section("tornado", "What the outcomes go with", plots=tuple(_tornados(kept)))


def _tornados(kept: _Kept) -> Iterator[Plot]:
    for outcome in kept.drawn:
        *columns, values = kept.columns(*kept.parameters, outcome)
        good = np.isfinite(values)
        if good.sum() >= 20 and np.ptp(values[good]) > 0.0:
            yield tornado_plot(outcome, dict(zip(kept.parameters, columns, strict=True)), values)


def _interval(given: Mapping[str, Any]) -> Interval:
    return Interval(*(np.nan if given[end] is None else float(given[end]) for end in ("value", "low", "high")))


def _probability(limit: Mapping[str, Any]) -> str:
    """How likely a limit is exceeded, in words; how often, where it was not drawn at random."""
    found = limit.get("probability")
    if found is None or found.get("value") is None:
        return f"{limit['exceeded']:,} of {known_rows(limit):,} rows exceed it" if "exceeded" in limit else ""
    low, high = (100.0 * found[end] for end in ("low", "high"))
    return f"exceeded by {100.0 * found['value']:.3g} % ({low:.3g} to {high:.3g} %)"
