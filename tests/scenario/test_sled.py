"""Sled scenarios: files and back, parameters, what is refused and in which words."""

from __future__ import annotations

import json
import tomllib
from typing import Any

import numpy as np
import pytest

from ridedown.errors import InvalidInput, UnknownName
from ridedown.scenario import (
    CrashScenario,
    NetworkScenario,
    SledScenario,
    dump,
    json_schema,
    load,
    lower,
    parameters,
    pulse_measured,
    substitute,
)
from ridedown.scenario.sled import KINDS
from ridedown.signals import TestRecord, TimeHistory, read, write

BELT = {"stiffness": "98.1 kN/m", "slack": "5 mm", "damping_ratio": "50 %"}
ADULT = {"kind": "adult", "mass": "80 kg", "restraint": BELT}
SINE = {"kind": "half-sine", "delta_v": "50 km/h", "duration": "100 ms"}
POINTS = {"kind": "points", "points": [["0 ms", "0 g"], ["40 ms", "-25 g"], ["90 ms", "0 g"]]}
WALL = {"vehicle1": {"mass": 1500, "speed": 14, "members": {"pieces": [{"stiffness": "300 kN/m"}]}}, "duration": "150 ms"}
EXAMPLES: list[dict[str, Any]] = [
    SINE,
    {"kind": "haversine", "peak": "20 g", "duration": "120 ms"},
    {"kind": "square", "peak": "20 g", "delta_v": 12},
    {"kind": "triangle", "peak": "20 g", "delta_v": 12, "peak_at": "30 %"},
    {"kind": "trapezoid", "peak": "20 g", "delta_v": 12, "rise": 0.1, "fall": 0.2},
    {"kind": "equivalent-square-wave", "speed": "56 km/h", "crush": "0.7 m"},
    {"kind": "tipped-equivalent-square-wave", "speed": 15, "crush": "0.62 m", "time": "90 ms"},
    {"kind": "fmvss-208-sled"},
    {**POINTS, "scale": "110 %"},
    {"kind": "scenario", "scenario": "paper-adult-offset", "vehicle": 2},
    {"kind": "scenario", "scenario": "marzbanrad-2", "vehicle": "vehicle"},
    {"kind": "scenario", "scenario": WALL, "scale": 0.9},
]


def sled(pulse: object, **more: Any) -> SledScenario:
    scenario = load({"pulse": pulse, "occupants": [ADULT], **more})
    assert isinstance(scenario, SledScenario)
    return scenario


def refusal(pulse: object, **more: Any) -> str:
    with pytest.raises(InvalidInput) as error:
        load({"pulse": pulse, **more})
    assert "\n" not in str(error.value)
    return str(error.value)


@pytest.fixture
def test_file(tmp_path):
    """A test of 200 ms, a haversine of 12 m/s within it, from -20 ms on; two channels that share it, and others."""
    time = np.arange(-200, 1801) * 1e-4
    pulse = -12 / 0.05 * np.where((time > 0) & (time < 0.1), (1 - np.cos(2 * np.pi * time / 0.1)) / 2, 0.0)
    curves = [
        TimeHistory(pulse / 9.80665 + sign * np.sin(300 * time), "g", start=-0.02, interval=1e-4, name=name)
        for sign, name in ((1, "tunnel left x"), (-1, "tunnel right x"))
    ]
    curves.append(TimeHistory(pulse * 0 + 5, "N", start=-0.02, interval=1e-4, name="belt"))
    codes = (("across", "11CHST0000H3ACYA"), ("in all", "11CHST0000H3ACRA"))
    curves += [TimeHistory(pulse, "m/s2", start=-0.02, interval=1e-4, name=name, code=code) for name, code in codes]
    write(TestRecord.of(curves, identifier="run7"), tmp_path / "run7.csv")
    return tmp_path / "run7.csv"


def measured(file: object, **more: Any) -> dict[str, Any]:
    return {"kind": "measured", "file": str(file), "channels": ["tunnel left x", "tunnel right x"], **more}


@pytest.mark.parametrize("pulse", EXAMPLES, ids=lambda pulse: pulse["kind"])
def test_every_kind_comes_back_from_its_file(pulse):
    scenario = sled(pulse, name="a sled", speed="13 m/s")
    assert load(tomllib.loads(dump(scenario))) == scenario
    assert SledScenario.model_validate(scenario.model_dump()) == scenario


def test_there_is_an_example_of_every_kind():
    assert {pulse["kind"] for pulse in EXAMPLES} | {"measured"} == set(KINDS)


