"""Generic pulses: how the vehicle of a sled is braked, by shapes with a name.

A named shape is given by magnitudes: its peak and its change of velocity are positive and brake the car. Points, and measured
channels, have the signs of SAE J211: a braking car's acceleration is negative.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from typing import Literal

import numpy as np
from pydantic import Field

from ridedown import network
from ridedown.scenario import pulse_shapes as shapes
from ridedown.scenario.base import Check, Model
from ridedown.scenario.quantities import (
    Distance,
    Duration,
    Number,
    Part,
    PeakDeceleration,
    Truth,
    VelocityChange,
    read,
)
from ridedown.units import ACCELERATION

FMVSS_208_PEAK = read("17.2 g", ACCELERATION)  # m/s2, FMVSS 208 S13
FMVSS_208_DURATION = 0.125  # s


class BasePulse(Model):
    """What all pulses tell of themselves."""

    @abstractmethod
    def change(self) -> Number | None:
        """The speed that the pulse takes from the vehicle, or that its source says it had [m/s]; None if not known."""

    @abstractmethod
    def end(self) -> Number:
        """When the pulse is over [s]."""

    def whole(self) -> float | None:
        """How long there is anything to simulate [s], for a pulse that was recorded; None for others."""
        return None


class OwnPulse(BasePulse):
    """A pulse that says itself what the acceleration is, with no other scenario to be solved for it."""

    @abstractmethod
    def lowered(self) -> network.Pulse:
        """The acceleration as the network takes it."""


class TwoOfThree(OwnPulse):
    """A shape with any two of change of velocity, duration and peak. The third follows."""

    delta_v: VelocityChange | None = Field(None, description="change of velocity, a magnitude")
    duration: Duration | None = Field(None, description="from the first to the last acceleration")
    peak: PeakDeceleration | None = Field(None, description="largest deceleration, a magnitude")

    @abstractmethod
    def mean(self) -> float:
        """Mean deceleration over the duration, in parts of the peak."""

    @abstractmethod
    def shape(self) -> shapes.Shape:
        """The shape, of duration 1 and peak 1."""

    def numbers(self) -> tuple[Number, Number, Number]:
        """Change of velocity [m/s], duration [s] and peak [m/s2]: the two that are given, and the third."""
        change, length, peak, mean = self.delta_v, self.duration, self.peak, self.mean()
        if length is None:
            assert change is not None
            assert peak is not None
            return change, change / (mean * peak), peak
        if peak is None:
            assert change is not None
            return change, length, change / (mean * length)
        return mean * peak * length, length, peak

    def lowered(self) -> network.Pulse:
        """The acceleration as the network takes it."""
        _, length, peak = self.numbers()
        return network.Pulse(*self.shape(), amplitude=-peak, length=length)

    def change(self) -> Number:
        """The change of velocity [m/s]."""
        return self.numbers()[0]

    def end(self) -> Number:
        """When the pulse is over [s]."""
        return self.numbers()[1]

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        names = ("delta_v", "duration", "peak")
        given = [name for name in names if getattr(self, name) is not None]
        missing = next((name for name in names if name not in given), "peak")
        two = "two of delta_v, duration and peak"
        yield Check("peak", len(given) < 3, "all of delta_v, duration and peak", two, "The third follows: take one out.")
        shown = "nothing" if not given else f"nothing beside {given[0]}"
        yield Check(missing, len(given) >= 2, shown, two, "Add one.")


class SimplePulse(TwoOfThree):
    """A shape that two numbers say everything of."""

    kind: Literal["half-sine", "haversine", "square"] = Field(description="the shape")

    def mean(self) -> float:
        """Mean deceleration, in parts of the peak."""
        return {"half-sine": 2.0 / np.pi, "haversine": 0.5, "square": 1.0}[self.kind]

    def shape(self) -> shapes.Shape:
        """The shape, of duration 1 and peak 1."""
        return {"half-sine": shapes.half_sine, "haversine": shapes.haversine, "square": shapes.square}[self.kind]()


class TrianglePulse(TwoOfThree):
    """Straight up to the peak and straight down."""

    kind: Literal["triangle"]
    peak_at: Part = Field(0.5, description="where the peak lies, as a part of the duration")

    def mean(self) -> float:
        """Mean deceleration, in parts of the peak."""
        return 0.5

    def shape(self) -> shapes.Shape:
        """The shape, of duration 1 and peak 1."""
        return shapes.triangle(one_of(self.peak_at))

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        yield from super().checks()
        yield same_in_all("peak_at", self.peak_at)


class TrapezoidPulse(TwoOfThree):
    """Straight up, constant, straight down."""

    kind: Literal["trapezoid"]
    rise: Part = Field(description="how long it rises, as a part of the duration")
    fall: Part = Field(description="how long it falls, as a part of the duration")

    def mean(self) -> float:
        """Mean deceleration, in parts of the peak."""
        return 1.0 - 0.5 * (one_of(self.rise) + one_of(self.fall))

    def shape(self) -> shapes.Shape:
        """The shape, of duration 1 and peak 1."""
        return shapes.trapezoid(one_of(self.rise), one_of(self.fall))

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        yield from super().checks()
        yield same_in_all("rise", self.rise)
        yield same_in_all("fall", self.fall)
        # two parts such as 0.9 and 0.1 may round to a little more than 1
        whole = self.rise + self.fall
        fix = "They are parts of the duration."
        yield Check("fall", whole <= 1.0 + 1e-12, f"{one_of(whole):.12g} together with the rise", "at most 1 together", fix)


class EquivalentSquareWave(OwnPulse):
    """The constant deceleration that stops a speed within a crush: `speed^2 / (2 crush)`."""

    kind: Literal["equivalent-square-wave"]
    speed: VelocityChange = Field(description="speed that is taken away")
    crush: Distance = Field(description="way to standstill")

    def lowered(self) -> network.Pulse:
        """The acceleration as the network takes it."""
        return network.Pulse(*shapes.square(), amplitude=-(self.speed**2) / (2.0 * self.crush), length=self.end())

    def change(self) -> Number:
        """The change of velocity [m/s]."""
        return self.speed

    def end(self) -> Number:
        """When the pulse is over [s]."""
        end: Number = 2.0 * self.crush / self.speed
        return end


class TippedEquivalentSquareWave(OwnPulse):
    """The deceleration, straight from A0 to A1, that stops a speed within a crush at a time.

    With `r = crush / (speed time)`: `A0 = (2 speed / time)(2 - 3 r)`, `A1 = (2 speed / time)(3 r - 1)`.
    """

    kind: Literal["tipped-equivalent-square-wave"]
    speed: VelocityChange = Field(description="speed that is taken away")
    crush: Distance = Field(description="way to standstill")
    time: Duration = Field(description="time to standstill")

    def lowered(self) -> network.Pulse:
        """The acceleration as the network takes it."""
        ratio = one_of(self._ratio())
        shape = shapes.ramp(2.0 - 3.0 * ratio, 3.0 * ratio - 1.0)
        return network.Pulse(*shape, amplitude=-2.0 * self.speed / self.time, length=self.time)

    def change(self) -> Number:
        """The change of velocity [m/s]."""
        return self.speed

    def end(self) -> Number:
        """When the pulse is over [s]."""
        return self.time

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        ratio = self._ratio()
        yield Check(
            "crush",
            (ratio >= 1.0 / 3.0) & (ratio <= 2.0 / 3.0),
            self.crush,
            "between 1/3 and 2/3 of speed times time",
            "Elsewhere the pulse would speed the car up at its beginning or its end, and standstill would not be at that time.",
            "m",
        )
        yield Check(
            "crush",
            np.abs(ratio - one_of(ratio)) <= 1e-12,
            self.crush,
            "crush / (speed time) the same in every row",
            "That ratio is the shape of the pulse, which all rows share; change two of the three together.",
            "m",
        )

    def _ratio(self) -> Number:
        return self.crush / (self.speed * self.time)


class FmvssPulse(OwnPulse):
    """The sled pulse of FMVSS 208 S13: a half-sine of 17.2 g and 125 ms, 48.3 km/h."""

    kind: Literal["fmvss-208-sled"]

    def lowered(self) -> network.Pulse:
        """The acceleration as the network takes it."""
        return network.Pulse(*shapes.half_sine(), amplitude=-FMVSS_208_PEAK, length=FMVSS_208_DURATION)

    def change(self) -> Number:
        """The change of velocity [m/s]."""
        return 2.0 / np.pi * FMVSS_208_PEAK * FMVSS_208_DURATION

    def end(self) -> Number:
        """When the pulse is over [s]."""
        return FMVSS_208_DURATION


def brakes(field: str, gone: float) -> Check:
    """The rule that a pulse takes speed from the vehicle: `gone` [m/s]."""
    return Check(
        field,
        gone > 0.0,
        f"a pulse that speeds the car up by {-gone:.3g} m/s" if gone < 0.0 else "a pulse that leaves the speed as it is",
        "one that brakes it",
        "A braking car has negative acceleration (SAE J211): turn the signs round.",
    )


def one_of(value: Number) -> float:
    """The value; of a column whose values are all the same, the first, and of none NaN."""
    values = np.ravel(value)
    return float(values[0]) if values.size else np.nan


def same_in_all(field: str, value: Number) -> Check:
    """The rule that a number which makes the shape of a pulse is the same in every row."""
    alike: Truth = True if not isinstance(value, np.ndarray) else value == value[:1]
    fix = (
        "It makes the shape of the pulse, which all rows share; vary delta_v, duration or peak, or take one scenario for each."
    )
    return Check(field, alike, value, "the same value in every row", fix)
