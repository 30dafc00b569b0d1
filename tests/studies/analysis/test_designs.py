"""Designs: the same rows however they are asked for, even, and correlated as wanted."""

import itertools
from collections.abc import Callable

import numpy as np
import pytest
from scipy import stats
from scipy.stats import qmc

from ridedown.errors import InvalidInput, UnknownName
from ridedown.studies.analysis.designs import (
    Design,
    Grid,
    LatinHypercube,
    Random,
    Scramblings,
    Sobol,
    Variables,
    normal_matrix,
    rank_matrix,
    seed_of,
)
from ridedown.studies.distributions import LogNormal, Normal, Uniform

DESIGNS: dict[str, Callable[[int], Design]] = {
    "random": lambda seed: Random(5, seed),
    "sobol": lambda seed: Sobol(5, seed),
    "scramblings": lambda seed: Scramblings(5, seed, size=250, count=4),
    "held hypercube": lambda seed: LatinHypercube(5, seed, 1000),
    "keyed hypercube": lambda seed: LatinHypercube(5, seed, 100_003),
}


@pytest.mark.parametrize("name", DESIGNS)
def test_a_row_is_the_same_whatever_it_is_asked_for_with(name):
    whole = DESIGNS[name](0).rows(0, 1000)
    again = DESIGNS[name](0)
    cuts = [0, 1, 2, 7, 8, 300, 301, 777, 1000]
    parts = [again.rows(a, b) for a, b in reversed(list(itertools.pairwise(cuts)))]
    assert (np.concatenate(parts[::-1]) == whole).all()
    assert again.rows(5, 5).shape == (0, 5)
    assert ((whole > 0.0) & (whole < 1.0)).all()


@pytest.mark.parametrize("name", DESIGNS)
def test_zero_is_a_seed_and_other_seeds_give_other_rows(name):
    first, second, third = (DESIGNS[name](seed).rows(0, 100) for seed in (0, 0, 1))
    assert (first == second).all()
    assert not (first == third).any()


@pytest.mark.parametrize("seed", [0, 1, 12345])
def test_sobol_rows_are_those_of_scipy(seed):
    theirs = qmc.Sobol(7, bits=52, rng=np.random.default_rng(seed)).random(4096)
    ours = Sobol(7, seed)
    assert np.abs(ours.rows(0, 4096) - theirs).max() <= 2.0**-53
    assert np.abs(ours.rows(1234, 4000) - theirs[1234:4000]).max() <= 2.0**-53


def test_sobol_rows_far_out_still_lie_one_to_a_cell():
    start = 5 << 30  # an aligned block of 2^12 rows is a net of its own: one row to every 2^-12 in each column
    rows = Sobol(4, 0).rows(start, start + 4096)
    for column in np.floor(rows * 4096).astype(int).T:
        assert np.unique(column).size == 4096


@pytest.mark.parametrize("size", [1, 2, 97, 65_536, 65_537, 100_003])
def test_a_hypercube_has_one_row_in_each_part(size):
    rows = LatinHypercube(3, 0, size).rows(0, size)
    for column in np.floor(rows * size).astype(int).T:
        assert (np.sort(column) == np.arange(size)).all()


def test_a_keyed_hypercube_is_mixed():
    size = 200_000
    rows = LatinHypercube(3, 0, size).rows(0, size)
    order = np.arange(size)
    for column in rows.T:
        assert abs(np.corrcoef(column, order)[0, 1]) < 4.0 / size**0.5
        assert abs(np.corrcoef(column[1:], column[:-1])[0, 1]) < 4.0 / size**0.5
    assert np.abs(np.corrcoef(rows.T) - np.eye(3)).max() < 4.0 / size**0.5
    # pairs of columns fill the square evenly
    counts = np.histogram2d(rows[:, 0], rows[:, 1], bins=20, range=[[0, 1], [0, 1]])[0].ravel()
    assert 1e-4 < stats.chisquare(counts).pvalue < 1.0 - 1e-4


def test_random_rows_are_uniform_and_independent():
    rows = Random(6, 0).rows(0, 50_000)
    for column in rows.T:
        assert stats.kstest(column, "uniform").pvalue > 1e-3
    assert np.abs(np.corrcoef(rows.T) - np.eye(6)).max() < 4.0 / 50_000**0.5


def test_a_hypercube_of_a_thousand_million_rows_needs_no_memory():
    rows = LatinHypercube(4, 0, 10**9).rows(10**9 - 10, 10**9)
    assert rows.shape == (10, 4)
    with pytest.raises(InvalidInput, match="rows: got up to 1000000001; need <= 1000000000"):
        LatinHypercube(4, 0, 10**9).rows(10**9, 10**9 + 1)


