"""Every TOML block in the documentation is a scenario, a calibration or a study that loads."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

from ridedown.scenario import dump, load
from ridedown.studies import load_calibration, load_study
from ridedown.studies.rows.plan import plan_of

ROOT = Path(__file__).parents[2]
BLOCKS = [
    pytest.param(block, id=f"{page.name}-{number}")
    for page in (ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")))
    for number, block in enumerate(re.findall(r"```toml\n(.*?)```", page.read_text(encoding="utf-8"), flags=re.DOTALL), 1)
]


def test_there_are_examples():
    assert len(BLOCKS) >= 4


@pytest.mark.parametrize("block", BLOCKS)
def test_example_loads_and_comes_back(block):
    if "[[cases]]" in block:
        assert load_calibration(tomllib.loads(block))[0].parameters
        return
    if "[[parameters]]" in block or block.startswith("kind = "):
        assert plan_of(load_study(tomllib.loads(block))).rows
        return
    scenario = load(tomllib.loads(block))
    assert load(tomllib.loads(dump(scenario))) == scenario


def test_links_between_pages_lead_somewhere():
    for page in (ROOT / "README.md", *(ROOT / "docs").rglob("*.md")):
        for target in re.findall(r"\]\((?!https?:)([^)#]+)", page.read_text(encoding="utf-8")):
            assert (page.parent / target).exists(), f"{page.name} points to {target}"
