"""The restraint law: closed forms, limits in which it is another law, and its reel, limiter, pretensioners and fill."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ridedown import load, simulate_many
from ridedown.network import Action, Builder, Curve, KelvinVoigt, Network, Restraint, Timer, channels
from ridedown.scenario import lower, substitute
from ridedown.solver.march import Stop
from ridedown.solver.solve import solve_many, solve_one, tracked
from ridedown.solver.workspace import structure_of
from tests.solver.sleds import CAR, MASS, Solved, constant, points, sled, spring

TIMES = np.linspace(0.0, 0.2, 401)


def assert_same(one: Solved, other: Solved, *, rtol: float = 1e-11) -> None:
    for channel in ("driver.acceleration", "driver.excursion", "driver.0.force"):
        expected = other.at(channel, TIMES)
        np.testing.assert_allclose(one.at(channel, TIMES), expected, rtol=0.0, atol=rtol * np.abs(expected).max())


# limits in which it is another law


def test_one_piece_with_damping_is_kelvin_voigt() -> None:
    plain = Solved(sled(KelvinVoigt(80e3, 800.0, 0.02)))
    assert_same(Solved(sled(spring(80e3, damping=800.0, slack=0.02))), plain)
    assert 2 in dict(plain.changes).values()  # it clips


@pytest.mark.parametrize("unloading", [None, 500e3])
def test_undamped_pieces_are_a_curve(unloading: float | None) -> None:
    knots, forces, slopes = (0.0, 0.05, 0.12), (500.0, 2000.0, 9000.0), (30e3, 100e3, 20e3)
    bouncing = points([0.0, 0.04, 0.0401, 0.08, 0.12, 0.121], [-200.0, -200.0, 150.0, 150.0, -350.0, 0.0])
    curve = Solved(sled(Curve(knots, forces, slopes, unloading), pulse=bouncing))
    restraint = Solved(sled(Restraint(knots, forces, slopes, unloading=unloading), pulse=bouncing))
    assert len(curve.changes) >= 5
    assert_same(restraint, curve)


def test_many_at_once_are_the_same_as_one() -> None:
    slack = np.linspace(0.0, 0.1, 150)
    everything = _everything(slack)
    network = sled(everything)
    channel = channels(network)["driver.0.force"]
    solved = solve_many(network, tracked([(channel, 1)]))
    assert (solved.stop == Stop.COMPLETED).all()
    for row in (0, 70, 149):
        alone = Solved(sled(_everything(float(slack[row]))))
        assert solved.best[0][row] == pytest.approx(alone.largest("driver.0.force")[0], rel=1e-12)
        assert solved.payout[0][row] == pytest.approx(alone.phases.payout[0], rel=1e-10, abs=1e-15)


def test_restraints_side_by_side_move_a_mass_as_each_by_itself() -> None:
    def held(slack: np.ndarray) -> Network:
        builder = Builder()
        car = builder.driven("vehicle1", CAR, speed=15.0)
        body = builder.body("driver", mass=MASS, speed=15.0, parent=car)
        bag = (Timer(Action.FILL, 0.01, 40.0), Timer(Action.FILL, 0.035, 0.0), Timer(Action.FILL, 0.06, -15.0))
        surface = spring(60e3, slack=-0.02, unloading=200e3)  # behind: it pushes at first
        for name, law, sign in (
            ("belt", _everything(slack), 1.0),
            ("bag", spring(50e3, damping=700.0, slack=0.03, empty=True, timers=(*bag, Timer(Action.FILL, 0.1, 0.0))), 1.0),
            ("back", surface, -1.0),
        ):
            builder.element(name, law, deflection={body: sign, car: -sign})
        return builder.build(duration=0.2)

    network = held(np.linspace(0.0, 0.1, 150))
    channel = channels(network)
    asked = [(channel["driver.acceleration"], 1), (channel["driver.acceleration"], -1), (channel["driver.excursion"], 1)]
    forces = [(channel[f"{element}.force"], 1) for element in network.elements]
    together, apart = solve_many(network, tracked(asked)), solve_many(network, tracked([*asked, *forces]))
    assert (together.stop == Stop.COMPLETED).all()
    assert (apart.best[3:] > 0.0).all(axis=1).all()  # all of them push
    for name in ("best", "best_time"):
        np.testing.assert_allclose(getattr(together, name), getattr(apart, name)[:3], rtol=1e-11)
    for name in ("position", "rate", "set", "reel", "payout"):
        np.testing.assert_allclose(getattr(together, name), getattr(apart, name), rtol=1e-10, atol=1e-14)
    assert structure_of(network, tracked(asked)).leader.tolist() == [0, 0, 0]
    assert structure_of(network, tracked(asked)).direction.tolist() == [1.0, 1.0, -1.0]
    assert structure_of(network, tracked([*asked, *forces])).leader.tolist() == [0, 1, 2]
    assert structure_of(network, tracked([*asked, forces[1]])).leader.tolist() == [0, 1, 0]


def test_passing_over_restraints_that_rest_changes_nothing() -> None:
    built = _rows_of(load("example-restraints"), 200)
    channel = channels(built)
    asked = [(channel[f"driver.{part}.acceleration"], 0) for part in ("pelvis", "chest", "head")]
    asked += [(channel[f"{element}.force"], 1) for element in built.elements]
    watched = [(channel[f"{element}.deflection"], 1) for element in built.elements]  # one that is looked at does not rest
    resting, awake = (solve_many(built, tracked([*asked, *more]), work=True) for more in ([], watched))
    assert (resting.stop == Stop.COMPLETED).all()
    for name in ("steps", "position", "rate", "reel", "payout", "set", "work"):
        np.testing.assert_array_equal(getattr(resting, name), getattr(awake, name))
    np.testing.assert_array_equal(resting.best, awake.best[: len(asked)])


@pytest.mark.parametrize("weight", [-1.0, 2.0, 0.5])
def test_a_deflection_of_any_weight_is_the_same_with_others_beside(weight: float) -> None:
    """Two restraints whose deflections are so many times the excursion; summed up side by side, or looked at one by one."""
    builder = Builder()
    car = builder.driven("vehicle1", CAR, speed=15.0)
    body = builder.body("driver", mass=MASS, speed=15.0, parent=car)
    for n, law in enumerate((spring(30e3, damping=300.0, slack=0.01), spring(20e3, unloading=90e3))):
        for sign in (1.0, -1.0):
            builder.element(f"driver.{n}{sign:+g}", law, deflection={body: sign * weight, car: -sign * weight})
    network = builder.build(duration=0.2)
    wanted = [(channels(network)["driver.acceleration"], 0), (channels(network)["driver.excursion"], 1)]
    phases, _ = solve_one(network)
    for work in (False, True):
        best = [column[0] for column in solve_many(network, tracked(wanted), work=work).best]
        for (channel, sense), value in zip(wanted, best, strict=True):
            assert value == pytest.approx(abs(phases.largest(phases.series(channel), sense)[0]), rel=1e-11)


def _rows_of(scenario: Any, rows: int) -> Any:
    """The network of so many rows in which belt, limiter and bag differ."""
    rng = np.random.default_rng(0)
    return lower(
        substitute(
            scenario,
            {
                "driver.shoulder-belt.load_limiter.force": rng.uniform(3.5e3, 6.5e3, rows),
                "driver.shoulder-belt.slack": rng.uniform(0.005, 0.05, rows),
                "driver.knee_bolster.gap": rng.uniform(0.05, 0.2, rows),
                "driver.airbag.gap": rng.uniform(0.05, 0.2, rows),
            },
        )
    ).widened(rows)


def _everything(slack: Any) -> Restraint:
    return Restraint(
        (0.0, 0.03),
        (0.0, 2000.0),
        (60e3, 120e3),
        slack=slack,
        damping=200.0,
        unloading=300e3,
        limits=(5000.0, 3000.0),
        payouts=(0.05, 0.2),
        stalls=(2000.0, 1500.0),
        free=True,
        timers=(
            Timer(Action.LOCK, 0.008),
            *_pull(Action.PULL_1, 0.012, 0.010, 0.10),
            *_pull(Action.PULL_2, 0.016, 0.010, 0.05),
        ),
    )


def _pull(action: Action, fire: float, duration: float, length: float) -> tuple[Timer, Timer]:
    return Timer(action, fire, length / duration), Timer(action, fire + duration, 0.0)


# closed forms


def test_constant_deceleration_with_slack() -> None:
    """A mass flies free over the slack s at a deceleration a, then swings about the spring's rest under it.

    k x = m a (1 + sqrt(1 + 2 k s / (m a))) at the top: from m x'' = m a - k x, x(0) = 0, x'(0)^2 = 2 a s.
    """
    a, k, s = 200.0, 60e3, 0.04
    solved = Solved(sled(spring(k, slack=s), pulse=constant(a)))
    stretch = MASS * a / k * (1.0 + np.sqrt(1.0 + 2.0 * k * s / (MASS * a)))
    force, when = solved.largest("driver.0.force")
    assert solved.times[0] == pytest.approx(np.sqrt(2.0 * s / a), rel=1e-13)
    assert force == pytest.approx(k * stretch, rel=1e-11)
    omega = np.sqrt(k / MASS)
    turn = np.arctan2(np.sqrt(2.0 * a * s) * omega, -a) / omega
    assert when == pytest.approx(np.sqrt(2.0 * s / a) + turn, rel=1e-8)


def test_constant_force_limiter() -> None:
    """From the force F on, the excursion grows at a - F / m, until the mass has the car's speed again."""
    a, k, limit = 200.0, 60e3, 25e3
    solved = Solved(sled(spring(k, limits=(limit, np.inf)), pulse=constant(a)))
    omega, rest = np.sqrt(k / MASS), MASS * a / k
    slip = np.arccos(1.0 - limit / (k * rest)) / omega  # k rest (1 - cos(omega t)) = F
    speed = rest * omega * np.sin(omega * slip)
    brake = limit / MASS - a
    payout = 0.5 * speed**2 / brake
    assert solved.changes[:3] == [(0, 1), (1, 4), (4, 1)]
    assert solved.times[1] == pytest.approx(slip, rel=1e-12)
    assert solved.times[2] == pytest.approx(slip + speed / brake, rel=1e-12)
    assert solved.largest("driver.excursion")[0] == pytest.approx(limit / k + payout, rel=1e-12)
    assert solved.phases.payout[0] == pytest.approx(payout, rel=1e-12)
    assert solved.phases.reel[0] == pytest.approx(-payout, rel=1e-12)


