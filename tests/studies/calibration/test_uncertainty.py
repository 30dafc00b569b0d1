"""Bands hold the truth as often as they say, whatever the colour of the noise."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import binom

from ridedown.studies.calibration.uncertainty import Block, noise_of, uncertainty
from tests.studies.calibration.coverage import KINDS, inside

_ROWS, _SETTLING = 30, 300
_T = np.linspace(0.0, 1.0, _ROWS)
SLOPE = np.stack([np.sin(np.pi * _T), _T * np.sin(2.0 * np.pi * _T), np.exp(-(((_T - 0.4) / 0.12) ** 2))], axis=1)
"""What three parameters do to thirty samples, of about the smoothness of a chest's acceleration."""


def first_order(rng: np.random.Generator, phi: float, rows: int = _ROWS) -> np.ndarray:
    drawn = rng.normal(0.0, np.sqrt(1.0 - phi**2), rows + _SETTLING)
    return lfilter([1.0], [1.0, -phi], drawn)[_SETTLING:]


@pytest.mark.parametrize("phi", [0.0, 0.4, 0.6, 0.8, 0.9])
def test_a_linear_model_in_noise_of_every_colour(phi: float) -> None:
    """Six hundred fits. With the likeliest correlation in place of the mean over all, bands held 0.92 to 0.94 from 0.4 on."""
    rng = np.random.default_rng(5)
    held = []
    for _ in range(600):
        noise = first_order(rng, phi)
        error = np.linalg.lstsq(SLOPE, noise, rcond=None)[0]
        found = uncertainty([Block(SLOPE, channel=SLOPE @ error - noise)], 3)
        held.append(np.abs(error) <= found.reach * found.deviation)
    # the three of one fit are not independent: limits as of six hundred, two standard deviations below and a little more above
    assert 0.95 - 0.018 <= np.mean(held) <= 0.975


def test_the_noise_of_a_long_record_is_told() -> None:
    rng = np.random.default_rng(1)
    found = noise_of(3.0 * first_order(rng, 0.6, rows=4000), np.ones((4000, 1)))
    assert found.phi == pytest.approx(0.6, abs=0.04)
    assert found.deviation == pytest.approx(3.0, rel=0.05)
    assert found.covariance[5] == pytest.approx(9.0 * 0.6**5, rel=0.25)
    assert found.independent == pytest.approx(4000 * (1.0 - 0.36) / (1.0 + 0.36), rel=0.1)


@pytest.mark.parametrize("kind", KINDS)
def test_true_parameters_lie_in_their_bands_about_as_often_as_they_should(kind: str) -> None:
    found = inside(kind, range(10))
    # one in ten thousand of right bands would fail this, and bands half as wide as they should be (68 %) nearly always
    least = binom.ppf(1e-4, len(found), 0.95)
    assert sum(found) >= least
    assert least > binom.ppf(0.5, len(found), 0.68)
