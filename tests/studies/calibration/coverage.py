"""How often the true parameters lie in their 95 % bands, by the kind of noise.

`python -m tests.studies.calibration.coverage 60` prints it for sixty random restraints a kind.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping

import numpy as np

from ridedown.studies import calibrate
from tests.studies.calibration.synthetic import (
    DAMPING,
    SLACK,
    STIFFNESS,
    Noise,
    lasting,
    record,
    restraint,
    spec,
    through_a_class,
    white,
)

NAMES = {"stiffness": STIFFNESS, "slack": SLACK, "damping": DAMPING}

KINDS: Mapping[str, tuple[Noise, float]] = {
    "white": (white, 20.0),
    "through CFC 60": (through_a_class(60.0), 3.0),
    "correlated over 5 ms": (lasting(0.005), 20.0),
    "correlated over 10 ms": (lasting(0.010), 20.0),
}
"""Each with its standard deviation [m/s2]; peaks are some 400."""


def inside(kind: str, seeds: Iterable[int]) -> list[bool]:
    """For each random restraint and each of its parameters, whether the band holds the truth."""
    noise, deviation = KINDS[kind]
    found = []
    for seed in seeds:
        rng = np.random.default_rng(seed)
        true = restraint(rng)
        done = calibrate(spec(record(true, deviation, rng, kind=noise)))
        found += [p.low <= true[NAMES[p.name]] <= p.high for p in done.parameters]
    return found


if __name__ == "__main__":
    for name in KINDS:
        print(f"{name:24} {np.mean(inside(name, range(int(sys.argv[1])))):.3f}")
