"""Reports on paper: what is in the file."""

from __future__ import annotations

import re
from functools import cache

import pytest

from ridedown.report import summary
from ridedown.report.figures import plots
from ridedown.report.pdf import Document, Part, pdf
from ridedown.report.run import pdf as pdf_of_run
from ridedown.report.study import Page, Section
from ridedown.report.study_pdf import pdf as pdf_of_study
from ridedown.report.tables import Column, Table
from ridedown.scenario import load
from ridedown.simulation import simulate
from tests.report.read_pdf import letters, pages, sections, unpacked


@cache
def of_p1() -> tuple[str, bytes]:
    response = simulate(load("p1"))
    made = pdf_of_run(response, plots(response))
    return unpacked(made), made


def small(**parts: object) -> bytes:
    return pdf(Document("A crash", "", "", (), (Part("Results", **parts),)))


def test_a_run_on_paper() -> None:
    text, _ = of_p1()
    assert 5 <= pages(text) <= 9
    assert {"Results", "Figures", "Events", "Sources", "Scenario"} <= set(sections(text))


def test_the_same_run_gives_the_same_bytes() -> None:
    response = simulate(load("p1"))
    assert pdf_of_run(response, plots(response)) == of_p1()[1]


def test_fonts_are_inside_and_text_is_text() -> None:
    text, _ = of_p1()
    fonts = set(re.findall(r"/FontName\s*/(\S+?)[\s/]", text))
    assert len(fonts) == len(re.findall(r"/FontFile[23]?\s", text)) >= 3
    assert all(name.partition("+")[2].startswith("DejaVu") for name in fonts)
    said = "".join(table.caption for table in summary.result_tables(simulate(load("p1"))))
    assert set(said) - {" "} <= letters(text)
    assert "−" in letters(text)


def test_figures_are_drawings_with_words() -> None:
    text, _ = of_p1()
    assert not re.search(r"/Subtype\s*/Image\b", text)
    drawn = plots(simulate(load("p1")))
    assert len(re.findall(r"/Alt[\s(<]", text)) >= len(drawn)
    assert "/StructTreeRoot" in text  # tagged: PDF/UA
    assert "pdfuaid:part" in text


def test_nothing_is_fetched_or_run() -> None:
    text, _ = of_p1()
    for word in ("/URI", "/JavaScript", "/Launch", "/SubmitForm", "/EmbeddedFile"):
        assert word not in text


def test_text_is_never_read_as_markup() -> None:
    evil = '#read("/etc/passwd") $x$ *bold* <label> @ref #panic("no") \\ // `raw`'
    table = Table(evil, (Column(evil, evil, numeric=False), Column(evil)), ((evil, evil),))
    made = pdf(Document(evil, evil, evil, (evil,), (Part(evil, words=(evil,), tables=(table,), text=evil),)))
    assert set(evil) - {" "} <= letters(unpacked(made))


def test_a_long_table_goes_on_from_page_to_page() -> None:
    columns = (Column("No."), Column("What", numeric=False))
    rows = tuple((f"{i}", "slack taken up") for i in range(150))
    text = unpacked(small(tables=(Table("Events", columns, rows),)))
    assert pages(text) == 3


@pytest.mark.parametrize("count", [2, 30])
def test_tables_of_any_width(count: int) -> None:
    columns = tuple(Column(f"Outcome {i}", "km/h") for i in range(count))
    made = small(tables=(Table("Wide", columns, (tuple("12345.6" for _ in columns),)),))
    assert pages(unpacked(made)) == 1


def test_words_in_other_scripts() -> None:
    assert small(words=("衝突 столкновение",))[:5] == b"%PDF-"


def test_a_study_on_paper() -> None:
    drawn = plots(simulate(load("sled-half-sine")))[:1]
    table = Table("Designs", (Column("Design"), Column("Peak", "g")), (("belt", "30"),))
    page = Page("Belts", "", "10 rows", (Section("figures", "Maps", (table,), drawn),), study='kind = "sweep"')
    assert {"Maps", "Study"} <= set(sections(unpacked(pdf_of_study(page))))
