"""NHTSA test 10146 before FMVSS 208, with the channels of its vehicle chosen by rule: a 2018 car, 57.09 km/h into a rigid wall.

Official values: the header of the test (HIC, 3 ms clip and femur forces, an oracle that nobody here wrote).
"""

from __future__ import annotations

from pathlib import Path

import pytest

from ridedown.limits import Verdict, assess, criteria_of
from ridedown.signals.ev5 import read_ev5
from ridedown.signals.record import TestRecord

DATA = Path(__file__).resolve().parents[3] / "shared" / "data" / "nhtsa_v10146"


@pytest.fixture(scope="module")
def record() -> TestRecord:
    if not DATA.is_dir():
        pytest.skip(f"measured test 10146 is not at {DATA}")
    return read_ev5(DATA)


def test_the_sensors_that_agree_are_the_right_primary_and_the_left_second(record: TestRecord) -> None:
    vehicle = criteria_of(record).vehicles[0]
    assert vehicle.used == ("94", "99")
    assert [reason.split()[1] for reason in vehicle.rejected] == ["93", "100"]
    drift = float(vehicle.rejected[0].split(": ")[1].split()[0])
    assert drift > 0.3  # m/s: 93 drifts after 120 ms


def test_the_pulse_gives_back_the_speed_and_9_to_10_kmh_of_rebound(record: TestRecord) -> None:
    data = criteria_of(record).as_json()["vehicle"]
    assert data["speed_kmh"] == pytest.approx(57.09)
    assert 9.0 <= data["delta_v_kmh"] - 57.09 <= 10.5
    assert data["dynamic_crush_m"] == pytest.approx(0.737, abs=0.005)
    assert data["time_to_zero_velocity_s"] == pytest.approx(0.073, abs=0.0015)
    assert data["restitution"] == pytest.approx((data["delta_v_kmh"] - 57.09) / 57.09, rel=1e-3)


@pytest.mark.parametrize(("seat", "hic", "femurs"), [("01", 140.0, (-1923.0, -2345.0)), ("02", 335.0, (-1182.0, -1378.0))])
def test_the_criteria_are_the_official_ones(record: TestRecord, seat: str, hic: float, femurs: tuple[float, float]) -> None:
    found = next(one for one in criteria_of(record).as_json()["occupants"] if one["seat"] == seat)
    assert found["hic15"] == pytest.approx(hic, abs=0.5)
    assert (found["femur_n"]["left"], found["femur_n"]["right"]) == pytest.approx(femurs, abs=0.5)
    assert found["clip_3ms_g"] == pytest.approx(41.0, abs=0.5)  # the header has it in whole g
    assert found["official"]["HIC"] == hic


def test_every_fmvss_208_limit_with_a_channel_is_kept_and_the_neck_has_none(record: TestRecord) -> None:
    found = assess(record, "FMVSS 208")
    assert not found.failed
    assert len(found.passed) == 10
    unjudged = {judgement.criterion for judgement in found.not_judged}
    assert unjudged == {"nij", "neck_tension", "neck_compression", ""}
    assert all("no file" in judgement.reason for judgement in found.not_judged if judgement.criterion)


def test_a_wall_is_no_road_restraint_system(record: TestRecord) -> None:
    found = [judgement for judgement in assess(record, "EN 1317").judgements if judgement.criterion == "asi"]
    assert all(judgement.verdict is Verdict.FAILED for judgement in found)
    assert all(judgement.value == pytest.approx(2.74, abs=0.02) for judgement in found)
