"""What a search found, as tables and sentences: the chosen design, the solution box, rare events."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ridedown.report.study_axes import Bar, Floats, Quantity
from ridedown.report.tables import NONE, Column, Table
from ridedown.studies.results.store import read_manifest, read_results


class Found:
    """What the finished search in a folder found. Raises: InvalidInput for a folder without results."""

    def __init__(self, folder: Path) -> None:
        self.results: dict[str, Any] = read_results(folder) or {}
        self.quantities = {one["name"]: Quantity(one["name"], one["unit"] or "") for one in read_manifest(folder)["columns"]}

    @property
    def tables(self) -> tuple[Table, ...]:
        """What was found, in numbers."""
        if "box" in self.results:
            return (self._box(),)
        if "rare" in self.results:
            return (self._rare(), self._likeliest())
        return tuple(table for table in (self._design(), self._held(), self._ends()) if table.rows)

    @property
    def notes(self) -> Iterator[str]:
        """What a reader has to know."""
        found = self.results
        for name in found.get("at_end", []):
            yield f"{name} is at an end of its range: a better design may lie beyond it."
        if box := found.get("box"):
            if box["verified"]:
                yield (
                    f"None of {box['verified']} rows in the box that had no part in finding it breaks a limit: fewer than "
                    f"{100.0 * box['bad_share']:.2g} % of its designs do, at {100.0 * box['confidence']:g} % confidence."
                )
            if box["binding"]:
                words = {limit["rule"]: self._words(limit) for limit in found["limits"]}
                yield f"Designs just outside the box break: {'; '.join(words[rule] for rule in box['binding'])}."
        yield from found.get("warnings", [])
        for limit in found.get("limits", []):
            yield from (f"{self._words(limit)}: {warning}" for warning in limit.get("warnings", []))
        seed = f"seed {found['seed']}"
        if "rare" in found:
            yield f"Rows are drawn where the limit is exceeded, and weighed ({seed}): their mean says nothing."
        else:
            yield f"{found['evaluations']:,} rows, {seed}."

    @property
    def front(self) -> tuple[dict[Quantity, Floats], dict[Quantity, Floats], int | None] | None:
        """Parameters and objectives of the front, (R,) each, and the row of its knee, if it has one; None without a front."""
        front = self.results.get("front")
        if not front or not any(front["parameters"].values()):
            return None
        units = {one["words"]: one["unit"] for one in self.results["objectives"]}
        parameters = {self.quantities[name]: np.array(column) for name, column in front["parameters"].items()}
        return (
            parameters,
            {Quantity(name, units[name]): np.array(of) for name, of in front["objectives"].items()},
            front["chosen"],
        )

    def _words(self, limit: Mapping[str, Any]) -> str:
        """A limit in words, in the unit that is read."""
        return f"{limit['outcome']} {_bar(limit).words(self.quantities[limit['outcome']])}"

    def _named(self, constraint: Mapping[str, Any]) -> str:
        """What a constraint is on; of a share the value that it is beyond is in the unit that is read."""
        beyond, outcome = constraint.get("beyond"), constraint["outcome"]
        if beyond is None:
            return str(constraint["of"])
        sign, value = (">", beyond["most"]) if beyond["most"] is not None else ("<", beyond["least"])
        return f"share with {outcome} {sign} {self.quantities[outcome].text(value)}"

    def _design(self) -> Table:
        columns = (
            Column("Chosen design", numeric=False), Column("Unit", numeric=False), Column("Value"), Column("From"), Column("To")
        )  # fmt: skip
        chosen = self.results["chosen"]
        rows = []
        for name, value in (chosen["parameters"] if chosen else {}).items():
            of = self.quantities[name]
            ends = (of.text(end, unit=False) for end in self.results["ranges"][name])
            rows.append((name, of.read_in or NONE, of.text(value, unit=False), *ends))
        size = len(self.results["front"]["parameters"][rows[0][0]]) if rows and self.results["front"] else 0
        return Table(f"The knee of a front of {size}" if size else "The best design found", columns, tuple(rows))

    def _held(self) -> Table:
        columns = (
            Column("Outcome", numeric=False),
            Column("Unit", numeric=False),
            Column("Value"),
            Column("Sought", numeric=False),
        )
        chosen = self.results["chosen"]
        rows = []
        if chosen:
            for one in self.results["objectives"]:
                of = Quantity(one["words"], one["unit"])
                sought = "as large as can be" if one["sense"] == "max" else "as small as can be"
                rows.append((of.name, of.read_in or NONE, of.text(chosen["objectives"][of.name], unit=False), sought))
            for one in self.results["constraints"]:
                of = Quantity(self._named(one), one["unit"])
                value = chosen["constraints"][one["words"]]
                rows.append((of.name, of.read_in or NONE, of.text(value, unit=False), _bar(one).words(of)))
        caption = "What it comes to" if chosen and chosen["feasible"] else "What it comes to: not all that is asked for"
        return Table(caption, columns, tuple(rows))

    def _ends(self) -> Table:
        """The designs of a front that are the best for each objective: how far one may go for it, and what that costs."""
        if self.front is None:
            return Table("", (), ())
        parameters, goals, _ = self.front
        every = {**parameters, **goals}
        rows = []
        for one in self.results["objectives"]:
            column = next(column for quantity, column in goals.items() if quantity.name == one["words"])
            best = int(np.argmax(column) if one["sense"] == "max" else np.argmin(column))
            rows.append((one["words"], *(of.text(float(values[best]), unit=False) for of, values in every.items())))
        columns = (Column("Best for", numeric=False), *(Column(of.name, of.read_in) for of in every))
        return Table(f"Ends of a front of {next(iter(every.values())).size} designs", columns, tuple(rows))

    def _box(self) -> Table:
        columns = (
            Column("Parameter", numeric=False), Column("Unit", numeric=False), Column("Box from"), Column("To"),
            Column("Range from"), Column("To"),
        )  # fmt: skip
        box, rows = self.results["box"], []
        for name, sides in box["ranges"].items():
            of = self.quantities[name]
            values = (of.text(value, unit=False) for value in (*sides, *self.results["ranges"][name]))
            rows.append((name, of.read_in or NONE, *values))
        rules = "; ".join(self._words(one) for one in self.results["limits"])
        return Table(f"Box, {100.0 * box['share']:.3g} % of the volume, with {rules}", columns, tuple(rows))

    def _rare(self) -> Table:
        columns = (
            Column("Limit", numeric=False), Column("Probability"), Column("From"), Column("To"), Column("Beta"),
            Column("Effective rows"), Column("Rows"),
        )  # fmt: skip
        rows = []
        for one in self.results["limits"]:
            chance = one["probability"]
            ends = (_cell(chance[end]) for end in ("value", "low", "high"))
            rows.append((self._words(one), *ends, _cell(one["beta"]), f"{one['effective']:.0f}", f"{one['evaluations']:,}"))
        return Table("How likely limits are exceeded", columns, tuple(rows))

    def _likeliest(self) -> Table:
        limits = [one for one in self.results["limits"] if one["likeliest"]]
        names = list(limits[0]["likeliest"]) if limits else []
        columns = (Column("Limit", numeric=False), *(Column(name, self.quantities[name].read_in) for name in names))
        rows = tuple(
            (self._words(one), *(self.quantities[name].text(one["likeliest"][name], unit=False) for name in names))
            for one in limits
        )
        return Table("The likeliest row beyond each limit", columns, rows)


def _bar(one: Mapping[str, Any]) -> Bar:
    most = one["most"] is not None
    return Bar(float(one["most"] if most else one["least"]), most=most)


def _cell(value: float | None) -> str:
    return NONE if value is None else f"{value:.3g}"
