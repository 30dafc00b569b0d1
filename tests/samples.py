"""Scenarios drawn at random, of every kind that can be written down; a seed names each for good.

Many numbers are drawn from a few round ones, so that members, slacks and knees often coincide, as they do in real input.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from hypothesis import settings

from ridedown.scenario import CrashScenario, NetworkScenario

Data = dict[str, Any]


def examples(count: int) -> settings:
    """So many examples of a property, the same ones on every run."""
    return settings(max_examples=count, deadline=None, derandomize=True)


def crash(seed: int, **changes: Any) -> CrashScenario:
    """A crash of one or two vehicles with up to three occupants; `changes` replace top-level keys."""
    return CrashScenario(**(crash_data(np.random.default_rng(seed)) | changes))


def network(seed: int) -> NetworkScenario:
    """Up to four masses in a chain to the wall, with elements of every law."""
    return NetworkScenario(**network_data(np.random.default_rng(seed)))


def crash_data(rng: np.random.Generator, *, wall: bool | None = None, softening: bool = True) -> Data:
    """What a crash is made of, in the shape of a scenario file.

    `softening` lets members lose force as they crush, which makes a light bar between them fall to one side: every
    rounding error then grows.
    """
    if wall is None:
        wall = bool(rng.random() < 0.2)
    data: Data = {
        "duration": float(rng.choice([0.1, 0.2])),
        "vehicle1": vehicle(rng, least=5.0, softening=softening),
    }
    if not wall:
        alike = rng.random() < 0.3
        data["vehicle2"] = dict(data["vehicle1"]) if alike else vehicle(rng, least=0.0, softening=softening)
        data["bar"] = bar(rng)
        if data["vehicle2"]["speed"] > 0.0 and rng.random() < 0.3:
            data["bar"]["speed"] = 0.0
    data["occupants"] = [occupant(rng, vehicles=1 if wall else 2) for _ in range(rng.integers(0, 4))]
    return data


def vehicle(rng: np.random.Generator, *, least: float, softening: bool = True) -> Data:
    """Speed is at least `least`; it stands still now and then if that is 0."""
    speed = float(rng.choice([13.33, rng.uniform(max(least, 3.0), 25.0), least]))
    front: Data = {"members": member(rng, softening=softening)}
    if rng.random() < 0.4:
        front = {side: member(rng, softening=softening) for side in ("right", "left")}
    return {"mass": float(rng.choice([1500.0, rng.uniform(700.0, 3000.0)])), "speed": speed, **front}


def member(rng: np.random.Generator, *, softening: bool = True, jump: bool = True) -> Data:
    """A curve of pieces or points; flat, stiffening or softening; elastic or plastic; with a `jump` to f0, or without."""
    start = float(rng.choice([0.0, 0.0, 20e3])) if jump else 0.0
    found: Data
    if rng.random() < 0.3:
        deflections = np.concatenate([[0.0], np.cumsum(rng.uniform(0.05, 0.2, 4))])
        forces = rng.uniform(10e3, 300e3, 5)
        forces[0] = start
        if not softening:
            forces.sort()
        found = {"points": [[float(d), float(f)] for d, f in zip(deflections, forces, strict=True)]}
    else:
        pieces = [
            {"stiffness": float(rng.choice([118.2e3, 10 ** rng.uniform(4.5, 6.0), 0.0])), "until": 0.3},
            {"stiffness": float(10 ** rng.uniform(5.0, 6.0)), "until": float(rng.choice([0.5, 0.4]))},
            {"stiffness": float(10 ** rng.uniform(4.5, 6.0))},
        ]
        found = {"initial_force": start, "pieces": pieces[rng.integers(0, 3) :]}
    if rng.random() < 0.5:
        steepest = (1.0 + 1e-9) * stiffest(found)  # the line then runs along the steepest piece
        found |= {"unloading": "plastic", "unloading_stiffness": float(rng.choice([steepest, steepest + 5e6, 2e7]))}
    return found


def stiffest(member: Mapping[str, Any]) -> float:
    """The steepest slope of a curve [N/m], but not less than 100 kN/m."""
    if "points" in member:
        d, f = np.array(member["points"]).T
        return float(max(1e5, *(np.diff(f) / np.diff(d))))
    return max(1e5, *(float(piece["stiffness"]) for piece in member["pieces"]))


def bar(rng: np.random.Generator) -> Data:
    """Full or offset, both lever arm laws, light and heavy."""
    found: Data = {
        "mass": float(rng.choice([40.0, 10 ** rng.uniform(0.5, 2.0)])),
        "rail_spacing": 1.1,
        "lever_arm": str(rng.choice(["work-conjugate", "printed"])),
    }
    if rng.random() < 0.7:
        found |= {"inertia": float(rng.choice([157.0, rng.uniform(60.0, 300.0)]))}
        found |= {"lateral_offset": float(rng.choice([0.0, 0.3, 0.6]))}
    return found


def occupant(rng: np.random.Generator, *, vehicles: int) -> Data:
    """An adult, or a child in its seat; coupled or not."""
    found: Data = {
        "kind": "adult",
        "mass": 80.0,
        "restraint": restraint(rng),
        "coupled": bool(rng.random() < 0.5),
        "vehicle": int(rng.integers(1, vehicles + 1)),
    }
    if rng.random() < 0.4:
        found |= {"kind": "child", "mass": 18.0, "seat": {"mass": 5.0, "restraint": restraint(rng)}}
    return found


def restraint(rng: np.random.Generator) -> Data:
    """Any law; undamped to overdamped; taut from the start, or slack."""
    return {
        "stiffness": float(rng.choice([50e3, 10 ** rng.uniform(4.0, 5.3)])),
        "damping_ratio": float(rng.choice([0.0, 0.1, 0.5, 1.5])),
        "slack": float(rng.choice([0.0, 0.005, 0.03])),
        "law": str(rng.choice(["threshold", "kelvin-voigt", "linear"])),
    }


def network_data(rng: np.random.Generator, *, softening: bool = True) -> Data:
    """What a network is made of, in the shape of a scenario file."""
    names = [f"m{i}" for i in range(1, rng.integers(2, 6))]
    speed = float(rng.uniform(3.0, 20.0))
    masses = [{"name": name, "mass": float(10 ** rng.uniform(1.0, 3.2)), "speed": speed} for name in names]
    pairs = list(zip(["wall", *names], names, strict=False))
    pairs += [("wall", str(name)) for name in rng.choice(names, rng.integers(0, 3))]
    elements = [{"name": f"e{i}", **element(rng, pair, softening=softening)} for i, pair in enumerate(pairs)]
    return {"duration": 0.1, "masses": masses, "elements": elements}


def element(rng: np.random.Generator, between: tuple[str, str], *, softening: bool = True) -> Data:
    """A curve or a tie between two bodies."""
    if rng.random() < 0.4:  # masses that move together would rest on a jump
        curve = member(rng, softening=softening, jump=between[0] == "wall")
        return {"between": between, "law": "curve", **curve}
    return {
        "between": between,
        "law": str(rng.choice(["linear", "kelvin-voigt", "threshold"])),
        "stiffness": float(10 ** rng.uniform(3.5, 5.5)),
        "damping": float(rng.choice([0.0, 10 ** rng.uniform(2.0, 4.0)])),
        "slack": float(rng.choice([0.0, 0.01])),
    }
