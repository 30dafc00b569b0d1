"""Every way in which a simulation can end, as sentences for the user."""

from __future__ import annotations

from enum import Enum

from ridedown.solver.march import Stop


class Status(Enum):
    """How a simulation ended; the value is its code in tables of outcomes."""

    COMPLETED = int(Stop.COMPLETED)
    TOO_MANY_STEPS = int(Stop.TOO_MANY_STEPS)
    BAR_TURNED = int(Stop.BAR_TURNED)
    NOT_FINITE = int(Stop.NOT_FINITE)
    CHATTER = int(Stop.CHATTER)

    @classmethod
    def of(cls, stop: int) -> Status:
        """The status of a solver's stop."""
        return cls(int(stop))

    @property
    def sentence(self) -> str:
        """What happened, and what to change."""
        return _SENTENCES[self]


_SENTENCES = {
    Status.COMPLETED: "the crash was solved to its end",
    Status.TOO_MANY_STEPS: (
        "more steps than the solver allows: very stiff parts, or one that bounces on an initial force f0. Raise the smallest "
        "masses, lower the largest stiffness or damping, or give the member a steep first piece instead of f0"
    ),
    Status.BAR_TURNED: (
        "the bumper bar turned by more than 80 degrees, where its members' ends run away to infinity. Raise the bar's inertia, "
        "or lower the offset"
    ),
    Status.NOT_FINITE: "a number overflowed. Look for a mass, stiffness or damping that is out of all proportion",
    Status.CHATTER: (
        "force laws switched on and off without end at one instant, as an initial force f0 does between parts at rest. "
        "Give the member a steep first piece instead of f0"
    ),
}
