"""Which kernels a command needs that have yet to be compiled on this machine."""

from __future__ import annotations


def of_a_run() -> list[str]:
    """Those of a simulated crash and of its occupants' criteria."""
    import ridedown.criteria.head  # noqa: PLC0415 - heavy, and not every command needs them
    import ridedown.solver.march  # noqa: F401, PLC0415
    from ridedown.compiled import unkept  # noqa: PLC0415

    of_occupants = ("ridedown.criteria.windows:best_window", "ridedown.criteria.levels:highest_reached")
    return [name for start in (*of_occupants, "ridedown.solver.") for name in unkept(start)]


def of_all_criteria() -> list[str]:
    """Those of every criterion, of occupants and vehicles."""
    import ridedown.criteria.many  # noqa: F401, PLC0415
    from ridedown.compiled import unkept  # noqa: PLC0415

    return unkept("ridedown.criteria.")
