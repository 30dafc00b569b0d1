"""The page of a study on paper."""

from __future__ import annotations

from ridedown.report.pdf import Document, Part
from ridedown.report.pdf import pdf as set_on_paper
from ridedown.report.study import Page


def pdf(page: Page) -> bytes:
    """What the page of a study has on it as PDF, A4."""
    parts = tuple(Part(one.title, tables=one.tables, plots=one.plots) for one in page.sections)
    if page.study:
        parts += (Part("Study", text=page.study),)
    return set_on_paper(Document(page.title, page.description, page.status, page.notes, parts))