@pytest.mark.parametrize("pulse", EXAMPLES[:9], ids=lambda pulse: pulse["kind"])
def test_every_kind_lowers_to_a_driven_vehicle_with_its_occupant(pulse):
    network = lower(sled(pulse))
    assert network.coordinates == ("vehicle1", "adult")
    assert network.driven == 0
    assert network.parent.tolist() == [-1, 0]
    assert network.pulse_start[0] == 0.0
    assert (np.diff(network.pulse_start) > 0).all()
    assert network.pulse_series.shape[1] <= 15


def test_the_occupant_is_the_one_of_a_crash():
    crash = lower(load({**WALL, "occupants": [ADULT]}))
    e, f = crash.elements.index("adult.restraint"), 0
    network = lower(sled(SINE))
    for name in ("stiffness", "damping", "slack"):
        assert getattr(network, name)[f] == getattr(crash, name)[e]


def test_what_is_left_out():
    assert sled(SINE).duration == 0.2
    assert sled({**SINE, "duration": "300 ms"}).duration == 0.3
    assert sled({"kind": "scenario", "scenario": WALL}).duration == 0.15
    assert sled(SINE).initial_speed == pytest.approx(50 / 3.6)
    assert sled(SINE, speed="60 km/h").initial_speed == pytest.approx(60 / 3.6)
    assert sled({"kind": "scenario", "scenario": WALL, "scale": 0.5}).initial_speed == 7.0
    assert [o.name for o in load({"pulse": SINE, "occupants": [ADULT, ADULT]}).occupants] == ["adult", "adult2"]


def test_numbers_have_paths():
    scenario = sled(SINE)
    assert {"pulse.delta_v", "pulse.duration", "adult.restraint.stiffness", "duration"} <= {
        p.path for p in parameters(scenario)
    }
    many = substitute(scenario, {"pulse.delta_v": [10.0, 12.0], "adult.restraint.stiffness": [5e4, 6e4], "speed": 11.0})
    assert lower(many).rate[0].tolist() == [11.0, 11.0]
    assert substitute(sled(POINTS), {"pulse.points.1.1": -300.0}).pulse.points[1] == (0.04, -300.0)
    assert lower(substitute(sled(POINTS), {"pulse.scale": [1.0, 2.0]})).pulse_amplitude.tolist() == [1.0, 2.0]


@pytest.mark.parametrize(
    ("pulse", "values", "sentence"),
    [
        (SINE, {"pulse.peak": 200.0}, "pulse.peak: got all of delta_v, duration and peak"),
        (SINE, {"pulse.delta_v": [10.0, -1.0]}, "pulse.delta_v: got -1 m/s in row 1"),
        (EXAMPLES[3], {"pulse.peak_at": [0.1, 0.2]}, "pulse.peak_at: got 0.2 in row 1; need the same value in every row"),
        (EXAMPLES[4], {"pulse.fall": [0.1, 0.2]}, "pulse.fall: got 0.2 in row 1"),
        (EXAMPLES[6], {"pulse.crush": [0.62, 0.7]}, "pulse.crush: got 0.7 m in row 1"),
        (POINTS, {"pulse.points.1.1": [-1.0, -2.0]}, "pulse.points.1.1: got -2 in row 1; need the same value in every row"),
        (POINTS, {"pulse.points.1.0": 0.2}, "pulse.points.2.0: got 0.09 s; need >= 0.2 s"),
    ],
)
def test_columns_that_would_change_the_shape_are_refused(pulse, values, sentence):
    with pytest.raises(InvalidInput) as error:
        substitute(sled(pulse), values)
    assert str(error.value).startswith(sentence)


def test_the_schema_knows_every_kind():
    schema = json.loads(json.dumps(json_schema()))
    kinds: set[str] = set()
    for definition in schema["$defs"].values():
        kind = definition.get("properties", {}).get("kind", {})
        kinds |= {kind["const"]} if "const" in kind else set(kind.get("enum", ()))
    assert set(KINDS) <= kinds
    assert "default" not in schema["$defs"]["SledScenario"]["properties"]["duration"]
    assert set(schema["$defs"]["SledScenario"]["properties"]) == set(SledScenario.model_fields)


