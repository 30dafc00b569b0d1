"""Pareto fronts that are known: ZDT1, a plane, and a crash by brute force."""

import numpy as np
import pytest
from scipy import stats

from ridedown import load, simulate_many
from ridedown.errors import InvalidInput
from ridedown.studies.analysis.goals import Goal, Requirement
from ridedown.studies.analysis.pareto import knee_of, pareto

TWO = [Goal("f"), Goal("g")]


def zdt1(table):
    """E. Zitzler, K. Deb, L. Thiele, 2000: the front is g = 1 - sqrt(f), all but the first parameter 0."""
    x = np.array(list(table.values()))
    g = 1.0 + 9.0 * x[1:].mean(axis=0)
    return {"f": x[0], "g": g * (1.0 - np.sqrt(x[0] / g))}


def test_zdt1():
    ranges = {f"x{i}": (0.0, 1.0) for i in range(8)}
    front = pareto(zdt1, ranges, TWO, generations=120, reference=(1.1, 1.1), seed=0)
    f, g = front.goals["f"], front.goals["g"]
    assert front.size >= 80
    exact = np.linspace(0.0, 1.0, 4001) ** 2
    away = np.hypot(f[:, None] - exact, g[:, None] - (1.0 - np.sqrt(exact))).min(axis=1)
    # at f = 0 to round-off a design is worse by nothing that the rule of dominance sees
    assert away[f > 1e-3].max() < 0.005
    assert (np.diff(f) > 0.0).all()
    assert np.diff(f).max() < 0.06
    # of the box to (1.1, 1.1): 0.11 + 0.1 + 2/3 exactly
    assert front.hypervolume == pytest.approx(1.1 * 1.1 - 1.0 + 2.0 / 3.0, rel=0.01)
    # the knee of 1 - sqrt(f) under the line from (0, 1) to (1, 0) is at f = 1/4
    assert f[front.knee] == pytest.approx(0.25, abs=0.05)
    assert front.algorithm == "nsga2"
    assert front.evaluations == 100 * 120 + front.size


def test_three_goals():
    def model(table):
        x, y = table["x"], table["y"]
        return {"f": x, "g": y, "h": 1.0 - x - y + 2.0 * np.maximum(x + y - 1.0, 0.0)}

    front = pareto(model, {"x": (0.0, 1.0), "y": (0.0, 1.0)}, [*TWO, Goal("h")], generations=40, seed=0)
    assert front.algorithm == "nsga3"
    total = sum(front.goals.values())
    assert total == pytest.approx(np.ones(front.size), abs=0.02)
    assert front.size > 50


def test_maximised_goals_and_requirements():
    front = pareto(
        lambda t: {"f": t["x"], "g": t["x"] * (2.0 - t["x"]) - t["y"], "sum": t["x"] + t["y"]},
        {"x": (0.0, 1.0), "y": (0.0, 1.0)},
        [Goal("f"), Goal("g", maximise=True)],
        requirements=[Requirement("sum", least=0.3)],
        candidates=60,
        generations=80,
        seed=0,
    )
    assert (front.requirements["sum >= 0.3"] >= 0.0).all()
    inside = front.goals["f"] > 0.31
    np.testing.assert_allclose(front.goals["g"][inside], (front.goals["f"] * (2.0 - front.goals["f"]))[inside], atol=0.02)
    assert front.goals["g"].max() == pytest.approx(1.0, abs=0.01)


def test_the_front_of_a_crash_known_by_brute_force():
    crash = load("paper-adult-full")
    outcomes = ["adult.acceleration.peak", "adult.excursion.max"]
    ranges = {"adult.restraint.stiffness": (20e3, 200e3), "adult.restraint.slack": (0.0, 0.05)}

    def evaluator(table):
        many = simulate_many(crash, table, outcomes=outcomes)
        return {name: many[name] for name in outcomes}

    stiffness, slack = (grid.ravel() for grid in np.meshgrid(np.linspace(20e3, 200e3, 120), np.linspace(0.0, 0.05, 26)))
    grid = evaluator(dict(zip(ranges, (stiffness, slack), strict=True)))
    grid_bad = np.stack([grid[name] for name in outcomes], axis=1)
    front = pareto(evaluator, ranges, [Goal(name) for name in outcomes], candidates=60, generations=40, seed=0)
    bad = np.stack([front.goals[name] for name in outcomes], axis=1)
    assert front.failed == 0

    def beaten(rows, by, room):
        return (rows[:, None, :] * (1.0 - room) > by[None, :, :]).all(axis=2).any(axis=1)

    # none of 3120 designs is better than one of the front by 1 % in both; and the front reaches each of the grid's own front
    assert not beaten(bad, grid_bad, 0.01).any()
    no_better = np.all(grid_bad[:, None] >= grid_bad[None], axis=2)
    worse = np.any(grid_bad[:, None] > grid_bad[None], axis=2)
    grid_front = grid_bad[~np.any(no_better & worse, axis=1)]
    assert len(grid_front) > 20
    reached = np.all(bad[:, None, :] <= 1.02 * grid_front[None], axis=2)
    assert np.all(np.any(reached, axis=0))
    # softer is gentler but goes farther; slack does no good on either count
    assert front.parameters["adult.restraint.slack"].max() < 0.002
    assert stats.spearmanr(front.parameters["adult.restraint.stiffness"], bad[:, 0]).statistic > 0.95


