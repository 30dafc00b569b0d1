"""The regulations as data."""

from __future__ import annotations

import pytest

from ridedown.errors import UnknownName
from ridedown.limits import CRITERIA, Person, regulation, regulations
from ridedown.limits.findings import OF_OCCUPANTS, OF_VEHICLES

G = 9.80665
ADULT, WOMAN = Person("01", "1", "Hybrid III 50", False), Person("02", "1", "Hybrid III 05", False)


def limit_of(name: str, person: Person, criterion: str) -> float:
    found = {limit.criterion: limit.at_most for limit in regulation(name).limits_of(person)}
    return found[criterion]


def test_all_that_were_asked_for_are_there() -> None:
    assert set(regulations()) >= {
        "FMVSS 208", "FMVSS 213", "UN R129", "UN R44", "Euro NCAP MPDB", "EN 1317", "MASH", "founding paper",
    }  # fmt: skip


def test_every_limit_is_of_a_criterion_that_is_computed_and_says_where_it_was_read() -> None:
    assert set(CRITERIA) == set(OF_OCCUPANTS) | set(OF_VEHICLES)
    for name in regulations():
        rule = regulation(name)
        assert rule.read
        assert rule.limits
        assert all(limit.criterion in CRITERIA and limit.at_most > 0.0 for limit in rule.limits)


@pytest.mark.parametrize(
    ("criterion", "male", "female"),
    [
        ("hic15", 700.0, 700.0),
        ("chest_3ms", 60 * G, 60 * G),
        ("chest_deflection", 0.063, 0.052),
        ("nij", 1.0, 1.0),
        ("neck_tension", 4170.0, 2620.0),
        ("neck_compression", 4000.0, 2520.0),
        ("femur_left", 10_008.0, 6805.0),
        ("femur_right", 10_008.0, 6805.0),
    ],
)
def test_fmvss_208_has_its_own_limits_for_either_dummy(criterion: str, male: float, female: float) -> None:
    assert limit_of("FMVSS 208", ADULT, criterion) == pytest.approx(male)
    assert limit_of("FMVSS 208", WOMAN, criterion) == pytest.approx(female)


def test_the_other_limits_are_as_the_notes_have_them() -> None:
    child = Person("03", "1", "Q3", True)
    assert limit_of("FMVSS 213", child, "hic36") == 1000.0
    assert limit_of("FMVSS 213", child, "chest_3ms") == pytest.approx(60 * G)
    assert limit_of("UN R129", child, "chest_3ms") == pytest.approx(55 * G)
    assert limit_of("UN R44", child, "chest_3ms") == pytest.approx(55 * G)
    assert limit_of("founding paper", ADULT, "chest_peak") == pytest.approx(60 * G)
    assert [limit.at_most for limit in regulation("Euro NCAP MPDB").limits] == pytest.approx([25 * G, 40 * G])
    assert [limit.at_most for limit in regulation("EN 1317").limits] == pytest.approx([1.0, 1.4, 1.9, 33 / 3.6])
    assert [limit.at_most for limit in regulation("MASH").limits] == pytest.approx([9.1, 12.2, 15.0 * G, 20.49 * G])


def test_small_children_have_their_own_head_limits_in_r129() -> None:
    for dummy, hic, head in (("Q1.5", 600.0, 75 * G), ("Q6", 800.0, 80 * G)):
        child = Person("03", "1", dummy, True)
        assert (limit_of("UN R129", child, "hic15"), limit_of("UN R129", child, "head_3ms")) == pytest.approx((hic, head))


def test_who_a_regulation_is_for() -> None:
    assert regulation("UN R129").refuses(ADULT) == "UN R129 is for children"
    assert regulation("founding paper").refuses(Person("03", "1", "Q3", True)) == "founding paper is for adults"
    assert regulation("UN R129").refuses(Person("03", "1")) == ""  # nothing known against it


def test_a_name_may_be_written_loosely_and_an_unknown_one_is_told_the_nearest() -> None:
    assert regulation("fmvss 208") is regulation("FMVSS208")
    with pytest.raises(UnknownName, match="FMVSS 208"):
        regulation("FMVSS 280")
