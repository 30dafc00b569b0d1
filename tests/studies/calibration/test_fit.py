"""Calibration: known parameters are found again, bands hold what they should, and what cannot be told is said."""

from __future__ import annotations

import re
import tomllib
from typing import Any

import numpy as np
import pytest

from ridedown.errors import InvalidInput, UnknownName
from ridedown.report.calibration import plots
from ridedown.report.calibration_tables import tables
from ridedown.scenario import load, substitute
from ridedown.signals import TestRecord
from ridedown.simulation import simulate
from ridedown.studies import calibrate
from ridedown.studies.calibration import fit
from ridedown.studies.calibration.posterior import Posterior
from tests.studies.calibration.synthetic import (
    BASE,
    CHEST,
    DAMPING,
    PARAMETERS,
    SLACK,
    STIFFNESS,
    TRUE,
    record,
    spec,
)

NAMES = {"stiffness": STIFFNESS, "slack": SLACK, "damping": DAMPING}


@pytest.fixture(scope="module")
def found():
    return calibrate(spec(record(TRUE, noise=10.0)))


def test_a_known_restraint_is_found_again(found):
    for name, path in NAMES.items():
        assert found.values[name] == pytest.approx(TRUE[path], rel=0.02)
    channel = found.channels[0]
    assert channel.rating.value > 0.95
    assert abs(channel.peak_error) < 0.01
    assert abs(channel.peak_time_error) < 2e-3
    assert found.warnings == ()
    assert found.starts[1] >= 2


def test_without_noise_it_is_found_to_the_last_digits():
    exact = calibrate(spec(record(TRUE, noise=0.0)))
    for name, path in NAMES.items():
        # what is left is the filter at two sampling rates
        assert exact.values[name] == pytest.approx(TRUE[path], rel=2e-3)


def test_bands_are_not_wider_than_they_need_be():
    errors = []
    for seed in range(8):
        rng = np.random.default_rng(100 + seed)
        done = calibrate(spec(record(TRUE, 20.0, rng)))
        errors += [(p.value - TRUE[NAMES[p.name]]) / (0.5 * (p.high - p.low)) for p in done.parameters]
    # errors over half bands: 1/2.05 where the bands are right
    assert 0.3 < np.sqrt(np.mean(np.square(errors))) < 0.75


def test_the_same_seed_finds_the_same_and_another_the_same_place():
    test = record(TRUE, noise=10.0)
    one, same = calibrate(spec(test)), calibrate(spec(test))
    other = calibrate(spec(test, search={"effort": "quick", "seed": 7}))
    assert one.values == same.values
    assert other.values == pytest.approx(one.values, rel=1e-3)


def test_two_factors_of_one_stiffness_cannot_be_told_apart():
    twice = [
        {"name": "stiffness", "paths": [STIFFNESS], "bounds": ["10 kN/m", "300 kN/m"], "scale": "log"},
        {"name": "tension", "paths": [STIFFNESS], "bounds": [0.5, 2.0], "scale": "log", "factor": True},
        *PARAMETERS[1:],
    ]
    done = calibrate(spec(record(TRUE, noise=10.0), parameters=twice))
    assert {"stiffness", "tension"} == set(done.confounded[0].names)
    assert "cannot be told apart" in done.warnings[-1]
    assert "fix it" in done.warnings[-1]  # no channel can tell
    assert done.values["stiffness"] * done.values["tension"] == pytest.approx(TRUE[STIFFNESS], rel=0.02)
    assert done.parameter("slack").high - done.parameter("slack").low < 0.01


def test_mass_and_stiffness_are_confounded_and_the_belt_force_would_tell():
    both = [
        {"name": "mass", "paths": ["adult.mass"], "bounds": ["40 kg", "160 kg"], "scale": "log"},
        PARAMETERS[0],
        PARAMETERS[2],
    ]
    test = record(TRUE, noise=10.0)
    base = substitute(BASE, {SLACK: TRUE[SLACK]})
    case = {"name": "sled", "scenario": base, "record": test, "targets": [CHEST]}
    done = calibrate(spec(test, cases=[case], parameters=both))
    assert {"mass", "stiffness"} == set(done.confounded[0].names)
    helps = done.confounded[0].helps
    assert "adult.restraint.force" in [one.channel for one in helps]
    listed = ", ".join(f"{one.channel} to {200.0 * one.with_it:.0f} %" for one in helps)  # one test: it need not be named
    assert done.confounded[0].sentence.endswith(f"Measuring one of these as well would narrow the band: {listed}.")
    force = {"channel": "adult.restraint.force", "measured": "adult.restraint.force", "window": ["0 ms", "150 ms"]}
    told = calibrate(spec(test, cases=[case | {"targets": [CHEST, force]}], parameters=both))
    assert told.confounded == ()
    assert told.values["mass"] == pytest.approx(80.0, rel=0.05)


