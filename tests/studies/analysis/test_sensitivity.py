"""Sobol indices and Morris effects of functions of which they are known exactly.

Ishigami: T. Ishigami, T. Homma, 1990; g: I. M. Sobol, 2003; both with indices as in A. Saltelli et al., Global sensitivity
analysis: the primer, 2008, sections 4.8 and 5.
"""

import numpy as np
import pytest

from ridedown.errors import InvalidInput
from ridedown.studies.analysis.designs import Variables
from ridedown.studies.analysis.sensitivity import morris_screening, sobol_indices
from ridedown.studies.distributions import Normal, Uniform

WIDE = Variables({f"x{i}": Uniform(lower=-np.pi, upper=np.pi) for i in (1, 2, 3, 4)})


def ishigami(table):
    a, b = 7.0, 0.1
    return {"y": np.sin(table["x1"]) + a * np.sin(table["x2"]) ** 2 + b * table["x3"] ** 4 * np.sin(table["x1"])}


def ishigami_exact():
    a, b, p = 7.0, 0.1, np.pi**4
    v1, v2, v13 = 0.5 * (1.0 + b * p / 5.0) ** 2, a * a / 8.0, b * b * p * p * 8.0 / 225.0
    whole = v1 + v2 + v13
    return np.array([v1, v2, 0.0, 0.0]) / whole, np.array([v1 + v13, v2, v13, 0.0]) / whole


COEFFICIENTS = np.array([0.0, 1.0, 4.5, 9.0, 99.0])
UNIT = Variables({f"x{i}": Uniform(lower=0.0, upper=1.0) for i in range(5)})


def sobol_g(table):
    return {"y": np.prod([(np.abs(4.0 * table[f"x{i}"] - 2.0) + a) / (1.0 + a) for i, a in enumerate(COEFFICIENTS)], axis=0)}


def sobol_g_exact():
    each = 1.0 / (3.0 * (1.0 + COEFFICIENTS) ** 2)
    whole = np.prod(1.0 + each) - 1.0
    return each / whole, each * np.prod(1.0 + each) / (1.0 + each) / whole


@pytest.mark.parametrize(
    ("model", "variables", "exact"), [(ishigami, WIDE, ishigami_exact), (sobol_g, UNIT, sobol_g_exact)], ids=["ishigami", "g"]
)
def test_indices_are_within_their_intervals(model, variables, exact):
    first, total = exact()
    held = tried = 0
    for seed in range(5):
        found = sobol_indices(model, variables, ["y"], blocks=2048, seed=seed)
        for i, index in enumerate(found.outcomes[0].indices):
            assert index.first.value == pytest.approx(first[i], abs=0.03)
            assert index.total.value == pytest.approx(total[i], abs=0.03)
            held += index.first.low <= first[i] <= index.first.high
            held += index.total.low <= total[i] <= index.total.high
            tried += 2
        assert found.evaluations == 2048 * (len(variables.names) + 2)
    assert held >= 0.9 * tried


def test_parameters_without_effect_are_named():
    assert sobol_indices(ishigami, WIDE, ["y"], blocks=64, seed=0).idle == ("x4",)
    assert morris_screening(ishigami, WIDE, ["y"], seed=0).idle == ("x4",)
    both = sobol_indices(lambda t: ishigami(t) | {"z": t["x4"]}, WIDE, ["y", "z"], blocks=64, seed=0)
    assert both.idle == ()
    assert [index.idle for index in both.outcomes[1].indices] == [True, True, True, False]


def test_constant_outcomes_are_said_to_be_so():
    def flat(table):
        return {"y": np.full(table["x1"].size, 0.1) * (1.0 + 1e-16 * table["x1"])}

    indices = sobol_indices(flat, WIDE, ["y"], blocks=64, seed=0)
    assert indices.outcomes[0].constant
    assert indices.outcomes[0].deviation == 0.0
    assert np.isnan(indices.outcomes[0].indices[0].first.value)
    assert indices.idle == WIDE.names
    effects = morris_screening(flat, WIDE, ["y"], seed=0)
    assert effects.outcomes[0].constant
    assert effects.idle == WIDE.names


def test_blocks_with_failed_rows_are_left_out_and_counted():
    def model(table):
        return {"y": np.where(table["x1"] > 3.0, np.nan, ishigami(table)["y"])}

    found = sobol_indices(model, WIDE, ["y"], blocks=512, seed=0)
    outcome = found.outcomes[0]
    assert outcome.of_blocks == 512
    assert 400 < outcome.blocks < 512
    assert found.failed > 0
    assert all(np.isfinite(index.total.value) for index in outcome.indices)
    screened = morris_screening(model, WIDE, ["y"], trajectories=200, seed=0).outcomes[0]
    assert 0 < screened.trajectories < screened.of_trajectories == 200
    lost = sobol_indices(lambda t: {"y": np.full(t["x1"].size, np.nan)}, WIDE, ["y"], blocks=8, seed=0)
    assert lost.outcomes[0].blocks == 0
    assert not lost.outcomes[0].constant
    assert lost.idle == ()


def test_effects_of_a_plane_are_its_slopes_over_the_range():
    variables = Variables({"a": Uniform(lower=0.0, upper=10.0), "b": Normal(mean=0.0, sd=1.0)})
    found = morris_screening(lambda t: {"y": 3.0 * t["a"] - t["b"]}, variables, ["y"], seed=0)
    a, b = found.outcomes[0].effects
    assert a.mean == pytest.approx(3.0 * 9.8)
    assert a.mean_size.low == pytest.approx(a.mean_size.high)
    assert b.mean < 0.0 < b.mean_size.value
    assert found.evaluations == 50 * 3


@pytest.mark.parametrize("run", [sobol_indices, morris_screening])
def test_zero_is_a_seed_and_batches_do_not_matter(run):
    results = [run(ishigami, WIDE, ["y"], seed=seed, batch=batch) for seed, batch in ((0, 50), (0, 10_000), (1, 10_000))]
    assert results[0] == results[1]
    assert results[0].outcomes != results[2].outcomes


def test_refuses():
    tied = Variables(dict(WIDE.distributions), {("x1", "x2"): 0.5})
    for run in (sobol_indices, morris_screening):
        with pytest.raises(InvalidInput, match="correlation: got x1 with x2; need independent parameters"):
            run(ishigami, tied, ["y"])
        with pytest.raises(TypeError, match="unexpected keyword"):
            run(ishigami, WIDE, ["y"], sede=0)  # type: ignore[call-arg]
    with pytest.raises(InvalidInput, match="levels: got 5; need an even number"):
        morris_screening(ishigami, WIDE, ["y"], levels=5)
    with pytest.raises(InvalidInput, match="blocks: got 1"):
        sobol_indices(ishigami, WIDE, ["y"], blocks=1)
