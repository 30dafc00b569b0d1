"""A measured test before a regulation: verdicts, and what cannot be judged and why."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ridedown import criteria
from ridedown.limits import Judgement, Verdict, assess
from ridedown.signals.history import Filter, TimeHistory
from ridedown.signals.record import Occupant, Vehicle
from tests.limits.records import TIME, Builder, G, bell, full


def by_criterion(judgements: tuple[Judgement, ...]) -> dict[str, Judgement]:
    return {judgement.criterion: judgement for judgement in judgements}


def test_every_criterion_of_fmvss_208_is_judged_where_every_channel_is_there() -> None:
    found = assess(full().record(), "FMVSS 208")
    assert {j.criterion for j in found.not_judged} == {""}  # containment, seen on film only
    assert not found.failed
    got = by_criterion(found.passed)
    assert got["hic15"].value == pytest.approx(criteria.hic(TIME, bell(60.0 * G)).value, rel=1e-3)
    clip = criteria.clip(TIME, bell(45.0 * G), cumulative=True).value
    assert got["chest_3ms"].value == pytest.approx(clip, rel=1e-3)
    assert got["chest_deflection"].value == pytest.approx(0.030, rel=1e-3)
    assert got["femur_right"].value == pytest.approx(9000.0, rel=1e-3)
    assert got["femur_right"].margin == pytest.approx(1008.0, rel=1e-2)
    assert got["femur_right"].clause == "S6.5"
    assert got["nij"].value == pytest.approx(1000.0 / 6806.0 + (20.0 + 0.01778 * 500.0) / 135.0, rel=1e-3)
    assert got["neck_tension"].used == ("8",)


def test_the_smaller_dummy_fails_what_the_larger_one_passes() -> None:
    found = by_criterion(assess(full().record(("Hybrid III", "05")), "FMVSS 208").failed)
    assert set(found) == {"femur_right"}
    assert found["femur_right"].margin == pytest.approx(6805.0 - 9000.0, rel=1e-2)
    assert str(found["femur_right"]).endswith("limit 6805 N, failed")


@pytest.mark.parametrize(("force", "verdict"), [(10_008.0, Verdict.PASSED), (10_008.1, Verdict.FAILED)])
def test_just_at_the_limit_passes(force: float, verdict: Verdict) -> None:
    b = Builder().add("femur_left", np.full(TIME.size, -force), "N", "z", "force")
    b.histories["1"] = b.histories["1"].replaced(filtered=Filter(600))  # as it stands: no rounding of a filter
    assert by_criterion(assess(b.record(), "FMVSS 208").judgements)["femur_left"].verdict is verdict


def test_a_missing_channel_is_named_and_the_rest_is_judged() -> None:
    b = full()
    b.infos["2"] = replace(b.infos["2"], readable=False, status="no file")
    found = by_criterion(assess(b.record(), "FMVSS 208").judgements)
    assert found["hic15"].verdict is Verdict.NOT_JUDGED
    assert "channel 2 head y: no file" in found["hic15"].reason
    assert found["chest_3ms"].verdict is Verdict.PASSED


@pytest.mark.parametrize("status", ["questionable", "meaningless", "Channel failed"])
def test_a_channel_that_its_laboratory_doubts_is_not_judged_by(status: str) -> None:
    b = full()
    b.infos["5"] = replace(b.infos["5"], status=status)
    found = by_criterion(assess(b.record(), "FMVSS 208").judgements)
    assert found["chest_3ms"].verdict is Verdict.NOT_JUDGED
    assert status in found["chest_3ms"].reason


def test_the_second_sensor_stands_in_and_is_named() -> None:
    b = full()
    b.infos["1"] = replace(b.infos["1"], status="questionable")
    b.add("head", bell(-40.0), "g", "x", redundant=True)
    found = by_criterion(assess(b.record(), "FMVSS 208").judgements)["hic15"]
    assert found.verdict is Verdict.PASSED
    assert len(b.infos) == 18
    assert found.used[0] == "18"
    assert any("second sensor" in remark for remark in found.remarks)


def test_axes_that_are_sampled_differently_are_not_put_together() -> None:
    b = full()
    b.histories["2"] = TimeHistory(np.zeros(100), "g", start=0.0, interval=1e-4, name="head y")
    found = by_criterion(assess(b.record(), "FMVSS 208").judgements)["hic15"]
    assert "not sampled at the same times" in found.reason


def test_a_rate_too_low_for_the_channel_class_is_a_reason() -> None:
    b = full()
    for key in "123":
        b.histories[key] = TimeHistory(np.zeros(200), "g", start=0.0, interval=1e-3, name="head")
    found = by_criterion(assess(b.record(), "FMVSS 208").judgements)["hic15"]
    assert found.verdict is Verdict.NOT_JUDGED
    assert "1000" in found.reason


def test_head_noise_beyond_the_channel_class_does_not_count() -> None:
    noise = 300.0 * np.sin(2.0 * np.pi * 4500.0 * TIME)
    b = Builder().triple("head", 60.0)
    b.histories["1"] = b.histories["1"].replaced(values=b.histories["1"].values + noise)
    quiet, loud = (
        by_criterion(assess(x.record(), "FMVSS 208").judgements)["hic15"] for x in (Builder().triple("head", 60.0), b)
    )
    assert loud.value == pytest.approx(quiet.value, rel=0.05)


def test_a_dummy_without_limits_is_said_so() -> None:
    found = assess(full().record(("THOR", "50")), "FMVSS 208")
    assert found.not_judged[0].reason == "FMVSS 208 has no limits here for THOR 50"
    assert not found.passed


def test_a_child_regulation_does_not_judge_an_adult() -> None:
    assert "is for children" in assess(full().record(), "UN R129").not_judged[0].reason


def test_a_child_is_judged_by_the_child_regulations() -> None:
    found = by_criterion(assess(full().record(("Q6", "")), "UN R129").judgements)
    assert found["chest_3ms"].verdict is Verdict.PASSED
    assert found["head_3ms"].limit == pytest.approx(80 * G)


def test_a_test_without_occupants_says_so() -> None:
    b = Builder().pulse("vehicle", bell(-40.0))
    assert "no occupants" in assess(b.record(None), "FMVSS 208").not_judged[0].reason


def test_asi_of_three_axes_is_judged_and_of_fewer_only_when_it_fails() -> None:
    whole = assess(full().record(), "EN 1317")
    assert {j.level for j in whole.failed if j.criterion == "asi"} == {"class A", "class B", "class C"}
    assert by_criterion(whole.judgements)["thiv"].verdict in {Verdict.PASSED, Verdict.FAILED}
    mild = Builder().pulse("vehicle", bell(-12.0, 0.08, 0.02))
    found = {j.level: j for j in assess(mild.record(), "EN 1317").judgements if j.criterion == "asi"}
    assert 0.5 < found["class A"].value < 1.0
    assert found["class A"].verdict is Verdict.NOT_JUDGED
    assert "lower bound" in found["class A"].reason
    assert "vertical" in " ".join(found["class A"].remarks)
    hard = Builder().pulse("vehicle", bell(-40.0, 0.06, 0.03))
    assert all(j.verdict is Verdict.FAILED for j in assess(hard.record(), "EN 1317").judgements if j.criterion == "asi")


def test_mash_needs_the_lateral_channel() -> None:
    found = assess(full().record(), "MASH")
    assert {j.criterion for j in found.passed + found.failed} == {"occupant_impact_velocity", "ridedown_acceleration"}
    bare = assess(Builder().pulse("vehicle", bell(-40.0)).record(), "MASH")
    assert all("no channel for lateral" in j.reason for j in bare.judgements)


def test_olc_is_judged_of_the_pulse_with_its_channels_named() -> None:
    found = assess(full().record(), "Euro NCAP MPDB")
    olc = by_criterion(found.judgements)["olc"]
    assert len(olc.used) == 2
    assert any("barrier trolley" in remark for remark in olc.remarks)


def test_a_seat_names_its_vehicle_where_more_than_one_has_occupants() -> None:
    b = full()
    for axis, share in zip("xyz", (-2 / 3, 1 / 3, 2 / 3), strict=True):
        b.add("head", bell(share * 90.0), "g", axis, vehicle=2)
    alone = b.record()
    both = replace(
        alone, vehicles=(*alone.vehicles, Vehicle(2)), occupants=(*alone.occupants, Occupant("01", 2, "Hybrid III", "50"))
    )
    heads = [one for one in assess(both, "FMVSS 208").judgements if one.criterion == "hic15"]
    assert [(one.subject, one.vehicle) for one in heads] == [("01 of vehicle 1", "1"), ("01 of vehicle 2", "2")]
    assert heads[0].value < heads[1].value
    assert by_criterion(assess(full().record(), "FMVSS 208").judgements)["hic15"].subject == "01"


def test_a_vehicle_is_named_for_machines_too() -> None:
    found = by_criterion(assess(full().record(), "Euro NCAP MPDB").judgements)["olc"]
    assert (found.subject, found.vehicle) == ("vehicle 1", "1")