def test_a_pretensioner_that_removes_exactly_the_slack() -> None:
    """It fires and is done before the car brakes: from then on the belt is one without slack."""
    late = points([0.0, 0.01, 0.01 + 1e-12], [0.0, 0.0, -200.0])
    slack = 0.06
    tightened = Solved(sled(spring(60e3, slack=slack, timers=_pull(Action.PULL_1, 0.002, 0.006, slack)), pulse=late))
    tight = Solved(sled(spring(60e3), pulse=late))
    for channel in ("driver.excursion", "driver.0.force"):
        expected = tight.at(channel, TIMES)
        np.testing.assert_allclose(tightened.at(channel, TIMES), expected, rtol=0.0, atol=1e-11 * expected.max())
    assert tightened.phases.reel[0] == pytest.approx(slack, rel=1e-14)


def test_a_pretensioner_pulls_a_mass_back_until_it_stalls() -> None:
    """In a car at rest it draws the occupant into the seat: at its stall force, m x'' = -F."""
    still = constant(0.0)
    stall, stiffness, length, duration = 1500.0, 200e3, 0.2, 0.01
    law = spring(stiffness, stalls=(stall, np.inf), timers=_pull(Action.PULL_1, 0.0, duration, length))
    solved = Solved(sled(law, pulse=still, duration=0.009))
    assert solved.changes[:3] == [(-1, 0), (0, 1), (1, 6)]
    held = solved.times[2]
    force = solved.at("driver.0.force", np.linspace(held, 0.009, 20))
    np.testing.assert_allclose(force, stall, rtol=1e-13)
    late = np.linspace(held, 0.009, 20)
    x0, v0 = solved.at("driver.excursion", held), solved.at("driver.excursion_velocity", held)
    expected = x0 + v0 * (late - held) - 0.5 * stall / MASS * (late - held) ** 2
    np.testing.assert_allclose(solved.at("driver.excursion", late), expected, rtol=1e-12, atol=1e-15)


