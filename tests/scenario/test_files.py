"""Files are read or refused with their name and line; what is dumped loads back equal."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ridedown import catalogue
from ridedown.errors import InvalidInput, UnknownName
from ridedown.scenario import CrashScenario, dump, load, substitute

Change = Callable[..., dict[str, Any]]

TOML = """\
name = "a wall test"
duration = "150 ms"

[vehicle1]
mass = "1500 kg"
speed = "48 km/h"
members = { pieces = [{ stiffness = "200 kN/m" }] }
"""

YAML = """\
name: a wall test
duration: 150 ms
vehicle1:
  mass: 15e2      # a number in YAML 1.2
  speed: 48 km/h
  members:
    pieces:
      - stiffness: 200 kN/m
"""


def _refusal(source: object) -> str:
    with pytest.raises(InvalidInput) as error:
        load(source)
    assert "\n" not in str(error.value)
    return str(error.value)


def test_toml_and_yaml_are_of_one_shape(tmp_path: Path) -> None:
    scenarios = []
    for name, text in (
        ("a.toml", TOML),
        ("a.yaml", YAML),
        ("a.yml", YAML),
        ("bare", TOML),
        ("bom.toml", "\ufeff" + TOML),
    ):
        (tmp_path / name).write_text(text, encoding="utf-8")
        scenarios += [load(tmp_path / name), load(str(tmp_path / name))]
    assert all(scenario == scenarios[0] for scenario in scenarios)
    assert scenarios[0].duration == 0.15


@pytest.mark.parametrize(
    ("name", "text", "line"),
    [
        ("a.toml", "name = 'x'\nduration = \n", 2),
        ("a.toml", "name = 'x'\nname = 'y'\n", 2),
        ("a.toml", "name = 'x'\nsources = [\n", 3),
        ("a.yaml", "a: [1\nb: 2", 2),
        ("a.yaml", "vehicle1:\n  mass: 1\n  mass: 2\n", 3),
        ("a.yaml", "vehicle1:\n\tmass: 1", 2),
        ("a.yaml", "a: !!python/object:os.system x\n", 1),
        ("a.yaml", "a: 1\n---\nb: 2\n", 2),
    ],
)
def test_syntax_errors_name_the_file_and_the_line(tmp_path: Path, name: str, text: str, line: int) -> None:
    (tmp_path / name).write_text(text, encoding="utf-8")
    assert _refusal(tmp_path / name).startswith(f"{tmp_path / name}, line {line}: got ")


@pytest.mark.parametrize("name", ["a.toml", "a.yaml"])
@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "an empty file"),
        (b" \n", "an empty file"),
        (b"# only a comment\n", "got no fields"),
        (b"name = '\xff'", "line 1: got no UTF-8"),
        (b"a = " + b"[" * 100_000, "got"),
        (b"\x00", "got"),
    ],
)
def test_files_that_hold_no_scenario(tmp_path: Path, name: str, content: bytes, words: str) -> None:
    (tmp_path / name).write_bytes(content)
    message = _refusal(tmp_path / name)
    assert message.startswith(str(tmp_path / name))
    assert words in message
    assert len(message) < 400


@pytest.mark.parametrize("text", ["- 1\n- 2\n", "just text\n", "3\n"])
def test_yaml_that_is_no_mapping(tmp_path: Path, text: str) -> None:
    (tmp_path / "a.yaml").write_text(text, encoding="utf-8")
    assert "need a table of fields" in _refusal(tmp_path / "a.yaml")


def test_yaml_numbers_that_are_none(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text(YAML.replace("15e2", ".nan"), encoding="utf-8")
    assert _refusal(tmp_path / "a.yaml").startswith("vehicle1.mass: got nan; need a finite number")


def test_files_that_are_not_there(tmp_path: Path) -> None:
    assert "got no such file" in _refusal(tmp_path / "a.toml")
    assert "got no such file" in _refusal("no/such/file")
    assert "Did you mean 'paper-adult-full'" in _refusal("paper-adult-ful.toml")
    assert "got a folder" in _refusal(tmp_path)
    assert "got a folder" in _refusal(str(tmp_path))
    assert "cannot be read" in _refusal("x" * 5000 + ".toml")
    assert "cannot be read" in _refusal("\0.toml")
    assert "got int" in _refusal(3)


def test_names_and_files_do_not_clash(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("neon-wall").mkdir()
    assert load("neon-wall").name == "neon-wall"
    Path("p1").write_text(TOML, encoding="utf-8")
    assert load("p1").name == "a wall test"


@pytest.mark.parametrize("name", ["paper-adult-ful", "x" * 5000, "a\0b", ""])
def test_unknown_names(name: str) -> None:
    with pytest.raises(UnknownName, match="catalogue: no"):
        load(name)


def test_an_unknown_name_offers_the_nearest() -> None:
    with pytest.raises(UnknownName, match="Did you mean 'marzbanrad-"):
        load("marzbanrad")


def test_loading_leaves_the_mapping_as_it_was(crash: Change) -> None:
    data = crash()
    load(data)
    assert data == crash()


@pytest.mark.parametrize("name", catalogue.names())
def test_dumped_catalogue_entries_load_back_equal(name: str, tmp_path: Path) -> None:
    scenario = load(name)
    (tmp_path / "a.toml").write_text(dump(scenario), encoding="utf-8")
    assert load(tmp_path / "a.toml") == scenario


def test_dumps_of_everything_that_may_be_given_load_back_equal(crash: Change, network: Change) -> None:
    data = crash("occupants.0.name", "sam")
    data["vehicle1"]["right"] = {"points": [[0, 1], [0.1, 2]], "unloading": "plastic", "unloading_stiffness": 1e6}
    data["vehicle1"]["left"] = data["vehicle1"].pop("members")
    data["bar"] = {"mass": 1 / 3, "inertia": 1, "arms": {"l1": 0, "l2": 0.1, "l3": 0.2, "l4": 0.3}, "speed": -0.1}
    for given_data in (data, network(), network("elements.2", {"between": ["m2", "m1"], "pieces": [{"stiffness": 3}]})):
        scenario = load(given_data)
        assert load(tomllib.loads(dump(scenario))) == scenario


@given(st.text(st.characters(exclude_categories=["Cs"])), st.floats(1e-300, 1e300))
def test_any_text_and_number_survives_a_dump(text: str, mass: float) -> None:
    scenario = CrashScenario(
        name=text,
        vehicle1={"mass": mass, "speed": 0, "members": {"points": [(0, 0)]}},
        sources=[{"title": text, "confidence": "primary"}],
    )
    assert load(tomllib.loads(dump(scenario))) == scenario


def test_dumps_are_written_with_units_and_without_defaults(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text(TOML, encoding="utf-8")
    text = dump(load(tmp_path / "a.toml"))
    assert 'mass = "1500 kg"' in text
    assert 'duration = "0.15 s"' in text
    assert "unloading" not in text


def test_columns_cannot_be_dumped() -> None:
    with pytest.raises(InvalidInput, match=r"^mass: got a column"):
        dump(substitute(load("p1"), {"vehicle1.mass": [1.0, 2.0]}))
