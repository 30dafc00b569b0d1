"""What restraints and bodies of occupants did, as a response tells it: results, events, energy, criteria, records."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from ridedown import Response, load, simulate, simulate_many
from ridedown.events import events_of
from ridedown.limits import Verdict, assess, criteria_of
from ridedown.network import Action, Timer
from ridedown.report import summary
from ridedown.scenario import CrashScenario, substitute
from tests.solver.sleds import Solved, points, sled, spring

BODIES = ("driver.pelvis", "driver.chest", "driver.head")


@pytest.fixture(scope="module")
def everything() -> Response:
    return simulate(load("example-restraints"))


BRAKING = 200.0  # m/s2


def braked(restraints: list[dict[str, Any]], *, duration: float = 0.06, mass: float = 80.0, **more: Any) -> Response:
    """A car of 1000 kg that a constant force slows down by BRAKING, from 15 m/s, to rest at 75 ms; it feels no occupant."""
    front = {"points": [[0, BRAKING * 1000 / 2]], "unloading": "plastic", "unloading_stiffness": 1e9}
    return simulate(
        load(
            {
                "duration": duration,
                "vehicle1": {"mass": 1000, "speed": 15, "members": front},
                "occupants": [{"name": "driver", "kind": "adult", "mass": mass, "restraints": restraints, **more}],
            }
        )
    )


def said(response: Response, who: str) -> list[str]:
    return [event.what for event in response.events if event.who == who]


def test_forces_on_the_occupant_move_its_centre_of_mass(everything: Response) -> None:
    times = np.linspace(0.0, everything.end_time, 4001)
    mass = everything.occupants["driver"].mass
    force = everything.at("driver.restraint.force", times)
    np.testing.assert_allclose(mass * everything.at("driver.acceleration", times), -force, atol=1e-9 * np.abs(force).max())
    bodies = everything.occupants["driver"].bodies
    mean = sum(bodies[name.split(".")[1]].mass * everything.at(f"{name}.excursion", times) for name in BODIES) / mass
    np.testing.assert_allclose(everything.at("driver.excursion", times), mean, atol=1e-12)


def test_everything_on_closes_its_balances(everything: Response) -> None:
    assert everything.completed
    assert abs(everything.energy.residual) < 1e-12
    assert abs(everything.momentum.residual) < 1e-12


def test_results_are_those_of_the_channels(everything: Response) -> None:
    assert list(everything.restraints) == [
        "driver.lap-belt",
        "driver.shoulder-belt",
        "driver.airbag",
        "driver.head-airbag",
        "driver.knee_bolster",
        "driver.seat-back",
        "driver.head-restraint",
    ]
    for name, result in everything.restraints.items():
        assert result.force == everything.maximum(f"{name}.force")
        assert result.travel == everything.maximum(f"{name}.deflection")
        assert result.absorbed == everything.energy.elements[name].absorbed
        assert (result.pulled_in is None) == (result.kind != "belt")
    for name, body in everything.occupants["driver"].bodies.items():
        assert body.peak_acceleration == everything.peak(f"driver.{name}.acceleration")
        assert body.excursion == everything.maximum(f"driver.{name}.excursion")


def test_the_events_say_who_did_what(everything: Response) -> None:
    belt = said(everything, "driver.shoulder-belt")
    assert belt == [
        "retractor locks",
        "pretensioner 1 fires",
        "slack taken up",
        "pretensioner 1 stalls at 1.5 kN",
        "pretensioner 2 fires",
        "pretensioner 2 stalls at 2.0 kN",
        "pretensioner 1 has ended",
        "pretensioner 2 has ended",
        "load limiter, stage 1, 4.0 kN",
        "load limiter, end of stage 1, 120 mm let out",
        "load limiter, stage 2, 5.5 kN",
        "load limiter holds",
        "slack again",
    ]
    assert said(everything, "driver.airbag")[:3] == ["bag fires", "contact", "bag full"]
    assert said(everything, "driver.knee_bolster") == ["contact", "on to piece 2", "starts to unload", "contact lost"]


@pytest.mark.parametrize(
    ("stalls", "expected"),
    [
        ((1000.0, np.inf), ["pretensioner 1 stalls at 1.0 kN", "pretensioner 1 pulls on", "pretensioner 1 stalls at 1.0 kN"]),
        (
            (1000.0, 1000.0),
            ["both pretensioners stall at 1.0 kN", "both pretensioners pull on", "pretensioner 1 stalls at 1.0 kN"],
        ),
    ],
)
def test_a_pretensioner_stalls_as_the_force_rises_and_pulls_on_as_it_falls(
    stalls: tuple[float, float], expected: list[str]
) -> None:
    actions = (Action.PULL_1, Action.PULL_2)
    timers = [
        Timer(action, time, rate)
        for action, stall in zip(actions, stalls, strict=True)
        for time, rate in ((0.01, 4.0), (0.18, 0.0))
        if stall < np.inf
    ]
    belt = spring(100e3, stalls=stalls, timers=tuple(timers))
    solved = Solved(sled(belt, pulse=points([0.0, 0.15, 0.19], [-150.0, -50.0, 0.0])))
    told = [event.what for event in events_of(solved.network, solved.phases)]
    assert [what for what in told if "stall" in what or "pull" in what] == expected


def test_a_summary_is_plain_data_without_holes(everything: Response) -> None:
    data = summary.run_data(everything)
    assert json.loads(json.dumps(data, allow_nan=False)) == data
    assert set(data["occupants"]["driver"]["bodies"]) == {"pelvis", "chest", "head"}
    assert data["restraints"]["driver.shoulder-belt"]["paid_out"] > 0.12
    titles = [table.caption.split(";")[0] for table in summary.result_tables(everything)]
    assert {"Bodies of the occupants", "Restraints"} <= set(titles)


def test_a_lumped_restraint_has_a_result_and_no_table() -> None:
    response = simulate(load("p1"))
    assert {name: one.kind for name, one in response.restraints.items()} == dict.fromkeys(
        ("adult.restraint", "child.restraint", "child.seat.restraint"), "lumped"
    )
    assert not any(table.caption.startswith("Restraints") for table in summary.result_tables(response))


# closed forms: the occupant moves ahead in the car with BRAKING until something holds it


def test_a_limiter_that_slips_to_the_end() -> None:
    stiffness, limit = 100e3, 4e3
    response = braked([{"kind": "belt", "stiffness": stiffness, "load_limiter": {"force": limit}}])
    belt, energy = response.restraints["driver.belt"], response.energy.elements["driver.belt"]
    travel = float(response.at("driver.excursion", response.end_time))
    assert said(response, "driver.belt") == ["slack taken up", "load limiter, 4.0 kN"]
    assert belt.force.value == pytest.approx(limit, rel=1e-12)
    assert belt.paid_out == pytest.approx(travel - limit / stiffness, rel=1e-12)
    assert energy.stored == pytest.approx(limit**2 / (2 * stiffness), rel=1e-10)
    assert energy.dissipated == pytest.approx(limit * (travel - limit / stiffness), rel=1e-10)
    # at the constant force from when x = F/k, v by the energy of BRAKING and the spring
    start = limit / stiffness
    omega = np.sqrt(stiffness / 80.0)
    since = response.end_time - np.arccos(1.0 - start * omega**2 / BRAKING) / omega
    speed = np.sqrt(2 * BRAKING * start - omega**2 * start**2)
    exact = start + speed * since + 0.5 * (BRAKING - limit / 80.0) * since**2
    assert travel == pytest.approx(exact, rel=1e-10)


def test_a_hard_stop_is_told_from_a_limiter_that_holds() -> None:
    limiter = {"force": "10 kN", "max_payout": "50 mm"}
    stopped = braked([{"kind": "belt", "stiffness": 1e5, "load_limiter": limiter}])
    assert said(stopped, "driver.belt")[1:3] == ["load limiter, 10.0 kN", "load limiter stops hard, 50 mm let out"]
    assert stopped.restraints["driver.belt"].paid_out == pytest.approx(0.05, rel=1e-12)
    held = braked(
        [{"kind": "belt", "stiffness": 1e5, "load_limiter": {"force": "24 kN", "max_payout": "300 mm"}}], duration=0.1
    )
    assert said(held, "driver.belt")[1:3] == ["load limiter, 24.0 kN", "load limiter holds"]
    assert 0.0 < held.restraints["driver.belt"].paid_out < 0.3


def test_a_first_stage_that_ends_at_a_time_stops_where_the_belt_is_out_before() -> None:
    limiter = {"force": "10 kN", "second_force": "6 kN", "switch_time": "55 ms", "max_payout": "50 mm"}
    response = braked([{"kind": "belt", "stiffness": 1e5, "load_limiter": limiter}])
    assert said(response, "driver.belt")[1:3] == ["load limiter, stage 1, 10.0 kN", "load limiter stops hard, 50 mm let out"]
    assert response.restraints["driver.belt"].paid_out == pytest.approx(0.05, rel=1e-12)
    later = braked([{"kind": "belt", "stiffness": 1e5, "load_limiter": limiter | {"switch_time": "25 ms"}}])
    assert "load limiter goes on to stage 2, 6.0 kN" in said(later, "driver.belt")
    assert later.restraints["driver.belt"].paid_out == pytest.approx(0.05, rel=1e-12)


def test_a_pretensioner_takes_in_what_it_is_given() -> None:
    tensioner = {"fire_time": 0.0, "pull_in": "40 mm", "duration": "5 ms"}
    response = braked([{"kind": "belt", "slack": "40 mm", "stiffness": 1e5, "pretensioners": [tensioner]}])
    belt = response.restraints["driver.belt"]
    assert belt.pulled_in == pytest.approx(0.04, rel=1e-12)
    assert belt.paid_out == 0.0
    # the belt is as if it had no slack, once it is pulled in
    late = response.at("driver.belt.force", 0.03)
    assert late == pytest.approx(1e5 * response.at("driver.belt.deflection", 0.03), rel=1e-12)


def test_belt_given_freely_is_no_negative_pull() -> None:
    tensioner = {"fire_time": "25 ms", "pull_in": "30 mm", "duration": "5 ms"}
    response = braked([{"kind": "belt", "stiffness": 1e5, "lock_time": "20 ms", "pretensioners": [tensioner]}])
    belt = response.restraints["driver.belt"]
    given = 0.5 * BRAKING * 0.02**2
    assert belt.pulled_in == pytest.approx(0.03, rel=1e-10)
    assert response.phases.reel[response.network.elements.index("driver.belt")] == pytest.approx(0.03 - given, rel=1e-10)
    assert said(response, "driver.belt")[:2] == ["retractor locks", "slack taken up"]


@pytest.mark.parametrize("fill_time", [0.02, 0.1])
def test_a_bag_stores_what_its_fill_says(fill_time: float) -> None:
    bag = {"kind": "airbag", "fire_time": "10 ms", "fill_time": fill_time, "stiffness": "50 kN/m"}
    response = braked([bag], duration=0.04)
    fill = min(0.03 / fill_time, 1.0)
    travel = float(response.at("driver.excursion", response.end_time))
    assert response.at("driver.airbag.force", response.end_time) == pytest.approx(fill * 50e3 * travel, rel=1e-9)
    assert response.energy.elements["driver.airbag"].stored == pytest.approx(fill * 0.5 * 50e3 * travel**2, rel=1e-10)


@pytest.mark.parametrize("duration", [0.015, 0.035, 0.055])
def test_a_plastic_belt_stores_what_its_unloading_line_gives_back(duration: float) -> None:
    belt = {"kind": "belt", "stiffness": 6e4, "unloading": "plastic", "unloading_stiffness": 2e5}
    response = braked([belt], duration=duration)
    force = float(response.at("driver.belt.force", response.end_time))
    assert force > 0.0
    assert response.energy.elements["driver.belt"].stored == pytest.approx(force**2 / (2 * 2e5), rel=1e-9)


def test_rebound_into_the_seat_back() -> None:
    back = {"kind": "seat_back", "gap": "20 mm", "stiffness": 4e4}
    response = braked([{"kind": "belt", "stiffness": 2e5}, back], duration=0.15)
    contact = next(event.time for event in response.events if event.who == "driver.seat_back")
    assert response.at("driver.excursion", contact) == pytest.approx(-0.02, abs=1e-12)
    assert response.at("driver.restraint.force", contact + 5e-3) < 0.0  # it pushes the occupant forward
    assert response.at("driver.acceleration", contact + 5e-3) > 0.0


# many


def test_many_give_what_one_gives(everything: Response) -> None:
    scenario = load("example-restraints")
    forces = np.array([3e3, 4e3, 5e3])
    names = ["driver.chest.acceleration.peak", "driver.restraint.force.max", "driver.airbag.absorbed"]
    many = simulate_many(scenario, {"driver.shoulder-belt.load_limiter.force": forces}, outcomes=names)
    assert many.completed.all()
    assert many[names[0]][1] == pytest.approx(abs(everything.peak("driver.chest.acceleration").value), rel=1e-9)
    assert many[names[1]][1] == pytest.approx(everything.maximum("driver.restraint.force").value, rel=1e-9)
    assert many[names[2]][1] == pytest.approx(everything.restraints["driver.airbag"].absorbed, rel=1e-9)
    one = simulate(substitute(scenario, {"driver.shoulder-belt.load_limiter.force": 3e3}))
    assert many[names[1]][0] == pytest.approx(one.maximum("driver.restraint.force").value, rel=1e-9)


# judged and recorded


def test_chest_and_head_are_judged_as_such_the_head_as_a_lower_bound(everything: Response) -> None:
    found = criteria_of(everything).occupants[0]
    assert not found.lumped
    assert found.findings["hic15"].used == ("driver.head.acceleration",)
    assert found.findings["head_3ms"].used == ("driver.head.acceleration",)
    assert found.findings["chest_3ms"].used == ("driver.chest.acceleration",)
    assert abs(everything.peak("driver.chest.acceleration").value) == pytest.approx(
        found.findings["chest_peak"].value, rel=1e-5
    )
    assert "no legs" in found.missing["femur_left"]
    judged = {one.criterion: one for one in assess(everything, "FMVSS 208").judgements if one.subject == "driver"}
    assert judged["chest_3ms"].verdict is Verdict.PASSED
    assert judged["hic15"].verdict is Verdict.NOT_JUDGED
    assert "lower bound" in judged["hic15"].reason


def test_bodies_of_other_names_are_not_judged() -> None:
    bodies = [{"name": "lower", "mass": 40}, {"name": "upper", "mass": 40}]
    joints = [{"between": ["lower", "upper"], "stiffness": 1e4}]
    restraints = [{"kind": "belt", "on": "upper", "stiffness": 6e4}]
    scenario = load("example-wall").model_dump(exclude={"occupants"}, exclude_none=True)
    del scenario["vehicle1"]["left"]
    scenario["vehicle1"]["members"] = scenario["vehicle1"].pop("right")
    person = {"name": "driver", "kind": "adult", "bodies": bodies, "joints": joints, "restraints": restraints}
    response = simulate(CrashScenario(**scenario, occupants=[person]))
    missing = criteria_of(response).occupants[0].missing
    assert missing["chest_3ms"] == "this occupant has no body called chest"
    assert missing["hic15"] == "this occupant has no body called head"


def test_pelvis_chest_and_head_are_recorded_as_such(everything: Response) -> None:
    record = everything.to_record()
    codes = {name: info.code for name, info in record.channels.items() if info.code and name.endswith(".acceleration")}
    assert codes == {
        "vehicle1.acceleration": "10VEHC000000ACX0",
        "driver.pelvis.acceleration": "11PELV000000ACX0",
        "driver.chest.acceleration": "11CHST000000ACX0",
        "driver.head.acceleration": "11HEAD000000ACX0",
    }
    assert record.occupants[0].dummy == "driver, 3 lumped masses"