def test_a_bag_that_is_full_before_it_is_met_is_a_spring_with_a_gap() -> None:
    timers = (Timer(Action.FILL, 0.001, 1.0 / 0.004), Timer(Action.FILL, 0.005, 0.0))
    bag = Solved(sled(spring(70e3, slack=0.08, damping=400.0, unloading=300e3, empty=True, timers=timers)))
    spring_ = Solved(sled(spring(70e3, slack=0.08, damping=400.0, unloading=300e3)))
    assert_same(bag, spring_)


def test_a_bag_pushes_as_much_as_it_is_full() -> None:
    fire, fill = 0.03, 0.05
    timers = (Timer(Action.FILL, fire, 1.0 / fill), Timer(Action.FILL, fire + fill, 0.0))
    solved = Solved(sled(spring(70e3, slack=0.01, damping=400.0, empty=True, timers=timers)))
    share = np.clip((TIMES - fire) / fill, 0.0, 1.0)
    line = 70e3 * (solved.at("driver.0.deflection", TIMES) - 0.01) + 400.0 * solved.at("driver.0.deflection_rate", TIMES)
    touching = solved.at("driver.0.deflection", TIMES) > 0.01
    expected = np.where(touching, np.maximum(share * line, 0.0), 0.0)
    np.testing.assert_allclose(solved.at("driver.0.force", TIMES), expected, rtol=1e-9, atol=1e-9 * expected.max())
    assert expected.max() > 1e3


