"""Something wrong in a scenario ends in one sentence that names the field, exit code 2, and nothing written."""

from __future__ import annotations

import copy
import json
from typing import Any

import pytest
from typer.testing import CliRunner

from ridedown.apps.cli import app

GOOD = {
    "vehicle1": {"mass": "1500 kg", "speed": "48 km/h", "members": {"pieces": [{"stiffness": "200 kN/m"}]}},
    "vehicle2": {
        "mass": "1500 kg",
        "speed": "48 km/h",
        "members": {"pieces": [{"stiffness": "100 kN/m", "until": "0.3 m"}, {"stiffness": "200 kN/m"}]},
    },
    "bar": {"mass": "40 kg", "inertia": "157 kg m2", "rail_spacing": "1.1 m", "lateral_offset": "0.8 m"},
    "occupants": [{"kind": "adult", "mass": "80 kg", "restraint": {"stiffness": "98.1 kN/m", "slack": "5 mm"}}],
}
MISSING = "(left out)"

TABLE = [
    # what is set, to what, and what the sentence says
    (("vehicle1", "mass"), "-1500 kg", ["vehicle1.mass", "> 0 kg"]),
    (("vehicle1", "mass"), 0, ["vehicle1.mass", "> 0 kg"]),
    (("vehicle1", "mass"), float("nan"), ["vehicle1.mass", "finite"]),
    (("vehicle2", "speed"), float("inf"), ["vehicle2.speed", "finite"]),
    (("vehicle2", "speed"), "-48 km/h", ["vehicle2.speed", "own forward direction"]),
    (("vehicle1", "mass"), MISSING, ["vehicle1.mass"]),
    (("vehicle1", "mas"), "1500 kg", ["vehicle1.mas", "mass"]),
    (("vehicle3",), {}, ["vehicle3", "vehicle"]),
    (("vehicle1", "members", "pieces", 0, "stiffness"), "40 kN", ["stiffness", "40 kN", "kN/m"]),
    (("vehicle2", "members", "pieces", 0, "until"), "-1 m", ["until"]),
    (("vehicle2", "members", "pieces", 1, "until"), "0.2 m", ["pieces"]),
    (("bar", "inertia"), 0, ["bar.inertia"]),
    (("bar", "inertia"), MISSING, ["bar.inertia", "unequal arms"]),
    (("bar",), MISSING, ["bar"]),
    (("occupants", 0, "restraint", "slack"), "-5 mm", ["slack", "-5 mm"]),
    (("occupants", 0, "restraint", "stiffness"), "stiff", ["stiffness", "stiff"]),
    (("occupants", 0, "restraint", "law"), "treshold", ["law", "threshold"]),
    (("occupants", 0, "kind"), "adlt", ["kind", "adult"]),
    (("occupants", 0, "vehicle"), 3, ["vehicle"]),
    (("duration",), 0, ["duration"]),
    (("duration",), "1 h", ["duration"]),
]


@pytest.mark.parametrize(("path", "value", "said"), TABLE, ids=[f"{'.'.join(map(str, p))}={v}" for p, v, _ in TABLE])
def test_one_sentence_and_nothing_written(tmp_path, path, value, said):
    result = run(scenario_with(path, value, tmp_path), tmp_path)
    assert one_sentence(result)
    for words in said:
        assert words in result.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("empty.toml", "", "empty"),
        ("broken.toml", "[vehicle1\n", "line 1"),
        ("broken.yaml", "a: [1,\n", "broken.yaml"),
        ("list.yaml", "- 1\n", "list"),
        ("bytes.toml", b"\xff\xfe", "UTF-8"),
    ],
)
def test_files_that_are_no_scenario(tmp_path, name, text, said):
    file = tmp_path / name
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    result = run(file, tmp_path)
    assert one_sentence(result)
    assert said in result.stderr


@pytest.mark.parametrize("name", ["paper-adult-ful", "no-such.toml", "folder/no-such.yaml", ".", "", "a\0b"])
def test_names_that_are_none(tmp_path, name):
    result = run(name, tmp_path)
    assert one_sentence(result)


def test_the_nearest_name_is_offered(tmp_path):
    assert "'paper-adult-full'" in run("paper-adult-ful", tmp_path).stderr


def test_no_occupants_is_fine(tmp_path):
    assert run(scenario_with(("occupants",), [], tmp_path), tmp_path).exit_code == 0


@pytest.mark.parametrize("command", [["run", "example-wall"], ["paper"], ["paper", "--identify"]])
def test_a_file_in_the_place_of_the_folder_is_refused_before_any_work(tmp_path, command):
    taken = tmp_path / "taken"
    taken.write_text("mine")
    result = CliRunner().invoke(app, [*command, "--out", str(taken)])
    assert one_sentence(result)
    assert "is a file" in result.stderr
    assert taken.read_text() == "mine"


@pytest.mark.parametrize("arguments", [["runn"], ["run"], ["run", "example-wall", "--jsn"], ["--vrsion"], ["schema", "x"]])
def test_commands_mistyped(arguments):
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 2
    assert "Error: " in result.stderr
    assert not result.stdout


def scenario_with(path, value, folder):
    data = copy.deepcopy(GOOD)
    inner: Any = data
    for key in path[:-1]:
        inner = inner[key]
    if value is MISSING:
        del inner[path[-1]]
    else:
        inner[path[-1]] = value
    file = folder / "scenario.yaml"
    # JSON is YAML, but for its names of what is no number
    file.write_text(json.dumps(data).replace("NaN", ".nan").replace("Infinity", ".inf"))
    return file


def run(source, folder):
    return CliRunner().invoke(app, ["run", str(source), "--out", str(folder / "out")])


def one_sentence(result) -> bool:
    """Whether it ended as an error should: exit code 2, one line on stderr, no word on stdout, no traceback."""
    assert result.exit_code == 2, (result.stdout, result.stderr, result.exception)
    assert result.stdout == ""
    assert result.stderr.startswith("ridedown: ")
    assert result.stderr.count("\n") == 1
    assert "Traceback" not in result.stderr
    return True
