"""Limiting performance: closed forms, a linear programme, proofs, laws of scaling, and restraints that none of it knows of."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog

from ridedown import criteria, load, network, simulate, simulate_many
from ridedown.criteria import STANDARD_GRAVITY
from ridedown.errors import InvalidInput, UnknownName
from ridedown.motion import motion_of
from ridedown.scenario import SledScenario
from ridedown.scenario.pulse_motion import PulseMotion
from ridedown.scenario.pulse_shapes import through
from ridedown.studies.bound import Bound, Design, Limiting, bound_study, gap_of, limiting_performance
from ridedown.studies.bound.least_peak import How, Room

SHAPES = {
    "square": {"kind": "square"},
    "half-sine": {"kind": "half-sine"},
    "haversine": {"kind": "haversine"},
    "late triangle": {"kind": "triangle", "peak_at": 0.8},
    "trapezoid": {"kind": "trapezoid", "rise": 0.2, "fall": 0.3},
}
EXCURSIONS = [1e-4, 0.01, 0.1, 0.3, 0.8]


def shape(name, delta_v=13.9, duration=0.1):
    pulse = {**SHAPES[name], "delta_v": delta_v, "duration": duration}
    return motion_of(SledScenario(pulse=pulse, duration=duration))


def random_motion(seed):
    """Straight pieces between random points; some speed the vehicle up."""
    rng = np.random.default_rng(seed)
    time = np.sort(np.append(rng.uniform(0.0, 0.12, 6), [0.0, 0.12]))
    braking = rng.uniform(-60.0, 300.0, 8) * rng.choice([0.0, 1.0, 1.0], 8)
    braking[3] = 250.0
    return PulseMotion(*through(time, -braking), end=0.12, speed=15.0)


def random_case(seed):
    rng = np.random.default_rng(1000 + seed)
    excursion = float(10 ** rng.uniform(-2.5, -0.3))
    slack = float(rng.choice([0.0, 0.0, 0.3 * excursion]))
    return Limiting(random_motion(seed), rearward=float(rng.choice([0.0, 0.0, 0.02, np.inf])), slack=slack), excursion


def check_possible(bound: Bound, lead_end: float) -> None:
    """The ideal history keeps the occupant within its room, and itself at or below the bound: no more is needed."""
    times = np.linspace(0.0, max(bound.end, lead_end) + 0.05, 20_001)
    place = bound.excursion_at(times)
    assert place.max() <= bound.excursion + 1e-11  # m, of the search
    assert place.min() >= -bound.rearward - 1e-11
    assert bound.deceleration(times).max() <= bound.peak * (1.0 + 1e-8)
    # deceleration and place are of one and the same motion
    fine = np.linspace(0.0, bound.end, 200_001)
    way = bound.lead.at(fine) - bound.excursion_at(fine)
    h = fine[1]
    second = np.diff(way, 2) / h**2
    assert second.max() <= bound.peak + 1e-3 + 16.0 * 2.0**-52 * np.abs(way).max() / h**2


def check_needed(limiting: Limiting, bound: Bound) -> None:
    """Three places of the occupant, whatever restrains it, ask for as much as the bound: no less will do."""
    assert bound.proof is not None
    begin = limiting.begin(bound.excursion)
    assert begin is not None
    room = Room(limiting.lead, limiting.free, bound.excursion, limiting.rearward, begin, limiting.horizon)
    s, r, f = bound.proof.start, bound.proof.rear, bound.proof.front
    low = {t: float(room.floor(np.array(t - begin))) for t in (s, f)}
    if r is None or r == s:  # it is just there, and at that rate
        assert s == begin
        assert 2.0 * low[f] / (f - s) ** 2 == pytest.approx(bound.peak, rel=1e-9)
        return
    high = float(room.ceiling(np.array(r - begin)))
    needed = 2.0 * ((low[f] - high) / (f - r) - (high - low[s]) / (r - s)) / (f - s)
    assert needed == pytest.approx(bound.peak, rel=1e-9)


@pytest.mark.parametrize("excursion", EXCURSIONS)
@pytest.mark.parametrize("rearward", [0.0, 0.05, np.inf])
def test_the_square_pulse_has_a_closed_form(excursion, rearward):
    v, duration = 13.9, 0.1
    way = 0.5 * v * duration  # of the vehicle
    bound = Limiting(shape("square", v, duration), rearward=rearward).bound(excursion)
    assert bound.peak == pytest.approx(v**2 / (2.0 * (way + excursion)), rel=1e-12)
    assert [stage.how for stage in bound.stages] == [How.HELD, How.CARRIED]
    assert bound.stages[0].end == pytest.approx(v / bound.peak, rel=1e-7)


@pytest.mark.parametrize("name", SHAPES)
def test_without_a_seat_behind_it_is_the_constant_deceleration_over_the_whole_way(name):
    motion = shape(name)
    way = float(motion.before(motion.end)[2])
    bound = Limiting(motion, rearward=np.inf).bound(0.3)  # so far that the occupant is held until the vehicle stands still
    assert bound.peak == pytest.approx(motion.speed**2 / (2.0 * (way + 0.3)), rel=1e-12)


@pytest.mark.parametrize("excursion", EXCURSIONS)
@pytest.mark.parametrize("name", SHAPES)
def test_named_shapes_are_possible_and_needed(name, excursion):
    limiting = Limiting(shape(name))
    bound = limiting.bound(excursion)
    check_possible(bound, limiting.lead.end)
    check_needed(limiting, bound)


@pytest.mark.parametrize("seed", range(25))
def test_any_pulse_is_possible_and_needed(seed):
    limiting, excursion = random_case(seed)
    bound = limiting.bound(excursion)
    if bound.peak == 0.0:  # the slack, or the excursion, is never reached
        assert bound.excursion_at(np.linspace(0.0, 5.0, 5001)).max() <= excursion
        return
    check_possible(bound, limiting.lead.end)
    check_needed(limiting, bound)


def programme(limiting: Limiting, bound: Bound, count: int) -> float:
    """The same as a linear programme: u constant on even intervals, the places at their ends within the room."""
    lead, begin = limiting.lead, limiting.begin(bound.excursion)
    assert begin is not None
    assert bound.proof is not None
    s = np.linspace(0.0, max(bound.proof.front + 0.02, 1.2 * lead.end) - begin, count + 1)
    h, time = s[1], begin + s[1:]
    row, column = np.mgrid[:count, :count]
    place = np.where(column <= row, h**2 * (row - column + 0.5), 0.0)
    tangent = limiting.free.at(begin) + limiting.free.rate(begin) * s[1:]
    least = np.maximum(lead.at(time) - bound.excursion, limiting.free.values(time)) - tangent
    none = np.zeros((count, 1))
    rows, right = [np.hstack((-place, none)), np.hstack((np.eye(count), none - 1.0))], [-least, np.zeros(count)]
    if np.isfinite(limiting.rearward):
        rows, right = [*rows, np.hstack((place, none))], [*right, lead.at(time) + limiting.rearward - tangent]
    cost = np.append(np.zeros(count), 1.0)
    bounds = [(None, None)] * count + [(0.0, None)]
    solved = linprog(cost, np.vstack(rows), np.concatenate(right), bounds=bounds)
    assert solved.x is not None
    return float(solved.x[-1])


@pytest.mark.parametrize("excursion", [0.02, 0.1, 0.3])
@pytest.mark.parametrize("name", SHAPES)
def test_a_linear_programme_comes_near(name, excursion):
    limiting = Limiting(shape(name))
    bound = limiting.bound(excursion)
    assert programme(limiting, bound, 300) == pytest.approx(bound.peak, rel=3e-3)  # of steps of half a millisecond


def test_the_linear_programme_converges_on_the_half_sine():
    limiting = Limiting(shape("half-sine"))
    bound = limiting.bound(0.1)
    off = [abs(programme(limiting, bound, count) - bound.peak) for count in (60, 480)]
    assert off[1] < off[0] / 8.0
    assert off[1] < 1e-4 * bound.peak


@pytest.mark.parametrize("seed", range(12))
def test_a_linear_programme_comes_near_on_any_pulse(seed):
    limiting, excursion = random_case(seed)
    bound = limiting.bound(excursion)
    if bound.proof is not None:
        assert programme(limiting, bound, 250) == pytest.approx(bound.peak, rel=0.03)


def test_a_free_occupant_that_uses_its_room_is_first_let_fly_then_held_back_to_the_seat():
    bound = Limiting(shape("half-sine")).bound(0.1)
    assert [stage.how for stage in bound.stages] == [How.FREE, How.HELD, How.CARRIED]
    assert bound.proof is not None
    assert bound.proof.rear is not None
    start, rear, front = bound.proof.start, bound.proof.rear, bound.proof.front
    place = bound.excursion_at([start, rear, front])
    assert place[0] > 1e-4
    np.testing.assert_allclose(place[1:], [0.0, 0.1], atol=1e-12)
    assert bound.excursion_at(np.linspace(0.0, rear, 101)).min() >= -1e-12


def test_with_no_room_the_occupant_has_the_vehicles_peak():
    assert Limiting(shape("half-sine")).bound(0.0).peak == pytest.approx(0.5 * np.pi * 13.9 / 0.1, rel=1e-12)
    nearly = Limiting(shape("half-sine")).bound(1e-9).peak
    assert 0.998 < nearly / (0.5 * np.pi * 13.9 / 0.1) < 1.0


@pytest.mark.parametrize("name", ["half-sine", "late triangle"])
def test_the_curve_falls_and_is_convex(name):
    excursions = np.linspace(0.0, 0.6, 31)
    peaks = Limiting(shape(name)).peaks(excursions)
    assert (np.diff(peaks) < 0.0).all()
    assert (np.diff(peaks, 2) > 0.0).all()


def test_more_room_behind_never_harms():
    motion = shape("late triangle")
    peaks = [Limiting(motion, rearward=rearward).bound(0.1).peak for rearward in (0.0, 0.01, 0.05, 0.2, np.inf)]
    assert (np.diff(peaks) <= 0.0).all()
    assert peaks[1] < peaks[0]


@pytest.mark.parametrize("seed", range(6))
def test_scales_as_length_over_time_squared(seed):
    motion, (longer, harder) = random_motion(seed), (2.5, 1.7)
    orders = np.arange(motion.series.shape[1])
    other = PulseMotion(longer * motion.start, harder * motion.series / longer**orders, end=longer * motion.end, speed=9.0)
    one = Limiting(motion, rearward=0.01).bound(0.1)
    two = Limiting(other, rearward=0.01 * harder * longer**2).bound(0.1 * harder * longer**2)
    assert two.peak == pytest.approx(harder * one.peak, rel=1e-9)


@pytest.mark.parametrize("name", SHAPES)
def test_the_occupant_load_criterion_is_a_special_case(name):
    motion = shape(name, 15.0, 0.11)
    time, acceleration, *_ = motion.knots(1e-8)
    found = criteria.olc([*time, motion.end, 0.4], [*acceleration, 0.0, 0.0], start=0.0)
    bound = Limiting(motion, rearward=np.inf, slack=0.065).bound(0.3)
    assert bound.peak == pytest.approx(found.value, rel=1e-7)  # of the knots' straight lines
    assert bound.stages[0].end == pytest.approx(found.start, rel=1e-7)
    assert bound.stages[1].end == pytest.approx(found.end, rel=1e-6)


def test_the_occupant_load_criterion_of_points_to_rounding():
    time, acceleration = [0.0, 0.02, 0.05, 0.09], [-30.0, -260.0, -190.0, 0.0]
    motion = PulseMotion(*through(time, acceleration), end=0.3, speed=0.0)
    bound = Limiting(motion, rearward=np.inf, slack=0.065).bound(0.3)
    assert bound.peak == pytest.approx(criteria.olc([*time, 0.3], [*acceleration, 0.0]).value, rel=1e-12)


@pytest.mark.parametrize("peak", [110.0, 160.0, 210.0])
def test_least_excursion_is_where_the_curve_has_that_peak(peak):
    limiting = Limiting(shape("half-sine"))
    assert limiting.bound(limiting.least_excursion(peak)).peak == pytest.approx(peak, rel=1e-9)


def test_a_peak_above_the_vehicles_needs_no_excursion_but_the_slack():
    assert Limiting(shape("half-sine")).least_excursion(250.0) == 0.0
    with_slack = Limiting(shape("half-sine"), slack=0.03)
    needed = with_slack.least_excursion(1000.0)
    assert 0.03 < needed < 0.04
    assert with_slack.bound(needed).peak == pytest.approx(1000.0, rel=1e-9)


def test_a_short_horizon_asks_for_less():
    motion = shape("half-sine")
    peaks = [Limiting(motion, horizon=horizon).bound(0.1).peak for horizon in (0.03, 0.06, 0.2, None)]
    assert peaks[0] == 0.0  # a free occupant is not yet there
    assert peaks[1] < 0.9 * peaks[2]
    assert peaks[2] == pytest.approx(peaks[3], rel=1e-12)


# restraints that know nothing of the bound

LUMPED = {"kind": "adult", "mass": 78.0, "restraint": {"stiffness": 5e4, "damping_ratio": 0.1, "slack": 0.01}}
BELT = {
    "kind": "adult",
    "mass": 78.0,
    "restraints": [
        {
            "kind": "belt",
            "slack": 0.03,
            "stiffness": 6e4,
            "damping_ratio": 0.05,
            "lock_time": 0.005,
            "pretensioners": [{"fire_time": 0.012, "pull_in": 0.1, "duration": 0.01, "stall_force": 1.5e3}],
            "load_limiter": {"force": 4e3},
        },
        {"kind": "airbag", "fire_time": 0.015, "fill_time": 0.03, "gap": 0.08, "stiffness": 3e4, "venting": 500.0},
        {"kind": "seat_back", "stiffness": 3e4, "damping": 600.0},
    ],
}


def uniform(rng, rows, **ranges):
    return {path.replace("__", "."): rng.uniform(low, high, rows) for path, (low, high) in ranges.items()}


def lumped_table(rng, rows):
    found = uniform(rng, rows, adult__restraint__damping_ratio=(0.0, 1.2), adult__restraint__slack=(0.0, 0.06))
    return {**found, "adult.restraint.stiffness": 10 ** rng.uniform(3.7, 5.5, rows)}


def belt_table(rng, rows):
    return uniform(
        rng,
        rows,
        adult__belt__slack=(0.0, 0.06),
        adult__belt__stiffness=(2e4, 2e5),
        adult__belt__pretensioners__0__pull_in=(0.0, 0.15),
        adult__belt__load_limiter__force=(1.6e3, 8e3),
        adult__airbag__gap=(0.0, 0.2),
        adult__airbag__stiffness=(5e3, 1e5),
        adult__airbag__venting=(0.0, 2e3),
    )


@pytest.mark.parametrize("occupant", ["lumped", "belt"])
@pytest.mark.parametrize("name", ["half-sine", "trapezoid"])
def test_no_restraint_of_ten_thousand_is_better(name, occupant):
    rows, rng = 2500, np.random.default_rng(len(name) + len(occupant))
    given, table = (LUMPED, lumped_table) if occupant == "lumped" else (BELT, belt_table)
    sled = SledScenario(pulse={**SHAPES[name], "delta_v": 13.9, "duration": 0.1}, duration=0.3, occupants=[given])
    times = np.linspace(0.0, 0.3, 301)
    names = ["adult.acceleration.min", "adult.excursion.max"]
    many = simulate_many(sled, table(rng, rows), outcomes=names, samples=["adult.excursion"], times=times)
    assert many.completed.all()
    peaks, reached = -many["adult.acceleration.min"], many["adult.excursion.max"]
    grid = np.geomspace(reached.min() * 0.999, reached.max() * 1.001, 60)
    curve = [Limiting(sled).bound(float(excursion)) for excursion in grid]
    # straight between points of a convex curve: not below it
    least = np.interp(reached, grid, [bound.peak for bound in curve])
    assert (least <= peaks).all()
    assert (least > 0.3 * peaks).any()  # it is not a bound that says nothing
    # and none of them was behind its place when the proof needs it not to be
    rears = [bound.proof.rear for bound in curve if bound.proof is not None and bound.proof.rear is not None]
    early = (times >= min(rears) - 1e-3) & (times <= max(rears) + 1e-3)
    assert many.samples["adult.excursion"][:, early].min() >= -1e-12


# designs beside the bound


def test_gap_of_a_simulation():
    response = simulate(load("sled-half-sine"))
    found = gap_of(response)
    assert found.holds
    assert found.design.name == "adult"
    assert found.design.excursion == pytest.approx(response.maximum("adult.excursion").value, rel=1e-12)
    assert found.design.peak == pytest.approx(-response.minimum("adult.acceleration").value, rel=1e-12)
    assert found.design.rearward == 0.0  # its rebound comes later, and is no help
    assert found.bound.peak == pytest.approx(Limiting(response).bound(found.design.excursion).peak, rel=1e-9)
    assert found.ratio == pytest.approx(found.bound.peak / found.design.peak, rel=1e-15)
    assert found.excess == pytest.approx(found.design.peak - found.bound.peak, rel=1e-15)


def test_gap_of_a_crash_and_of_a_chest():
    response = simulate(load("example-restraints"))
    whole, chest = gap_of(response), gap_of(response, "driver.chest", name="chest")
    assert whole.design.name == "driver"
    assert chest.design.name == "chest"
    assert 0.0 < whole.ratio < 1.0
    assert 0.0 < chest.ratio < 1.0


def test_gap_refuses_what_it_cannot_compare():
    with pytest.raises(UnknownName, match="adult"):
        gap_of(simulate(load("sled-half-sine")), "adlt")
    with pytest.raises(InvalidInput, match="without occupants"):
        gap_of(simulate(SledScenario(pulse={"kind": "square", "delta_v": 10.0, "duration": 0.1})))


def test_a_bound_study_has_the_curve_the_ideal_and_the_designs():
    sled = load("sled-half-sine")
    excursions = np.linspace(0.05, 0.4, 8)
    study = bound_study(sled, excursions, designs=[gap_of(simulate(sled)), Design("other", 300.0, 0.2)], excursion=0.25)
    np.testing.assert_allclose(study.peaks, Limiting(sled).peaks(excursions), rtol=1e-15)
    assert (study.unlimited <= study.peaks).all()
    assert study.ideal.excursion == 0.25
    assert [one.design.name for one in study.gaps] == ["adult", "other"]
    assert study.gaps[1].ratio == pytest.approx(limiting_performance(sled, 0.2).peak / 300.0, rel=1e-12)
    data = study.as_json()
    assert data["designs"][1]["ratio"] == study.gaps[1].ratio
    assert data["ideal"]["stages"][0]["does"] == "free"


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"rearward": -0.1}, "rearward: got -0.1 m"),
        ({"slack": -0.1}, "slack: got -0.1 m"),
        ({"horizon": 0.0}, "horizon: got 0 s"),
        ({"rearward": float("nan")}, "rearward: got nan"),
    ],
)
def test_options_that_mean_nothing_are_refused(options, words):
    with pytest.raises(InvalidInput, match=words):
        Limiting(shape("square"), **options)


def test_excursions_that_mean_nothing_are_refused():
    with pytest.raises(InvalidInput, match="excursion: got -1 m"):
        Limiting(shape("square")).bound(-1.0)
    with pytest.raises(InvalidInput, match=r"excursion: got 0\.05 m; need > 0\.065 m, the slack"):
        Limiting(shape("square"), slack=0.065).bound(0.05)
    with pytest.raises(InvalidInput, match="excursions"):
        bound_study(shape("square"), [0.2, 0.1])


def test_a_pulse_of_the_wrong_sign_is_refused():
    with pytest.raises(InvalidInput, match="turn the signs round"):
        Limiting(network.Pulse(np.array([0.0, 0.1]), np.array([[100.0], [0.0]])))


def test_peaks_in_g():
    assert Limiting(shape("square")).bound(0.3).peak_g == pytest.approx(
        Limiting(shape("square")).bound(0.3).peak / STANDARD_GRAVITY
    )
