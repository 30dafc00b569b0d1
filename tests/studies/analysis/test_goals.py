"""Measures over a population, and designs judged against it."""

import numpy as np
import pytest

from ridedown.errors import InvalidInput
from ridedown.studies.analysis.designs import Variables
from ridedown.studies.analysis.goals import Beyond, Goal, Judge, Mean, MeanPlus, Population, QuantileOf, Requirement, Worst
from ridedown.studies.distributions import Normal

VALUES = np.array([[1.0, 2.0, 3.0, 10.0]])
WEIGHTS = np.array([0.4, 0.3, 0.2, 0.1])


@pytest.mark.parametrize(
    ("measure", "bad", "good"),
    [
        (Mean(), 2.6, -2.6),
        (MeanPlus(2.0), 2.6 + 2.0 * 6.64**0.5, -2.6 + 2.0 * 6.64**0.5),
        (QuantileOf(0.7), 2.0, -1.0),
        (QuantileOf(0.95), 10.0, -1.0),
        (Worst(), 10.0, -1.0),
        (Beyond(most=2.0), 0.3, -0.3),
        (Beyond(least=2.0), 0.4, -0.4),
    ],
    ids=str,
)
def test_measures_are_of_how_bad_an_outcome_is(measure, bad, good):
    assert measure.of(VALUES, WEIGHTS, 1.0) == pytest.approx([bad])
    assert measure.of(VALUES, WEIGHTS, -1.0) == pytest.approx([good])


def test_weights_of_zero_do_not_count():
    assert Worst().of(VALUES, np.array([0.5, 0.5, 0.0, 0.0]), 1.0).tolist() == [2.0]


def test_designs_meet_each_row_of_the_population_in_batches():
    sizes = []

    def model(table):
        sizes.append(table["x"].size)
        return {"y": table["x"] * table["mass"]}

    population = Population({"mass": [1.0, 3.0]}, weights=[3.0, 1.0], scatter={"x": [0.0, 1.0]})
    judge = Judge(model, {"x": (0.0, 10.0)}, [Goal("y")], [Requirement("y", most=6.0, measure=Worst())], population, batch=4)
    judged = judge(np.array([[0.0], [0.1], [0.5]]))
    # (3 x + 3 (x + 1)) / 4
    np.testing.assert_allclose(judged.goals[:, 0], [0.75, 2.25, 8.25])
    np.testing.assert_allclose(judged.excess[:, 0], [-3.0, 0.0, 12.0])
    assert judged.feasible.tolist() == [True, True, False]
    assert sizes == [4, 2]


def test_a_design_with_a_failed_row_has_failed():
    def model(table):
        return {"y": np.where(table["x"] * table["mass"] > 5.0, np.nan, table["x"])}

    judge = Judge(model, {"x": (0.0, 10.0)}, [Goal("y", Beyond(most=1.0))], (), Population({"mass": [0.0, 1.0]}))
    judged = judge(np.array([[0.1], [0.9]]))
    assert judged.failed.tolist() == [False, True]
    assert judged.goals[:, 0].tolist() == [0.0, np.inf]
    assert judge.runs.failed == 1


def test_a_population_is_drawn():
    drawn = Population.drawn(Variables({"mass": Normal(mean=75.0, sd=10.0)}), 256).arrays()
    assert drawn[0]["mass"].mean() == pytest.approx(75.0, abs=0.1)
    assert drawn[2].sum() == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: Population({"m": [1.0, 2.0], "n": [1.0]}).arrays(), "population: got 1 rows of n; need 2, as in m"),
        (lambda: Population({"m": [1.0, 2.0]}, weights=[1.0]).arrays(), "population: got 1 rows of weights; need 2, as in m"),
        (lambda: Population({"m": [1.0]}, weights=[-1.0]).arrays(), "population: got weights down to -1"),
        (lambda: Population({"m": [np.nan]}).arrays(), "population: got m of shape"),
        (lambda: Judge(None, {"x": (0, 1)}, [Goal("y")], (), Population({"x": [1.0]})), "got x, which the design sets"),
        (lambda: Judge(None, {"x": (0, 1)}, [Goal("y")], (), Population(scatter={"z": [1.0]})), "got scatter of z; need a"),
        (lambda: Judge(None, {"x": (1, 1)}, [Goal("y")]), "x: got 1 to 1; need a least value and a larger one"),
        (lambda: Judge(None, {}, [Goal("y")]), "ranges: got none"),
        (lambda: Judge(None, {"x": (0, 1)}, []), "goals: got none"),
        (lambda: Judge(None, {"x": (0, 1)}, [Goal("y"), Goal("y")]), "goals: got y twice"),
        (lambda: Requirement("y"), "y: got most None and least None"),
        (lambda: QuantileOf(1.0), "share: got 1.0"),
        (Beyond, "share beyond: got most None"),
    ],
)
def test_refuses(make, sentence):
    with pytest.raises(InvalidInput, match=sentence):
        make()
