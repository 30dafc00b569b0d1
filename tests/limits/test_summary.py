"""Every criterion of a crash, and the plain data made of it."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from ridedown.limits import criteria_of
from ridedown.limits.measured import RecordEvidence
from ridedown.signals.history import Filter, TimeHistory
from tests.limits.records import TIME, Builder, bell, full


def test_the_plain_data_has_what_the_commands_promise_and_is_json() -> None:
    data = criteria_of(full().record()).as_json()
    assert json.loads(json.dumps(data, allow_nan=False)) == data
    driver, vehicle = data["occupants"][0], data["vehicle"]
    assert {"seat", "hic15", "hic36", "clip_3ms_g", "chest_deflection_mm", "femur_n", "official"} <= set(driver)
    assert {"delta_v_kmh", "dynamic_crush_m", "time_to_zero_velocity_s", "olc_g", "vpi_ms2", "peak_g"} <= set(vehicle)
    assert driver["femur_n"] == pytest.approx({"left": -3000.0, "right": -9000.0}, rel=1e-3)
    assert driver["chest_deflection_mm"] == pytest.approx(30.0, rel=1e-3)
    assert set(driver["injury_risk"]) == {"head", "neck", "chest", "femur", "combined"}
    assert not driver["not_computed"]
    assert vehicle["peak_g"] == pytest.approx(40.0, rel=1e-2)


def test_change_of_velocity_crush_and_time_are_those_of_the_pulse() -> None:
    data = criteria_of(full().record(speed=12.0)).as_json()["vehicle"]
    assert data["delta_v_kmh"] == pytest.approx(3.6 * 40 * 9.80665 * 0.025 * np.sqrt(np.pi), rel=5e-3)
    v = 12.0 + np.cumsum(bell(-40.0, 0.08, 0.025)[TIME >= 0]) * 9.80665e-4
    assert data["time_to_zero_velocity_s"] == pytest.approx(1e-4 * int(np.argmax(v < 0.0)), abs=3e-4)
    assert data["dynamic_crush_m"] == pytest.approx(v[v > 0.0].sum() * 1e-4, rel=5e-3)


def test_without_a_speed_the_rest_is_still_computed() -> None:
    vehicle = criteria_of(full().record(speed=None)).vehicles[0]
    assert vehicle.crush is None
    assert "no speed" in vehicle.missing["speed"]
    assert vehicle.delta_v is not None


def test_a_vehicle_that_does_not_stop_has_no_crush_and_says_so() -> None:
    vehicle = criteria_of(full().record(speed=60.0)).vehicles[0]
    assert (vehicle.crush, vehicle.time_to_zero_velocity, vehicle.restitution) == (None, None, None)
    assert "does not come to rest" in vehicle.missing["dynamic_crush"]


def test_a_damaged_channel_stops_nothing_else() -> None:
    b = full()
    del b.histories["1"]  # the header promises a curve that cannot be read
    driver = criteria_of(b.record()).occupants[0]
    assert "hic15" in driver.missing
    assert "got no curve file" in driver.missing["hic15"]
    assert "chest_3ms" in driver.findings


def test_the_pulse_is_the_mean_of_the_sensors_that_agree_and_the_others_are_named() -> None:
    b = Builder()
    b.pulse("seat_crossmember_left", bell(-40.0) + np.where(TIME > 0.1, 1.0, 0.0))  # drifts by 1 g after 100 ms
    b.pulse("seat_crossmember_right", bell(-41.0)).pulse("seat_crossmember_left", bell(-39.0), redundant=True)
    vehicle = criteria_of(b.record()).vehicles[0]
    assert vehicle.used == ("2", "3")
    assert vehicle.rejected[0].startswith("channel 1")
    assert vehicle.peak.value == pytest.approx(-40.0 * 9.80665, rel=1e-2)


def test_a_sensor_that_ends_early_or_is_doubted_is_no_part_of_the_pulse() -> None:
    b = Builder()
    b.pulse("seat_crossmember_left", bell(-40.0)).pulse("seat_crossmember_right", bell(-40.0))
    b.pulse("seat_crossmember_right", bell(-40.0), status="questionable")
    b.histories["2"] = TimeHistory(bell(-40.0)[:1200], "g", start=-0.05, interval=1e-4, name="right")
    vehicle = criteria_of(b.record()).vehicles[0]
    assert vehicle.used == ("1",)
    assert any("ends early" in reason for reason in vehicle.rejected)
    assert any("questionable" in reason for reason in vehicle.rejected)
    assert any("only sensor" in remark for remark in vehicle.remarks)


def test_an_offset_before_contact_is_taken_off_the_pulse() -> None:
    clean, shifted = Builder(), Builder()
    for b, offset in ((clean, 0.0), (shifted, 0.7)):
        b.pulse("seat_crossmember_left", bell(-40.0) + offset).pulse("seat_crossmember_right", bell(-40.0) + offset)
    assert criteria_of(shifted.record()).vehicles[0].delta_v == pytest.approx(
        criteria_of(clean.record()).vehicles[0].delta_v, rel=1e-3
    )


def test_the_engine_is_no_place_for_a_vehicles_pulse() -> None:
    vehicle = criteria_of(Builder().pulse("engine_top", bell(-90.0)).record()).vehicles[0]
    assert vehicle.delta_v is None
    assert "no acceleration along x in the occupant compartment" in vehicle.missing["pulse"]


def test_what_was_filtered_to_its_class_is_not_filtered_again() -> None:
    b = Builder().add("femur_left", bell(-3000.0, width=0.001), "N", "z", "force")
    raw = b.histories["1"]
    once = criteria_of(b.record()).occupants[0].findings["femur_left"].value
    b.histories["1"] = raw.replaced(filtered=Filter(600, "SAE J211"))
    assert criteria_of(b.record()).occupants[0].findings["femur_left"].value == pytest.approx(3000.0, rel=1e-12)
    assert once < 3000.0
    b.histories["1"] = raw.replaced(filtered=Filter(60))
    finding = criteria_of(b.record()).occupants[0].findings["femur_left"]
    assert any("recorded in class 60, needs 600" in remark for remark in finding.remarks)


def test_occupants_that_only_the_channels_know_are_found() -> None:
    b = Builder().triple("head", 50.0)
    person = RecordEvidence(b.record(None)).people[0]
    assert (person.name, person.dummy, person.child) == ("01", "", None)
    assert "hic15" in criteria_of(b.record(None)).occupants[0].findings


def test_channels_of_another_vehicle_are_left_alone() -> None:
    b = Builder().pulse("vehicle", bell(-40.0))
    b.infos["1"] = replace(b.infos["1"], vehicle=2)
    found = criteria_of(b.record(None))
    assert [vehicle.vehicle for vehicle in found.vehicles] == ["1", "2"]
    assert found.vehicles[0].delta_v is None
    assert found.vehicles[1].delta_v is not None


def test_something_else_is_no_evidence() -> None:
    with pytest.raises(TypeError, match="need a TestRecord or a Response"):
        criteria_of(42)
