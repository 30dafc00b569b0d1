"""A study's numbers as tables, in the units that people read: the same in a terminal and on its page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from ridedown.report.study_axes import Bar, Quantity
from ridedown.report.tables import NONE, Column, Table, number

Summary = Mapping[str, Any]
"""What `ridedown.studies.results.summary.summary_of` says of a folder, SI."""

_OUTCOME = (Column("Outcome", numeric=False), Column("Unit", numeric=False))


def number_tables(summary: Summary) -> tuple[Table, ...]:
    """The reach of every outcome, how often limits are exceeded, quantiles, and the rows that failed; those with rows."""
    of = {name: Quantity(name, one["unit"] or "") for name, one in summary["outcomes"].items()}
    found = summary.get("results") or {}
    made = (_outcomes(summary, of), _limits(found, of), _quantiles(found, of), failed_table(summary))
    return tuple(table for table in made if table.rows)


def sensitivity_tables(summary: Summary) -> tuple[Table, ...]:
    """The Sobol indices of each outcome, or the elementary effects on it; none of another kind of study."""
    return tuple(_sensitivities(summary))


def failed_table(summary: Summary) -> Table:
    """The rows that failed, by why."""
    columns = (Column("Rows"), Column("Status", numeric=False), Column("Why", numeric=False))
    rows = tuple((f"{one['rows']:,}", str(one["status"]), str(one["why"] or "")) for one in summary["failed"])
    return Table("Rows that failed", columns, rows)


def known_rows(limit: Mapping[str, Any]) -> int:
    """Of how many rows it is known whether they exceed a limit: a row that failed is not one that holds it."""
    return int(limit["rows"] - limit.get("failed", 0))


def _outcomes(summary: Summary, of: Mapping[str, Quantity]) -> Table:
    columns = (*_OUTCOME, Column("Least"), Column("Mean"), Column("Largest"))
    rows = tuple(
        (name, of[name].read_in or NONE, *(_value(of[name], one[key]) for key in ("min", "mean", "max")))
        for name, one in summary["outcomes"].items()
    )
    return Table(f"{summary['done']:,} rows", columns, rows)


def _limits(found: Mapping[str, Any], of: Mapping[str, Quantity]) -> Table:
    """How often limits are exceeded; of rows drawn at random how likely that is, with the ends of its interval."""
    limits = found.get("limits", [])
    drawn = found.get("kind") == "sample"
    ends = (Column("Probability", "%"), Column("from", "%"), Column("to", "%")) if drawn else (Column("Share", "%"),)
    columns = (_OUTCOME[0], Column("Limit", numeric=False), Column("Exceeded"), Column("Of rows"), *ends)
    rows = []
    for limit in limits:
        quantity, most = of[limit["outcome"]], limit["most"] is not None
        words = Bar(float(limit["most"] if most else limit["least"]), most=most).words(quantity)
        known = known_rows(limit)
        share = limit["exceeded"] / known if known else None
        chance = limit.get("probability") or {}
        shares = [chance.get(end) for end in ("value", "low", "high")] if drawn else [share]
        cells = (NONE if one is None else f"{100.0 * one:.4g}" for one in shares)
        rows.append((quantity.name, words, f"{limit['exceeded']:,}", f"{known:,}", *cells))
    return Table("Limits", columns, tuple(rows))


def _quantiles(found: Mapping[str, Any], of: Mapping[str, Quantity]) -> Table:
    if found.get("kind") != "sample":
        return Table("", (), ())
    shares = [one["share"] for one in next(iter(found["outcomes"].values()))["quantiles"]]
    rows = tuple(
        (name, of[name].read_in or NONE, *(_value(of[name], one["value"]) for one in outcome["quantiles"]))
        for name, outcome in found["outcomes"].items()
    )
    columns = (Column("Quantiles", numeric=False), _OUTCOME[1], *(Column(f"{100 * share:g} %") for share in shares))
    return Table(f"Of {found['design']} rows, seed {found['seed']}", columns, rows)


def _sensitivities(summary: Summary) -> Iterator[Table]:
    found = summary.get("results") or {}
    if "method" not in found:
        return
    for name, outcome in found["outcomes"].items():
        if found["method"] == "sobol":
            rows = tuple(
                (
                    one["parameter"],
                    *(_share(one[which][end]) for which in ("first", "total") for end in ("value", "low", "high")),
                )
                for one in outcome["indices"]
            )
            heads = tuple(Column(head) for head in ("First", "from", "to", "Total", "from", "to"))
            yield Table(f"Sobol indices of {name}", (Column("Parameter", numeric=False), *heads), rows)
        else:
            quantity = Quantity(name, summary["outcomes"][name]["unit"] or "")
            rows = tuple(
                (
                    one["parameter"],
                    *(_value(quantity, one["mean_size"][end]) for end in ("value", "low", "high")),
                    _value(quantity, one["deviation"]),
                )
                for one in outcome["effects"]
            )
            heads = tuple(Column(head, quantity.read_in) for head in ("Mean size", "from", "to", "Deviation"))
            yield Table(f"Elementary effects on {name}", (Column("Parameter", numeric=False), *heads), rows)


def _value(quantity: Quantity, value: float | None) -> str:
    return NONE if value is None else quantity.text(value, unit=False)


def _share(value: float | None) -> str:
    """A share of the variance: what is below a thousandth is rounding, or no matter."""
    return number(value, 3)
