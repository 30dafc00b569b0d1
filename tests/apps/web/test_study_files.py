"""Files to start studies from: each can be run as it is, whatever the scenario."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from ridedown import catalogue
from ridedown.apps.web.studies import Studies, _loaded
from ridedown.apps.web.study_files import KINDS, study_file
from ridedown.errors import UnknownName
from ridedown.scenario import dump, load, substitute
from ridedown.studies.rows.plan import plan_of

SOME = ("p1", "example-offset", "example-restraints", "sled-half-sine", "marzbanrad-5", "neon-wall")


def text(kind: str, **message: object) -> str:
    made = study_file({"study": kind, **message})["toml"]
    assert isinstance(made, str)
    return made


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", SOME)
def test_it_is_a_study_of_its_kind(kind: str, name: str) -> None:
    made = text(kind, scenario=name)
    data = tomllib.loads(made)
    assert data["scenario"] == name
    assert (data["kind"], data["name"]) == ("sample" if kind == "rare" else kind, kind)
    plan = plan_of(_loaded(made))
    assert plan.rows > 1
    if kind != "bound":
        assert len(plan.units) >= 2  # parameters that the scenario has


@pytest.mark.parametrize("name", catalogue.names())
def test_every_scenario_can_be_swept(name: str) -> None:
    assert plan_of(_loaded(text("sweep", scenario=name))).rows == 61 * 41


def test_what_was_changed_is_in_the_file() -> None:
    made = _loaded(text("sweep", scenario="p1", values={"adult.mass": 66.0}))
    assert made.scenarios[""] == substitute(load("p1"), {"adult.mass": 66.0})
    own = dump(substitute(load("example-restraints"), {"driver.shoulder-belt.load_limiter.force": 4500.0}))
    assert _loaded(text("sample", toml=own)).scenarios[""] == load(tomllib.loads(own))


def test_a_kind_that_there_is_not() -> None:
    with pytest.raises(UnknownName, match="sweep"):
        text("swep", scenario="p1")


def test_how_a_study_stands_is_looked_up_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:

    studies = Studies(tmp_path)
    begun = studies.answer({"action": "start", "toml": text("bound", scenario="sled-half-sine")})["running"]["name"]
    while not studies.answer({"action": "list"})["running"]["ended"]:
        pass
    (told,) = studies.answer({"action": "list"})["studies"]
    assert (told["name"], told["kind"], told["complete"], told["done"]) == (begun, "bound", True, 15)
    monkeypatch.setattr(Studies, "summary", None)
    monkeypatch.setattr(Studies, "_sums", None)
    assert studies.answer({"action": "list"})["studies"] == [told]