def test_a_grid_is_every_combination_once():
    grid = Grid({"a": [1.0, 2.0, 3.0], "b": [5.0, 6.0]})
    columns = grid.columns(0, grid.size)
    assert list(zip(columns["a"], columns["b"], strict=True)) == [(a, b) for a in (1.0, 2.0, 3.0) for b in (5.0, 6.0)]
    assert grid.columns(4, 5)["a"].tolist() == [3.0]
    assert Grid({name: np.arange(1000.0) for name in "abcd"}).columns(10**12 - 1, 10**12)["a"].tolist() == [999.0]
    with pytest.raises(InvalidInput, match="need <= 6, the size of the grid"):
        grid.columns(0, 7)
    with pytest.raises(InvalidInput, match="a: got levels"):
        Grid({"a": []})
    with pytest.raises(InvalidInput, match="levels: got none"):
        Grid({})


@pytest.mark.parametrize("rank", [-0.9, 0.5, 0.95])
def test_ranks_correlate_as_wanted(rank):
    variables = Variables(
        {"a": LogNormal(median=1.0, sigma=0.5), "b": Uniform(lower=0.0, upper=1.0), "c": Normal(mean=0.0, sd=1.0)},
        {("a", "b"): rank},
    )
    drawn = variables.columns(Sobol(3, 0).rows(0, 1 << 14))
    assert stats.spearmanr(drawn["a"], drawn["b"]).statistic == pytest.approx(rank, abs=0.005)
    assert stats.spearmanr(drawn["a"], drawn["c"]).statistic == pytest.approx(0.0, abs=0.005)
    # and each keeps its own distribution
    assert stats.kstest(drawn["b"], "uniform").statistic < 0.005


def test_values_of_the_cube_and_of_normals_are_the_same():
    variables = Variables({"a": LogNormal(median=1.0, sigma=0.5), "b": Normal(mean=0.0, sd=1.0)}, {("a", "b"): 0.4})
    unit = Random(2, 0).rows(0, 50)
    one, other = variables.columns(unit), variables.columns_from_normal(stats.norm.ppf(unit))
    for name in variables.names:
        np.testing.assert_allclose(one[name], other[name], rtol=1e-12)


def test_correlations_that_cannot_be_name_the_pair():
    names = ("a", "b", "idle", "c")
    pairs = {("a", "b"): 0.9, ("b", "c"): 0.9, ("a", "c"): -0.5, ("a", "idle"): 0.2}
    with pytest.raises(
        InvalidInput, match=r"correlation: got [-.0-9]+ between \w and \w, which the other correlations rule out"
    ):
        normal_matrix(rank_matrix(names, pairs), names)
    assert normal_matrix(rank_matrix(names, pairs | {("a", "c"): 0.8}), names)[0, 3] == pytest.approx(
        2 * np.sin(np.pi * 0.8 / 6)
    )


@pytest.mark.parametrize(
    ("given", "error", "sentence"),
    [
        ({("a", "x"): 0.5}, UnknownName, "correlation: no 'x'"),
        ({("a", "a"): 0.5}, InvalidInput, "got a with itself"),
        ({("a", "b"): 0.5, ("b", "a"): 0.5}, InvalidInput, "got b with a twice"),
        ({("a", "b"): 1.0}, InvalidInput, "got 1 between a and b; need > -1 and < 1"),
        ({("a", "b"): float("nan")}, InvalidInput, "got nan between a and b"),
    ],
)
def test_refuses_pairs(given, error, sentence):
    with pytest.raises(error, match=sentence):
        rank_matrix(("a", "b"), given)


def test_seeds():
    assert seed_of(0) == 0
    assert seed_of(np.random.default_rng(0)) == seed_of(np.random.default_rng(0))
    assert seed_of(None) != seed_of(None)
    for wrong in (-1, True, 1.5, "0"):
        with pytest.raises(InvalidInput, match="seed: got"):
            seed_of(wrong)


@pytest.mark.parametrize("make", [lambda: Sobol(0, 0), lambda: Random(0, 0), lambda: LatinHypercube(2, 0, 0)])
def test_refuses_empty_designs(make):
    with pytest.raises(InvalidInput, match="need a whole number of 1 or more"):
        make()


def test_refuses_rows_that_are_not():
    with pytest.raises(InvalidInput, match="rows: got 3 to 2; need 0 <= start <= stop"):
        Random(1, 0).rows(3, 2)
    with pytest.raises(InvalidInput, match="dimensions: got 30000; need <= "):
        Sobol(30_000, 0)
    with pytest.raises(InvalidInput, match="parameters: got none"):
        Variables({})