@pytest.mark.parametrize(
    ("pulse", "sentence"),
    [
        ({}, 'pulse.kind: got nothing; need one of "half-sine"'),
        ("half-sine", 'pulse: got "half-sine"; need a table'),
        ({**SINE, "kind": "halfsine"}, 'pulse.kind: got "halfsine"'),
        ({**SINE, "peak": "20 g"}, "pulse.peak: got all of delta_v, duration and peak; need two"),
        ({"kind": "square"}, "pulse.delta_v: got nothing; need two"),
        ({"kind": "square", "peak": "20 g"}, "pulse.delta_v: got nothing beside peak; need two"),
        ({**SINE, "duration": 0}, "pulse.duration: got 0 s; need > 0 s"),
        ({**SINE, "duration": "-1 ms"}, 'pulse.duration: got "-1 ms"; need > 0 s'),
        ({**SINE, "delta_v": "-50 km/h"}, 'pulse.delta_v: got "-50 km/h"; need > 0 m/s'),
        ({**SINE, "delta_v": float("nan")}, "pulse.delta_v: got nan; need a finite number"),
        ({**SINE, "rise": 0.1}, "pulse.rise: got an unknown key"),
        ({**EXAMPLES[4], "fall": 0.95}, "pulse.fall: got 1.05 together with the rise"),
        ({"kind": "points", "points": []}, "pulse.points: got 0; need 2"),
        ({"kind": "points", "points": [[0, -1], [0.1, -2], [0.05, 0]]}, "pulse.points.2.0: got 0.05 s; need >= 0.1 s"),
        ({"kind": "points", "points": [[0, 1], [0.1, 50]]}, "pulse.points: got a pulse that speeds the car up by 2.55 m/s"),
        ({"kind": "points", "points": [[0, 0], [0.1, 0]]}, "pulse.points: got a pulse that leaves the speed as it is"),
        ({"kind": "points", "points": [[0, -1], [0.1, float("inf")]]}, "pulse.points.1.1: got inf"),
        ({"kind": "points", "points": [[-0.1, -1], [0.1, 0]]}, "pulse.points.0.0: got -0.1 s; need >= 0 s"),
        ({"kind": "points", "points": [[0.1, -1], [0.1, 0]]}, "pulse.points: got all at 0.1 s"),
        ({**EXAMPLES[6], "crush": 0.2}, "pulse.crush: got 0.2 m; need between 1/3 and 2/3 of speed times time"),
        ({"kind": "scenario", "scenario": "paper-adult-ofset"}, 'pulse.scenario: got "paper-adult-ofset"'),
        ({"kind": "scenario", "scenario": "sled-fmvss-208"}, "pulse.scenario: got a sled"),
        ({"kind": "scenario", "scenario": "not/there.toml"}, 'pulse.scenario: got "not/there.toml"'),
        ({"kind": "scenario", "scenario": 3}, "pulse.scenario: got int; need a crash or a network"),
        ({"kind": "scenario", "scenario": {"vehicle1": {"mass": -1}}}, "pulse.scenario.vehicle1.mass: got -1 kg"),
        ({"kind": "scenario", "scenario": WALL, "vehicle": 2}, "pulse.vehicle: got 2; need one of 1"),
        ({"kind": "scenario", "scenario": "marzbanrad-2"}, "pulse.vehicle: got 1; need one of vehicle, occupant"),
    ],
)
def test_bad_pulses_are_refused_in_one_sentence(pulse, sentence):
    assert refusal(pulse).startswith(sentence)


def test_the_nearest_name_is_offered():
    assert 'Did you mean "half-sine"?' in refusal({**SINE, "kind": "halfsine"})
    assert "'paper-adult-offset'" in refusal({"kind": "scenario", "scenario": "paper-adult-ofset"})
    with pytest.raises(UnknownName, match=r"pulse\.delta_v"):
        substitute(sled(SINE), {"pulse.deltav": 3.0})


def test_a_sled_follows_one_crash_not_many():
    many = substitute(load(WALL), {"vehicle1.mass": [1400.0, 1500.0]})
    assert refusal({"kind": "scenario", "scenario": many}).startswith("pulse.scenario: got a scenario of columns")


def test_a_sled_has_one_vehicle_that_nothing_pushes():
    assert refusal(SINE, occupants=[{**ADULT, "vehicle": 2}]).startswith("occupants.0.vehicle: got 2; need 1.")
    assert refusal(SINE, occupants=[{**ADULT, "coupled": True}]).startswith("occupants.0.coupled: got true; need false")
    assert refusal(SINE, vehicle1={"mass": 1}).startswith("vehicle1: got an unknown key")


def test_a_measured_pulse_is_the_mean_of_its_channels(test_file):
    scenario = sled(measured(test_file, cfc="none"), speed=12)
    assert scenario.duration == pytest.approx(0.18)
    found = scenario.pulse.recorded()
    assert found.channels == ("tunnel left x", "tunnel right x")
    assert found.gone == pytest.approx(12, rel=1e-4)
    assert found.samples == 1801
    # each is a sine of 1 g and 300/s off the mean: its velocity 2 g / 300 at most
    assert found.apart == pytest.approx(2 * 9.80665 / 300, rel=1e-3)
    assert found.time[0] == 0.0
    assert found.time.size < 30
    assert load(tomllib.loads(dump(scenario))) == scenario


