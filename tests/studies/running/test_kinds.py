"""Studies whose rows follow from one another or from no crash: bounds, optimisations, solution boxes, rare events."""

from __future__ import annotations

import errno
from dataclasses import dataclass, field, replace

import numpy as np
import pyarrow.parquet as pq
import pytest
from scipy.optimize import brentq
from scipy.stats import norm

from ridedown import load, simulate, simulate_many
from ridedown.errors import InvalidInput, UnknownName
from ridedown.studies import query, run_study
from ridedown.studies.analysis.goals import Beyond, Goal, MeanPlus, Population, Requirement
from ridedown.studies.analysis.optimise import optimise
from ridedown.studies.bound import Design, bound_study, gap_of
from ridedown.studies.file.study import load_study
from ridedown.studies.results.findings import finite
from ridedown.studies.results.store import Store, read_manifest, read_results
from ridedown.studies.rows.crashes import COMPLETED, Rows
from ridedown.studies.rows.plan import Function, plan_of
from ridedown.studies.running.execution import Progress, Stopped, run_plan
from ridedown.studies.running.searches import designs_tried
from tests.studies.small import contents

BOUND = {
    "kind": "bound",
    "name": "Sled",
    "scenario": "sled-half-sine",
    "bound": {
        "excursions": ["100 mm", "200 mm", 0.3],
        "occupants": ["adult"],
        "designs": [{"name": "belt", "peak": "30 g", "excursion": "250 mm"}],
    },
}


def test_a_bound_study_is_what_bound_study_finds_and_is_kept_like_any_other(tmp_path):
    folder = run_study(BOUND, tmp_path / "out")
    sled = load("sled-half-sine")
    designs = [gap_of(simulate(sled), "adult"), Design("belt", 30 * 9.80665, 0.25)]
    direct = bound_study(sled, [0.1, 0.2, 0.3], designs=designs, name="Sled")
    said = read_results(folder)
    assert said is not None
    assert said["bound"] == finite(direct.as_json())
    rows = query(folder, "SELECT excursion, peak, peak_without_seat FROM results ORDER BY row").to_pydict()
    assert rows == {"excursion": [0.1, 0.2, 0.3], "peak": list(direct.peaks), "peak_without_seat": list(direct.unlimited)}
    assert {one["name"]: one["unit"] for one in read_manifest(folder)["columns"]}["peak"] == "m/s2"
    before = contents(folder)
    next((folder / "chunks").iterdir()).unlink()
    run_study(BOUND, folder, resume=True)
    assert contents(folder) == before
    assert read_results(folder) == said