def test_a_bag_that_fills_untouched_costs_no_step() -> None:
    timers = (Timer(Action.FILL, 0.0251, 1.0 / 0.02), Timer(Action.FILL, 0.0451, 0.0))
    late = Solved(sled(spring(70e3, slack=0.3, damping=400.0, empty=True, timers=timers)))
    full = Solved(sled(spring(70e3, slack=0.3, damping=400.0)))
    assert late.phases.start.size == full.phases.start.size
    assert late.largest("driver.0.force")[0] > 1e3
    assert late.changes[:2] == [(-1, 0), (-1, 1)]  # each at its own time
    assert late.times == sorted(late.times)
    assert late.times[:2] == [0.0251, 0.0451]
    assert_same(late, full)


@pytest.mark.parametrize(("met", "full"), [(0.1, False), (0.5, True)])
def test_a_bag_met_after_its_timers_waited_is_as_full_as_they_say(met: float, full: bool) -> None:
    """The pulse has no point between firing and contact: what is due goes off where the bag is met, as much as it is late."""
    fire, fill = 0.03, 0.05
    pulse = points([0.0, 0.12, 0.19], [-100.0, -300.0, 0.0])
    timers = (Timer(Action.FILL, fire, 1.0 / fill), Timer(Action.FILL, fire + fill, 0.0))
    solved = Solved(sled(spring(70e3, slack=met, empty=True, timers=timers), pulse=pulse))
    times = np.linspace(0.0, 0.11, 300)
    share, past = np.clip((times - fire) / fill, 0.0, 1.0), solved.at("driver.0.deflection", times) - met
    expected = share * 70e3 * np.maximum(past, 0.0)
    np.testing.assert_allclose(solved.at("driver.0.force", times), expected, rtol=1e-10, atol=1e-10 * expected.max())
    assert 0.0 < share[past > 0.0][0] <= 1.0
    assert (share[past > 0.0] == 1.0).all() == full


def test_timers_that_wait_go_off_before_the_end() -> None:
    timers = (Timer(Action.FILL, 0.02, 1.0 / 0.02), Timer(Action.FILL, 0.04, 0.0))
    solved = Solved(sled(spring(70e3, slack=9.0, empty=True, timers=timers), pulse=constant(100.0), duration=0.05))
    assert solved.changes == [(-1, 0), (-1, 1)]
    assert solved.times == [0.02, 0.04]


# the reel


def test_a_free_reel_gives_and_takes_until_it_locks() -> None:
    law = spring(60e3, slack=0.01, free=True, timers=(Timer(Action.LOCK, 0.04),))
    solved = Solved(sled(law))
    locked_at = solved.at("driver.excursion", 0.04)
    assert locked_at > 0.01
    assert not solved.at("driver.0.force", np.linspace(0.0, 0.04, 50)).any()
    later = np.linspace(0.0401, 0.1, 50)
    stretch = np.maximum(solved.at("driver.excursion", later) - locked_at, 0.0)
    np.testing.assert_allclose(solved.at("driver.0.force", later), 60e3 * stretch, rtol=1e-12)
    assert solved.phases.reel[0] == pytest.approx(0.01 - locked_at, rel=1e-13)


def test_a_reel_that_locks_before_the_slack_is_gone_changes_nothing() -> None:
    law = spring(60e3, slack=0.05, free=True, timers=(Timer(Action.LOCK, 0.01),))
    assert_same(Solved(sled(law)), Solved(sled(spring(60e3, slack=0.05))))