def test_its_file_is_looked_for_beside_the_scenario(test_file, monkeypatch):
    path = test_file.parent / "sled.toml"
    path.write_text('speed = 12\n[pulse]\nkind = "measured"\nfile = "run7.csv"\nchannels = "tunnel left x"\n')
    monkeypatch.chdir("/")
    scenario = load(path)
    assert scenario.pulse.file == str(test_file)
    assert scenario.pulse.channels == ("tunnel left x",)
    other = test_file.parent / "outer.toml"
    other.write_text('[pulse]\nkind = "scenario"\nscenario = "wall.toml"\n')
    (test_file.parent / "wall.toml").write_text(dump(load(WALL)))
    assert isinstance(load(other).pulse.scenario, CrashScenario)
    other.write_text('[pulse]\nkind = "scenario"\nscenario = "marzbanrad-2"\nvehicle = "vehicle"\n')
    assert isinstance(load(other).pulse.scenario, NetworkScenario)


def test_a_file_is_read_once_until_it_changes(test_file, monkeypatch):
    reads = []

    def counting(path):
        reads.append(path)
        return read(path)

    monkeypatch.setattr("ridedown.signals.read", counting)
    scenario = sled(measured(test_file), speed=12)
    for _ in range(3):
        lower(substitute(scenario, {"adult.restraint.stiffness": [5e4, 6e4]}))
    assert len(reads) == 1
    test_file.write_text(test_file.read_text() + "\n")
    lower(scenario)
    assert len(reads) == 2


def test_its_files_are_looked_at_a_few_times_for_a_table_of_crashes(test_file, monkeypatch):
    looks = []

    def counting(path):
        looks.append(path)
        return stamp(path)

    stamp = pulse_measured._stamp
    scenario = substitute(sled(measured(test_file), speed=12), {"adult.mass": 75.0})
    monkeypatch.setattr(pulse_measured, "_stamp", counting)
    lower(substitute(scenario, {"adult.restraint.stiffness": np.linspace(5e4, 6e4, 1000)}))
    assert 1 <= len(looks) <= 4


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"file": "nowhere.csv"}, "pulse.file: got"),
        ({"file": ""}, "pulse.file: got"),
        ({"channels": "tunel left x"}, 'pulse.channels: got "tunel left x"; need a channel of'),
        ({"channels": []}, "pulse.channels: got an empty list"),
        ({"channels": "belt"}, 'pulse.channels: got "belt", in "N"; need an acceleration'),
        ({"channels": ["tunnel left x", "across"]}, 'pulse.channels: got "across", along y; need an acceleration along x'),
        ({"channels": "in all"}, 'pulse.channels: got "in all", a resultant; need an acceleration along x'),
        ({"cfc": 0}, "pulse.cfc: got 0; need a channel frequency class"),
        ({"cfc": 2000}, "pulse.cfc: got 2000; need what its signal allows"),
        ({"window": "1 s"}, "pulse.window: got 1 s; need 0.18 s at most"),
        ({"time_zero": "-30 ms"}, "pulse.time_zero: got -0.03 s; need -0.02 .. 0.18 s"),
        ({"zero_offset": True, "time_zero": "-20 ms"}, "pulse.zero_offset: got true; need what its signal allows"),
        ({"reversed": True}, "pulse.channels: got a pulse that speeds the car up by 12 m/s"),
        ({"scale": 0}, "pulse.scale: got 0; need > 0"),
    ],
)
def test_what_a_test_cannot_give_is_refused_in_one_sentence(test_file, change, sentence):
    said = refusal(measured(test_file) | change, speed=12)
    assert said.startswith(sentence)
    if "tunel" in said:
        assert "Did you mean 'tunnel left x'" in said


def test_without_a_speed_in_the_record_it_has_to_be_given(test_file):
    assert refusal(measured(test_file)).startswith("speed: got nothing; need the initial speed of the vehicle")


def test_a_shift_and_an_offset(test_file):
    plain = sled(measured(test_file, cfc="none"), speed=12).pulse.recorded()
    early = sled(measured(test_file, cfc="none", time_zero="-10 ms"), speed=12).pulse.recorded()
    assert early.time[-1] == pytest.approx(plain.time[-1] + 0.01)
    assert early.time[np.argmin(early.value)] == pytest.approx(plain.time[np.argmin(plain.value)] + 0.01, abs=2e-3)
    one = {"channels": "tunnel left x", "cfc": "none"}
    off = sled(measured(test_file, **one), speed=12).pulse.recorded()
    zeroed = sled(measured(test_file, **one, zero_offset=True), speed=12).pulse.recorded()
    # the mean of sin(300 t) over the 20 ms before time zero, in g
    offset = 9.80665 * np.sin(300 * np.arange(-200, 0) * 1e-4).mean()
    assert zeroed.gone - off.gone == pytest.approx(offset * 0.18, rel=1e-9)
