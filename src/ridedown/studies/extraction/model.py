"""What an extraction looks for: a front of one mass on its members, or of cabin and engine, as a vector of numbers near 1.

One mass: the cabin stands for the whole car and crushes one curve. Two masses: the cabin crushes the rails against the wall
and the firewall against the engine, the engine its block against the wall, and mounts, a spring with a damper, hold the
engine in the cabin. Curves unload on a line to a permanent set.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ridedown.criteria.checks import Floats
from ridedown.scenario import CrashScenario, NetworkScenario

RAILS, BLOCK, FIREWALL, MOUNTS = "rails", "block", "firewall", "mounts"

_STEEPER = 1.001  # an unloading line as steep as the steepest piece is allowed; rounding must not make it softer
_SHARE = (0.03, 0.6)  # of the engine in the mass
_MOUNT_STIFFNESS, _MOUNT_DAMPING = (0.0, 3.0), (0.0, 3.0)
_FORCE, _FIRST, _GAP, _WIDTH, _UNLOADING = (0.0, 4.0), (0.0, 1.0), (0.0, 0.9), (0.02, 1.0), (0.3, 3.0)


@dataclass(frozen=True, slots=True)
class Shape:
    """A curve to be found: its element's name, the bodies it is between, how many pieces, whether it begins after a gap.

    Its numbers: the force at first contact, or the gap; the force at the end of each piece; the width of each piece; the
    logarithm to base 10 of the stiffness of unloading. After the last piece the force stays.
    """

    name: str
    between: tuple[str, str]
    pieces: int
    gap: bool = False

    @property
    def size(self) -> int:
        """How many numbers it has."""
        return 2 * self.pieces + 2

    def bounds(self) -> list[tuple[float, float]]:
        """Of each number."""
        first = _GAP if self.gap else _FIRST
        return [first, *[_FORCE] * self.pieces, *[_WIDTH] * self.pieces, _UNLOADING]

    def curve(self, numbers: Floats) -> tuple[Floats, Floats, Floats]:
        """Deflections and forces of its points and the stiffness of unloading, in units of the scale: (..., k) each, and (...).

        numbers: (..., size).
        """
        n = self.pieces
        first, forces, widths = numbers[..., :1], numbers[..., 1 : 1 + n], numbers[..., 1 + n : 1 + 2 * n]
        none = np.zeros_like(first)
        ends = np.cumsum(widths, axis=-1)
        if self.gap:
            deflections = np.concatenate((none, first, first + ends), axis=-1)
            forces = np.concatenate((none, none, forces), axis=-1)
        else:
            deflections, forces = np.concatenate((none, ends), axis=-1), np.concatenate((first, forces), axis=-1)
        slopes = np.diff(forces, axis=-1) / np.diff(deflections, axis=-1)
        return deflections, forces, np.maximum(10.0 ** numbers[..., -1], _STEEPER * slopes.max(axis=-1))

    def split(self, numbers: Floats, piece: int) -> tuple[Shape, Floats]:
        """The same curve with one of its pieces cut in two."""
        n = self.pieces
        before = numbers[piece] if piece or not self.gap else 0.0
        half = 0.5 * numbers[1 + n + piece]
        forces = np.insert(numbers[1 : 1 + n], piece, 0.5 * (before + numbers[1 + piece]))
        widths = np.insert(numbers[1 + n : 1 + 2 * n], piece, half)
        widths[piece + 1] = half
        return replace(self, pieces=n + 1), np.concatenate((numbers[:1], forces, widths, numbers[-1:]))


@dataclass(frozen=True, slots=True)
class Scale:
    """What the numbers are multiples of, and what is given: mass [kg], speed [m/s], force [N], length [m], duration [s]."""

    mass: float
    speed: float
    force: float
    length: float
    duration: float


@dataclass(frozen=True, slots=True)
class Form:
    """A front to be found: of one mass with one shape, or of two with three shapes (rails, block, firewall)."""

    scale: Scale
    shapes: tuple[Shape, ...]

    @property
    def masses(self) -> int:
        """1 or 2."""
        return 1 if len(self.shapes) == 1 else 2

    @property
    def leading(self) -> int:
        """How many numbers come before those of the shapes: the engine's share of the mass, its mounts."""
        return 0 if self.masses == 1 else 3

    def bounds(self) -> tuple[Floats, Floats]:
        """Least and largest of each number."""
        pairs = [_SHARE, _MOUNT_STIFFNESS, _MOUNT_DAMPING] if self.masses == 2 else []
        pairs += [pair for shape in self.shapes for pair in shape.bounds()]
        return np.array([pair[0] for pair in pairs]), np.array([pair[1] for pair in pairs])

    def parts(self, numbers: Floats) -> list[Floats]:
        """The numbers (..., n) of each shape."""
        ends = self.leading + np.cumsum([shape.size for shape in self.shapes])
        return [numbers[..., end - shape.size : end] for shape, end in zip(self.shapes, ends, strict=True)]

    def splits(self, numbers: Floats, most: int) -> Iterator[tuple[Form, Floats, int]]:
        """Every front with one more piece and the same curves, and the index of the new point's force."""
        parts = self.parts(numbers)
        for i, shape in enumerate(self.shapes):
            if shape.pieces >= most:
                continue
            for piece in range(shape.pieces):
                if parts[i][1 + shape.pieces + piece] < 2.0 * _WIDTH[0]:
                    continue
                finer, part = shape.split(parts[i], piece)
                before = numbers[: self.leading + sum(s.size for s in self.shapes[:i])]
                after = np.concatenate([np.zeros(0), *parts[i + 1 :]])
                form = replace(self, shapes=(*self.shapes[:i], finer, *self.shapes[i + 1 :]))
                yield form, np.concatenate((before, part, after)), before.size + 1 + piece

    # as a scenario

    def columns(self, numbers: Floats) -> dict[str, Floats]:
        """The numbers (R, n) as a table for `simulate_many`: parameter paths to columns (R,), SI."""
        scale = self.scale
        table: dict[str, Floats] = {}
        if self.masses == 2:
            engine = numbers[:, 0] * scale.mass
            table |= {"engine.mass": engine, "cabin.mass": scale.mass - engine}
            table[f"{MOUNTS}.stiffness"] = numbers[:, 1] * scale.force / scale.length
            table[f"{MOUNTS}.damping"] = numbers[:, 2] * scale.force / scale.speed
        for shape, part in zip(self.shapes, self.parts(numbers), strict=True):
            # of one mass, each of the two members takes half
            place, share = ("vehicle1.members", 0.5) if self.masses == 1 else (shape.name, 1.0)
            deflections, forces, unloading = shape.curve(part)
            for i in range(deflections.shape[1]):
                table[f"{place}.points.{i}.1"] = share * scale.force * forces[:, i]
                if i:
                    table[f"{place}.points.{i}.0"] = scale.length * deflections[:, i]
            table[f"{place}.unloading_stiffness"] = share * scale.force / scale.length * unloading
        return table

    def scenario(self, numbers: Floats, *, digits: int | None = None) -> CrashScenario | NetworkScenario:
        """The front against the wall; its values rounded to so many significant digits."""
        values = {path: _rounded(column[0], digits) for path, column in self.columns(numbers[np.newaxis]).items()}
        scale = self.scale
        if self.masses == 1:
            vehicle = {"mass": scale.mass, "speed": scale.speed, "members": _curve(values, "vehicle1.members")}
            return CrashScenario.model_validate({"duration": scale.duration, "vehicle1": vehicle})
        elements: list[dict[str, object]] = [
            {"name": shape.name, "between": shape.between, "law": "curve", **_curve(values, shape.name)}
            for shape in self.shapes
        ]
        mounts = {name: values[f"{MOUNTS}.{name}"] for name in ("stiffness", "damping")}
        elements.append({"name": MOUNTS, "between": ("engine", "cabin"), "law": "linear", **mounts})
        engine = values["engine.mass"]
        masses = [("cabin", scale.mass - engine), ("engine", engine)]
        return NetworkScenario.model_validate(
            {
                "duration": scale.duration,
                "masses": [{"name": name, "mass": mass, "speed": scale.speed} for name, mass in masses],
                "elements": elements,
            }
        )


