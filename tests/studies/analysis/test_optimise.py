"""One goal: optima that are known, plain, constrained, robust and by probability."""

import numpy as np
import pytest
from scipy import stats

from ridedown.errors import InvalidInput
from ridedown.studies.analysis.goals import Beyond, Goal, MeanPlus, Population, QuantileOf, Requirement
from ridedown.studies.analysis.optimise import optimise

SQUARE = {"x": (-5.0, 5.0), "y": (-5.0, 5.0)}


def test_the_least_of_many_valleys():
    def rastrigin(table):
        x = np.array(list(table.values()))
        return {"f": 10.0 * len(x) + (x * x - 10.0 * np.cos(2.0 * np.pi * x)).sum(axis=0)}

    found = optimise(rastrigin, {"a": (-5.12, 4.0), "b": (-5.12, 4.0), "c": (-5.12, 4.0)}, Goal("f"), seed=0)
    assert found.value == pytest.approx(0.0, abs=1e-9)
    assert list(found.parameters.values()) == pytest.approx([0.0] * 3, abs=1e-6)
    assert (found.feasible, found.at_end, found.warnings) == (True, (), ())


def test_a_constrained_optimum():
    # Hock and Schittkowski 1981, problem 22: minimum 1 at (1, 1), where both constraints are active
    found = optimise(
        lambda t: {"f": (t["x"] - 2.0) ** 2 + (t["y"] - 1.0) ** 2, "sum": t["x"] + t["y"], "above": t["y"] - t["x"] ** 2},
        SQUARE,
        Goal("f"),
        requirements=[Requirement("sum", most=2.0), Requirement("above", least=0.0)],
        seed=0,
    )
    assert found.feasible
    assert found.value == pytest.approx(1.0, abs=1e-6)
    assert list(found.parameters.values()) == pytest.approx([1.0, 1.0], abs=1e-6)
    assert found.requirements["sum <= 2"] <= 2.0
    assert found.requirements["above >= 0"] >= 0.0
    assert found.polished


def test_the_most_at_the_end_of_a_range():
    found = optimise(lambda t: {"f": t["x"] - t["y"] ** 2}, SQUARE, Goal("f", maximise=True), seed=0)
    assert found.value == pytest.approx(5.0)
    assert found.at_end == ("x",)


def test_a_kink():
    found = optimise(lambda t: {"f": np.abs(t["x"] - 1.0) + 10.0 * np.abs(t["y"] - t["x"])}, SQUARE, Goal("f"), seed=0)
    assert found.value == pytest.approx(0.0, abs=1e-4)


# f(x, e) = (x - 1)^2 + (2 + e) x with e ~ (0, s): mean (x - 1)^2 + 2 x, deviation s x for x > 0
NOISE = np.array([-3.0, -1.0, 1.0, 3.0]) * 0.6 / 5.0**0.5
ROBUST = Population({"e": NOISE})


def linear_quadratic(table):
    return {"f": (table["x"] - 2.0) ** 2 + (1.0 + table["e"]) * table["x"]}


def test_a_robust_optimum_in_closed_form():
    # mean plus k sigma: (x - 2)^2 + x + k s x, least where x = 2 - (1 + k s) / 2
    for k in (0.0, 1.0, 2.0):
        found = optimise(linear_quadratic, {"x": (0.0, 5.0)}, Goal("f", MeanPlus(k)), population=ROBUST, seed=0)
        assert found.parameters["x"] == pytest.approx(2.0 - 0.5 * (1.0 + 0.6 * k), abs=1e-5)
        assert found.evaluations % 4 == 0


def test_an_optimum_by_probability_in_closed_form():
    # capacity x against a load of N(10, 2) in 2000 equal parts, at most 2 % of which may exceed it: x = 10 + 2 * 2.0537
    load = 10.0 + 2.0 * stats.norm.ppf((np.arange(2000) + 0.5) / 2000)
    exact = 10.0 + 2.0 * stats.norm.ppf(0.98)
    for requirement in (
        Requirement("over", most=0.02, measure=Beyond(most=0.0)),
        Requirement("over", most=0.0, measure=QuantileOf(0.98)),
    ):
        found = optimise(
            lambda t: {"cost": t["x"], "over": t["load"] - t["x"]},
            {"x": (0.0, 30.0)},
            Goal("cost"),
            requirements=[requirement],
            population=Population({"load": load}),
            candidates=16,
            generations=40,
            seed=0,
        )
        assert found.feasible
        assert found.parameters["x"] == pytest.approx(exact, abs=0.02)


def test_what_cannot_be_is_said_so():
    found = optimise(
        lambda t: {"f": t["x"], "g": t["x"] ** 2 + t["y"] ** 2}, SQUARE, Goal("f"), requirements=[Requirement("g", most=-1.0)],
        generations=40, seed=0,
    )  # fmt: skip
    assert not found.feasible
    assert "comes nearest" in found.warnings[0]
    assert list(found.parameters.values()) == pytest.approx([0.0, 0.0], abs=1e-2)


def test_failed_rows_are_counted_and_not_chosen():
    found = optimise(lambda t: {"f": np.where(t["x"] < 1.0, np.nan, t["x"])}, SQUARE, Goal("f"), seed=0)
    assert found.parameters["x"] == pytest.approx(1.0, abs=1e-3)
    assert found.failed > 0
    assert "rows failed" in found.warnings[0]


def test_same_seed_same_result_whatever_the_batch():
    def model(table):
        return {"f": np.sin(3.0 * table["x"]) + table["x"] ** 2 + (table["y"] - 0.3) ** 2}

    results = [
        optimise(model, SQUARE, Goal("f"), generations=10, seed=seed, batch=batch)
        for seed, batch in ((0, 7), (0, 10_000), (1, 7))
    ]
    assert results[0] == results[1]
    assert results[0].evaluations != results[2].evaluations or results[0].parameters != results[2].parameters


def test_refuses():
    with pytest.raises(InvalidInput, match="candidates: got 2; need a whole number of 8"):
        optimise(linear_quadratic, {"x": (0.0, 1.0)}, Goal("f"), candidates=2)
    with pytest.raises(TypeError, match="unexpected keyword"):
        optimise(linear_quadratic, {"x": (0.0, 1.0)}, Goal("f"), popsize=2)  # type: ignore[call-arg]
