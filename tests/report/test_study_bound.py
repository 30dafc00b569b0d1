"""What is said of a bound and of the designs beside it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from ridedown import load, simulate
from ridedown.report.study import bound_page
from ridedown.report.study_bound import beside_in_words, history_in_words
from ridedown.studies.bound import Design, bound_study, gap_of
from ridedown.studies.bound.least_peak import How, Stage

SLED = load("sled-half-sine")
BUILT = Design("belt", 300.0, 0.25)


@pytest.fixture(scope="module")
def simulated():
    return gap_of(simulate(SLED))


def test_a_simulated_occupant_beside_a_bound_with_slack_is_said_to_be_judged_without(simulated):
    study = bound_study(SLED, [0.1, 0.3], designs=[simulated, BUILT], slack=0.02)
    said = beside_in_words(study)
    assert said.startswith("The least peak beside adult is without the slack")  # the belt's numbers are judged with it
    assert said in bound_page(study).html()
    assert study.gaps[0].bound.peak < study.gaps[1].bound.peak


def test_without_slack_there_is_nothing_to_say(simulated):
    assert beside_in_words(bound_study(SLED, [0.1, 0.3], designs=[simulated, BUILT])) == ""


def test_stages_too_short_to_see_are_not_told(simulated):
    stages = (
        Stage(How.FREE, 0.0, 0.01), Stage(How.HELD, 0.01, 0.05), Stage(How.CARRIED, 0.05, 0.05001),
        Stage(How.HELD, 0.05001, 0.08), Stage(How.CARRIED, 0.08, float("inf")),
    )  # fmt: skip
    told = history_in_words(replace(simulated.bound, stages=stages))
    assert told == "free from 0.0 ms; held from 10.0 ms; carried from 80.0 ms"
