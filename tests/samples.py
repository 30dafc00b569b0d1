"""Scenarios drawn at random, of every kind that can be written down; a seed names each for good.

Many numbers are drawn from a few round ones, so that members, slacks and knees often coincide, as they do in real input.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ridedown.scenario import CrashScenario, NetworkScenario

Data = dict[str, Any]


def crash(seed: int, **changes: Any) -> CrashScenario:
    """A crash of one or two vehicles with up to three occupants; `changes` replace top-level keys."""
    return CrashScenario(**(crash_data(np.random.default_rng(seed)) | changes))


def two_vehicles(seed: int, **bar: Any) -> CrashScenario:
    """A crash of two vehicles; `bar` replaces keys of the bar."""
    rng = np.random.default_rng(seed)
    data = crash_data(rng, wall=False)
    data["bar"] |= bar
    return CrashScenario(**data)


def network(seed: int) -> NetworkScenario:
    """Up to four masses in a chain to the wall, with elements of every law beside it."""
    return NetworkScenario(**network_data(np.random.default_rng(seed)))


def crash_data(rng: np.random.Generator, *, wall: bool | None = None) -> Data:
    """What a crash is made of, in the shape of a scenario file."""
    if wall is None:
        wall = bool(rng.random() < 0.2)
    data: Data = {"duration": float(rng.choice([0.1, 0.2])), "vehicle1": vehicle(rng, least=5.0)}
    if not wall:
        alike = rng.random() < 0.3
        data["vehicle2"] = dict(data["vehicle1"]) if alike else vehicle(rng, least=0.0)
        data["bar"] = bar(rng)
    data["occupants"] = [occupant(rng, vehicles=1 if wall else 2) for _ in range(rng.integers(0, 4))]
    return data


def vehicle(rng: np.random.Generator, *, least: float) -> Data:
    """Speed is at least `least`; it stands still now and then if that is 0."""
    speed = float(rng.choice([13.33, rng.uniform(max(least, 3.0), 25.0), least]))
    front: Data = {"members": member(rng)}
    if rng.random() < 0.4:
        front = {"right": member(rng), "left": member(rng)}
    return {"mass": float(rng.choice([1500.0, rng.uniform(700.0, 3000.0)])), "speed": speed, **front}


def member(rng: np.random.Generator) -> Data:
    """A curve of pieces or points; flat, stiffening or softening; elastic or plastic."""
    found: Data
    if rng.random() < 0.3:
        deflections = np.concatenate([[0.0], np.cumsum(rng.uniform(0.05, 0.2, 4))])
        forces = rng.uniform(10e3, 300e3, 5)
        forces[0] = rng.choice([0.0, 15e3])
        found = {"points": [[float(d), float(f)] for d, f in zip(deflections, forces, strict=True)]}
    else:
        found = {
            "initial_force": float(rng.choice([0.0, 0.0, 20e3])),
            "pieces": [
                {"stiffness": float(rng.choice([118.2e3, 10 ** rng.uniform(4.5, 6.0), 0.0])), "until": 0.3},
                {"stiffness": float(10 ** rng.uniform(5.0, 6.0)), "until": float(rng.choice([0.5, 0.4]))},
                {"stiffness": float(10 ** rng.uniform(4.5, 6.0))},
            ][rng.integers(0, 3) :],
        }
        if "until" not in found["pieces"][0] and rng.random() < 0.5:
            found["initial_force"] = 0.0
    if rng.random() < 0.5:
        steepest = stiffest(found)  # as stiff as that, the line runs along the steepest piece
        found |= {"unloading": "plastic", "unloading_stiffness": float(rng.choice([steepest, steepest + 5e6, 2e7]))}
    return found


def stiffest(member: Data) -> float:
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
    turning = rng.random() < 0.7
    if turning:
        found |= {"inertia": float(rng.choice([157.0, rng.uniform(60.0, 300.0)]))}
        found |= {"lateral_offset": float(rng.choice([0.0, 0.3, 0.6]))}
    if rng.random() < 0.3:
        found["speed"] = 0.0
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


def network_data(rng: np.random.Generator) -> Data:
    """What a network is made of, in the shape of a scenario file."""
    count = int(rng.integers(1, 5))
    names = [f"m{i}" for i in range(1, count + 1)]
    speed = float(rng.uniform(3.0, 20.0))
    masses = [{"name": name, "mass": float(10 ** rng.uniform(1.0, 3.2)), "speed": speed} for name in names]
    pairs = list(zip(["wall", *names], names, strict=False))
    for _ in range(rng.integers(0, 3)):
        pairs.append(("wall", str(rng.choice(names))))
    return {"duration": 0.1, "masses": masses, "elements": [element(rng, pair) for pair in pairs]}


def element(rng: np.random.Generator, between: tuple[str, str]) -> Data:
    """A curve or a tie between two bodies."""
    if rng.random() < 0.4:
        return {"between": between, "law": "curve", **member(rng)}
    return {
        "between": between,
        "law": str(rng.choice(["linear", "kelvin-voigt", "threshold"])),
        "stiffness": float(10 ** rng.uniform(3.5, 5.5)),
        "damping": float(rng.choice([0.0, 10 ** rng.uniform(2.0, 4.0)])),
        "slack": float(rng.choice([0.0, 0.01])),
    }
