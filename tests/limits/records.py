"""Test records built channel by channel."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ridedown.errors import InvalidInput
from ridedown.signals.history import TimeHistory
from ridedown.signals.record import ChannelInfo, Occupant, TestRecord, Vehicle

TIME = np.arange(-500, 2000) * 1e-4
G = 9.80665


def bell(peak: float, at: float = 0.07, width: float = 0.02) -> np.ndarray:
    """A smooth pulse that no channel class takes anything from."""
    pulse: np.ndarray = peak * np.exp(-(((TIME - at) / width) ** 2))
    return pulse


class Builder:
    """Collects channels; `record` makes the test."""

    def __init__(self) -> None:
        self.infos: dict[str, ChannelInfo] = {}
        self.histories: dict[str, TimeHistory] = {}

    def add(
        self, place: str, values: np.ndarray | None, unit: str, axis: str, quantity: str = "acceleration", **fields: object
    ) -> Builder:
        """One channel; None for one that has no curve. `fields` as of ChannelInfo; occupant 01 unless said otherwise."""
        key = str(len(self.infos) + 1)
        given = {"occupant": "01", "vehicle": 1, "name": f"{place} {axis}", "readable": values is not None} | fields
        self.infos[key] = ChannelInfo(key, location=place, quantity=quantity, axis=axis, unit=unit, **given)
        if values is not None:
            self.histories[key] = TimeHistory(values, unit, start=-0.05, interval=1e-4, name=f"{place} {axis}")
        return self

    def triple(self, place: str, peak_g: float) -> Builder:
        """Three axes whose resultant has this peak: 2/3, 1/3 and 2/3 of it."""
        for axis, share in zip("xyz", (-2 / 3, 1 / 3, 2 / 3), strict=True):
            self.add(place, bell(share * peak_g), "g", axis)
        return self

    def pulse(self, place: str, values: np.ndarray, **fields: object) -> Builder:
        """A vehicle's acceleration along x [g]."""
        return self.add(place, values, "g", "x", occupant=None, **fields)

    def record(self, dummy: tuple[str, str] | None = ("Hybrid III", "50"), speed: float | None = 15.0) -> TestRecord:
        """The test: one vehicle, one occupant in seat 01."""

        def load(info: ChannelInfo) -> TimeHistory:
            if info.key not in self.histories:
                raise InvalidInput(f"channel {info.key}: got no curve file; need one.")
            return self.histories[info.key]

        occupants: Iterable[Occupant] = () if dummy is None else (Occupant("01", 1, *dummy),)
        return TestRecord(
            "t1",
            title="a test",
            vehicles=(Vehicle(1, speed=speed),),
            occupants=tuple(occupants),
            channels=self.infos,
            load=load,
        )


def full() -> Builder:
    """A test with every channel that an adult is judged by, a pulse left and right, lateral, vertical and yaw."""
    b = Builder().triple("head", 60.0).triple("chest", 45.0)
    b.add("chest", bell(-30.0), "mm", "x", "displacement")
    b.add("neck_upper", bell(1000.0), "N", "z", "force").add("neck_upper", bell(500.0), "N", "x", "force")
    b.add("neck_upper", bell(-20.0), "N m", "y", "moment")
    b.add("femur_left", bell(-3000.0), "N", "z", "force").add("femur_right", bell(-9000.0), "N", "z", "force")
    for side in ("left", "right"):
        b.pulse(f"seat_crossmember_{side}", bell(-40.0, 0.08, 0.025))
    b.add("vehicle", bell(2.0), "g", "y", occupant=None).add("vehicle", bell(1.0), "g", "z", occupant=None)
    return b.add("vehicle", 0.0 * TIME, "rad/s", "z", "angular velocity", occupant=None)
