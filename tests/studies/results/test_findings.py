"""What finished studies say: of samples, of sensitivity, of limits; and known answers through the same store."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.stats import norm

from ridedown.errors import InvalidInput, UnknownName
from ridedown.studies import query
from ridedown.studies.analysis.designs import Variables
from ridedown.studies.analysis.evaluation import Limit
from ridedown.studies.analysis.reliability import exceedance
from ridedown.studies.analysis.reliability import plan_of as points_of
from ridedown.studies.distributions import Normal, Uniform
from ridedown.studies.file.study import SensitivityOptions, load_study
from ridedown.studies.results.findings import column
from ridedown.studies.results.store import read_results
from ridedown.studies.rows.crashes import COMPLETED, Rows
from ridedown.studies.rows.plan import Drawn, Listed, Plan, plan_of
from ridedown.studies.rows.sensitivity_rows import asked_rows, told_by
from ridedown.studies.running.execution import run_plan
from tests.studies.small import SWEEP, contents, run

SPEED = {"name": "speed", "paths": ["vehicle1.speed", "vehicle2.speed"], "range": ["40 km/h", "56 km/h"]}
BELT = {
    "path": "adult.restraint.stiffness",
    "distribution": {"kind": "truncated-normal", "mean": "98 kN/m", "sd": "10 kN/m", "lower": "50 kN/m"},
}
TOGETHER = {"between": ["adult.restraint.stiffness", "speed"], "rank": 0.5}
SAMPLE = {
    "kind": "sample",
    "scenario": "p1",
    "outcomes": ["adult.excursion.max"],
    "parameters": [BELT, SPEED],
    "correlations": [TOGETHER],
    "limits": [{"outcome": "adult.excursion.max", "most": "230 mm"}],
    "sample": {"rows": 256, "seed": 0},
}


@pytest.mark.parametrize("design", ["sobol", "latin-hypercube", "random"])
def test_a_sample_is_its_seeds_whatever_runs_it(tmp_path, design):
    study = {**SAMPLE, "sample": {"rows": 256, "design": design, "seed": 0}}
    one = run(tmp_path / "one", study=study, threads=1)
    other = run(tmp_path / "other", study=study, threads=3)
    assert contents(one) == contents(other)
    another = run(tmp_path / "another", study={**study, "sample": {"rows": 256, "design": design, "seed": 1}})
    assert contents(one) != contents(another)
    k, v = column(one, "adult.restraint.stiffness"), column(one, "speed")
    assert np.corrcoef(k, v)[0, 1] == pytest.approx(0.5, abs=0.12)
    assert k.min() >= 50e3
    assert (v.min() >= 40 / 3.6) & (v.max() <= 56 / 3.6)
    said = read_results(one)
    assert said is not None
    beyond = int((column(one, "adult.excursion.max") > 0.23).sum())
    assert said["limits"][0]["exceeded"] == beyond > 0
    chance = said["limits"][0]["probability"]
    assert chance["low"] < chance["value"] == beyond / 256 < chance["high"]
    middle = said["outcomes"]["adult.excursion.max"]["quantiles"][3]
    assert middle["share"] == 0.5
    assert middle["value"] == pytest.approx(np.median(column(one, "adult.excursion.max")), rel=1e-12)


def test_a_sweep_counts_what_exceeds_its_limits(tmp_path):
    limits = [{"outcome": "adult.excursion.max", "most": 0.25, "least": "10 cm"}]
    folder = run(tmp_path / "out", study={**SWEEP, "limits": limits})
    said = read_results(folder)
    assert said is not None
    assert [one["rule"] for one in said["limits"]] == ["adult.excursion.max <= 0.25", "adult.excursion.max >= 0.1"]
    (beyond,) = query(folder, 'SELECT count(*) AS n FROM results WHERE "adult.excursion.max" > 0.25')["n"].to_pylist()
    assert [one["exceeded"] for one in said["limits"]] == [beyond, 0]
    assert 0 < beyond < 120


@pytest.mark.parametrize(
    ("limit", "error", "said"),
    [
        ({"outcome": "adult.excursion.mx", "most": 1}, UnknownName, r"limits\.0.*adult\.excursion\.max"),
        ({"outcome": "adult.excursion.max", "most": "30 g"}, InvalidInput, r"limits\.0\.most.*a length"),
    ],
)
def test_limits_that_do_not_fit_are_refused_before_anything_is_written(tmp_path, limit, error, said):
    with pytest.raises(error, match=said):
        run(tmp_path / "out", study={**SWEEP, "limits": [limit]})
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"sample": {"rows": 0}}, r"sample\.rows"),
        ({"sample": {"seed": -1}}, r"sample\.seed"),
        ({"sample": {"design": "sobool"}}, "sobol"),
        ({"sample": {"count": 5}}, r"sample\.count"),
        ({"correlations": [{"between": ["speed", "speed"], "rank": 0.5}]}, r"^correlations\.0: got speed with itself"),
        ({"correlations": [{"between": ["speed", "adult.restraint.stiffness"], "rank": 1.5}]}, r"^correlations\.0: got 1\.5"),
        ({"correlations": [TOGETHER, TOGETHER]}, r"^correlations\.1: got .* twice"),
        ({"kind": "sensitivity", "sample": None}, "correlations"),
        ({"kind": "sensitivity", "correlations": []}, "sample"),
        ({"parameters": [{**BELT, "distribution": {"kind": "normal", "mean": "98 kN", "sd": "1 kN"}}]}, "a force"),
        ({"parameters": [{**BELT, "distribution": {"kind": "normal", "mean": 1e4, "sd": 1e4}}]}, "outside"),
    ],
)
def test_what_does_not_fit_a_sample_is_refused(change, said):
    with pytest.raises(InvalidInput, match=said):
        plan_of(load_study({**SAMPLE, **change}))


def test_a_correlation_with_a_parameter_that_is_none_is_told_the_nearest():
    with pytest.raises(UnknownName, match=r"^correlations\.0: no 'sped'\. Did you mean 'speed'"):
        plan_of(load_study({**SAMPLE, "correlations": [{"between": ["speed", "sped"], "rank": 0.5}]}))


@dataclass(frozen=True)
class Known:
    """A function with a known answer, in the place of crashes."""

    of: str

    @property
    def units(self):
        return {"y": ""}

    def rows(self, columns: Mapping[str, np.ndarray]) -> Rows:
        x = list(columns.values())
        if self.of == "ishigami":  # Ishigami and Homma 1990, a = 7, b = 0.1
            y = np.sin(x[0]) + 7.0 * np.sin(x[1]) ** 2 + 0.1 * x[2] ** 4 * np.sin(x[0])
        elif self.of == "g":  # Sobol's g function
            y = np.prod([(abs(4.0 * one - 2.0) + a) / (1.0 + a) for one, a in zip(x, G, strict=True)], axis=0)
        else:
            y = np.sum(x, axis=0)
        return Rows({"y": y}, np.zeros(y.size, dtype=np.int32), [(COMPLETED, "")])


G = (0.0, 1.0, 4.5, 9.0)


def through_the_store(folder, function, variables, design):
    plan = Plan("known", dict.fromkeys(variables.names, ""), design, function, chunk_rows=1000)
    loaded = load_study({**SWEEP, "outcomes": ["energy.final"]})  # stands in for a study: the store keeps one beside the rows
    return run_plan(loaded, plan, folder, threads=2)


def ishigami():
    a, b = 7.0, 0.1
    first = 0.5 * (1.0 + b * np.pi**4 / 5.0) ** 2, a * a / 8.0, 0.0
    together = b * b * np.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    variance = sum(first) + together
    return np.array(first) / variance, (np.array(first) + np.array([together, 0.0, together])) / variance


def g_function():
    parts = np.array([1.0 / (3.0 * (1.0 + a) ** 2) for a in G])
    variance = np.prod(1.0 + parts) - 1.0
    total = np.array([part * np.prod(1.0 + np.delete(parts, i)) for i, part in enumerate(parts)])
    return parts / variance, total / variance


@pytest.mark.parametrize(
    ("function", "dimensions", "reach", "exact"),
    [("ishigami", 3, (-np.pi, np.pi), ishigami()), ("g", 4, (0.0, 1.0), g_function())],
)
def test_sensitivity_indices_with_a_known_answer_lie_in_their_intervals(tmp_path, function, dimensions, reach, exact):
    options = SensitivityOptions(rows=4096, seed=0, confidence=0.999)
    variables = Variables({f"x{i}": Uniform(lower=reach[0], upper=reach[1]) for i in range(dimensions)})
    rows = asked_rows(options, variables)
    folder = through_the_store(tmp_path / "out", Known(function), variables, Listed(rows))
    said = told_by(options, variables, rows, {"y": column(folder, "y")})
    for i, index in enumerate(said["outcomes"]["y"]["indices"]):
        for kind, right in zip(("first", "total"), exact, strict=True):
            assert index[kind]["low"] <= right[i] <= index[kind]["high"]
            assert index[kind]["value"] == pytest.approx(right[i], abs=0.02)


def test_the_probability_of_a_linear_normal_problem_lies_in_its_interval(tmp_path):
    variables = Variables({"a": Normal(mean=1.0, sd=0.6), "b": Normal(mean=2.0, sd=0.8)})
    points, rows, groups = points_of("sobol", 2, 16_384, 16, 0)
    folder = through_the_store(tmp_path / "out", Known("sum"), variables, Drawn(variables, points, rows, groups))
    found = exceedance(Limit("y", most=5.0), column(folder, "y"), groups=groups)
    assert found.probability.low <= norm.sf(2.0) <= found.probability.high
    assert found.probability.value == pytest.approx(norm.sf(2.0), rel=0.05)


@pytest.mark.parametrize("method", ["sobol", "morris"])
def test_a_sensitivity_study_resumes_and_says_what_is_idle(tmp_path, method):
    belts = [f"{who}.restraint.stiffness" for who in ("adult", "child")]
    study = {
        "kind": "sensitivity",
        "scenario": "p1",
        "outcomes": ["adult.excursion.max"],
        "sensitivity": {"method": method, "rows": 16},
        "parameters": [*({"path": path, "range": ["40 kN/m", "60 kN/m"]} for path in belts), SPEED],
    }
    folder = run(tmp_path / "out", study=study)
    said = read_results(folder)
    assert said is not None
    assert said["idle"] == ["child.restraint.stiffness"]
    before = contents(folder)
    next((folder / "chunks").iterdir()).unlink()
    run(folder, study=study, resume=True)
    assert contents(folder) == before
    assert read_results(folder) == said


def test_the_papers_trends_in_its_damping_series(tmp_path):
    loaded = load_study("paper-damping")
    folder = run_plan(loaded, plan_of(loaded), tmp_path / "out")
    assert query(folder, "SELECT DISTINCT status FROM results")["status"].to_pylist() == ["completed"]
    excursion = column(folder, "full.adult.excursion.max")
    assert (np.diff(excursion) < 0.0).all()  # more damping, less excursion
    assert (column(folder, "offset.adult.acceleration.peak") < column(folder, "full.adult.acceleration.peak")).all()
