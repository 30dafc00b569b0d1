"""What is said of where a sled's pulse comes from."""

from __future__ import annotations

import numpy as np
import pytest

from ridedown import load
from ridedown.report.pulse import about
from ridedown.signals import TestRecord, TimeHistory, write


@pytest.mark.parametrize(("apart", "said"), [(0.01, "velocities come up to 0.12 m/s away"), (0.2, "velocities disagree")])
def test_how_far_averaged_sensors_agree_is_said(tmp_path, apart, said):
    pulse = np.full(1001, -120.0)  # 12 m/s in 100 ms
    curves = [
        TimeHistory(pulse * (1.0 + sign * apart), "m/s2", interval=1e-4, name=name)
        for sign, name in ((1, "left"), (-1, "right"))
    ]
    write(TestRecord.of(curves, identifier="run7"), tmp_path / "run7.csv")
    given = {"kind": "measured", "file": str(tmp_path / "run7.csv"), "channels": ["left", "right"], "cfc": "none"}
    (sentence,) = about(load({"speed": 12, "pulse": given}))
    assert said in sentence
    (alone,) = about(load({"speed": 12, "pulse": given | {"channels": "left"}}))
    assert "velocities" not in alone
