"""The front of NHTSA test 10146 from its cabin, its engine and its wall: 1719 kg at 57.09 km/h, load cells summed.

Bars of the project: crush within 2 %, its time within 3 ms, rebound within 10 %, cabin acceleration and force on the wall both
rated 0.8 or better by ISO/TS 18571, which one mass cannot do.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from ridedown import load, simulate
from ridedown.signals import read
from ridedown.studies.extraction.extract import Extraction, extract

DATA = Path(__file__).resolve().parents[3] / "shared" / "data" / "nhtsa_v10146"


@pytest.fixture(scope="module")
def found() -> Extraction:
    if not DATA.is_dir():
        pytest.skip(f"measured test 10146 is not at {DATA}")
    return extract(read(DATA), barrier=read(DATA / "barrier_total_fx.csv"))


def test_what_was_measured(found: Extraction) -> None:
    test = found.test
    assert test.used == ("94", "99")
    assert test.mass == 1719.0
    assert test.crush == pytest.approx(0.737, abs=0.002)
    assert test.stop == pytest.approx(0.073, abs=0.0005)
    assert 9.0 <= 3.6 * test.rebound <= 10.5


def test_the_wall_and_the_car_agree_in_momentum(found: Extraction) -> None:
    assert found.momentum.ratio == pytest.approx(1.0, abs=0.01)
    assert found.momentum.rebound_ratio == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("masses", ["one", "two"])
def test_crush_time_and_rebound(found: Extraction, masses: str) -> None:
    model = getattr(found, masses).simulated
    assert model.crush == pytest.approx(found.test.crush, rel=0.02)
    assert model.stop == pytest.approx(found.test.stop, abs=0.003)
    assert model.rebound == pytest.approx(found.test.rebound, rel=0.10)


def test_two_masses_follow_cabin_and_wall_and_one_cannot(found: Extraction) -> None:
    assert found.two.cabin.value > 0.85
    assert found.two.barrier.value > 0.85
    assert found.one.cabin.value > 0.85
    assert found.one.barrier.value < 0.8


def test_the_engine_is_one(found: Extraction) -> None:
    # engine, gearbox and what moves with them, of a 2.5 l car
    assert 250.0 < found.two.engine_mass < 500.0


def test_the_file_reproduces_it(found: Extraction, tmp_path: Path) -> None:
    file = tmp_path / "front.toml"
    file.write_text(found.toml, encoding="utf-8")
    response = simulate(load(file))
    crush = response.maximum("cabin.displacement")
    assert (crush.value, crush.time) == (found.two.simulated.crush, found.two.simulated.stop)
    assert found.warnings == ()
