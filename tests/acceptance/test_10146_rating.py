"""Channels of NHTSA test 10146 rated against each other: by ours and by the package of the makers of ISO/TS 18571."""

from __future__ import annotations

from pathlib import Path

import pytest

from ridedown import criteria
from ridedown.signals import filtered, resultant
from ridedown.signals.ev5 import read_ev5
from ridedown.signals.record import TestRecord
from tests.criteria import rating_twins as twins

DATA = Path(__file__).resolve().parents[3] / "shared" / "data" / "nhtsa_v10146"

pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason="the measured crash, shared/data/nhtsa_v10146, is not at hand")

PAIRS = {
    "two sensors of the compartment": (94, 99, 60),
    "the same, unfiltered": (94, 99, 1000),
    "engine and compartment": (94, 93, 60),
    "femurs of the driver": (23, 24, 600),
    "femurs of the passenger": (69, 70, 600),
}


@pytest.fixture(scope="module")
def record() -> TestRecord:
    return read_ev5(DATA)


@pytest.mark.parametrize("name", PAIRS)
@pytest.mark.parametrize("end", [0.08, 0.15])
def test_measured_channels_rate_as_by_the_package(record: TestRecord, name: str, end: float) -> None:
    first, second, frequency_class = PAIRS[name]
    check(filtered(record.history(first), frequency_class), filtered(record.history(second), frequency_class), end)


@pytest.mark.parametrize(("first", "second", "cfc"), [(1, 47, 1000), (13, 59, 180)])
def test_heads_and_chests_rate_as_by_the_package(record: TestRecord, first: int, second: int, cfc: int) -> None:
    one, other = (resultant(*(filtered(record.history(key + axis), cfc) for axis in range(3))) for key in (first, second))
    check(one, other, 0.15)


def check(one, other, end: float) -> None:
    found = criteria.rating(one, other, start=0.0, end=end)
    columns = []
    for curve in (one, other):
        time, values = curve.si
        chosen = (time > -1e-9) & (time < end + 1e-9)  # the record is at 10 kHz, as the rating is
        columns.append(values[chosen])
    parts = found.corridor, found.phase, found.magnitude, found.slope
    assert parts == pytest.approx(twins.by_package(*columns), abs=1e-9)
    assert 0.0 < found.value < 1.0
