"""Longitudinal members: force against deflection in linear pieces."""

from __future__ import annotations

from collections.abc import Iterator
from functools import reduce
from typing import Literal

import numpy as np
from pydantic import Field

from ridedown.scenario.base import Check, Model, exclusive
from ridedown.scenario.quantities import Deflection, Distance, Force, Number, Stiffness


class Piece(Model):
    """One linear piece of a force-deflection curve."""

    stiffness: Stiffness = Field(description="slope of the force on this piece")
    until: Distance | None = Field(None, description="deflection where the piece ends; the last piece has none")


class ForceCurve(Model):
    """A force against a deflection in linear pieces, and how it unloads."""

    pieces: tuple[Piece, ...] | None = Field(None, description="linear pieces, in order of deflection")
    points: tuple[tuple[Deflection, Force], ...] | None = Field(
        None, description="instead of pieces: deflection and force, from deflection 0; constant beyond the last point"
    )
    unloading: Literal["elastic", "plastic"] = Field("elastic", description="along the curve, or to a permanent set")
    unloading_stiffness: Stiffness | None = Field(None, description="slope of the plastic unloading line")

    @property
    def first_force(self) -> Number:
        """Force where the first piece starts [N]."""
        return 0.0

    def curve(self) -> tuple[tuple[Number, ...], tuple[Number, ...], tuple[Number, ...]]:
        """Where each piece starts [m], the force there [N] and its slope [N/m]."""
        if self.points is not None:
            deflections, forces = zip(*self.points, strict=True)
            slopes = [
                (f1 - f0) / (d1 - d0) for d0, d1, f0, f1 in zip(deflections, deflections[1:], forces, forces[1:], strict=False)
            ]
            return deflections, forces, (*slopes, 0.0)
        pieces = self.pieces or ()
        force: Number = self.first_force
        start: Number = 0.0
        knots, at_knot = [], []
        for piece in pieces:
            knots.append(start)
            at_knot.append(force)
            if piece.until is not None:
                force = force + piece.stiffness * (piece.until - start)
                start = piece.until
        return tuple(knots), tuple(at_knot), tuple(piece.stiffness for piece in pieces)

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        yield exclusive(
            "pieces",
            "points",
            given=self.pieces is not None and self.points is not None,
            fix="Give the curve once, by its slopes or by its points.",
        )
        yield from self._given()
        yield from self._pieces_in_order()
        yield from self._points_in_order()
        yield from self._unloads()

    def _given(self) -> Iterator[Check]:
        given = self.pieces if self.points is None else self.points
        yield Check(
            "pieces" if self.points is None else "points",
            bool(given),
            "nothing" if given is None else "an empty list",
            "at least one piece",
            'For a single spring write pieces = [{ stiffness = "300 kN/m" }].',
        )

    def _pieces_in_order(self) -> Iterator[Check]:
        pieces = self.pieces or ()
        before: Number = 0.0
        for i, piece in enumerate(pieces[:-1]):
            field = f"pieces.{i}.until"
            yield Check(
                field,
                piece.until is not None,
                "nothing",
                "the deflection where this piece ends",
                "Only the last piece goes on for ever.",
            )
            assert piece.until is not None
            need = "knots that increase" if i == 0 else f"more than pieces.{i - 1}.until"
            yield Check(field, piece.until > before, piece.until, need, "Put the pieces in order of deflection.", "m")
            before = piece.until
        if pieces:
            last = len(pieces) - 1
            end = pieces[-1].until
            yield Check(
                f"pieces.{last}.until",
                end is None,
                "" if end is None else end,
                "none on the last piece",
                "Leave it out, for the last piece goes on for ever, or add the piece that follows.",
                "m",
            )

    def _points_in_order(self) -> Iterator[Check]:
        if self.points is None:
            return
        first = self.points[0][0]
        yield Check("points.0.0", first == 0.0, first, "the first point at deflection 0 m", "Start the table at 0.", "m")
        for i in range(1, len(self.points)):
            deflection = self.points[i][0]
            yield Check(
                f"points.{i}.0",
                deflection > self.points[i - 1][0],
                deflection,
                f"more than points.{i - 1}.0",
                "Put the points in order of deflection.",
                "m",
            )

    def _unloads(self) -> Iterator[Check]:
        plastic, line = self.unloading == "plastic", self.unloading_stiffness
        yield Check(
            "unloading_stiffness",
            plastic or line is None,
            "a value with elastic unloading",
            "none",
            'Take it out, or set unloading = "plastic".',
        )
        yield Check(
            "unloading_stiffness",
            not plastic or line is not None,
            "nothing",
            "the stiffness of the plastic unloading line",
            "Give it, at least as stiff as the stiffest piece.",
        )
        if line is not None:
            stiffest = reduce(np.maximum, self.curve()[2])
            yield Check(
                "unloading_stiffness",
                (line >= stiffest) & (line > 0.0),
                line,
                f"> 0 and at least that of the stiffest piece ({np.max(stiffest):.6g} N/m)",
                "A softer line would cross the loading curve.",
                "N/m",
            )


class ForceDeflection(ForceCurve):
    """A force-deflection curve: pieces or points, and how it unloads. It only pushes: no force up to zero deflection.

    The paper's eq. 9 is the case of two pieces. `elastic` comes back along the curve; `plastic` comes back down a line
    of `unloading_stiffness` to a permanent set, and up the same line on reloading.
    """

    initial_force: Force | None = Field(None, description="force at first contact, with pieces; 0 if left out")

    def complete(self) -> None:
        """Fill in what was left out."""
        if self.pieces is not None and self.initial_force is None:
            self._fill(initial_force=0.0)

    @property
    def first_force(self) -> Number:
        """Force where the first piece starts [N]."""
        return 0.0 if self.initial_force is None else self.initial_force

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        yield from super().checks()
        yield exclusive(
            "points",
            "initial_force",
            given=self.points is not None and self.initial_force is not None,
            fix="With points, the first one holds the initial force.",
        )


class Member(ForceDeflection):
    """A longitudinal member at the front of a vehicle."""
