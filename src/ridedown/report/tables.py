"""Tables as data: written once, shown in a terminal and on a page."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Column:
    """A column's title and unit, and whether it holds numbers (set flush right)."""

    title: str
    unit: str = ""
    numeric: bool = True


@dataclass(frozen=True, slots=True)
class Table:
    """A caption, columns, and rows of text, one cell a column; the first cell names the row."""

    caption: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[str, ...], ...]

    @property
    def has_units(self) -> bool:
        """Whether any column has a unit, and so a line of units stands below the titles."""
        return any(column.unit for column in self.columns)

    def turned(self) -> Table:
        """The table on its side: a column for each row, a row for each column.

        >>> Table("", (Column("Car"), Column("Mass", "kg")), (("one", "900"), ("two", "1500"))).turned().rows
        (('Mass, kg', '900', '1500'),)
        """
        first, *others = self.columns
        columns = (Column(first.title, numeric=False), *(Column(row[0]) for row in self.rows))
        rows = (
            (f"{column.title}, {column.unit}".removesuffix(", "), *(row[c] for row in self.rows))
            for c, column in enumerate(others, 1)
        )
        return Table(self.caption, columns, tuple(rows))

    def without_empty_columns(self) -> Table:
        """The table without the columns in which no row has anything to say."""
        kept = [c for c in range(len(self.columns)) if any(row[c] != NONE for row in self.rows)]
        rows = tuple(tuple(row[c] for c in kept) for row in self.rows)
        return Table(self.caption, tuple(self.columns[c] for c in kept), rows)


NONE = "\u2013"
"""An en dash: there is no such number."""


def number(value: float | None, digits: int = 1, *, scale: float = 1.0) -> str:
    """A number with `digits` decimals after multiplying by `scale`, with a true minus sign; a dash where there is none.

    >>> number(0.26813, 1, scale=1e3), number(-0.001), number(None)
    ('268.1', '0.0', '–')
    """
    if value is None or not math.isfinite(value):
        return NONE
    text = f"{scale * value:.{digits}f}"
    return text.lstrip("-") if float(text) == 0.0 else text.replace("-", "\u2212")