def test_one_restraint_in_two_tests_with_a_speed_of_each():
    slow = substitute(BASE, {"vehicle1.speed": 9.0, "vehicle2.speed": 9.0})
    tests = [record(TRUE, 10.0), record(TRUE, 10.0, base=slow)]
    cases = [
        {"name": name, "scenario": scenario, "record": test, "targets": [CHEST]}
        for name, scenario, test in zip(("fast", "slow"), (BASE, slow), tests, strict=True)
    ]
    speed = {"name": "speed", "paths": ["vehicle1.speed"], "bounds": ["5 m/s", "20 m/s"], "each": True}
    done = calibrate({"cases": cases, "parameters": [*PARAMETERS, speed], "search": {"effort": "quick"}})
    assert list(done.values) == ["stiffness", "slack", "damping", "speed (fast)", "speed (slow)"]
    assert done.values["speed (fast)"] == pytest.approx(13.33, rel=0.02)
    assert done.values["speed (slow)"] == pytest.approx(9.0, rel=0.02)
    titles = [plot.title for plot in plots(done) if plot.name.startswith("channel-")]
    assert titles == ["adult.acceleration (fast)", "adult.acceleration (slow)"]
    assert done.values["stiffness"] == pytest.approx(TRUE[STIFFNESS], rel=0.02)


def test_what_is_predicted_is_not_fitted():
    test = record(TRUE, noise=10.0)
    early = CHEST | {"window": ["0 ms", "90 ms"]}
    late = CHEST | {"window": ["90 ms", "150 ms"]}
    case = {"name": "early", "scenario": BASE, "record": test, "targets": [early]}
    predict = [{"name": "late", "scenario": BASE, "record": test, "targets": [late, {"outcome": "adult.excursion.max"}]}]
    done = calibrate(spec(test, cases=[case], predict=predict))
    alone = calibrate(spec(test, cases=[case]))
    assert done.values == alone.values
    predicted = next(c for c in done.channels if not c.fitted)
    assert predicted.within > 0.8
    true = simulate(substitute(BASE, TRUE)).maximum("adult.excursion").value
    number = next(n for n in done.numbers if n.name == "adult.excursion.max")
    assert number.low <= true <= number.high
    assert number.high - number.low < 0.2 * true


def test_numbers_limits_and_roundings_are_met():
    done = calibrate(
        {
            "cases": [
                {
                    "scenario": "neon-wall",
                    "targets": [
                        {"outcome": "vehicle1.right.deflection.max", "value": "0.70 m", "within": "5 mm"},
                        {"outcome": "vehicle1.velocity.change", "max": "-17.7 m/s", "sigma": "0.1 m/s"},
                    ],
                }
            ],
            "parameters": [
                {"name": "force", "factor": True, "bounds": [0.5, 2], "paths": ["vehicle1.members.points.*.1"]},
                {"name": "unloading", "bounds": ["2 MN/m", "50 MN/m"], "paths": ["vehicle1.members.unloading_stiffness"]},
            ],
            "search": {"effort": "quick"},
        }
    )
    assert [n.met for n in done.numbers] == [True, True]
    assert abs(done.numbers[0].model - 0.70) <= 0.005


def test_an_interrupt_gives_the_best_so_far(monkeypatch):
    calls = []

    def interrupted(residuals, start):
        calls.append(start)
        raise KeyboardInterrupt

    monkeypatch.setattr(fit, "least_squares", interrupted)
    done = calibrate(spec(record(TRUE, noise=10.0)))
    assert len(calls) == 1
    assert done.interrupted
    assert "Interrupted" in done.warnings[0]
    assert done.as_json()["interrupted"]
    assert done.values["stiffness"] == pytest.approx(TRUE[STIFFNESS], rel=0.3)


def test_the_posterior_agrees_with_the_bands():
    pytest.importorskip("emcee")
    done = calibrate(spec(record(TRUE, noise=10.0), posterior=True))
    for p in done.parameters:
        low, middle, high = done.posterior.quantiles(p.name)
        assert p.low < middle < p.high
        assert 0.4 < (high - low) / (p.high - p.low) < 2.0


def test_fitted_scenarios_load(found):
    again = load(tomllib.loads(found.toml("sled")))
    assert again.occupants[0].restraint.stiffness == pytest.approx(found.values["stiffness"])


