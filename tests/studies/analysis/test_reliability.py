"""Probabilities and quantiles against exact ones; intervals that hold them as often as they say."""

import numpy as np
import pytest
from scipy import stats

from ridedown.errors import InvalidInput
from ridedown.studies.analysis.designs import Variables
from ridedown.studies.analysis.evaluation import Limit
from ridedown.studies.analysis.reliability import exceedance, sample, share_interval, summary, wilson_interval
from ridedown.studies.distributions import LogNormal, Normal

VARIABLES = Variables({"load": Normal(mean=10.0, sd=2.0), "strength": Normal(mean=20.0, sd=3.0)})
BETA = 10.0 / 13.0**0.5
EXACT = float(stats.norm.sf(BETA))
LIMIT = Limit("margin", least=0.0)


def margin(table):
    return {"margin": table["strength"] - table["load"]}


@pytest.mark.parametrize(("count", "size"), [(0, 50), (1, 50), (25, 50), (50, 50), (3, 10_000)])
def test_share_intervals_are_those_of_scipy(count, size):
    for ours, method in ((share_interval, "exact"), (wilson_interval, "wilson")):
        theirs = stats.binomtest(count, size).proportion_ci(0.95, method)
        assert ours(count, size) == pytest.approx((theirs.low, theirs.high), rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("design", ["random", "latin-hypercube", "sobol"])
def test_intervals_of_a_linear_normal_problem_hold_as_often_as_they_say(design):
    held, quantiles, means = 0, 0, 0
    for seed in range(40):
        found = sample(
            margin, VARIABLES, ["margin"], limits=[LIMIT], rows=8192, design=design, scramblings=8, shares=(0.05,), seed=seed
        )
        chance = found.exceedances[0].probability
        held += chance.low <= EXACT <= chance.high
        low_quantile = found.summaries[0].quantiles[0].value
        quantiles += low_quantile.low <= 10.0 + 13.0**0.5 * stats.norm.ppf(0.05) <= low_quantile.high
        means += found.summaries[0].mean.low <= 10.0 <= found.summaries[0].mean.high
    # of 40 at 95 %, fewer than 33 hold once in a thousand times
    assert min(held, quantiles, means) >= 33


def test_a_sobol_sequence_is_more_exact_than_random_rows():
    def width(design):
        limit = Limit("margin", least=6.0)
        chance = sample(margin, VARIABLES, ["margin"], limits=[limit], design=design, seed=0).exceedances[0].probability
        return chance.high - chance.low

    assert width("sobol") < 0.7 * width("random")


@pytest.mark.parametrize("design", ["random", "latin-hypercube", "sobol"])
def test_same_seed_same_result_whatever_the_batch(design):
    results = [
        sample(margin, VARIABLES, ["margin"], limits=[LIMIT], rows=1000, design=design, scramblings=4, seed=seed, batch=batch)
        for seed, batch in ((0, 7), (0, 100_000), (1, 100_000))
    ]
    assert results[0] == results[1]
    assert results[0].summaries != results[2].summaries
    assert results[0].evaluations == (1024 if design == "sobol" else 1000)


def test_exceedance_of_nothing_and_of_everything():
    none = exceedance(Limit("y", most=1.0), np.zeros(1600), groups=16)
    assert (none.probability.value, none.probability.low) == (0.0, 0.0)
    assert none.probability.high == pytest.approx(1.0 - 0.025 ** (1 / 1600))
    assert none.beta == np.inf
    every = exceedance(Limit("y", most=1.0), np.full(1600, 2.0), groups=16).probability
    assert (every.value, every.high) == (1.0, 1.0)
    assert exceedance(Limit("y", most=1.0), np.ones(100)).exceeded == 0  # at the limit is within it


@pytest.mark.parametrize("groups", [1, 10])
def test_failed_rows_widen_the_interval(groups):
    values = np.tile(np.repeat([0.0, 2.0], [9, 1]), 200)
    whole = exceedance(Limit("y", most=1.0), values, groups=groups)
    values[::40] = np.nan
    part = exceedance(Limit("y", most=1.0), values, groups=groups)
    assert (part.failed, part.rows) == (50, 2000)
    assert part.probability.value == pytest.approx(200 / 1950)
    assert part.probability.low <= whole.probability.low
    assert part.probability.high >= 0.125
    assert summary("y", values, groups=groups).failed == 50


def test_quantiles_beyond_the_sample_have_no_bound():
    found = summary("y", np.arange(50.0), shares=(0.5, 0.999))
    median, far = found.quantiles
    assert median.value.value == 24.5
    assert (median.value.low, median.value.high) == (17.0, 32.0)  # the 18th and the 33rd of 50, as tables of sign tests have it
    assert far.value.high == np.inf
    assert (found.least, found.largest) == (0.0, 49.0)


def test_all_failed():
    found = sample(
        lambda t: {"margin": np.full(t["load"].size, np.nan)}, VARIABLES, ["margin"], limits=[LIMIT], rows=64, seed=0
    )
    assert (found.failed, found.summaries[0].failed) == (64, 64)
    chance = found.exceedances[0].probability
    assert np.isnan(chance.value)
    assert (chance.low, chance.high) == (0.0, 1.0)


def test_correlated_parameters():
    variables = Variables(dict(VARIABLES.distributions), {("load", "strength"): 0.6})
    r = 2.0 * np.sin(np.pi * 0.6 / 6.0)
    exact = stats.norm.sf(4.0 / (13.0 - 2.0 * r * 6.0) ** 0.5)
    chance = (
        sample(margin, variables, ["margin"], limits=[Limit("margin", least=6.0)], rows=65_536, seed=0)
        .exceedances[0]
        .probability
    )
    assert chance.low < exact < chance.high
    assert chance.high < 1.3 * exact


def test_refuses():
    one = Variables({"x": LogNormal(median=1.0, sigma=1.0)})
    for options, sentence in (
        ({"design": "sobl"}, "design: got 'sobl'; need one of sobol"),
        ({"rows": 0}, "rows: got 0"),
        ({"confidence": 1.0}, "confidence: got 1.0; need > 0 and < 1"),
        ({"shares": (1.5,)}, "shares: got 1.5"),
        ({"scramblings": 1}, "scramblings: got 1; need a whole number of 2"),
        ({"seed": -1}, "seed: got -1"),
    ):
        with pytest.raises(InvalidInput, match=sentence):
            sample(lambda t: {"y": t["x"]}, one, ["y"], limits=[Limit("y", most=1.0)], **options)
    with pytest.raises(TypeError, match="unexpected keyword"):
        sample(lambda t: {"y": t["x"]}, one, ["y"], desing="sobol")  # type: ignore[call-arg]
    with pytest.raises(InvalidInput, match=r"values: got shape \(10,\); need a column whose length 3 divides"):
        exceedance(Limit("y", most=1.0), np.zeros(10), groups=3)
