"""Distributions against scipy's, and what they refuse."""

import numpy as np
import pytest
from pydantic import TypeAdapter
from scipy import integrate, stats

from ridedown.errors import InvalidInput
from ridedown.scenario.base import Model
from ridedown.scenario.quantities import Quantity
from ridedown.studies.distributions import (
    KINDS,
    AnyDistribution,
    Discrete,
    Distribution,
    LogNormal,
    Normal,
    Triangular,
    TruncatedNormal,
    Uniform,
)
from ridedown.units import FRACTION, LENGTH, STIFFNESS

PAIRS = {
    "normal": (Normal(mean=3.0, sd=2.0), stats.norm(3.0, 2.0)),
    "cut": (TruncatedNormal(mean=3.0, sd=2.0, lower=1.0, upper=4.0), stats.truncnorm(-1.0, 0.5, 3.0, 2.0)),
    "far tail": (TruncatedNormal(mean=0.0, sd=1.0, lower=5.0), stats.truncnorm(5.0, np.inf)),
    "lower tail": (TruncatedNormal(mean=0.0, sd=1.0, upper=-5.0), stats.truncnorm(-np.inf, -5.0)),
    "median": (LogNormal(median=2.0, sigma=0.3), stats.lognorm(0.3, scale=2.0)),
    "uniform": (Uniform(lower=-1.0, upper=3.0), stats.uniform(-1.0, 4.0)),
    "triangular": (Triangular(lower=1.0, mode=2.0, upper=5.0), stats.triang(0.25, 1.0, 4.0)),
    "left edge": (Triangular(lower=1.0, mode=1.0, upper=5.0), stats.triang(0.0, 1.0, 4.0)),
    "right edge": (Triangular(lower=1.0, mode=5.0, upper=5.0), stats.triang(1.0, 1.0, 4.0)),
}


@pytest.mark.parametrize("name", PAIRS)
def test_agrees_with_scipy(name):
    ours, theirs = PAIRS[name]
    u = np.array([1e-9, 1e-3, 0.1, 0.25, 0.5, 0.9, 0.999])
    x = ours.ppf(u)
    np.testing.assert_allclose(x, theirs.ppf(u), rtol=1e-9)
    np.testing.assert_allclose(ours.cdf(x), u, rtol=1e-6, atol=1e-14)  # x itself is rounded
    np.testing.assert_allclose(ours.logpdf(x[1:]), theirs.logpdf(x[1:]), rtol=1e-9)
    np.testing.assert_allclose(ours.pdf(x[1:]), theirs.pdf(x[1:]), rtol=1e-9)
    assert ours.expected() == pytest.approx(theirs.mean(), rel=1e-9)
    assert ours.deviation() == pytest.approx(theirs.std(), rel=1e-6)  # scipy integrates the far tail numerically


@pytest.mark.parametrize("name", PAIRS)
def test_the_density_integrates_to_one_and_ends_with_the_support(name):
    ours, _ = PAIRS[name]
    low, high = (np.clip(bound, *ours.ppf([1e-14, 1.0 - 1e-14])) for bound in ours.support())
    total = integrate.quad(lambda x: float(ours.pdf(x)), low, high, points=[float(ours.ppf(0.5))], limit=200)[0]
    assert total == pytest.approx(1.0, rel=1e-7)
    for bound, outward in zip(ours.support(), (-1.0, 1.0), strict=True):
        if np.isfinite(bound):
            assert ours.pdf(bound + outward) == 0.0


@pytest.mark.parametrize("name", PAIRS)
def test_from_normal_is_the_inverse_at_the_normals_share(name):
    ours, _ = PAIRS[name]
    z = np.linspace(-5.0, 5.0, 41)
    np.testing.assert_allclose(ours.from_normal(z), ours.ppf(stats.norm.cdf(z)), rtol=1e-8, atol=1e-14)


def test_discrete_values_come_with_their_weights():
    ours = Discrete(values=[3.0, 1.0, 2.0], weights=[2.0, 1.0, 0.0])
    u = (np.arange(3000) + 0.5) / 3000
    drawn, counts = np.unique(ours.ppf(u), return_counts=True)
    assert drawn.tolist() == [1.0, 3.0]
    assert counts.tolist() == [1000, 2000]
    assert ours.pdf([1.0, 2.0, 3.0]) == pytest.approx([1 / 3, 0.0, 2 / 3])
    assert ours.cdf([0.9, 1.0, 2.9, 3.0]) == pytest.approx([0.0, 1 / 3, 1 / 3, 1.0])
    assert (ours.expected(), ours.deviation()) == pytest.approx((7 / 3, (8 / 9) ** 0.5))
    assert Discrete(values=[1.0, 2.0]).ppf([0.0, 1.0]).tolist() == [1.0, 2.0]


def test_values_are_read_with_their_units():
    same = [
        Normal(mean="98.1 kN/m", sd="5 kN/m"),
        Normal(mean=98.1, sd=5, unit="kN/m"),
        Normal(mean=98.1, sd="5000 N/m", unit="kN/m"),
        Normal(mean=98100.0, sd=5000.0, unit="N/m"),
    ]
    assert all(one == same[0] for one in same)
    assert (same[0].mean, same[0].sd, same[0].unit) == (98100.0, 5000.0, "N/m")
    assert Discrete(values=["48 km/h", "36 km/h"]).values == (480 / 36, 10.0)
    assert Uniform(lower="40 %", upper="60 %") == Uniform(lower=0.4, upper=0.6, unit="")
    for one in same:
        assert Normal.model_validate(one.model_dump()) == one