@pytest.mark.parametrize(
    ("changes", "error", "words"),
    [
        ({"parameters": [PARAMETERS[0] | {"bounds": [1e5, 1e4]}]}, InvalidInput, "bounds"),
        ({"parameters": [PARAMETERS[0] | {"bounds": ["10 kN", "300 kN/m"]}]}, InvalidInput, "bounds.0"),
        ({"parameters": [PARAMETERS[1] | {"scale": "log"}]}, InvalidInput, "log scale"),
        ({"parameters": [PARAMETERS[0] | {"paths": ["adult.restraint.stifness"]}]}, UnknownName, "stiffness"),
        ({"parameters": [PARAMETERS[0] | {"cases": ["sledd"]}]}, UnknownName, "sled"),
        ({"parameters": [PARAMETERS[0], PARAMETERS[0] | {"name": "again"}]}, InvalidInput, "set before"),
        ({"parameters": []}, InvalidInput, "parameters"),
        ({"sarch": {}}, InvalidInput, "search"),
        ({"search": {"effort": "normale"}}, InvalidInput, "normal"),
        ({"search": {"seed": -1}}, InvalidInput, "seed"),
    ],
)
def test_what_is_wrong_is_said(changes, error, words):
    with pytest.raises(error, match=words):
        calibrate(spec(record(TRUE, noise=1.0), **changes))


@pytest.mark.parametrize(
    ("target", "error", "words"),
    [
        ({"channel": "adult.acceleration"}, InvalidInput, "measured"),
        ({"outcome": "adult.excursion.max"}, InvalidInput, "value"),
        ({"outcome": "adult.excursion.max", "value": "0.2 m"}, InvalidInput, "sigma"),
        ({"outcome": "adult.excursion.max", "value": "2 kN", "sigma": "1 mm"}, InvalidInput, "value"),
        ({"outcome": "adult.excursion.max", "value": 0.2, "sigma": 0.0}, InvalidInput, "sigma"),
        ({"outcome": "adult.excursion.mux", "value": 0.2, "sigma": 0.1}, UnknownName, r"^cases\.0\.targets\.0\.outcome: .*max"),
        (CHEST | {"channel": "adult.exursion"}, UnknownName, r"^cases\.0\.targets\.0\.channel: .*excursion"),
        (CHEST | {"measured": "chst"}, UnknownName, r"^cases\.0\.targets\.0\.measured: channel"),
        (CHEST | {"measured": ["adult.acceleration", "adult.excursion"]}, InvalidInput, r"targets\.0\.measured: .*one unit"),
        (CHEST | {"measured": "adult.excursion"}, InvalidInput, "acceleration"),
        (CHEST | {"window": ["0 ms", "900 ms"]}, InvalidInput, "window"),
        (CHEST | {"window": ["90 ms", "50 ms"]}, InvalidInput, "window"),
        (CHEST | {"cfc": 10000}, InvalidInput, "cfc"),
        (CHEST | {"cfc": "100 Hz"}, InvalidInput, "which is no frequency"),
        (CHEST | {"weight": 0}, InvalidInput, "weight"),
        (CHEST | {"outcome": "adult.excursion.max"}, InvalidInput, "both"),
    ],
)
def test_a_target_that_cannot_be_is_refused(target, error, words):
    test = record(TRUE, noise=1.0)
    with pytest.raises(error, match=words):
        calibrate(spec(test, cases=[{"name": "sled", "scenario": BASE, "record": test, "targets": [target]}]))


def test_a_posterior_much_wider_than_its_band_is_said():
    done = calibrate(spec(record(TRUE, noise=10.0)))
    names = tuple(p.name for p in done.parameters)
    assert [p.by_ratio for p in done.parameters] == [True, False, False]

    def drawn(p, wider):
        low, high = (np.log(end) if p.by_ratio else end for end in (p.low, p.high))
        values = 0.5 * (low + high) + 0.5 * wider * (high - low) * np.linspace(-1.0, 1.0, 1001)
        return np.exp(values) if p.by_ratio else values

    for wide in ((), ("stiffness",), ("slack", "damping")):
        draws = np.stack([drawn(p, 2.5 if p.name in wide else 1.5) for p in done.parameters], axis=1)
        said = fit._wider(done.parameters, Posterior(names, draws, 0.3, 40.0))
        assert (() if said is None else said.names) == wide
        assert said is None or said.sentence.startswith(f"The posterior of {', '.join(wide)} is more than twice")