@pytest.mark.parametrize(("second", "by_time"), [(6000.0, False), (2500.0, False), (6000.0, True), (2500.0, True)])
def test_two_stages(second: float, by_time: bool) -> None:
    switch = 0.055
    law = spring(
        80e3,
        limits=(4000.0, second),
        payouts=(np.inf if by_time else 0.08, np.inf),
        timers=(Timer(Action.STAGE_2, switch),) if by_time else (),
    )
    solved = Solved(sled(law))
    force = solved.at("driver.0.force", TIMES)
    changes = list(zip(solved.times, solved.changes, strict=True))
    begin = next(t for t, (_, after) in changes if after == 4)
    end = switch if by_time else next(t for t, (before, _) in changes if before == 4)
    then = next(t for t, (_, after) in changes if after == 5)
    assert begin < end <= then
    np.testing.assert_allclose(force[(begin < TIMES) & (end > TIMES)], 4000.0, rtol=1e-12)
    assert solved.at("driver.0.force", then + 1e-6) == pytest.approx(second, rel=1e-9)
    assert force.max() == pytest.approx(max(4000.0, second), rel=1e-12)


def test_a_hard_stop_when_all_is_let_out() -> None:
    law = spring(80e3, limits=(4000.0, 5000.0), payouts=(0.05, 0.12), damping=100.0)
    solved = Solved(sled(law))
    assert solved.phases.payout[0] == pytest.approx(0.12, rel=1e-12)
    late = np.linspace(0.08, 0.12, 30)
    stretch = solved.at("driver.excursion", late) - 0.12
    expected = 80e3 * stretch + 100.0 * solved.at("driver.excursion_velocity", late)
    np.testing.assert_allclose(solved.at("driver.0.force", late), expected, rtol=1e-10)
    assert expected.max() > 5000.0


def test_a_stage_that_may_let_out_no_more_is_passed_over() -> None:
    """What a stage by time may let out is used up before it begins: the belt stops, and its lower force never counts."""
    law = spring(80e3, limits=(4000.0, 2500.0), payouts=(0.05, 0.05), timers=(Timer(Action.STAGE_2, 0.15),))
    solved = Solved(sled(law))
    assert solved.phases.payout[0] == pytest.approx(0.05, rel=1e-12)
    assert solved.phases.reel[0] == pytest.approx(-0.05, rel=1e-12)
    stretch = np.maximum(solved.at("driver.excursion", np.linspace(0.06, 0.2, 50)) - 0.05, 0.0)
    np.testing.assert_allclose(solved.at("driver.0.force", np.linspace(0.06, 0.2, 50)), 80e3 * stretch, rtol=1e-9, atol=1e-6)
    assert stretch.max() * 80e3 > 4000.0


@pytest.mark.parametrize("unloading", [None, 160e3])
def test_a_lower_stage_lets_out_at_once_no_more_than_is_left(unloading: float | None) -> None:
    """3000 N less would take 37.5 mm of this webbing, or 18.75 mm on its unloading line; 10 mm are left."""
    law = spring(80e3, limits=(4000.0, 1000.0), payouts=(0.05, 0.06), unloading=unloading)
    solved = Solved(sled(law))
    assert solved.phases.payout[0] == pytest.approx(0.06, rel=1e-12)
    assert solved.phases.reel[0] == pytest.approx(-0.06, rel=1e-12)
    slipping = next(t for t, (_, after) in zip(solved.times, solved.changes, strict=True) if after in {4, 5})
    stop = next(t for t in solved.times if t > slipping)
    assert solved.at("driver.0.force", stop - 1e-9) == pytest.approx(4000.0, rel=1e-9)
    assert solved.at("driver.0.force", stop + 1e-9) == pytest.approx(4000.0 - 0.01 * (unloading or 80e3), rel=1e-5)
    top = solved.largest("driver.excursion")[0]
    assert solved.largest("driver.0.force")[0] == pytest.approx(80e3 * (top - 0.06), rel=1e-9)


def test_the_belt_never_gives_more_than_its_limit_whatever_its_damper() -> None:
    for damping in (0.0, 300.0, 3000.0):
        solved = Solved(sled(spring(80e3, limits=(5000.0, np.inf), damping=damping, unloading=400e3)))
        assert solved.largest("driver.0.force")[0] == pytest.approx(5000.0, rel=1e-12)
        assert solved.stop == Stop.COMPLETED


