"""Injury and pulse criteria: one function each, SI in, the field's units where a name says so.

Each takes times [s] and values, (n,) each, as a measured or a simulated history's `si` gives them, and treats the signal as
straight between its samples, exactly: no result depends on how finely it was sampled, but for what sampling itself loses.

>>> import numpy as np
>>> from ridedown import criteria
>>> time = np.linspace(0.0, 0.1, 1001)
>>> head = 9.80665 * 50 * np.sin(np.pi * np.clip((time - 0.02) / 0.06, 0.0, 1.0))  # 50 g, 60 ms
>>> round(criteria.hic(time, head).value, 2), round(criteria.clip(time, head).value_g, 2)
(248.58, 49.85)
"""

from ridedown.criteria.checks import STANDARD_GRAVITY
from ridedown.criteria.chest import CHEST_CONSTANTS, ChestConstants, ViscousCriterion, chest_deflection, viscous_criterion
from ridedown.criteria.energy import EnergySplit, energy_split, ridedown_efficiency
from ridedown.criteria.head import HIC, Clip, clip, hic, hic_by_sum, severity_index
from ridedown.criteria.legs import TIBIA_LIMITS, TibiaIndex, TibiaLimits, femur_force, tibia_index
from ridedown.criteria.neck import NECK_INTERCEPTS, NeckForces, NeckIntercepts, Nij, condyle_moment, neck_forces, nij
from ridedown.criteria.occupant_load import OLC, VPI, olc, vpi
from ridedown.criteria.pulse import (
    Peak,
    average_square_wave,
    coefficient_of_restitution,
    delta_v,
    dynamic_crush,
    equivalent_square_wave,
    peak,
    time_to_zero_velocity,
)
from ridedown.criteria.rating import Rating, rating
from ridedown.criteria.risk import (
    chest_injury_risk,
    combined_risk,
    femur_injury_risk,
    head_injury_risk,
    neck_injury_risk,
    relative_risk,
)
from ridedown.criteria.roadside import (
    ASI,
    AfterContact,
    HeadImpact,
    OccupantImpact,
    Ridedown,
    asi,
    occupant_impact_velocity,
    occupant_ridedown_acceleration,
    phd,
    thiv,
)

__all__ = [
    "ASI",
    "CHEST_CONSTANTS",
    "HIC",
    "NECK_INTERCEPTS",
    "OLC",
    "STANDARD_GRAVITY",
    "TIBIA_LIMITS",
    "VPI",
    "AfterContact",
    "ChestConstants",
    "Clip",
    "EnergySplit",
    "HeadImpact",
    "NeckForces",
    "NeckIntercepts",
    "Nij",
    "OccupantImpact",
    "Peak",
    "Rating",
    "Ridedown",
    "TibiaIndex",
    "TibiaLimits",
    "ViscousCriterion",
    "asi",
    "average_square_wave",
    "chest_deflection",
    "chest_injury_risk",
    "clip",
    "coefficient_of_restitution",
    "combined_risk",
    "condyle_moment",
    "delta_v",
    "dynamic_crush",
    "energy_split",
    "equivalent_square_wave",
    "femur_force",
    "femur_injury_risk",
    "head_injury_risk",
    "hic",
    "hic_by_sum",
    "neck_forces",
    "neck_injury_risk",
    "nij",
    "occupant_impact_velocity",
    "occupant_ridedown_acceleration",
    "olc",
    "peak",
    "phd",
    "rating",
    "relative_risk",
    "ridedown_efficiency",
    "severity_index",
    "thiv",
    "tibia_index",
    "time_to_zero_velocity",
    "viscous_criterion",
    "vpi",
]
