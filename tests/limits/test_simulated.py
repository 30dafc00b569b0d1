"""A simulated crash before a regulation: what a lumped mass can tell, and what it cannot."""

from __future__ import annotations

import json

import pytest

from ridedown import load, simulate
from ridedown.limits import Verdict, assess, criteria_of
from ridedown.limits.simulated import ResponseEvidence
from ridedown.response import Response
from ridedown.signals.history import TimeHistory

G = 9.80665


def test_the_chest_of_a_lumped_adult_is_judged_and_its_head_is_not() -> None:
    response = simulate(load("p1"))
    found = {j.criterion: j for j in assess(response, "FMVSS 208").judgements if j.subject == "adult"}
    peak = abs(response.peak("adult.acceleration").value)
    assert 0.8 * peak < found["chest_3ms"].value <= peak
    assert found["chest_3ms"].verdict in {Verdict.PASSED, Verdict.FAILED}
    assert (found["chest_3ms"].verdict is Verdict.PASSED) == (found["chest_3ms"].value <= 60 * G)
    assert "whole lumped mass" in found["chest_3ms"].remarks[0]
    assert found["hic15"].verdict is Verdict.NOT_JUDGED
    assert "no head" in found["hic15"].reason
    assert found["hic15"].value is not None  # shown as an indicator


def test_a_lumped_child_is_judged_by_the_child_regulations_only() -> None:
    response = simulate(load("p1"))
    child = [j for j in assess(response, "UN R129").judgements if j.subject == "child"]
    assert [j.criterion for j in child] == ["chest_3ms"]
    adult = [j for j in assess(response, "UN R129").judgements if j.subject == "adult"]
    assert adult[0].reason == "UN R129 is for children"


def test_the_criteria_of_a_response_are_those_of_its_exact_channels() -> None:
    response = simulate(load("p1"))
    found = criteria_of(response)
    data = found.as_json()
    assert json.loads(json.dumps(data, allow_nan=False)) == data
    assert data["simulated"]
    vehicle = response.vehicles["vehicle1"]
    assert data["vehicle"]["dynamic_crush_m"] == vehicle.dynamic_crush.value
    assert data["vehicle"]["peak_g"] == pytest.approx(abs(vehicle.peak_acceleration.value) / G, rel=1e-5)
    assert data["vehicle"]["time_to_zero_velocity_s"] == pytest.approx(vehicle.time_to_rest, abs=1e-5)
    assert {occupant["seat"] for occupant in data["occupants"]} == set(response.occupants)
    assert "no ribs" in data["occupants"][0]["not_computed"]["chest_deflection"]


def test_the_roadside_criteria_of_a_head_on_crash_are_complete() -> None:
    found = {j.criterion: j for j in assess(simulate(load("p1")), "EN 1317").judgements}
    assert found["asi"].verdict is not Verdict.NOT_JUDGED


def test_a_pulse_that_begins_with_a_jump_begins_at_zero(monkeypatch: pytest.MonkeyPatch) -> None:
    def history(self: Response, channel: str, tolerance: float = 1e-6) -> TimeHistory:
        return TimeHistory([-120.0, -120.0, 0.0], "m/s2", stamps=[0.0, 0.1, 0.2], name=channel)

    monkeypatch.setattr(Response, "history", history, raising=False)
    pulse = ResponseEvidence(simulate(load("p1"))).pulse("vehicle1")
    assert pulse.time.tolist() == [0.0, 0.0, 0.1, 0.2]
    assert pulse.acceleration.tolist() == [0.0, -120.0, -120.0, 0.0]


def test_the_founding_papers_limit_is_on_the_peak() -> None:
    response = simulate(load("p1"))
    found = {j.subject: j for j in assess(response, "founding paper").judgements}
    peak = abs(response.peak("adult.acceleration").value)
    assert found["adult"].value == pytest.approx(peak, rel=1e-4)
    assert (found["adult"].verdict is Verdict.PASSED) == (peak <= 60 * G)
    assert found["child"].reason == "founding paper is for adults"


def test_two_vehicles_have_no_restitution_of_a_wall() -> None:
    data = criteria_of(simulate(load("example-offset"))).as_json()
    assert "fixed wall" in json.dumps(data)
    assert not any("restitution" in key and data["vehicle"][key] is not None for key in data["vehicle"])


def test_a_response_as_a_record_is_judged_by_what_its_codes_say() -> None:
    response = simulate(load("example-wall"))
    direct, recorded = criteria_of(response).as_json()["vehicle"], criteria_of(response.to_record()).as_json()["vehicle"]
    assert recorded["delta_v_kmh"] == pytest.approx(direct["delta_v_kmh"], rel=1e-2)
    assert recorded["dynamic_crush_m"] == pytest.approx(direct["dynamic_crush_m"], rel=1e-2)
