"""Limiting performance: the least peak deceleration that any restraint could give, and how far a restraint is from it.

`lead` is a pulse as an occupant meets it, `least_peak` the exact solution on it, `limiting` what is asked of both.
"""

from __future__ import annotations

from ridedown.studies.bound.limiting import (
    Bound,
    BoundStudy,
    Design,
    Gap,
    Limiting,
    bound_study,
    gap,
    gap_of,
    limiting_performance,
)

__all__ = ["Bound", "BoundStudy", "Design", "Gap", "Limiting", "bound_study", "gap", "gap_of", "limiting_performance"]
