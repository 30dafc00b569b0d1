"""Studies: what is learnt from many crashes. `calibrate` finds a model's parameters from tests,
`extract` (in `ridedown.studies.extract`) a front structure from a wall test.
"""

from ridedown.studies.calibration import Calibration, load_calibration
from ridedown.studies.fit import calibrate
from ridedown.studies.fitted import Calibrated

__all__ = ["Calibrated", "Calibration", "calibrate", "load_calibration"]