def test_another_place_that_fits_as_well_is_said_where_the_search_came_by_it():
    # a crash is the same mirrored: the peak tells how far off centre it is, and not to which side
    asked = {"outcome": "vehicle1.acceleration.peak", "value": 290.0, "sigma": 2.0}
    offset = {"name": "offset", "bounds": [-0.7, 0.7], "paths": ["bar.lateral_offset"]}
    search = {"effort": "quick"}
    done = calibrate({"cases": [{"scenario": "p1", "targets": [asked]}], "parameters": [offset], "search": search})
    (p,) = done.parameters
    assert p.high - p.low < 0.1
    (said,) = [word for word in done.warnings if word.startswith("The search came by")]
    assert [row[-1] for row in tables(done)[0].rows] == ["see the notes"]
    low, high = (float(word) for word in re.findall(r"(\S+) mm", said.replace("\u2212", "-")))
    assert low == pytest.approx(-high, rel=0.1)
    assert min(abs(1e-3 * low - p.value), abs(1e-3 * high - p.value)) < 0.5 * (p.high - p.low)
    one_side = calibrate(
        {"cases": [{"scenario": "p1", "targets": [asked]}], "parameters": [offset | {"bounds": [0.0, 0.7]}], "search": search}
    )
    assert not any(word.startswith("The search came by") for word in one_side.warnings)


def test_nothing_of_the_kind_is_said_of_bands_that_hold():
    assert not any(word.startswith("The search came by") for word in calibrate(spec(record(TRUE, noise=10.0))).warnings)


def test_a_record_that_is_not_there_is_said_with_its_case():
    test = record(TRUE, noise=1.0)
    with pytest.raises(InvalidInput, match=r"^sled\.record: path: got .*nowhere\.csv"):
        calibrate(spec(test, cases=[{"name": "sled", "scenario": BASE, "record": "nowhere.csv", "targets": [CHEST]}]))


def test_bounds_that_break_a_rule_everywhere_are_refused_with_the_rule():
    belt: dict[str, Any] = {"kind": "belt", "stiffness": "60 kN/m", "load_limiter": {"force": "4 kN"}}
    belt["pretensioners"] = [{"fire_time": "10 ms", "pull_in": "50 mm", "duration": "8 ms", "stall_force": "2 kN"}]
    sled = {"pulse": {"kind": "fmvss-208-sled"}, "occupants": [{"kind": "adult", "mass": 80, "restraints": [belt]}]}
    target = {"outcome": "adult.excursion.max", "value": "300 mm", "sigma": "10 mm"}
    force = {"name": "force", "paths": ["adult.belt.load_limiter.force"], "bounds": ["0.5 kN", "1.5 kN"]}
    cases = [{"name": "sled", "scenario": sled, "targets": [target]}]
    with pytest.raises(
        InvalidInput, match=r"middle, sled: .*load_limiter\.force: .*need more than pretensioners\.0\.stall_force"
    ):
        calibrate({"cases": cases, "parameters": [force], "search": {"effort": "quick"}})


def test_what_the_model_cannot_give_is_said():
    # a spring of one stiffness: its peak follows from its excursion
    asked = {"adult.excursion.max": ("250 mm", "2 mm"), "adult.acceleration.peak": ("60 g", "1 g")}
    targets = [{"outcome": name, "value": value, "sigma": sigma} for name, (value, sigma) in asked.items()]
    cases = [{"name": "sled", "scenario": BASE, "targets": targets}]
    found = calibrate({"cases": cases, "parameters": PARAMETERS[:1], "search": {"effort": "quick"}})
    missed = [n.name for n in found.numbers if not n.met]
    assert missed
    assert found.warnings[0].startswith(f"Not met: {', '.join(missed)}. ")
    limit = {"outcome": "adult.excursion.max", "max": "100 mm", "sigma": "50 mm"}
    cases = [{"name": "sled", "scenario": BASE, "targets": [*targets[:1], limit]}]
    found = calibrate({"cases": cases, "parameters": PARAMETERS[:1], "search": {"effort": "quick"}})
    assert [n.met for n in found.numbers] == [True, False]
    assert not any(text.startswith("Not met") for text in found.warnings)


@pytest.mark.parametrize(("code", "said"), [("11CHST0000H3ACYA", "along y"), ("11CHST0000H3ACRA", "a resultant")])
def test_a_channel_that_is_not_along_x_is_refused(code, said):
    made = record(TRUE, noise=1.0).history("adult.acceleration")
    test = TestRecord.of([made.replaced(name="chest", code=code)], identifier="sled 7")
    target = CHEST | {"measured": "chest"}
    with pytest.raises(InvalidInput, match=rf"targets\.0\.measured: got 'chest', .*{said}; need a channel along x"):
        calibrate(spec(test, cases=[{"name": "sled", "scenario": BASE, "record": test, "targets": [target]}]))
