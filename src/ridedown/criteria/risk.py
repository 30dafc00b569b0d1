"""How likely an injury is, given a criterion: the risk curves of the US New Car Assessment Program for the frontal crash.

They belong to the Hybrid III 50th-percentile male and 5th-percentile female, and to the criteria as FMVSS 208 defines them.
A probability from a curve says what a population of such people in such crashes would suffer, not what one person will.

References:
    NHTSA, Consumer Information; New Car Assessment Program, final decision notice, 73 Federal Register 40016, 11 July 2008.
    The notice was not at hand. Its coefficients were compared, all of them, with an independent public program that rates
    measured NCAP tests by them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from ridedown.criteria.checks import number
from ridedown.errors import InvalidInput, UnknownName

REFERENCE_RISK = 0.15
"""The average risk of the fleet that a combined risk is compared with for the stars."""


@dataclass(frozen=True, slots=True)
class Logistic:
    """1/(1 + exp(a - b x^n)), the form of all curves but the head's; x in the unit that the notice uses."""

    a: float
    b: float
    power: float = 1.0

    def at(self, x: float) -> float:
        """The probability at x >= 0."""
        return 1.0 / (1.0 + math.exp(self.a - self.b * x**self.power))


@dataclass(frozen=True, slots=True)
class RiskCurves:
    """Of one dummy: neck of its tension or compression [kN], chest of its deflection [mm], femur of its force [kN]."""

    neck_force: Logistic
    chest: Logistic
    femur: Logistic


RISK_CURVES: Mapping[str, RiskCurves] = {
    "Hybrid III 50": RiskCurves(Logistic(10.9745, 2.375), Logistic(10.5456, 1.568, 0.4612), Logistic(5.795, 0.5196)),
    "Hybrid III 05": RiskCurves(Logistic(10.958, 3.770), Logistic(10.5456, 1.7212, 0.4612), Logistic(5.7949, 0.7619)),
}
"""By dummy."""

_NIJ = Logistic(3.2269, 1.9688)
_HEAD_MEAN, _HEAD_SPREAD = 7.45231, 0.73998


def head_injury_risk(hic15: float) -> float:
    """Probability of a head injury of AIS 3 or more: the normal distribution of (ln HIC15 - 7.45231)/0.73998. Both dummies.

    >>> round(head_injury_risk(700.0), 4)
    0.1116

    Raises: InvalidInput for a HIC that is negative or not finite.
    """
    hic15 = _magnitude(hic15, "hic15", "")
    if hic15 == 0.0:
        return 0.0
    return 0.5 * math.erfc(-(math.log(hic15) - _HEAD_MEAN) / (_HEAD_SPREAD * math.sqrt(2.0)))


def neck_injury_risk(nij: float, tension: float, compression: float, *, dummy: str = "Hybrid III 50") -> float:
    """Probability of a neck injury of AIS 3 or more: the largest of those of Nij, peak tension and peak compression [N].

    The curve of Nij does not go to zero with Nij: without any load it still says 3.8 %.

    >>> round(neck_injury_risk(0.3, 1000.0, 200.0), 4), round(neck_injury_risk(0.0, 0.0, 0.0), 4)
    (0.0668, 0.0382)

    Raises: InvalidInput for values that are negative or not finite; UnknownName.
    """
    force = max(_magnitude(tension, "tension", "N"), _magnitude(compression, "compression", "N"))
    return max(_NIJ.at(_magnitude(nij, "nij", "")), _curves(dummy).neck_force.at(force / 1000.0))


def chest_injury_risk(deflection: float, *, dummy: str = "Hybrid III 50") -> float:
    """Probability of a chest injury of AIS 3 or more, of the peak deflection of the sternum as a magnitude [m].

    >>> round(chest_injury_risk(0.063), 4), round(chest_injury_risk(0.052, dummy="Hybrid III 05"), 4)
    (0.513, 0.5255)

    Raises: InvalidInput for a deflection that is negative or not finite; UnknownName.
    """
    return _curves(dummy).chest.at(1000.0 * _magnitude(deflection, "deflection", "m"))


def femur_injury_risk(force: float, *, dummy: str = "Hybrid III 50") -> float:
    """Probability of an injury of AIS 2 or more of knee, thigh or hip, of the peak femur compression as a magnitude [N].

    >>> round(femur_injury_risk(10_000.0), 4)
    0.3546

    Raises: InvalidInput for a force that is negative or not finite; UnknownName.
    """
    return _curves(dummy).femur.at(_magnitude(force, "force", "N") / 1000.0)


def combined_risk(*risks: float) -> float:
    """Probability of at least one of several injuries, taken as independent: 1 - (1 - p1)(1 - p2)...

    >>> round(combined_risk(0.1, 0.2), 12)
    0.28

    Raises: InvalidInput for a risk outside 0 .. 1.
    """
    spared = 1.0
    for risk in risks:
        if not 0.0 <= risk <= 1.0:
            raise InvalidInput(f"risk: got {risk:g}; need 0 <= risk <= 1. Give probabilities, not percentages.")
        spared *= 1.0 - risk
    return 1.0 - spared


def relative_risk(combined: float) -> float:
    """The combined risk over the fleet's 15 %: the relative risk score that NCAP's stars are given by.

    >>> relative_risk(0.15)
    1.0
    """
    return _magnitude(combined, "combined", "") / REFERENCE_RISK


def _magnitude(value: float, name: str, unit: str) -> float:
    checked = number(value, name, unit)
    if checked < 0.0:
        raise InvalidInput(f"{name}: got {f'{checked:g} {unit}'.rstrip()}; need >= 0. Give the magnitude.")
    return checked


def _curves(dummy: str) -> RiskCurves:
    if dummy not in RISK_CURVES:
        raise UnknownName.among("dummy", dummy, RISK_CURVES)
    return RISK_CURVES[dummy]
