"""Wall tests made by ridedown itself from fronts that are known, as a laboratory would record them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ridedown.errors import InvalidInput
from ridedown.response import Response
from ridedown.scenario import CrashScenario, NetworkScenario
from ridedown.signals.history import TimeHistory
from ridedown.signals.record import Barrier, ChannelInfo, TestRecord, Vehicle
from ridedown.simulation import simulate

SPEED, MASS, ENGINE = 15.0, 1500.0, 300.0
TIME = np.arange(-500, 2500) * 1e-4


def one_mass(speed: float = SPEED) -> CrashScenario:
    """A car of one mass whose front stiffens and springs back with a seventh of its speed."""
    members = {
        "points": [[0.0, 20e3], [0.2, 90e3], [0.45, 110e3], [0.7, 240e3]],
        "unloading": "plastic",
        "unloading_stiffness": 6e6,
    }
    return CrashScenario(duration=0.25, vehicle1={"mass": MASS, "speed": speed, "members": members})


def two_masses() -> NetworkScenario:
    """A car whose engine, 300 of 1500 kg, meets the wall after 0.3 m and the firewall 0.15 m later."""

    def curve(name: str, between: tuple[str, str], points: list[list[float]], unloading: float) -> dict[str, Any]:
        plastic = {"unloading": "plastic", "unloading_stiffness": unloading}
        return {"name": name, "between": between, "law": "curve", "points": points, **plastic}

    return NetworkScenario(
        duration=0.25,
        masses=[
            {"name": "cabin", "mass": MASS - ENGINE, "speed": SPEED},
            {"name": "engine", "mass": ENGINE, "speed": SPEED},
        ],
        elements=[
            curve("rails", ("wall", "cabin"), [[0.0, 30e3], [0.15, 220e3], [0.7, 280e3]], 15e6),
            curve("block", ("wall", "engine"), [[0.0, 0.0], [0.3, 0.0], [0.45, 500e3]], 15e6),
            curve("firewall", ("engine", "cabin"), [[0.0, 0.0], [0.15, 0.0], [0.4, 300e3]], 8e6),
            {"name": "mounts", "between": ("engine", "cabin"), "law": "linear", "stiffness": 80e3, "damping": 6e3},
        ],
    )


def record(
    scenario: CrashScenario | NetworkScenario,
    *,
    noise: float = 0.0,
    seed: int = 0,
    barrier: bool = True,
    until: float = 0.25,
    header: Mapping[str, Any] | None = None,
) -> TestRecord:
    """The channels of a simulated wall test: two of the cabin, two of the engine if there is one, the wall's force.

    noise: standard deviation of white noise, as a part of each channel's peak, before any filter. until: where the record ends.
    """
    response = simulate(scenario)
    rng = np.random.default_rng(seed)
    body = "vehicle1" if isinstance(scenario, CrashScenario) else "cabin"
    acceleration = on_clock(response, f"{body}.acceleration", until) / 9.80665
    channels = [(f"seat_crossmember_{side}", "acceleration", "g", acceleration) for side in ("left", "right")]
    if body == "cabin":
        engine = on_clock(response, "engine.acceleration", until) / 9.80665
        channels += [(f"engine_{end}", "acceleration", "g", engine) for end in ("top", "bottom")]
    if barrier:
        walls = ("vehicle1.right", "vehicle1.left") if body == "vehicle1" else ("rails", "block")
        force = -np.sum([on_clock(response, f"{name}.force", until) for name in walls], axis=0)
        channels.append(("barrier", "force", "N", force))
    infos, curves = {}, {}
    for number, (place, quantity, unit, values) in enumerate(channels, 1):
        key = str(number)
        noisy = values + noise * np.abs(values).max() * rng.standard_normal(values.size)
        infos[key] = ChannelInfo(
            key, number, place, location=place, quantity=quantity, axis="x", unit=unit, vehicle=0 if place == "barrier" else 1
        )
        curves[key] = TimeHistory(noisy, unit, start=TIME[0], interval=1e-4, name=place)

    def load(info: ChannelInfo) -> TimeHistory:
        if info.key not in curves:
            raise InvalidInput(f"channel {info.key}: got no curve; need one.")
        return curves[info.key]

    given: dict[str, Any] = {
        "title": "a made wall test",
        "laboratory": "ridedown",
        "vehicles": (Vehicle(1, mass=MASS, speed=SPEED),),
        "barrier": Barrier(kind="R"),
        "channels": infos,
        "load": load,
    }
    return TestRecord("made", **{**given, **(header or {})})


def on_clock(response: Response, channel: str, until: float) -> np.ndarray:
    """A channel on the recorder's clock, 0 before the contact, up to a time."""
    time = TIME[: int(np.searchsorted(TIME, until + 1e-9))]
    values: np.ndarray = np.where(time >= 0.0, response.at(channel, np.clip(time, 0.0, response.end_time)), 0.0)
    return values
