"""From a good candidate to the least sum of squares: trust region with bounds, every Jacobian from one batch of crashes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Function = Callable[[Floats], Floats]
"""Points of the unit cube (R, n) to values (R, m); NaN in rows that cannot be."""

STEP = 5e-4
"""Of a difference, in parts of the box: truncation is its square, and what a crash is solved to is far less."""

_TOLERANCE = 1e-7
_MOST_EVALUATIONS = 60


def jacobian(function: Function, point: Floats, step: float = STEP) -> Floats:
    """Derivatives of a function's values by the coordinates of a point, (m, n): central differences, from the point's one side
    where the other is outside the cube or cannot be; zero where neither can.

    >>> jacobian(lambda x: x**2, np.array([0.3, 0.6])).round(6)
    array([[0.6, 0. ],
           [0. , 1.2]])
    """
    n = point.size
    sides = np.concatenate([point + step * np.eye(n), point - step * np.eye(n), point[None]])
    inside = np.clip(sides, 0.0, 1.0)
    values = function(inside)
    ahead, behind, here = values[:n], values[n : 2 * n], values[-1]
    columns = []
    for i in range(n):
        high, low = ahead[i], behind[i]
        right, left = inside[i, i], inside[n + i, i]
        if np.isnan(high).any():
            high, right = here, point[i]
        if np.isnan(low).any():
            low, left = here, point[i]
        columns.append((high - low) / (right - left) if right > left else np.zeros_like(here))
    return np.stack(columns, axis=1)


def least_squares(residuals: Function, start: Floats) -> tuple[Floats, float]:
    """The point of the unit cube (n,) near `start` where the squares of the residuals are least, and their sum there.

    >>> point, value = least_squares(lambda x: 10.0 * (x - 0.25) * np.array([1.0, 2.0]), np.array([0.9, 0.1]))
    >>> point.round(6).tolist(), round(value, 12)
    ([0.25, 0.25], 0.0)
    """
    from scipy.optimize import least_squares as scipy_least_squares  # noqa: PLC0415  slow to import

    inner = np.clip(start, 1e-9, 1.0 - 1e-9)  # the method needs to start inside
    first = residuals(inner[None])[0]
    if np.isnan(first).any():
        return start, np.inf

    def at(point: Floats) -> Floats:
        row: Floats = residuals(point[None])[0]
        return row

    def slope(point: Floats) -> Floats:
        return jacobian(residuals, point)

    found = scipy_least_squares(
        at,
        inner,
        jac=slope,
        bounds=(0.0, 1.0),
        method="trf",
        xtol=_TOLERANCE,
        ftol=_TOLERANCE,
        gtol=_TOLERANCE,
        max_nfev=_MOST_EVALUATIONS,
    )
    end: Floats = found.x
    return end, 2.0 * float(found.cost)
