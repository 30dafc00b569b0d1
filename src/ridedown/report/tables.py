"""Tables as data: written once, shown in a terminal and on a page."""

from __future__ import annotations

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


MINUS, NONE = "\u2212", "\u2013"  # a true minus sign; an en dash for "not there"


def number(value: float | None, digits: int = 3, *, scale: float = 1.0) -> str:
    """A number with `digits` decimals after multiplying by `scale`; a dash where there is none.

    >>> number(0.26813, 1, scale=1e3), number(None)
    ('268.1', '–')
    """
    if value is None or value != value:  # noqa: PLR0124  nan
        return NONE
    text = f"{scale * value:.{digits}f}"
    if float(text) == 0.0:
        text = text.lstrip("-")
    return text.replace("-", MINUS)