def test_nothing_feasible_is_an_empty_front():
    front = pareto(
        zdt1, {"a": (0.0, 1.0), "b": (0.0, 1.0)}, TWO, requirements=[Requirement("f", most=-1.0)], generations=5, seed=0
    )
    assert (front.size, front.knee, front.feasible, front.hypervolume) == (0, None, False, 0.0)
    assert "No design" in front.warnings[0]


def test_failed_rows_are_counted_and_not_on_the_front():
    def model(table):
        found = zdt1(table)
        return {"f": np.where(table["a"] < 0.5, np.nan, found["f"]), "g": found["g"]}

    front = pareto(model, {"a": (0.0, 1.0), "b": (0.0, 1.0)}, TWO, generations=30, seed=0)
    assert front.failed > 0
    assert front.goals["f"].min() >= 0.5
    assert "rows failed" in front.warnings[0]


def test_zero_is_a_seed_and_batches_do_not_matter():
    def found(seed, batch):
        front = pareto(zdt1, {"a": (0.0, 1.0), "b": (0.0, 1.0)}, TWO, candidates=20, generations=5, seed=seed, batch=batch)
        return front.goals["g"].tolist()

    assert found(0, 7) == found(0, 10_000)
    assert found(0, 7) != found(1, 7)


def test_the_knee():
    assert knee_of(np.array([[0.0, 4.0], [1.0, 3.5], [2.0, 1.0], [10.0, 0.0]])) == 2
    assert knee_of(np.array([[1.0, 1.0]])) == 0
    # the plane through the corners of three goals is x + y + z = 1 here, and the middle is nearer the ideal
    corners = np.eye(3)
    assert knee_of(np.vstack([corners, [[0.2, 0.2, 0.2]]])) == 3
    # two corners in one: both goals besides the first are best in the same design
    assert knee_of(np.array([[0.0, 1.0, 1.0], [1.0, 0.0, 0.0], [0.2, 0.2, 0.2]])) == 2


@pytest.mark.parametrize(
    "front",
    [
        [[0.0, 1.0], [1.0, 0.0]],
        [[0.0, 1.0], [0.25, 0.75], [1.0, 0.0]],
        [[0.0, 1.0], [0.5, 0.9], [0.9, 0.5], [1.0, 0.0]],
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.6, 0.6, 0.6]],
        [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.5, 0.0]],
    ],
    ids=["two", "straight", "the wrong way", "the wrong way in three", "flat in three"],
)
def test_a_front_that_bulges_nowhere_to_the_better_side_has_no_knee(front):
    assert knee_of(np.array(front)) is None


def test_a_front_without_a_knee_says_so():
    def circle(table):
        angle = 0.5 * np.pi * table["a"]
        return {"f": np.sin(angle), "g": np.cos(angle)}

    front = pareto(circle, {"a": (0.0, 1.0)}, TWO, candidates=20, generations=5, seed=0)
    assert front.size > 5
    assert front.knee is None
    assert "no knee" in front.warnings[0]


def test_refuses():
    ranges = {"a": (0.0, 1.0), "b": (0.0, 1.0)}
    for options, sentence in (
        ({"algorithm": "nsga1"}, "algorithm: got 'nsga1'; need nsga2 or nsga3"),
        ({"reference": (1.0,)}, "reference: got 1 numbers; need 2"),
        ({"candidates": 1}, "candidates: got 1"),
    ):
        with pytest.raises(InvalidInput, match=sentence):
            pareto(zdt1, ranges, TWO, **options)
    with pytest.raises(InvalidInput, match="goals: got 1; need two or more"):
        pareto(zdt1, ranges, TWO[:1])
    with pytest.raises(TypeError, match="unexpected keyword"):
        pareto(zdt1, ranges, TWO, pop_size=10)  # type: ignore[call-arg]
