"""NHTSA test 10146: belt and airbag of both occupants from their chests, and what they predict of the other and the rest."""

from __future__ import annotations

import shutil
import time
from pathlib import Path

import pytest

from ridedown.studies import Calibrated, calibrate
from ridedown.studies.calibration.fitted import FittedChannel

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT.parent / "shared" / "data" / "nhtsa_v10146"

pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason="the measured crash, shared/data/nhtsa_v10146, is not at hand")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The example's files with the record beside them, as their user has them."""
    made = tmp_path_factory.mktemp("calibration") / "camry"
    shutil.copytree(ROOT / "docs" / "examples" / "camry", made)
    (made / "nhtsa_v10146").symlink_to(DATA)
    return made


def said(channel: FittedChannel) -> str:
    assert channel.rating is not None
    assert channel.peak_error is not None
    return f"{channel.case}: ISO/TS 18571 {channel.rating.value:.3f}, peak {channel.peak_error:+.1%}"


def both(found: Calibrated) -> tuple[FittedChannel, FittedChannel]:
    fitted, predicted = (next(c for c in found.channels if c.fitted is kind) for kind in (True, False))
    return fitted, predicted


@pytest.mark.parametrize("occupant", ["driver", "passenger"])
def test_belt_and_airbag_follow_the_chest(folder: Path, occupant: str) -> None:
    start = time.process_time()
    found = calibrate(folder / f"fit-{occupant}.toml")
    took = time.process_time() - start
    fitted, predicted = both(found)
    print(f"{said(fitted)} in {took:.0f} s of processor time; {said(predicted)}")
    assert fitted.rating.value >= 0.90
    assert abs(fitted.peak_error) <= 0.02
    assert fitted.rms / abs(fitted.measured_peak.value) < 0.05
    assert took < 20.0
    # the other occupant, never fitted: fair at least, and the peak about right
    assert predicted.rating.value > 0.70
    assert abs(predicted.peak_error) < 0.10


@pytest.mark.parametrize("occupant", ["driver", "passenger"])
def test_the_first_90_ms_do_not_tell_the_rest_and_the_notes_say_so(folder: Path, occupant: str) -> None:
    found = calibrate(folder / f"early-{occupant}.toml")
    fitted, predicted = both(found)
    print(f"{said(fitted)}; {said(predicted)}")
    assert fitted.rating.value >= 0.90
    assert abs(predicted.peak_error) < 0.25
    assert any("airbag venting" in one.names for one in found.confounded)
    assert any(help_.channel.endswith("belt.force") for one in found.confounded for help_ in one.helps)
