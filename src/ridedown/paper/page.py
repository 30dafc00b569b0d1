"""The reproduction as tables and as one HTML page."""

from __future__ import annotations

from collections.abc import Sequence

from ridedown.paper import cases
from ridedown.paper.numbers import ACCELERATION, Headline
from ridedown.paper.trends import Trend
from ridedown.report.page import render
from ridedown.report.style import Plot
from ridedown.report.tables import Column, Table
from ridedown.scenario import dump, load


def numbers_table(headlines: Sequence[Headline]) -> Table:
    """The ten numbers beside ours."""
    within = sum(h.rounds_to_print for h in headlines)
    worst = max(abs(h.error) for h in headlines)
    return Table(
        f"The paper's numbers and ours (g = 9.81 m/s²): worst error {100.0 * worst:.1f} %; "
        f"{within} of {len(headlines)} round to what is printed",
        (
            Column("Figure"),
            Column("Case", numeric=False),
            Column("Quantity", numeric=False),
            Column("Paper"),
            Column("Ours"),
            Column("Error"),
            Column("Rounds to the print", numeric=False),
        ),
        tuple(_number_row(h) for h in headlines),
    )


def trends_table(trends: Sequence[Trend]) -> Table:
    """Every trend, held or not, and the values that say so."""
    held = sum(t.holds for t in trends)
    return Table(
        f"What the paper says of its figures: {held} of {len(trends)} hold",
        (
            Column("Figure"),
            Column("Trend", numeric=False),
            Column("Holds", numeric=False),
            Column("Ours", numeric=False),
        ),
        tuple((str(t.figure), t.trend, "yes" if t.holds else "NO", t.evidence) for t in trends),
    )


def html(headlines: Sequence[Headline], trends: Sequence[Trend], plots: Sequence[Plot]) -> str:
    """One page with all of it."""
    return render(
        "ridedown.paper",
        "paper.html",
        numbers=numbers_table(headlines),
        trends=trends_table(trends),
        plots=plots,
        scenario=dump(load(cases.ADULT_OFFSET.scenario)),
    )


def _number_row(h: Headline) -> tuple[str, ...]:
    digits = (0, 1) if h.quantity == ACCELERATION else (2, 3)
    return (
        str(h.figure),
        h.case,
        h.quantity,
        f"{h.paper:.{digits[0]}f}",
        f"{h.ours:.{digits[1]}f}",
        f"{100 * h.error:+.1f} %".replace("-", "\u2212"),
        "yes" if h.rounds_to_print else "no",
    )