def test_two_pretensioners_stall_one_after_the_other() -> None:
    """The weaker holds the belt at its own force while the stronger is still to come, which then pulls it on to its own."""
    law = spring(
        100e3,
        stalls=(2500.0, 1200.0),
        timers=(*_pull(Action.PULL_1, 0.004, 0.03, 0.15), *_pull(Action.PULL_2, 0.001, 0.03, 0.15)),
    )
    solved = Solved(sled(law, pulse=constant(5.0), duration=0.034))
    held = [after for _, after in solved.changes if after in (6, 7)]
    assert [mode for n, mode in enumerate(held) if mode not in held[:n]] == [7, 6]
    force = solved.at("driver.0.force", np.linspace(0.0, 0.0339, 2000))
    assert force.max() == pytest.approx(2500.0, rel=1e-12)
    plateau = np.isclose(force, 1200.0, rtol=1e-12).sum()
    assert plateau > 20


def _stalled(until: float, **more: Any) -> Solved:
    """A belt that its pretensioner pulls tight, to its stall force, and that is then pulled out of it, until the time given."""
    length = 4.0 * (until - 0.01)
    law = spring(100e3, stalls=(1000.0, np.inf), timers=_pull(Action.PULL_1, 0.01, until - 0.01, length), **more)
    return Solved(sled(law, pulse=points([0.0, 0.15, 0.19], [-150.0, -50.0, 0.0])))


@pytest.mark.parametrize("before", [1e-6, 1e-4, 3e-4])
def test_a_pretensioner_that_has_ended_does_not_pull_again(before: float) -> None:
    """Also where it ends just before the force falls to its stall force: its timer waits, and the guard is there no more."""
    whole = _stalled(0.18)
    stalls, pulls_on = [time for change, time in zip(whole.changes, whole.times, strict=True) if change == (1, 6)][:2]
    early, late = _stalled(stalls + 0.01), _stalled(pulls_on - before)
    assert [now for _, now in late.changes].count(6) == 1
    assert pulls_on - before in late.times
    assert_same(late, early, rtol=1e-8)  # steps differ, and with them what is left out inside them


def test_the_end_of_a_pretensioner_that_is_stalled_leaves_a_limiter_slipping() -> None:
    long, short = _stalled(0.18, limits=(2500.0, np.inf)), _stalled(0.05, limits=(2500.0, np.inf))
    slips = [time for (_, now), time in zip(short.changes, short.times, strict=True) if now == 4]
    assert len(slips) == 1
    assert slips[0] < 0.05
    assert_same(short, long)


def test_random_belts_agree_with_small_steps() -> None:
    """Against the reel moved by hand, a microsecond at a time: return mapping on the force, undamped."""
    rng = np.random.default_rng(4)
    for _ in range(6):
        slack, stiffness = rng.uniform(0.0, 0.08), rng.uniform(40e3, 150e3)
        stalls = rng.uniform(800.0, 2500.0, 2)
        limit, most = rng.uniform(2600.0, 8000.0), rng.uniform(0.05, 0.3)
        fire, pull_in, lock = rng.uniform(0.008, 0.03, 2), rng.uniform(0.02, 0.12, 2), rng.uniform(0.0, 0.008)
        law = spring(
            stiffness,
            slack=slack,
            limits=(limit, np.inf),
            payouts=(most, np.inf),
            stalls=(stalls[0], stalls[1]),
            free=True,
            timers=(
                Timer(Action.LOCK, lock),
                *_pull(Action.PULL_1, fire[0], 0.01, pull_in[0]),
                *_pull(Action.PULL_2, fire[1], 0.01, pull_in[1]),
            ),
        )
        solved = Solved(sled(law))
        excursion, payout = _by_small_steps(slack, stiffness, stalls, limit, most, fire, pull_in, lock)
        assert solved.largest("driver.excursion")[0] == pytest.approx(excursion, rel=2e-4)
        assert solved.phases.payout[0] == pytest.approx(payout, abs=2e-4)


