"""The studies that come with ridedown: one of each kind, and each says what it claims to say."""

from __future__ import annotations

from typing import Any

import pytest

from ridedown import catalogue
from ridedown.studies import load_study, run_study
from ridedown.studies.results.store import read_manifest, read_results
from ridedown.studies.rows.plan import plan_of

KINDS = {"sweep", "sample", "sensitivity", "optimise", "box", "bound"}


def test_there_is_one_of_each_kind_and_each_says_where_its_numbers_are_from() -> None:
    loaded = {name: load_study(name) for name in catalogue.studies()}
    assert {one.study.kind for one in loaded.values()} == KINDS
    for name, one in loaded.items():
        assert one.study.name
        assert one.study.description
        assert one.text.startswith("# ")
        assert 30 < plan_of(one).rows <= 40_000, name


@pytest.fixture(scope="module")
def found(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What the example of that name found."""
    folder = run_study(request.param, tmp_path_factory.mktemp(request.param) / "out", threads=2)
    assert not read_manifest(folder)["remarks"]  # every parameter has an effect
    results = read_results(folder)
    assert results is not None
    return results


@pytest.mark.parametrize("found", ["example-sample"], indirect=True)
def test_sample(found: dict[str, Any]) -> None:
    chances = [limit["probability"] for limit in found["limits"]]
    assert len(chances) == 2
    assert all(0.01 < chance["low"] < chance["high"] < 0.5 for chance in chances)


@pytest.mark.parametrize("found", ["example-rare"], indirect=True)
def test_rare(found: dict[str, Any]) -> None:
    chance = found["limits"][0]["probability"]
    assert 1e-6 < chance["low"] < chance["value"] < chance["high"] < 1e-4
    assert chance["high"] < 1.5 * chance["low"]


@pytest.mark.parametrize("found", ["example-sensitivity"], indirect=True)
def test_sensitivity(found: dict[str, Any]) -> None:
    clip = {one["parameter"]: one for one in found["outcomes"]["adult.clip_3ms"]["indices"]}
    assert clip["offset"]["first"]["value"] > 0.8
    assert clip["child's belt"]["total"]["high"] < 1e-6  # is nothing to the adult


@pytest.mark.parametrize("found", ["example-optimise"], indirect=True)
def test_optimise(found: dict[str, Any]) -> None:
    assert found["chosen"]["feasible"]
    assert found["at_end"] == ["damping"]
    assert max(found["chosen"]["constraints"].values()) <= 0.3 * (1.0 + 1e-9)


@pytest.mark.parametrize("found", ["example-front"], indirect=True)
def test_front(found: dict[str, Any]) -> None:
    front = found["front"]
    assert len(front["parameters"]["stiffness"]) > 30
    assert 0 < front["chosen"] < len(front["parameters"]["stiffness"]) - 1  # a knee, and no end


@pytest.mark.parametrize("found", ["example-box"], indirect=True)
def test_box(found: dict[str, Any]) -> None:
    assert found["box"]["verified"] >= 149  # (1 - 0.02)^149 < 0.05
    assert found["box"]["share"] > 0.05


@pytest.mark.parametrize("found", ["example-bound"], indirect=True)
def test_bound(found: dict[str, Any]) -> None:
    assert {one["name"] for one in found["bound"]["designs"]} == {"adult", "softer belt"}
