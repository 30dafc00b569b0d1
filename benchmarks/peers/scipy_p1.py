"""P1 by scipy's `solve_ivp`, RK45 at a relative tolerance of 1e-6: what a user of MATLAB's `ode45` would write.

The right-hand side tests the bounds of the laws itself, the integrator steps over them, and peaks are the largest of
values sampled every 0.1 ms.
"""

from __future__ import annotations

from math import tan

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.p1_reference import (
    ADULT,
    BAR_INERTIA,
    BAR_MASS,
    CHILD,
    END,
    LONG_ARM,
    SEAT,
    SHORT_ARM,
    SLACK,
    STATES,
    Floats,
)

TOLERANCE = 1e-6
SAMPLES = np.linspace(0.0, END, 2001)


class Crash:
    """One parameter set of P1."""

    def __init__(self, params: Floats) -> None:
        (self.m1, self.m2, self.k1, self.k2, self.knee, *self.ties, self.speed) = map(float, params)

    def push(self, d: float) -> float:
        """Force of a longitudinal member."""
        if d <= 0.0:
            return 0.0
        return self.k1 * d if d <= self.knee else self.k1 * self.knee + self.k2 * (d - self.knee)

    def slope(self, _: float, y: Floats) -> list[float]:
        """Derivative of the state x1 v1 x2 v2 xb vb th om xa va xc vc xs vs."""
        x1, v1, x2, v2, xb, vb, th, om, xa, va, xc, vc, xs, vs = y.tolist()
        ka, ca, kc, cc, ks, cs = self.ties
        tangent = tan(th)
        far, near = LONG_ARM * tangent, SHORT_ARM * tangent
        f11, f12 = self.push(x1 - xb - far), self.push(x1 - xb + near)
        f21, f22 = self.push(x2 + xb - far), self.push(x2 + xb + near)
        adult = pull(ka, ca, xa - x1, va - v1)
        child = pull(kc, cc, xc - xs, vc - vs)
        seat = pull(ks, cs, xs - x1, vs - v1)
        return [
            *(v1, -(f11 + f12) / self.m1),
            *(v2, -(f21 + f22) / self.m2),
            *(vb, (f11 + f12 - f21 - f22) / BAR_MASS),
            *(om, ((f11 + f21) * LONG_ARM - (f12 + f22) * SHORT_ARM) / BAR_INERTIA),
            *(va, -adult / ADULT),
            *(vc, -child / CHILD),
            *(vs, (child - seat) / SEAT),
        ]

    def outcomes(self) -> Floats:
        """The six outcomes."""
        start = np.zeros(STATES)
        start[[1, 3, 9, 11, 13]] = self.speed
        y = solve_ivp(self.slope, (0.0, END), start, method="RK45", rtol=TOLERANCE, t_eval=SAMPLES).y
        ka, ca, kc, cc, _, _ = self.ties
        excursion, rate = y[8] - y[0], y[9] - y[1]
        stretch, stretch_rate = y[10] - y[12], y[11] - y[13]
        adult = np.where(excursion > SLACK, ka * (excursion - SLACK) + ca * rate, 0.0)
        child = np.where(stretch > SLACK, kc * (stretch - SLACK) + cc * stretch_rate, 0.0)
        tangent = np.tan(y[6])
        vehicle = np.zeros(len(SAMPLES))
        for d in (y[0] - y[4] - LONG_ARM * tangent, y[0] - y[4] + SHORT_ARM * tangent):
            vehicle += self.k1 * np.clip(d, 0.0, self.knee) + self.k2 * np.maximum(d - self.knee, 0.0)
        columns = (adult / ADULT, excursion, child / CHILD, stretch, vehicle / self.m1, y[0])
        return np.array([column.max() for column in columns])


def pull(k: float, c: float, d: float, v: float) -> float:
    """Force of a restraint."""
    return max(0.0, k * (d - SLACK) + c * v) if d > SLACK else 0.0


def solve(params: Floats) -> Floats:
    """Outcomes (N, 6) of parameter sets (N, 12)."""
    return np.array([Crash(row).outcomes() for row in params])