class _File(Model):
    stiffness: AnyDistribution


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        (
            {"kind": "normal", "mean": "98 kN/m", "sd": "5 mm"},
            "stiffness.sd: got a length beside a stiffness; need values of one",
        ),
        ({"kind": "normal", "mean": "98 kN/m"}, "stiffness.sd: got nothing; need"),
        ({"kind": "normal", "mean": "98 kN/m", "sd": 0}, "stiffness.sd: got 0 N/m; need > 0 N/m."),
        ({"kind": "normal", "mean": "98 kn/m", "sd": 1}, 'stiffness.mean: got "98 kn/m"; need a unit.* Did you mean "kN/m"?'),
        ({"kind": "normal", "mean": "98", "sd": 1}, 'stiffness.mean: got "98"; need a bare number, or text with a unit'),
        ({"kind": "normal", "mean": True, "sd": 1}, "stiffness.mean: got True; need a number"),
        ({"kind": "normal", "mean": float("nan"), "sd": 1}, "stiffness.mean: got nan; need a finite number"),
        ({"kind": "normal", "mean": 1, "sd": 1, "unit": "parsec"}, 'stiffness.unit: got "parsec"; need a unit'),
        ({"kind": "normal", "mean": 1, "std": 1}, 'stiffness.std: got an unknown key; .*Did you mean "sd"?'),
        ({"kind": "norml", "mean": 1, "sd": 1}, 'stiffness.kind: got "norml"; need one of .* Did you mean "normal"?'),
        ({"mean": 1, "sd": 1}, "stiffness.kind: got nothing; need one of"),
        ("normal", 'stiffness: got "normal"; need a table'),
        ({"kind": "uniform", "lower": 2, "upper": 1}, "stiffness.upper: got 1; need > lower, 2."),
        ({"kind": "triangular", "lower": 1, "mode": 9, "upper": 2}, "stiffness.mode: got 9; need a value from lower to upper"),
        ({"kind": "truncated-normal", "mean": 1, "sd": 1}, "stiffness.lower: got no bound; need lower, upper or both"),
        ({"kind": "truncated-normal", "mean": 0, "sd": 1, "lower": 9}, "stiffness.lower: got 1.1e-19 of the normal within"),
        ({"kind": "truncated-normal", "mean": 0, "sd": 1, "lower": 2, "upper": 1}, "stiffness.upper: got 1; need > lower, 2"),
        ({"kind": "lognormal", "median": 1, "sd": 1}, "stiffness.sigma: got nothing; need median and sigma, or mean and sd"),
        ({"kind": "lognormal", "mean": 1, "median": 1, "sd": 1}, "got both median and mean"),
        ({"kind": "lognormal", "mean": 1, "sd": 1, "sigma": 1}, "stiffness.sigma: got sigma beside mean"),
        ({"kind": "lognormal", "median": -1, "sigma": 1}, "stiffness.median: got -1; need > 0"),
        ({"kind": "discrete", "values": []}, "stiffness.values: got an empty list"),
        ({"kind": "discrete", "values": [1, 1]}, "stiffness.values: got a value twice"),
        ({"kind": "discrete", "values": [1, "2 mm", "3 kg"]}, "stiffness.values: got a mass beside a length"),
        ({"kind": "discrete", "values": [1, 2], "weights": [1]}, "stiffness.weights: got a list of 1; need a list of 2"),
        ({"kind": "discrete", "values": [1, 2], "weights": [0, 0]}, "stiffness.weights: got weights that are all zero"),
    ],
)
def test_refuses_in_one_sentence(given, sentence):
    with pytest.raises(InvalidInput, match=sentence.replace("?", r"\?")):
        _File(stiffness=given)


def test_a_file_holds_any_kind():
    for kind, model in KINDS.items():
        assert model.model_fields["kind"].default == kind
    assert isinstance(_File(stiffness={"kind": "uniform", "lower": 1, "upper": 2}).stiffness, Uniform)
    assert _File(stiffness=Uniform(lower=1, upper=2)).stiffness.upper == 2.0
    schema = TypeAdapter(AnyDistribution).json_schema()
    assert len(schema["oneOf"]) == len(KINDS)


STIFF = Quantity(STIFFNESS, least=0.0)


@pytest.mark.parametrize(
    ("distribution", "quantity", "sentence"),
    [
        (Normal(mean="5 mm", sd="1 mm"), STIFF, "belt.stiffness: got a distribution of a length; need a stiffness"),
        (Normal(mean=5.0, sd=1.0), STIFF, "got a normal distribution with 2.9e-07 of its values outside >= 0 N/m"),
        (Uniform(lower=-1.0, upper=3.0), STIFF, "with 0.25 of its values outside"),
        (
            Uniform(lower=0.5, upper=1.5),
            Quantity(FRACTION, above=0.0, most=1.0),
            "with 0.5 of its values outside > 0  and <= 1",
        ),
        (Discrete(values=[0.0, 1.0]), Quantity(LENGTH, above=0.0), "with 0.5 of its values outside > 0 m"),
    ],
)
def test_a_parameter_refuses_what_it_cannot_hold(distribution, quantity, sentence):
    with pytest.raises(InvalidInput, match=sentence.replace("  ", " ")):
        distribution.check_against(quantity, "belt.stiffness")


@pytest.mark.parametrize(
    "distribution",
    [
        Normal(mean="98 kN/m", sd="5 kN/m"),
        Normal(mean=98e3, sd=5e3),
        Uniform(lower=0.0, upper=1.0),
        LogNormal(median=1.0, sigma=1.0),
        TruncatedNormal(mean=0.0, sd=1.0, lower=0.0),
        Discrete(values=[0.0, 1.0]),
    ],
)
def test_a_parameter_takes_what_stays_within_its_bounds(distribution: Distribution):
    distribution.check_against(STIFF, "belt.stiffness")