def _by_small_steps(
    slack: float,
    stiffness: float,
    stalls: np.ndarray,
    limit: float,
    most: float,
    fire: np.ndarray,
    pull_in: np.ndarray,
    lock: float,
) -> tuple[float, float]:
    step = 2e-6
    car = np.interp((np.arange(int(0.2 / step)) + 0.5) * step, CAR.start, CAR.series[:, 0])
    x = v = reel = payout = top = 0.0
    locked = False
    for n, braking in enumerate(car):
        t = n * step
        if t >= lock and not locked:
            locked, reel = True, min(slack - x, 0.0)
        force = 0.0
        if locked:
            for begin, length, stall in zip(fire, pull_in, stalls, strict=True):
                if begin <= t < begin + 0.01:
                    room = (stall / stiffness) - max(x - slack + reel, 0.0) if x - slack + reel > 0.0 else np.inf
                    reel += min(length / 0.01 * step, max(room, 0.0))
            force = stiffness * max(x - slack + reel, 0.0)
            if force > limit and payout < most:
                out = min((force - limit) / stiffness, most - payout)
                reel, payout = reel - out, payout + out
                force = stiffness * max(x - slack + reel, 0.0)
        v += (-force / MASS - braking) * step
        x += v * step
        top = max(top, x)
    return top, payout


def test_a_damper_that_alone_gives_more_than_the_limit_slips_bare() -> None:
    """The slack is gone at 4.5 m/s, so c v is 9 kN at once: the limiter lets all of it out until c v is down to its force."""
    a, slack, damping, limit = 200.0, 0.05, 2000.0, 4000.0
    solved = Solved(sled(spring(60e3, slack=slack, damping=damping, limits=(limit, np.inf)), pulse=constant(a)))
    taken_up = np.sqrt(2.0 * slack / a)
    assert solved.times[0] == pytest.approx(taken_up, rel=1e-12)
    late = np.linspace(taken_up + 1e-9, 0.2, 400)
    np.testing.assert_allclose(solved.at("driver.0.force", late), limit, rtol=1e-12)
    # a - F / m > 0: it is drawn on faster and faster, so that the webbing never stretches
    assert solved.phases.payout[0] == pytest.approx(solved.at("driver.excursion", 0.2) - slack, rel=1e-12)


def test_bare_slip_ends_where_the_damper_gives_the_limit() -> None:
    braking = points([0.0, 0.03, 0.0300001, 0.2], [-200.0, -200.0, 0.0, 0.0])
    damping, limit, slack = 2000.0, 9000.0, 0.05
    solved = Solved(sled(spring(60e3, slack=slack, damping=damping, limits=(limit, np.inf)), pulse=braking, duration=0.1))
    force = solved.at("driver.0.force", np.linspace(0.0, 0.1, 2001))
    assert force.max() == pytest.approx(limit, rel=1e-12)
    paid_out, top = solved.phases.payout[0], solved.largest("driver.excursion")[0]
    assert 0.0 < paid_out < top - slack
    late = np.linspace(0.06, 0.09, 50)  # the reel is fixed by then
    line = 60e3 * (solved.at("driver.excursion", late) - slack - paid_out)
    line += damping * solved.at("driver.excursion_velocity", late)
    np.testing.assert_allclose(solved.at("driver.0.force", late), np.maximum(line, 0.0), rtol=1e-9, atol=1e-6)


def test_a_belt_that_closes_above_a_stall_force_is_stalled_at_once() -> None:
    a, slack, damping = 200.0, 0.03, 2500.0
    timers = _pull(Action.PULL_1, 0.010, 0.010, 0.10)
    solved = Solved(sled(spring(60e3, slack=slack, damping=damping, stalls=(1500.0, np.inf), timers=timers), pulse=constant(a)))
    closed = next(t for t, change in zip(solved.times, solved.changes, strict=True) if change == (0, 1))
    taken_in = 0.10 / 0.010 * (closed - 0.010)
    speed = solved.at("driver.excursion_velocity", closed)
    assert damping * speed > 1500.0
    late = np.linspace(closed, 0.05, 200)[1:]
    line = 60e3 * (solved.at("driver.excursion", late) - slack + taken_in) + damping * solved.at(
        "driver.excursion_velocity", late
    )
    np.testing.assert_allclose(solved.at("driver.0.force", late), line, rtol=1e-10)
    assert line.min() > 1500.0