def test_a_bound_of_a_crash_without_a_seat(tmp_path):
    options = {"grid": {"start": 0.1, "stop": "30 cm", "count": 2}, "seat": False, "slack": "50 mm", "vehicle": "vehicle2"}
    said = read_results(run_study({"kind": "bound", "scenario": "p1", "bound": options}, tmp_path / "out"))
    direct = bound_study(simulate(load("p1")), [0.1, 0.3], vehicle="vehicle2", rearward=np.inf, slack=0.05, name="p1")
    assert said is not None
    assert said["bound"] == finite(direct.as_json())


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"excursion": 0.3}, r"bound\.excursions: got nothing"),
        ({"excursions": [0.2, 0.1]}, "do not rise"),
        ({"excursions": [0.2]}, "two or more"),
        ({"excursions": ["1 kg", 0.2]}, r"bound\.excursions\.0: got \"1 kg\", a mass"),
        ({"excursions": [0.2, 0.3], "ocupants": ["adult"]}, r"bound\.ocupants.*\"occupants\""),
        ({"excursions": [0.2, 0.3], "occupants": ["adlt"]}, r"bound\.occupants\.0.*'adult'"),
        ({"excursions": [0.2, 0.3], "vehicle": "vehicle2"}, r"bound\.vehicle.*'vehicle1'"),
        ({"excursions": [0.2, 0.3], "slack": 0.25}, "more than the slack"),
        ({"grid": {"start": 0.4, "stop": 0.3, "count": 3}}, r"bound\.grid\.start"),
        ({"grid": {"start": 0.1, "stop": 0.3, "cuont": 3}}, r"bound\.grid\.cuont.*\"count\""),
    ],
)
def test_what_does_not_fit_a_bound_is_refused_before_anything_is_written(tmp_path, options, said):
    with pytest.raises((InvalidInput, UnknownName), match=said):
        run_study({**BOUND, "bound": options}, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_bound_has_no_parameters_and_no_one_else_a_bound(tmp_path):
    varied = [{"path": "adult.restraint.stiffness", "values": ["60 kN/m"]}]
    with pytest.raises(InvalidInput, match="parameters"):
        run_study({**BOUND, "parameters": varied}, tmp_path / "out")
    with pytest.raises(InvalidInput, match=r"\[bound\] with kind"):
        run_study({**BOUND, "kind": "sweep", "parameters": varied}, tmp_path / "out")


STIFFNESS, DAMPING = "adult.restraint.stiffness", "adult.restraint.damping"
PEAK, WAY = "adult.acceleration.peak", "adult.excursion.max"
BELT = {"path": STIFFNESS, "range": ["20 kN/m", "120 kN/m"]}
OPTIMISE = {
    "kind": "optimise",
    "scenario": "p1",
    "parameters": [BELT],
    "optimise": {
        "objectives": [{"outcome": PEAK}],
        "constraints": [{"outcome": WAY, "most": "250 mm"}],
        "candidates": 16,
        "generations": 12,
    },
}
FRONT = {
    **OPTIMISE,
    "parameters": [BELT, {"path": DAMPING, "range": [0, "3 kN s/m"]}],
    "optimise": {**OPTIMISE["optimise"], "objectives": [{"outcome": PEAK}, {"outcome": WAY}]},
}
LIMITS = [{"outcome": WAY, "most": "250 mm"}, {"outcome": PEAK, "most": "32 g"}]
BOX = {**FRONT, "kind": "box", "optimise": None, "limits": LIMITS, "box": {"rounds": 6, "rows": 32, "bad_share": 0.1}}
DRAWN = {"kind": "truncated-normal", "mean": "98 kN/m", "sd": "10 kN/m", "lower": "30 kN/m"}
RARE = {
    "kind": "sample",
    "scenario": "p1",
    "outcomes": [WAY],
    "parameters": [{"path": STIFFNESS, "distribution": DRAWN}],
    "limits": [{"outcome": WAY, "most": "290 mm"}],
    "sample": {"rare": True, "rows": 1000, "level_rows": 300},
}


def softest(most):
    """The stiffness of the adult's belt with which it comes just so far [N/m]."""
    p1 = load("p1")

    def over(stiffness):
        return float(simulate_many(p1, {STIFFNESS: [stiffness]}, outcomes=[WAY])[WAY][0]) - most

    return brentq(over, 20e3, 120e3, xtol=1e-6)


def test_an_optimisation_finds_the_best_that_is_known(tmp_path):
    folder = run_study(OPTIMISE, tmp_path / "out")
    said = read_results(folder)
    assert said is not None
    stiffness = softest(0.25)  # a harder belt has a higher peak, a softer one comes too far
    assert said["chosen"]["feasible"]
    assert said["chosen"]["parameters"][STIFFNESS] == pytest.approx(stiffness, rel=1e-6)
    assert said["chosen"]["constraints"] == {f"{WAY} <= 0.25": pytest.approx(0.25, rel=1e-8)}
    rows = query(folder, f'SELECT min("{PEAK}") AS least FROM results WHERE "{WAY}" <= 0.25').to_pylist()
    assert rows[0]["least"] == pytest.approx(said["chosen"]["objectives"][PEAK], rel=1e-12)
    manifest = read_manifest(folder)
    assert manifest["rows"] == said["evaluations"] == pq.read_table(folder / "chunks").num_rows


def test_a_robust_optimisation_is_what_the_function_finds(tmp_path):
    study = {
        **OPTIMISE,
        "population": [{"values": {"adult.mass": "50 kg"}}, {"values": {"adult.mass": "90 kg"}, "weight": 3}],
        "optimise": {
            "objectives": [{"outcome": PEAK, "measure": "mean-plus", "sigmas": 2}],
            "constraints": [{"outcome": WAY, "measure": "probability", "above": "25 cm", "most": 0.25}],
            "candidates": 8,
            "generations": 5,
            "seed": 3,
        },
    }
    said = read_results(run_study(study, tmp_path / "out"))
    assert said is not None
    assert [one["beyond"] for one in said["constraints"]] == [{"most": 0.25, "least": None}]
    plan = plan_of(load_study(study))
    direct = optimise(
        plan.function,
        {STIFFNESS: (20e3, 120e3)},
        Goal(PEAK, MeanPlus(2.0)),
        requirements=[Requirement(WAY, most=0.25, measure=Beyond(most=0.25))],
        population=Population({"adult.mass": [50.0, 90.0]}, weights=[1.0, 3.0]),
        candidates=8,
        generations=5,
        seed=3,
    )
    assert said is not None
    assert said["population"] == {"adult.mass": [50.0, 90.0]}
    assert said["chosen"]["parameters"] == direct.parameters
    assert said["chosen"]["objectives"] == {direct.goal: direct.value}
    assert said["evaluations"] == direct.evaluations


def test_a_population_is_drawn_from_distributions_the_same_for_each_design(tmp_path):
    masses = {"path": "adult.mass", "distribution": {"kind": "truncated-normal", "mean": 75, "sd": 10, "lower": 40}}
    options = {**OPTIMISE["optimise"], "candidates": 8, "generations": 2, "population_rows": 16}
    folder = run_study({**OPTIMISE, "parameters": [BELT, masses], "optimise": options}, tmp_path / "out")
    found = query(folder, 'SELECT count(DISTINCT "adult.mass") AS n, count(*) AS rows FROM results').to_pylist()[0]
    assert found["n"] == 16
    assert found["rows"] % 16 == 0


@dataclass(frozen=True, eq=False)
class Failing:
    """A function that fails after so many rows, as a machine does."""

    function: Function
    most: int
    error: type[BaseException] = OSError
    seen: list[int] = field(default_factory=list)

    @property
    def units(self):
        return self.function.units

    def rows(self, columns):
        self.seen.append(next(iter(columns.values())).size)
        if sum(self.seen) > self.most:
            raise self.error("unplugged")
        return self.function.rows(columns)


def made(folder):
    """All that a finished study keeps, by file name."""
    return contents(folder) | {name: (folder / name).read_bytes() for name in ("manifest.json", "results.json", "study.json")}


@pytest.mark.parametrize("study", [OPTIMISE, FRONT, BOX, RARE], ids=["one", "several", "box", "rare"])
def test_a_search_that_broke_off_resumes_to_the_same_bytes(tmp_path, study):
    loaded = load_study(study)
    plan = replace(plan_of(loaded), chunk_rows=32)
    whole, broken = tmp_path / "whole", tmp_path / "broken"
    told: list[Progress] = []
    run_plan(loaded, plan, whole, threads=3, report=told.append)
    rows = read_manifest(whole)["rows"]
    assert told[-1].done == rows
    for kills in (0, 1):
        failing = Failing(plan.function, rows // 3 + (0 if kills else 40))  # the first run looks for parameters without effect
        with pytest.raises(OSError, match="unplugged"):
            run_plan(loaded, replace(plan, function=failing), broken, resume=kills > 0)
        kept = contents(broken)
        assert 0 < len(kept) < len(contents(whole))
        assert all(data == contents(whole)[name] for name, data in kept.items())
    counted = Failing(plan.function, 10**9)
    run_plan(loaded, replace(plan, function=counted), broken, threads=1, resume=True)
    assert made(broken) == made(whole)
    assert sum(counted.seen) < 0.75 * rows  # what was kept was not computed again


def test_a_search_that_is_interrupted_says_how_many_rows_are_kept(tmp_path):
    loaded = load_study(OPTIMISE)
    plan = replace(plan_of(loaded), chunk_rows=64)
    with pytest.raises(Stopped) as stopped:
        run_plan(loaded, replace(plan, function=Failing(plan.function, 150, KeyboardInterrupt)), tmp_path / "out")
    assert stopped.value.progress.done == pq.read_table(tmp_path / "out" / "chunks").num_rows > 0


def test_rows_that_differ_from_those_kept_are_not_gone_on_with(tmp_path):
    loaded = load_study(OPTIMISE)
    plan = replace(plan_of(loaded), chunk_rows=16)
    folder = run_plan(loaded, plan, tmp_path / "out")
    early = folder / "chunks" / "chunk-00000001.parquet"
    table = pq.read_table(early)
    column = table.column_names.index(PEAK)
    other = table.set_column(column, PEAK, [table[PEAK].to_numpy()[::-1]])
    pq.write_table(other.replace_schema_metadata(table.schema.metadata), early)
    with pytest.raises(InvalidInput, match="not those kept"):
        run_plan(loaded, plan, folder, resume=True)


@pytest.mark.parametrize("study", [OPTIMISE, FRONT, BOX, RARE], ids=["one", "several", "box", "rare"])
def test_a_full_disk_is_said_in_a_sentence_whatever_library_searches(tmp_path, study, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    loaded = load_study(study)
    plan = replace(plan_of(loaded), chunk_rows=32)
    put = Store._put
    monkeypatch.setattr(Store, "_put", lambda self, path, data: (full if path.suffix == ".parquet" else put)(self, path, data))
    with pytest.raises(InvalidInput, match="full disk"):
        run_plan(loaded, plan, tmp_path / "out")


@dataclass(frozen=True)
class Odd:
    """Less is better, but the lower half cannot be, for two reasons."""

    @property
    def units(self):
        return {PEAK: "m/s2", WAY: "m"}

    def rows(self, columns):
        x = columns[STIFFNESS]
        reason = np.where(x < 40e3, 1, np.where(x < 70e3, 2, 0)).astype(np.int32)
        y = np.where(reason > 0, np.nan, x)
        return Rows({PEAK: y, WAY: 0.0 * y}, reason, [(COMPLETED, ""), ("refused", "too soft"), ("refused", "soft")])


def test_rows_that_failed_stay_with_their_reasons_and_are_not_chosen(tmp_path):
    loaded = load_study(OPTIMISE)
    folder = run_plan(loaded, replace(plan_of(loaded), function=Odd(), chunk_rows=64), tmp_path / "out", threads=2)
    said = read_results(folder)
    assert said is not None
    assert 70e3 <= said["chosen"]["parameters"][STIFFNESS] < 70.1e3
    rows = query(folder, f'SELECT why, min("{STIFFNESS}") AS a, max("{STIFFNESS}") AS b FROM results GROUP BY why').to_pylist()
    reach = {row["why"]: (row["a"], row["b"]) for row in rows}
    assert reach["too soft"][1] < 40e3 <= reach["soft"][0] <= reach["soft"][1] < 70e3 <= reach[None][0]
    assert said["failed"] == query(folder, "SELECT count(*) AS n FROM results WHERE status = 'refused'")["n"][0].as_py() > 0


def test_a_front_holds_no_design_that_another_is_better_than(tmp_path):
    said = read_results(run_study(FRONT, tmp_path / "out"))
    assert said is not None
    peaks, ways = (np.array(said["front"]["objectives"][name]) for name in (PEAK, WAY))
    assert peaks.size > 5
    assert (np.diff(peaks) > 0.0).all()
    assert (np.diff(ways) < 0.0).all()
    assert ways.max() <= 0.25
    knee = said["front"]["chosen"]
    assert said["chosen"]["objectives"] == {PEAK: peaks[knee], WAY: ways[knee]}


def test_a_box_holds_its_limits(tmp_path):
    said = read_results(run_study(BOX, tmp_path / "out"))
    assert said is not None
    (k0, k1), (c0, c1) = (said["box"]["ranges"][name] for name in (STIFFNESS, DAMPING))
    corners = {STIFFNESS: [k0, k0, k1, k1, 0.5 * (k0 + k1)], DAMPING: [c0, c1, c0, c1, 0.5 * (c0 + c1)]}
    middle = simulate_many(load("p1"), corners, outcomes=[WAY, PEAK])
    assert middle[WAY][-1] <= 0.25
    assert middle[PEAK][-1] <= 32 * 9.80665
    assert said["box"]["verified"] >= 29  # (1 - 0.1)^29 < 0.05


def test_the_probability_of_a_rare_event_holds_the_exact_one(tmp_path):
    said = read_results(run_study(RARE, tmp_path / "out"))
    assert said is not None
    exact = norm.cdf(softest(0.29), 98e3, 10e3)  # the softer belts come farther; what is cut off below 30 kN/m is 5e-12
    chance = said["limits"][0]["probability"]
    assert exact < 1e-3
    assert chance["low"] <= exact <= chance["high"]
    assert chance["high"] < 1.3 * chance["low"]
    assert said["limits"][0]["likeliest"][STIFFNESS] == pytest.approx(softest(0.29), rel=0.02)


def changed(study, **options):
    return {**study, "optimise": {**study["optimise"], **options}}


@pytest.mark.parametrize(
    ("study", "said"),
    [
        (changed(OPTIMISE, objektives=[]), r"optimise\.objektives.*\"objectives\""),
        (changed(OPTIMISE, objectives=[]), r"optimise\.objectives: got none"),
        (changed(OPTIMISE, objectives=[{"outcome": PEAK, "sense": "minn"}]), r"sense.*\"min\""),
        (changed(OPTIMISE, objectives=[{"outcome": "adult.acceleration.peek"}]), r"adult\.acceleration\.peak"),
        (changed(OPTIMISE, constraints=[{"outcome": WAY, "most": "30 g"}]), r"constraints\.0\.most.*a length"),
        (changed(OPTIMISE, constraints=[{"outcome": WAY}]), r"constraints\.0\.most: got nothing"),
        (changed(OPTIMISE, objectives=[{"outcome": PEAK, "measure": "worst"}]), "a population"),
        (changed(OPTIMISE, objectives=[{"outcome": PEAK, "measure": "quantile"}]), r"objectives\.0\.share"),
        (changed(OPTIMISE, objectives=[{"outcome": PEAK, "sigmas": 2}]), r"objectives\.0\.sigmas"),
        (changed(OPTIMISE, objectives=[{"outcome": PEAK}, {"outcome": PEAK}]), "twice"),
        (changed(OPTIMISE, candidates=4), r"optimise\.candidates: got 4"),
        (changed(OPTIMISE, algorithm="nsga2"), r"optimise\.algorithm"),
        ({**OPTIMISE, "optimise": None}, r"optimise: got nothing"),
        ({**OPTIMISE, "limits": LIMITS}, r"optimise\.constraints"),
        ({**OPTIMISE, "parameters": [{"path": STIFFNESS, "values": [1e5]}]}, "range"),
        ({**OPTIMISE, "population": [{"values": {"adult.mas": 1}}]}, r"population.*adult\.mass"),
        ({**OPTIMISE, "population": [{"values": {"adult.mass": "1 kN"}}]}, r"population.*a force"),
        ({**OPTIMISE, "population": [{"values": {STIFFNESS: 1e5}}]}, r"population\.0\.values.*which a parameter sets too"),
        ({**BOX, "limits": []}, r"limits: got none"),
        ({**BOX, "parameters": RARE["parameters"]}, r"parameters\.0\.range"),
        ({**BOX, "box": {"rows": 2}}, r"box\.rows"),
        ({**RARE, "limits": []}, r"limits: got none"),
        ({**RARE, "sample": {"rare": True, "design": "random"}}, r"sample\.design"),
        ({**RARE, "sample": {"rear": True}}, r"sample\.rear.*\"rare\""),
    ],
)
def test_what_does_not_fit_a_search_is_refused_before_anything_is_written(tmp_path, study, said):
    with pytest.raises((InvalidInput, UnknownName), match=said):
        run_study(study, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_one_outcome_of_several_scenarios_is_no_objective(tmp_path):
    scenarios = [{"name": "full", "scenario": "paper-adult-full"}, {"name": "offset", "scenario": "paper-adult-offset"}]
    study = {**OPTIMISE, "scenario": None, "scenarios": scenarios}
    with pytest.raises(InvalidInput, match=r"full\.adult\.acceleration\.peak.*weighted"):
        run_study(study, tmp_path / "out")


def test_what_an_optimisation_made_of_its_rows_is_found_again(tmp_path):
    population = [{"values": {"adult.mass": "50 kg"}}, {"values": {"adult.mass": "90 kg"}, "weight": 3}]
    objective = {"outcome": PEAK, "measure": "mean-plus", "sigmas": 2}
    constraint = {"outcome": WAY, "measure": "worst", "most": "300 mm"}
    options = {"objectives": [objective], "constraints": [constraint], "candidates": 8, "generations": 4}
    loaded = load_study({**OPTIMISE, "population": population, "optimise": options})
    plan = plan_of(loaded)
    folder = run_plan(loaded, plan, tmp_path / "out")
    said = read_results(folder)
    assert said is not None
    table = query(folder, "SELECT * FROM results ORDER BY row")
    columns = {name: table[name].to_numpy() for name in (*plan.units, *plan.function.units)}
    tried = designs_tried(loaded, plan.function.units, columns)
    assert tried.rows == 2
    assert 2 * tried.goal.size == said["evaluations"]
    peaks, ways = (columns[name].reshape(-1, 2) for name in (PEAK, WAY))
    mean = peaks @ [0.25, 0.75]
    np.testing.assert_allclose(tried.goal, mean + 2.0 * np.sqrt(((peaks - mean[:, None]) ** 2) @ [0.25, 0.75]), rtol=1e-12)
    np.testing.assert_array_equal(tried.held, ways.max(axis=1) <= 0.3)
    assert tried.goal[tried.held].min() == pytest.approx(next(iter(said["chosen"]["objectives"].values())), rel=1e-12)
