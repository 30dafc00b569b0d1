"""Batches, counts and what an evaluator may not give back."""

import numpy as np
import pytest

from ridedown.errors import InvalidInput, UnknownName
from ridedown.studies.analysis.evaluation import Limit, Runs


def test_batches_are_put_together_and_counted():
    sizes, told = [], []

    def model(table):
        sizes.append(table["x"].size)
        return {"y": np.where(table["x"] == 3.0, np.nan, 2.0 * table["x"]), "z": np.where(table["x"] == 4.0, np.inf, 1.0)}

    runs = Runs(model, ["y", "z"], batch=4, total=20, progress=lambda done, total: told.append((done, total)))
    found = runs({"x": np.arange(10.0)})
    assert sizes == [4, 4, 2]
    np.testing.assert_array_equal(found["y"], [0, 2, 4, np.nan, 8, 10, 12, 14, 16, 18])
    assert np.isnan(found["z"][4])  # an infinite outcome has failed too
    assert (runs.done, runs.failed) == (10, 2)
    assert told == [(4, 20), (8, 20), (10, 20)]


def test_refuses_what_is_no_outcome():
    with pytest.raises(UnknownName, match=r"outcome: no 'yy'\. Did you mean 'y'"):
        Runs(lambda table: {"y": table["x"]}, ["yy"])({"x": np.zeros(3)})
    with pytest.raises(InvalidInput, match=r"y: got an array of shape \(2,\); need \(3,\)"):
        Runs(lambda _: {"y": np.zeros(2)}, ["y"])({"x": np.zeros(3)})
    with pytest.raises(InvalidInput, match="outcomes: got none"):
        Runs(lambda _: {}, [])
    with pytest.raises(InvalidInput, match="batch: got 0"):
        Runs(lambda _: {}, ["y"], batch=0)


def test_a_limit_is_one_bound():
    assert Limit("y", most=2.0).excess(np.array([1.0, 3.0])).tolist() == [-1.0, 1.0]
    assert Limit("y", least=2.0).excess(np.array([1.0, 3.0])).tolist() == [1.0, -1.0]
    assert Limit("y", least=2.0).rule == "y >= 2"
    for wrong in ({}, {"most": 1.0, "least": 0.0}, {"most": float("nan")}):
        with pytest.raises(InvalidInput, match="y: got most"):
            Limit("y", **wrong)