@pytest.mark.parametrize("unloading", [None, 400e3])
def test_a_weaker_second_stage_of_a_damped_belt(unloading: float | None) -> None:
    law = Restraint(
        (0.0, 0.02),
        (0.0, 1000.0),
        (50e3, 100e3),
        damping=900.0,
        unloading=unloading,
        limits=(5000.0, 1800.0),
        timers=(Timer(Action.STAGE_2, 0.05),),
    )
    solved = Solved(sled(law))
    force = solved.at("driver.0.force", np.linspace(0.0501, 0.09, 300))
    np.testing.assert_allclose(force, 1800.0, rtol=1e-12)
    assert solved.phases.payout[0] == pytest.approx(-solved.phases.reel[0], rel=1e-12)


def test_a_slipping_belt_comes_off_its_curve_once() -> None:
    """A light damper and a steep line: where the occupant no longer gains speed, only round-off tells curve and line apart."""
    waves = points([0.0, 0.02, 0.05, 0.06, 0.07, 0.1, 0.12], [0.0, -250.0, -350.0, -50.0, -350.0, -100.0, 0.0])
    for damping in (1.0, 10.0, 100.0):
        for slack in np.linspace(0.0, 0.03, 16):
            law = spring(50e3, unloading=5e6, damping=damping, slack=slack, limits=(3000.0, np.inf))
            solved = Solved(sled(law, pulse=waves))
            assert solved.stop == Stop.COMPLETED
            # the limiter gives the force, so the damper hardly counts
            undamped = Solved(sled(spring(50e3, unloading=5e6, slack=slack, limits=(3000.0, np.inf)), pulse=waves))
            assert solved.phases.payout[0] == pytest.approx(undamped.phases.payout[0], rel=2e-5 * damping)


def test_the_farthest_way_back_after_a_step_that_starts_where_the_occupant_turns() -> None:
    """Its rate is zero there but for round-off: no place to look for where it turns next."""
    slack = np.linspace(0.0, 0.05, 40)
    belt = Restraint(
        (0.0, 0.043), (0.0, 2150.0), (50e3, 2.1e3), slack, 5.6, 50.00000005e3,
        limits=(3000.0, np.inf), stalls=(np.inf, 1500.0), free=True,
        timers=(Timer(Action.LOCK, 0.01), *_pull(Action.PULL_2, 0.01, 0.005, 0.1)),
    )  # fmt: skip
    builder = Builder()
    car = builder.body("vehicle1", mass=2056.0, speed=6.33)
    body = builder.body("driver", mass=MASS, speed=6.33, parent=car)
    builder.element("vehicle1.front", Curve((0.0,), (0.0,), (233e3,)), deflection={car: 1.0})
    builder.element("driver.belt", belt, deflection={body: 1.0, car: -1.0})
    network = builder.build(duration=0.15)
    excursion = channels(network)["driver.excursion"]
    least = solve_many(network, tracked([(excursion, -1)])).best[0]
    for row, value in enumerate(least):
        phases, _ = solve_one(network.rows(np.array([row])))
        assert value == pytest.approx(phases.largest(phases.series(excursion), -1)[0], rel=1e-10, abs=1e-13)


def test_of_a_level_top_the_first_point_is_the_peak() -> None:
    limited, who = load("example-restraints"), "driver.shoulder-belt.force"
    network = lower(limited)
    phases, _ = solve_one(network)
    of_belt = phases.event_element == network.elements.index("driver.shoulder-belt")
    slips = phases.event_time[of_belt & (phases.event_before == 1) & (phases.event_after == 5)][0]
    force, when = phases.largest(phases.series(channels(network)[who]), 1)
    assert force == pytest.approx(5500.0, rel=1e-12)
    assert when == pytest.approx(slips, abs=1e-12)  # where the limiter holds again, the force is the same but for round-off
    many = simulate_many(limited, {"driver.shoulder-belt.slack": np.full(40, 0.03)}, outcomes=[f"{who}.max_time"])
    np.testing.assert_allclose(many[f"{who}.max_time"], slips, rtol=1e-9)


def test_a_bag_may_empty_too() -> None:
    timers = ((0.0, 50.0), (0.02, 0.0), (0.05, -10.0), (0.1, 0.0))
    bag = spring(40e3, empty=True, timers=tuple(Timer(Action.FILL, time, rate) for time, rate in timers))
    times = np.array([0.0601, 0.0701, 0.0801])
    solved = Solved(sled(bag))
    share = solved.at("driver.0.force", times) / (40e3 * solved.at("driver.0.deflection", times))
    np.testing.assert_allclose(share, 1.0 - 10.0 * (times - 0.05), rtol=1e-9)
