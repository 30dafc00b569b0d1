"""What can go wrong, as exceptions.

RidedownError
|-- InvalidInput        (also a ValueError)    a field holds what it may not; names the field
|-- UnknownName         (also a LookupError)   no such scenario, channel, parameter or outcome; offers the nearest
`-- SimulationStopped   (also a RuntimeError)  the solver stopped before the end; carries the part computed so far
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ridedown.response import Response


class RidedownError(Exception):
    """Base of every error that ridedown raises on purpose."""


class InvalidInput(RidedownError, ValueError):
    """A field holds a value it may not; the message names the field and what to change."""


class UnknownName(RidedownError, LookupError):
    """A name that is not known; the message offers the nearest ones."""

    @classmethod
    def among(cls, kind: str, name: str, known: Iterable[str]) -> UnknownName:
        """The error for `name`, which is not among the `known` names of this kind."""
        known = list(known)
        near = difflib.get_close_matches(name, known, n=3, cutoff=0.5)
        if near:
            return cls(f"{kind}: no {name!r}. Did you mean {' or '.join(repr(n) for n in near)}?")
        shown = ", ".join(known[:12]) + (", ..." if len(known) > 12 else "")
        return cls(f"{kind}: no {name!r}. Known: {shown or 'none'}.")


class SimulationStopped(RidedownError, RuntimeError):
    """The solver could not go on to the end; `response` holds the part computed so far."""

    def __init__(self, message: str, response: Response) -> None:
        super().__init__(message)
        self.response = response
