from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ridedown.errors import InvalidInput
from ridedown.signals.isomme_text import by_key, descriptors_of, folded, one_line, read_descriptors, written


def test_a_value_may_hold_colons_and_a_key_may_repeat():
    head = descriptors_of("Time of test                :10:32:45\nComments:one\nComments  :NOVALUE\nComments: two\n", "t.mme")
    assert head.text("time of TEST") == "10:32:45"
    assert head.all("Comments") == ("one", "two")
    assert len(head.pairs) == 4


@pytest.mark.parametrize("missing", ["", "NOVALUE", "  novalue ", " "])
def test_novalue_and_empty_are_missing(missing):
    head = descriptors_of(f"Unit :{missing}\n", "t.001")
    assert head.text("Unit") == ""
    assert head.number("Unit") is None
    assert head.quantity("Unit") is None


def test_quantities_may_name_their_unit():
    head = descriptors_of("a:13.92\nb: 50 km/h\nc:965kg\nd:fast\ne:-1.5e-4\nf:NOVALUE\ng:1e999\n", "t.mme")
    assert head.quantity("a") == (13.92, "")
    assert head.quantity("b") == (50.0, "km/h")
    assert head.quantity("c") == (965.0, "kg")
    assert head.number("e") == -1.5e-4
    with pytest.raises(InvalidInput, match=r"^t\.mme:4: got d 'fast'; need a number"):
        head.quantity("d")
    with pytest.raises(InvalidInput, match=r"^t\.mme:2: got b '50 km/h'; need a bare number"):
        head.number("b")
    with pytest.raises(InvalidInput, match=r"^t\.mme:1: got a '13.92'; need a whole number"):
        head.whole("a")
    with pytest.raises(InvalidInput, match=r"^t\.mme:7"):
        head.number("g")


def test_the_head_of_a_channel_ends_where_the_values_begin():
    head, end = read_descriptors(["Unit:g", "", "Comments:x", "1.0", "2.0"], "t.001")
    assert end == 3
    assert head.pairs == (("Unit", "g"), ("Comments", "x"))


def test_a_line_that_is_no_descriptor_is_named():
    with pytest.raises(InvalidInput, match=r"^t\.mme:2: got 'rubbish'"):
        descriptors_of("Title:x\nrubbish\n", "t.mme")


WORDS = st.text(st.characters(blacklist_categories=["Cs", "Cc"], blacklist_characters=":"), min_size=1, max_size=40)
VALUES = st.text(st.characters(blacklist_categories=["Cs", "Cc"]), max_size=60)


@given(st.lists(st.tuples(WORDS.filter(lambda key: key.split()), VALUES), max_size=8))
def test_what_is_written_is_read_again(pairs):
    read = descriptors_of(written(pairs), "t.mme")
    expected = [(" ".join(k.split()), "" if v.strip().upper() == "NOVALUE" else v.strip()) for k, v in pairs]
    assert [(folded(k), v) for k, v in read] == [(folded(k), v) for k, v in expected]


def test_a_value_of_several_lines_repeats_its_key():
    text = written([("Comments", "a\r\nb"), ("Title", "")])
    assert text == "Comments                    :a\nComments                    :b\nTitle                       :NOVALUE\n"
    assert by_key(descriptors_of(text, "t.mme")) == {"Comments": "a\nb", "Title": ""}


def test_one_line_holds_no_line_end():
    assert one_line(" a \r\n b\n") == "a b"
