"""Study files: read, named, hashed, refused."""

from __future__ import annotations

import pytest

from ridedown import load
from ridedown.errors import InvalidInput, UnknownName
from ridedown.scenario import dump
from ridedown.studies.file.limits import limits_of, value_of
from ridedown.studies.file.study import load_study
from ridedown.studies.rows.plan import plan_of

BELT = {"path": "adult.restraint.stiffness", "values": ["60 kN/m", "98.1 kN/m"]}
SWEEP = {"kind": "sweep", "scenario": "p1", "parameters": [BELT]}


def test_a_scenario_is_looked_for_beside_the_study(tmp_path):
    (tmp_path / "car.toml").write_text(dump(load("example-wall")))
    (tmp_path / "study.yaml").write_text(
        "kind: sweep\nscenario: car.toml\nparameters:\n  - path: vehicle1.mass\n    values: [1 t, 1.2 t]\n"
    )
    loaded = load_study(tmp_path / "study.yaml")
    assert loaded.scenarios[""] == load("example-wall")
    assert loaded.text.startswith("kind: sweep")


def test_a_scenario_can_be_written_out():
    inline = {"vehicle1": {"mass": "1 t", "speed": "10 m/s", "members": {"pieces": [{"stiffness": "200 kN/m"}]}}}
    given = {"kind": "sweep", "scenario": inline, "parameters": [{"path": "vehicle1.mass", "values": [1000, 1200]}]}
    assert load_study(given).scenarios[""].vehicle1.mass == 1000.0


def test_the_hash_is_of_what_results_depend_on():
    loaded = load_study(SWEEP)
    assert loaded.hash == load_study({**SWEEP, "name": "named", "description": "and described"}).hash
    assert loaded.hash != load_study({**SWEEP, "scenario": "paper-adult-full"}).hash
    assert loaded.hash != load_study({**SWEEP, "outcomes": ["adult.hic15"]}).hash


def test_what_a_measured_pulse_holds_is_part_of_the_hash(tmp_path):
    study = {
        "kind": "sweep",
        "scenario": {
            "pulse": {"kind": "measured", "file": str(tmp_path / "p.csv"), "channels": 1, "cfc": "none"},
            "speed": 10.0,
            "occupants": [{"kind": "adult", "mass": 80, "restraint": {"stiffness": 98e3, "slack": 0}}],
        },
        "parameters": [BELT],
    }
    hashes = set()
    for peak in (-100.0, -120.0):
        (tmp_path / "p.csv").write_text(
            "time [s],11VEHC000000ACX0 [m/s2]\n" + "".join(f"{i * 1e-3!r},{peak!r}\n" for i in range(101))
        )
        hashes.add(load_study(study).hash)
    assert len(hashes) == 2


REFUSED = [
    ({"kind": "swep"}, ["kind", "sweep"]),
    ({"kind": "sample", "seeed": 0}, ["seeed"]),
    ({"scenario": None}, ["scenario", "nothing"]),
    ({"parameters": []}, ["parameters"]),
    ({"paramters": []}, ["paramters", "parameters"]),
    ({"scenarios": [{"name": "a", "scenario": "p1"}]}, ["both"]),
    ({"scenario": None, "scenarios": [{"name": "a", "scenario": "p1"}] * 2}, ["scenarios.1.name"]),
    ({"scenario": None, "scenarios": [{"name": "a", "scenario": "p1", "weight": 0}]}, ["weight"]),
    ({"scenario": {"vehicle1": {"mass": "1 t"}}}, ["scenario.vehicle1"]),
    ({"outcomes": ["adult.hic15", "adult.hic15"]}, ["outcomes", "twice"]),
    ({"limits": [{"outcome": "adult.hic15"}]}, ["limits.0.most"]),
    ({"parameters": [{"path": "adult.mass", "range": [60, 80]}]}, ["parameters.0.values", "sweep"]),
    ({"step": 0}, ["step"]),
    ({"step": "20 ms"}, ["step", "20 ms", "<= 0.001 s"]),  # a 3 ms clip of such samples is no clip
    ({"step": 1e-9}, ["step", ">= 1e-06 s"]),
    ({"kind": "sample", "sample": {"confidence": "95 g"}}, ["sample.confidence", "a fraction such as"]),
    ({"kind": "sample", "sample": {"confidence": "195 %"}}, ["sample.confidence", "between 0 and 1"]),
]


@pytest.mark.parametrize(("change", "said"), REFUSED, ids=[f"{i}-{said[0]}" for i, (_, said) in enumerate(REFUSED)])
def test_refused_in_one_sentence(change, said):
    with pytest.raises(InvalidInput) as refused:
        load_study({**SWEEP, **change})
    for words in said:
        assert words in str(refused.value)


@pytest.mark.parametrize("name", ["adult.clip_3ms", "Adult.Clip_3ms"])
def test_a_parameter_does_not_take_the_place_of_an_outcome(name):
    study = {**SWEEP, "outcomes": ["adult.clip_3ms"], "parameters": [BELT | {"name": name}]}
    with pytest.raises(InvalidInput, match=r"parameters\.0\.name: got .*the name of an outcome"):
        plan_of(load_study(study))


