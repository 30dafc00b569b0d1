"""Reports on paper: the same words, tables and figures as on the pages, set by typst as one PDF that needs nothing else.

Figures stay drawings, text stays text, fonts are inside, and the same report gives the same bytes.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import matplotlib as mpl

import ridedown
from ridedown.report.style import Plot
from ridedown.report.tables import Table

_FONTS = Path(mpl.get_data_path()) / "fonts" / "ttf"
"""DejaVu, which every figure is set in: matplotlib brings it along."""


@dataclass(frozen=True, slots=True)
class Part:
    """A heading and what stands below it: sentences, tables, figures, a file's text as it is."""

    title: str
    words: tuple[str, ...] = ()
    tables: tuple[Table, ...] = ()
    plots: tuple[Plot, ...] = ()
    text: str = ""


@dataclass(frozen=True, slots=True)
class Document:
    """A report: title, a description, a line on how it stands, what a reader has to know, and its parts."""

    title: str
    description: str
    status: str
    notes: tuple[str, ...]
    parts: tuple[Part, ...]


def pdf(document: Document) -> bytes:
    """The report as PDF, A4.

    >>> made = pdf(Document("A crash", "", "", (), (Part("Results", words=("Nothing moved.",)),)))
    >>> made[:5], made == pdf(Document("A crash", "", "", (), (Part("Results", words=("Nothing moved.",)),)))
    (b'%PDF-', True)
    """
    import typst  # noqa: PLC0415  a whole compiler, which only those wait for who want it

    plots = [plot for part in document.parts for plot in part.plots]
    figures = {plot.name: f"figure-{k}.svg" for k, plot in enumerate(plots)}
    sources: Any = {  # its files by name, `main` the first: typst's own annotations know paths only
        "main": files("ridedown.report").joinpath("templates", "report.typ").read_bytes(),
        "data.json": json.dumps(_data(document, figures)).encode(),
        **{figures[plot.name]: plot.svg for plot in plots},
    }
    # all it reads is in memory; ua-1 is PDF/UA: tagged, with words for every figure, or it is not made
    made = typst.compile(sources, font_paths=[str(_FONTS)], format="pdf", pdf_standards="ua-1")
    assert isinstance(made, bytes)
    return made


def _data(document: Document, figures: Mapping[str, str]) -> dict[str, object]:
    """What the template reads. figures: the file of each, by name."""
    return {
        "version": ridedown.__version__,
        "title": document.title,
        "description": document.description,
        "status": document.status,
        "notes": document.notes,
        "parts": [
            {
                "title": part.title,
                "words": part.words,
                "tables": [_table(table) for table in part.tables if table.rows],
                "plots": [
                    {"file": figures[plot.name], "title": plot.title, "description": plot.description} for plot in part.plots
                ],
                "text": part.text,
            }
            for part in document.parts
        ],
    }


def _table(table: Table) -> dict[str, object]:
    columns = [{"title": one.title, "unit": one.unit, "numeric": one.numeric} for one in table.columns]
    return {"caption": table.caption, "units": table.has_units, "columns": columns, "rows": table.rows}
