"""The page of a study: whole, by itself, and of what is in the folder."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

from ridedown import load
from ridedown.report import study as report
from ridedown.report.study_axes import Bar, Quantity
from ridedown.report.study_found import Found
from ridedown.studies import run_study
from ridedown.studies.bound import Design, bound_study
from ridedown.studies.file.study import load_study
from ridedown.studies.results.summary import summary_of

OUTCOMES = ["adult.excursion.max", "adult.acceleration.peak"]
STIFFNESS = {"path": "adult.restraint.stiffness", "values": ["40 kN/m", "60 kN/m", "98.1 kN/m"]}
RATIO = {"path": "adult.restraint.damping_ratio", "values": [0.1, 0.3, 0.5, 0.9]}
SPEED = {"path": "pulse.delta_v", "values": ["40 km/h", "50 km/h", "56 km/h"]}


def run(folder, *parameters):
    loaded = load_study({"kind": "sweep", "scenario": "sled-half-sine", "outcomes": OUTCOMES, "parameters": list(parameters)})
    return loaded, run_study(loaded, folder / "results")


def check_alone(html):
    """Nothing is fetched, every figure has words, every link of the page leads somewhere."""
    assert not re.search(r'(?:src|href)="(?!data:|#)', html)
    assert "http" not in re.sub(r"data:[^\"]*", "", html)
    assert all(len(alt) > 20 for alt in re.findall(r'alt="([^"]*)"', html))
    for anchor in re.findall(r'href="#([^"]+)"', html):
        assert f'id="{anchor}"' in html


def test_a_sweep_of_two_parameters_has_maps_and_carpets(tmp_path):
    loaded, folder = run(tmp_path, STIFFNESS, RATIO)
    page = report.page_of(loaded, folder)
    assert [section.anchor for section in page.sections] == ["carpets", "maps", "outcomes"]
    assert [len(section.plots) for section in page.sections] == [1, 2, 0]
    page.write(folder)
    html = (folder / "index.html").read_text(encoding="utf-8")
    check_alone(html)
    assert html == report.page_of(loaded, folder).html()  # the same bytes each time
    assert {path.name for path in (folder / "figures").iterdir()} == {f"{p.name}.svg" for s in page.sections for p in s.plots}


def test_a_sweep_of_one_parameter_has_lines(tmp_path):
    loaded, folder = run(tmp_path, STIFFNESS)
    figures, _ = report.page_of(loaded, folder).sections
    np.testing.assert_allclose(figures.plots[0].figure.axes[0].lines[0].get_xdata(), [40.0, 60.0, 98.1])


def test_a_sweep_of_three_parameters_holds_one_and_says_so(tmp_path):
    loaded, folder = run(tmp_path, SPEED, STIFFNESS, RATIO)
    plots = [plot for section in report.page_of(loaded, folder).sections for plot in section.plots]
    assert plots
    assert all("Held: " in plot.description for plot in plots)


def test_limits_are_drawn_and_counted(tmp_path, monkeypatch):
    loaded, folder = run(tmp_path, STIFFNESS, RATIO)
    limit = {"outcome": "adult.excursion.max", "most": 0.25, "least": None, "rule": "", "exceeded": 5, "rows": 12, "failed": 0}
    summary = {**summary_of(folder), "results": {"kind": "sweep", "limits": [limit]}}
    monkeypatch.setattr(report, "summary_of", lambda _folder: summary)
    html = report.page_of(loaded, folder).html()
    assert "Limit, at most 250 mm" in html
    cells = ["adult.excursion.max", "at most 250 mm", "5", "12", "41.67"]
    assert re.search(r"\s*".join(rf"<t[hd][^>]*>{re.escape(cell)}</t[hd]>" for cell in cells), html)
    check_alone(html)


def kept_of_kind(tmp_path, monkeypatch, kind, results):
    loaded, folder = run(tmp_path, SPEED, {**STIFFNESS, "values": np.linspace(4e4, 1e5, 8).tolist()})
    summary = {**summary_of(folder), "results": results}
    monkeypatch.setattr(report, "summary_of", lambda _folder: summary)
    object.__setattr__(loaded.study, "kind", kind)
    return report.page_of(loaded, folder)


def estimate(value):
    return {"value": value, "low": 0.9 * value, "high": 1.1 * value, "confidence": 0.95}


def test_a_sample_has_distributions_with_the_probability(tmp_path, monkeypatch):
    limit = {"outcome": "adult.excursion.max", "most": 0.25, "least": None, "exceeded": 5, "rows": 24, "failed": 0}
    limit["probability"] = estimate(0.2)
    quantiles = [{"share": share, **estimate(0.2 + 0.1 * share)} for share in (0.05, 0.25, 0.5, 0.95)]
    results = {"kind": "sample", "limits": [limit], "outcomes": {"adult.excursion.max": {"quantiles": quantiles}}}
    results |= {"design": "sobol", "seed": 0}
    page = kept_of_kind(tmp_path, monkeypatch, "sample", results)
    assert [section.anchor for section in page.sections] == ["distributions", "exceeded", "tornado", "outcomes"]
    assert "exceeded by 20 % (18 to 22 %)" in page.html()
    assert "5 % are at most 205 mm." in page.sections[0].plots[0].description
    assert "25 %" not in page.sections[0].plots[0].description
    assert [table.caption for table in page.sections[-1].tables] == ["24 rows", "Limits", "Of sobol rows, seed 0"]
    check_alone(page.html())


@pytest.mark.parametrize("method", ["sobol", "morris"])
def test_sensitivities_have_bars_and_a_tornado(tmp_path, monkeypatch, method):
    indices = [{"parameter": name, "first": estimate(0.3), "total": estimate(0.4)} for name in ("a", "b")]
    effects = [{"parameter": name, "mean_size": estimate(0.05), "deviation": 0.01} for name in ("a", "b")]
    of = {"indices": indices} if method == "sobol" else {"effects": effects}
    results = {"method": method, "outcomes": {"adult.excursion.max": of}, "idle": ["b"]}
    page = kept_of_kind(tmp_path, monkeypatch, "sensitivity", results)
    assert [section.anchor for section in page.sections] == ["indices", "tornado", "outcomes"]
    assert page.sections[0].title == "Sensitivities. Without any effect: b."
    check_alone(page.html())


def test_a_bound_is_written_with_its_numbers(tmp_path):
    study = bound_study(load("sled-half-sine"), np.linspace(0.1, 0.4, 4), designs=[Design("belt", 300.0, 0.25)], name="Least")
    report.write_bound(study, tmp_path)
    check_alone((tmp_path / "index.html").read_text(encoding="utf-8"))
    assert json.loads((tmp_path / "bound.json").read_text(encoding="utf-8"))["peaks_m_s2"] == study.peaks.tolist()


def test_a_front_has_a_table_in_order_and_its_chosen_design():
    goals = {Quantity("x", "m"): np.array([0.3, 0.2]), Quantity("y", "m/s2"): np.array([200.0, 300.0])}
    section = report.front_section({Quantity("k", "N/m"): np.array([5e4, 9e4])}, goals, chosen=0, limits={"x": [Bar(0.35)]})
    assert [plot.name for plot in section.plots] == ["front-y-x", "parallel"]
    assert section.tables[0].rows == (("1", "90", "200", "30.59"), ("2 (chosen)", "50", "300", "20.39"))


def test_a_search_has_what_it_found_and_not_the_spread_of_its_rows(tmp_path):
    ranged = [{"path": STIFFNESS["path"], "range": ["40 kN/m", "120 kN/m"]}, {"path": RATIO["path"], "range": [0.1, 0.9]}]
    common = {"scenario": "sled-half-sine", "outcomes": OUTCOMES, "parameters": ranged}
    limits = [{"outcome": OUTCOMES[0], "most": "200 mm"}]
    drawn = {"path": STIFFNESS["path"], "distribution": {"kind": "uniform", "lower": "60 kN/m", "upper": "90 kN/m"}}
    goals = [{"outcome": outcome} for outcome in OUTCOMES]
    several = {"objectives": goals, "candidates": 8, "generations": 4}
    share = {"outcome": OUTCOMES[1], "measure": "probability", "above": "25 g", "most": 0.5}
    one = {**several, "objectives": goals[:1], "constraints": [{"outcome": OUTCOMES[1], "most": "20 g"}, share]}
    people = [{"values": {"adult.mass": "60 kg"}}, {"values": {"adult.mass": "80 kg"}}]
    studies = {
        "front": {**common, "kind": "optimise", "optimise": several},
        "one": {**common, "kind": "optimise", "optimise": one, "population": people},
        "box": {**common, "kind": "box", "limits": limits, "box": {"rounds": 3, "rows": 16, "bad_share": 0.2}},
        "rare": {
            **common, "kind": "sample", "parameters": [drawn], "limits": limits,
            "sample": {"rare": True, "rows": 200, "level_rows": 100},
        },
    }  # fmt: skip
    drawn_as = {"front": {"front", "parallel"}, "one": {"tried"}, "box": {"box", "slice"}, "rare": {"rare"}}
    for name, study in studies.items():
        loaded = load_study(study)
        folder = run_study(loaded, tmp_path / name)
        page = report.page_of(loaded, folder)
        assert [section.anchor for section in page.sections] == ["found", "front" if name == "front" else "figures"]
        assert drawn_as[name] <= {plot.name.split("-")[0] for plot in page.sections[1].plots}
        page.write(folder)
        html = (folder / "index.html").read_text(encoding="utf-8")
        check_alone(html)
        assert ">Mean<" not in html
        assert "seed 0" in html
        words = {"front": "The knee of a front of", "one": "at an end of its range", "box": "200 mm", "rare": "Effective rows"}
        assert words[name] in html
        assert (f">share with {OUTCOMES[1]} &gt; 25 g<" in html) == (name == "one")
        assert " &lt;= " not in html.split("<pre", 1)[0]  # limits are said in words, in the unit that is read


def test_the_ends_of_a_front_are_the_best_for_each_objective(tmp_path):
    ranged = [{"path": STIFFNESS["path"], "range": ["40 kN/m", "120 kN/m"]}]
    goals = [{"outcome": "adult.excursion.max"}, {"outcome": "adult.excursion.min", "sense": "max"}]
    optimise = {"objectives": goals, "candidates": 8, "generations": 2}
    study = {"kind": "optimise", "scenario": "sled-half-sine", "parameters": ranged, "optimise": optimise}
    found = Found(run_study(study, tmp_path / "front"))
    (ends,) = (table for table in found.tables if table.caption.startswith("Ends of a front of"))
    assert [(column.title, column.unit) for column in ends.columns[1:]] == [
        (STIFFNESS["path"], "kN/m"), ("adult.excursion.max", "mm"), ("adult.excursion.min", "mm"),
    ]  # fmt: skip
    assert found.front is not None
    _, of, _ = found.front
    least, most = of[Quantity("adult.excursion.max", "m")].min(), of[Quantity("adult.excursion.min", "m")].max()
    assert [row[0] for row in ends.rows] == ["adult.excursion.max", "adult.excursion.min"]
    assert ends.rows[0][2] == Quantity("", "m").text(float(least), unit=False)
    assert ends.rows[1][3] == Quantity("", "m").text(float(most), unit=False)


def test_an_outcome_that_is_the_same_in_every_row_is_named_and_not_drawn(tmp_path):
    outcomes = ["adult.acceleration.peak", "child.acceleration.peak"]
    belt = {"path": "adult.restraint.stiffness", "range": ["78 kN/m", "118 kN/m"]}
    told = {"kind": "sample", "scenario": "p1", "outcomes": outcomes, "sample": {"rows": 64, "seed": 0}, "parameters": [belt]}
    loaded = load_study(told)
    section = report.page_of(loaded, run_study(loaded, tmp_path / "results")).sections[0]
    assert section.title == "Distributions. The same in every row: child.acceleration.peak"
    assert len(section.plots) == 1