def test_shares_may_be_in_percent():
    assert load_study({**SWEEP, "kind": "sample", "sample": {"confidence": "90 %"}}).study.sample.confidence == 0.9
    constraint = {"outcome": "adult.clip_3ms", "measure": "quantile", "share": "95 %", "most": "40 g"}
    optimise = {"objectives": [{"outcome": "adult.excursion.max"}], "constraints": [constraint]}
    found = load_study(
        {**STUDY_OF_ONE, "kind": "optimise", "population": [{"values": {"adult.mass": 50}}], "optimise": optimise}
    )
    assert found.study.optimise.constraints[0].share == 0.95


@pytest.mark.parametrize(("given", "value"), [("30 %", 0.3), (0.3, 0.3)])
def test_limits_without_a_unit_are_bare_or_in_percent(given, value):
    assert value_of("limits.0.most", given, "") == pytest.approx(value, rel=1e-15)
    with pytest.raises(InvalidInput, match=r"limits\.0\.most: .*This outcome has no unit"):
        value_of("limits.0.most", "30 g", "")


def test_unknown_names_offer_the_nearest():
    with pytest.raises(UnknownName, match="p1"):
        load_study({**SWEEP, "scenario": "p2"})
    with pytest.raises(UnknownName, match=r"adult\.clip_3ms"):
        plan_of(load_study({**SWEEP, "outcomes": ["adult.clip_3"]}))
    with pytest.raises(UnknownName, match=r"adult\.excursion\.max"):
        plan_of(load_study({**SWEEP, "outcomes": ["adult.excursion.mx"]}))


@pytest.mark.parametrize(("name", "text", "said"), [
    ("none.toml", None, "none.toml"),
    ("empty.toml", "", "empty"),
    ("broken.toml", "[a\n", "line 1"),
    ("bytes.toml", b"\xff\xfe", "UTF-8"),
    ("study.txt", "kind = 'sweep'", "toml"),
])  # fmt: skip
def test_files_that_are_no_study(tmp_path, name, text, said):
    if text is not None:
        (tmp_path / name).write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(InvalidInput, match=said):
        load_study(tmp_path / name)


STUDY_OF_ONE = {"scenario": "p1", "parameters": [{"path": "adult.restraint.stiffness", "range": ["40 kN/m", "160 kN/m"]}]}


@pytest.mark.parametrize(
    ("change", "place"),
    [
        ({"kind": "sample", "outcomes": ["energy.final", "adult.hic_15"]}, "outcomes.1"),
        ({"kind": "sample", "limits": [{"outcome": "adult.hic_15", "most": 700}]}, "limits.0.outcome"),
        ({"kind": "box", "limits": [{"outcome": "adult.hic_15", "most": 700}]}, "limits.0.outcome"),
        ({"kind": "optimise", "optimise": {"objectives": [{"outcome": "adult.hic_15"}]}}, "optimise.objectives.0.outcome"),
        (
            {
                "kind": "optimise",
                "optimise": {
                    "objectives": [{"outcome": "adult.hic15"}],
                    "constraints": [{"outcome": "adult.hic_15", "most": 700}],
                },
            },
            "optimise.constraints.0.outcome",
        ),
    ],
)
def test_a_misspelt_outcome_is_said_where_it_stands_with_the_nearest(change, place):
    with pytest.raises(UnknownName, match=rf"^{place}: no 'adult.hic_15'\. Did you mean 'adult.hic15'"):
        plan_of(load_study({**STUDY_OF_ONE, **change}))


def test_what_is_limited_is_kept_without_being_listed():
    limits = [{"outcome": "adult.hic15", "most": 700}, {"outcome": "adult.excursion.max", "most": "300 mm"}]
    kept = list(plan_of(load_study({**STUDY_OF_ONE, "kind": "sample", "limits": limits})).function.units)
    usual = list(plan_of(load_study({**STUDY_OF_ONE, "kind": "sample"})).function.units)
    assert kept == [*usual, "adult.hic15"]
    listed = plan_of(load_study({**STUDY_OF_ONE, "kind": "sample", "limits": limits, "outcomes": ["energy.final"]}))
    assert list(listed.function.units) == ["energy.final", "adult.hic15", "adult.excursion.max"]


@pytest.mark.parametrize("kind", ["sample", "box"])
def test_bounds_that_nothing_can_hold_at_once_are_refused(kind):
    limits = [{"outcome": "adult.excursion.max", "most": "200 mm", "least": "0.3 m"}]
    loaded = load_study({**STUDY_OF_ONE, "kind": kind, "limits": limits})
    with pytest.raises(InvalidInput, match=r"limits\.0\.least: got 0\.3 m, above most, 200 mm; need least <= most"):
        limits_of(loaded.study, plan_of(loaded).function.units)