def _curve(values: dict[str, float], place: str) -> dict[str, object]:
    """The curve whose numbers are at these paths, as a scenario has it."""
    count = sum(path.startswith(f"{place}.points.") and path.endswith(".1") for path in values)
    points = [(values.get(f"{place}.points.{i}.0", 0.0), values[f"{place}.points.{i}.1"]) for i in range(count)]
    return unloading_curve(points, values[f"{place}.unloading_stiffness"])


def unloading_curve(points: list[tuple[float, float]], unloading: float) -> dict[str, object]:
    """A curve that unloads plastically, as a scenario has it, its line at least as steep as the steepest piece."""
    steepest = max((f1 - f0) / (d1 - d0) for (d0, f0), (d1, f1) in pairwise(points))
    return {"points": points, "unloading": "plastic", "unloading_stiffness": max(unloading, _STEEPER * steepest)}


def _rounded(value: float, digits: int | None) -> float:
    return float(value) if digits is None else float(f"{value:.{digits}g}")


# what to begin with


def one_mass(scale: Scale, deflections: Floats, forces: Floats, unloading: float) -> tuple[Form, Floats]:
    """A front of one mass with this curve, in units of the scale; unloading is a logarithm."""
    form = Form(scale, (Shape(RAILS, ("wall", "cabin"), deflections.size - 1),))
    numbers = np.concatenate((forces[:1], forces[1:], np.diff(deflections), [unloading]))
    return form, within(form, numbers)


def two_masses(scale: Scale, share: float, gap: float, clearance: float, rails: Floats) -> tuple[Form, Floats]:
    """A front of two masses to begin with: the engine's share of the mass, its gap to the wall, the firewall's to it.

    rails: forces at the points of the rails' curve, evenly spaced to the crush.
    """
    pieces = rails.size - 1
    form = Form(
        scale,
        (
            Shape(RAILS, ("wall", "cabin"), pieces),
            Shape(BLOCK, ("wall", "engine"), 2, gap=True),
            Shape(FIREWALL, ("engine", "cabin"), 2, gap=True),
        ),
    )
    reach = max(0.1, 1.0 - gap - clearance)
    numbers = np.concatenate(
        (
            [share, 0.1, 0.2],
            rails,
            np.full(pieces, 1.0 / pieces),
            [1.3],
            [gap, 0.5, 0.5, 0.1, 0.1, 1.3],
            [clearance, 0.2, 0.4, 0.5 * reach, 0.5 * reach, 1.0],
        )
    )
    return form, within(form, numbers)


def within(form: Form, numbers: Floats) -> Floats:
    """The numbers, each brought a little inside its bounds."""
    low, high = form.bounds()
    room = 1e-3 * (high - low)
    inside: Floats = np.clip(numbers, low + room, high - room)
    return inside
