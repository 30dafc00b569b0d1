from __future__ import annotations

from datetime import date

import pytest

from ridedown.errors import InvalidInput
from ridedown.signals.ev5_header import FIELDS, MAX_PROBLEMS, Row, read_header


def header(*lines: str) -> str:
    return "\n".join(("----- EV5 -----", *lines, "----- END -----", ""))


TEST = ("----- TEST -----", "V5|" + "|" * 18)


def test_fields_have_their_names_in_order():
    line = "|".join(f"v{i}" for i in range(44))
    row = read_header(header(*TEST, "----- OCCUPANT -----", line)).rows("OCCUPANT")[0]
    assert row.text("HIC") == "v32"
    assert row.text("OCCCOM") == "v43"
    assert row.extra == ()


def test_there_are_as_many_fields_as_the_guide_lists():
    assert {section: len(names) for section, names in FIELDS.items()} == {
        "TEST": 20, "VEHICLE": 81, "BARRIER": 5, "OCCUPANT": 44, "RESTRAINT": 7, "INSTRUMENTATION": 20,
    }  # fmt: skip
    assert all(len(set(names)) == len(names) for names in FIELDS.values())


def test_later_fields_are_kept_as_they_stand():
    row = read_header(header(*TEST, "----- BARRIER -----", "R|LCB|0|0|WALL|new| field ")).rows("BARRIER")[0]
    assert row.extra == ("new", " field ")


def test_a_bar_at_the_end_is_no_field():
    found = read_header(header(*TEST, "----- BARRIER -----", "R|LCB|0|0|WALL|"))
    assert found.rows("BARRIER")[0].extra == ()
    assert found.problems == ()


def test_a_short_record_is_said_and_the_rest_not_available():
    found = read_header(header(*TEST, "----- BARRIER -----", "R|LCB"), "v1.EV5")
    assert found.rows("BARRIER")[0].number("BARANG") is None
    assert found.problems == ("v1.EV5:5: BARRIER has 2 fields of 5; the rest count as not available",)


def test_null_and_empty_are_not_available():
    row = Row(7, {"HIC": " NULL ", "T1": "", "T2": "null", "CSI": "0"})
    assert (row.number("HIC"), row.number("T1"), row.text("T2"), row.number("CSI"), row.number("TTI")) == (
        None,
        None,
        "",
        0.0,
        None,
    )
    assert row.date("HIC") is None


def test_dates_are_read_and_wrong_ones_refused():
    assert Row(3, {"D": "03/OCT/2017"}).date("D") == date(2017, 10, 3)
    assert Row(3, {"D": "3-oct-2017"}).date("D") == date(2017, 10, 3)
    for wrong in ("31/FEB/2017", "10/03/2017", "03/OKT/2017", "00/JAN/0000"):
        with pytest.raises(InvalidInput, match=r"need a date such as 03/OCT/2017\. Correct line 3"):
            Row(3, {"D": wrong}).date("D")


@pytest.mark.parametrize("text", ["twelve", "1,5", "nan", "1e400", "1e309", "1_0"])
def test_what_is_no_number_is_refused_with_its_line(text):
    with pytest.raises(InvalidInput, match=r"HIC: got .* need a number.* line 9"):
        Row(9, {"HIC": text}).number("HIC")


def test_a_whole_number_is_whole_and_bounded():
    assert Row(1, {"NFP": "-500", "NLP": "2999.0"}).whole("NLP") == 2999
    for wrong in ("1.5", "1e12"):
        with pytest.raises(InvalidInput, match="whole number below 1e9"):
            Row(1, {"NFP": wrong}).whole("NFP")


def test_an_unknown_section_is_kept_and_said():
    found = read_header(header(*TEST, "----- HYPERLOOP -----", "a|b"))
    assert found.unknown == {"HYPERLOOP": ("a|b",)}
    assert "HYPERLOOP" in found.problems[0]


def test_a_header_cut_short_is_said():
    found = read_header("----- EV5 -----\n----- TEST -----\nV5|A|" + "|" * 17)
    assert "cut short" in found.problems[-1]


def test_a_header_without_test_is_said():
    assert any("no TEST record" in problem for problem in read_header(header("----- BARRIER -----", "R|LCB|0|0|W")).problems)


@pytest.mark.parametrize(
    "text",
    ["", "\n\n", "# only comments\n", "time,force\n0,1\n", "----- TEST -----\nV5|x\n", "\x00\x01\xff", "----- EV5 -----\n"],
)
def test_what_is_no_header_is_refused(text):
    with pytest.raises(InvalidInput):
        read_header(text)


def test_line_ends_letter_case_and_comments_do_not_matter():
    text = "# c\r\n----- ev5 -----\r\n----- Test -----\r\n# c\r\n\r\nV5|A TEST" + "|" * 18 + "\r\n----- end -----\r\nrubbish"
    found = read_header(text)
    assert found.rows("TEST")[0].text("TITLE") == "A TEST"
    assert found.problems == ()


def test_problems_are_bounded():
    found = read_header(header(*TEST, "----- RESTRAINT -----", *["1|01"] * 5000))
    assert len(found.rows("RESTRAINT")) == 5000
    assert len(found.problems) <= MAX_PROBLEMS
