"""The front structure of a vehicle from a wall test, as a scenario that reproduces the test.

One mass follows what the cabin does. But the wall feels the engine stop, and the cabin does not: where the wall's force was
measured too, a second mass, the engine, lets one front follow both, and its mass is found with it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ridedown import __version__
from ridedown.criteria import STANDARD_GRAVITY, Rating, rating
from ridedown.criteria.checks import Floats
from ridedown.errors import InvalidInput, SimulationStopped
from ridedown.response import Response
from ridedown.scenario import CrashScenario, NetworkScenario, dump
from ridedown.scenario.member import ForceDeflection
from ridedown.scenario.model import Source
from ridedown.scenario.networks import Crush
from ridedown.signals.record import TestRecord
from ridedown.studies.extraction import fit
from ridedown.studies.extraction.measured import Momentum, WallTest, wall_test
from ridedown.studies.extraction.model import Form, unloading_curve

STEPS = fit.STEPS + 2
"""Of progress, about."""

CRUSH_NEAR, TIME_NEAR, REBOUND_NEAR = 0.02, 0.003, 0.10
"""How near a front must come for no warning: crush [1], its time [s], rebound speed [1]."""

_DIGITS = 5
_CLOSE = 0.02  # part of the reached deflection
_LONGEST_RATED = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class Front:
    """A front found, and what it reached against the test it was found from. SI.

    crush, stop (its time), rebound: of the response. cabin, barrier: ratings by ISO/TS 18571 of the cabin's acceleration and
    of the force on the wall, None where that was not measured. engine_mass, and engine_range, the least and the largest of
    those fronts from other starts that do about as well: None for one mass.
    """

    scenario: CrashScenario | NetworkScenario
    simulated: fit.Simulated
    cabin: Rating
    barrier: Rating | None
    engine_mass: float | None
    engine_range: tuple[float, float] | None = None

    @property
    def response(self) -> Response:
        """The simulated test."""
        return self.simulated.response

    @property
    def curves(self) -> dict[str, ForceDeflection]:
        """Its curves by name; for one mass that of both members together."""
        if isinstance(self.scenario, CrashScenario):
            member = self.scenario.vehicle1.right
            points = [(d, 2.0 * f) for d, f in member.points or ()]
            whole = unloading_curve(points, 2.0 * float(member.unloading_stiffness or 0.0))
            return {"front": ForceDeflection.model_validate(whole)}
        return {element.name: element for element in self.scenario.elements if isinstance(element, Crush)}


@dataclass(frozen=True, slots=True, eq=False)
class Extraction:
    """What was extracted from a wall test.

    test: what the record told. one: the front of one mass. two: that of cabin and engine, None where the wall's force is not
    there. warnings: sentences on what makes the result doubtful.
    """

    test: WallTest
    one: Front
    two: Front | None
    warnings: tuple[str, ...]

    @property
    def best(self) -> Front:
        """The front of two masses, or the one of one mass where there is no other."""
        return self.one if self.two is None else self.two

    @property
    def momentum(self) -> Momentum | None:
        """The wall's impulse beside the loss of momentum: whether the data are consistent."""
        return self.test.momentum

    @property
    def toml(self) -> str:
        """The best front as a scenario file, with what it reached in comments."""
        lines = [f"# {line}" for line in (*reached(self), *(f"Warning: {text}" for text in self.warnings))]
        return "\n".join(" ".join(line.split()) for line in lines) + "\n\n" + dump(self.best.scenario)

    def as_json(self) -> dict[str, Any]:
        """Everything but the curves over time, as plain data for JSON; SI."""
        test = self.test
        return {
            "test": {"identifier": test.identifier, "title": test.title},
            "mass": test.mass,
            "speed": test.speed,
            "channels": list(test.used),
            "measured": {
                "crush": test.crush,
                "time_of_crush": test.stop,
                "rebound_speed": test.rebound,
                "restitution": None if test.rebound is None else test.rebound / test.speed,
                "peak_acceleration": -test.peak,
            },
            "momentum": None if self.momentum is None else _momentum(self.momentum),
            "one_mass": _front(self.one, test),
            "two_masses": None if self.two is None else _front(self.two, test),
            "notes": list(test.notes),
            "warnings": list(self.warnings),
            "scenario": self.toml,
        }


def extract(
    record: TestRecord,
    *,
    mass: float | None = None,
    speed: float | None = None,
    channels: Sequence[str | int] = (),
    engine: Sequence[str | int] | None = None,
    barrier: TestRecord | None = None,
    masses: int | None = None,
    pieces: int = fit.MOST,
    seed: int | np.random.Generator | None = 0,
    advance: Callable[[str], None] = lambda _: None,
) -> Extraction:
    """Find the front structure that reproduces a wall test: force against deflection, unloading, and the engine's mass.

    mass [kg], speed [m/s]: of the vehicle; the header's if left out. channels: the cabin's accelerations along x, averaged; if
    left out, the mean of the two that agree best in velocity. engine: the engine's; those that the record names so if None,
    none at all if empty. barrier: a record with the force on the wall, if it is not among the test's own channels. masses: 1
    or 2; two where the wall's force is known, if left out. pieces: of a curve, at most. seed: of the starts; the same one finds
    the same front. advance: called with a word at each step.

    Raises: InvalidInput for a test that is none of one vehicle against a fixed rigid wall, a record that ends before
    standstill, a missing mass, speed or channel, and for two masses without the wall's force. SimulationStopped, should the
    front found not be one that can be simulated.

    >>> import numpy as np
    >>> from ridedown.signals import TestRecord, TimeHistory
    >>> time = np.arange(-500, 1500) * 1e-4
    >>> pulse = np.where(time > 0, -250 * np.sin(np.pi * time / 0.1), 0) * (time < 0.1)
    >>> record = TestRecord.of([TimeHistory(pulse, "m/s2", start=-0.05, interval=1e-4, name="cabin")], identifier="half sine")
    >>> found = extract(record, mass=1500, speed=14.0, channels=["cabin"])
    >>> abs(found.one.simulated.crush / found.test.crush - 1) < 0.01, found.two is None
    (True, True)
    """
    if masses not in {None, 1, 2}:
        raise InvalidInput(f"masses: got {masses}; need 1 or 2. Leave it out for two where the wall's force is known.")
    if isinstance(pieces, bool) or not 1 <= pieces <= 20:
        raise InvalidInput(f"pieces: got {pieces}; need 1 .. 20. A few follow a test well; {fit.MOST} is the default.")
    if isinstance(seed, int) and (isinstance(seed, bool) or seed < 0):
        raise InvalidInput(f"seed: got {seed}; need a whole number of 0 or more.")
    test = wall_test(record, mass=mass, speed=speed, channels=channels, engine=engine, barrier=barrier)
    if masses == 2 and test.barrier is None:
        why = "; ".join(text for text in (*test.warnings, *test.notes) if "barrier" in text)
        raise InvalidInput(
            f"masses: got 2 without the force on the wall{f' ({why})' if why else ''}; need it to tell the engine from the "
            "cabin. Give it with --barrier, or extract one mass."
        )
    one = _found(test, *fit.fit_one_mass(test, most=pieces))
    advance("one mass")
    two = None
    if test.barrier is not None and masses != 1:
        rng = np.random.default_rng(seed)
        form, numbers, engines = fit.fit_two_masses(test, most=pieces, rng=rng, advance=advance)
        two = replace(_found(test, form, numbers), engine_range=engines)
    best = one if two is None else two
    return Extraction(test, one, two, (*test.warnings, *_shortcomings(best, test)))


def _found(test: WallTest, form: Form, numbers: Floats) -> Front:
    """The front as a scenario of few digits and no more points than the test reached, and what that scenario reaches."""
    whole = form.scenario(numbers, digits=_DIGITS)
    of_whole = _simulated(test, whole)
    cut = _reached_only(whole, of_whole.response)
    changed = float(np.abs(_simulated(test, cut).acceleration - of_whole.acceleration).max())
    scenario = _described(cut if changed < _CLOSE * test.peak else whole, test)
    simulated = _simulated(test, scenario)
    since = test.time >= -1e-9
    end = min(test.end, _LONGEST_RATED)
    time = np.maximum(test.time[since], 0.0)
    cabin = rating((time, test.acceleration[since]), (time, simulated.acceleration[since]), start=0.0, end=end)
    wall = None
    if test.barrier is not None:
        wall = rating((time, test.barrier[since]), (time, simulated.barrier[since]), start=0.0, end=end)
    engine = None
    if isinstance(scenario, NetworkScenario):
        engine = float(next(body.mass for body in scenario.masses if body.name == "engine"))
    return Front(scenario, simulated, cabin, wall, engine)


def _simulated(test: WallTest, scenario: CrashScenario | NetworkScenario) -> fit.Simulated:
    found = fit.simulated(test, scenario)
    if found is None:
        from ridedown.simulation import simulate  # noqa: PLC0415  to say why

        stopped = simulate(scenario, throw=False)
        raise SimulationStopped(f"the front found stops at {1e3 * stopped.end_time:.3f} ms: {stopped.status.sentence}", stopped)
    return found


def _reached_only(scenario: CrashScenario | NetworkScenario, response: Response) -> CrashScenario | NetworkScenario:
    """The scenario without the points that the test did not reach: of what lies beyond it tells nothing."""
    if isinstance(scenario, CrashScenario):
        cut = _cut(scenario.vehicle1.right, response.maximum("vehicle1.right.deflection").value)
        vehicle = {"mass": scenario.vehicle1.mass, "speed": scenario.vehicle1.speed, "members": cut}
        return CrashScenario.model_validate({"duration": scenario.duration, "vehicle1": vehicle})
    elements: list[dict[str, Any]] = []
    for element in scenario.elements:
        if not isinstance(element, Crush):
            elements.append(element.model_dump())
            continue
        cut = _cut(element, response.maximum(f"{element.name}.deflection").value)
        if any(force > 0.0 for _, force in cut["points"]):
            elements.append({"name": element.name, "between": element.between, "law": "curve", **cut})
    masses = [body.model_dump() for body in scenario.masses]
    return NetworkScenario.model_validate({"duration": scenario.duration, "masses": masses, "elements": elements})


def _cut(curve: ForceDeflection, reach: float) -> dict[str, Any]:
    points = curve.points or ()
    deflections, forces = np.array(points).T
    reach = float(f"{max(reach, 1e-3):.{_DIGITS}g}")
    kept = list(points)
    if reach < deflections[-1]:
        # a point just before the last one says nothing, unless it ends the gap
        kept = [(d, f) for d, f in points if d < reach and (f == 0.0 or d == 0.0 or d < (1.0 - _CLOSE) * reach)]
        kept.append((reach, float(f"{np.interp(reach, deflections, forces):.{_DIGITS}g}")))
    if len(kept) < 2:
        kept = [*points[:2]]
    return unloading_curve([(float(d), float(f)) for d, f in kept], float(curve.unloading_stiffness or 0.0))


def _described(scenario: CrashScenario | NetworkScenario, test: WallTest) -> CrashScenario | NetworkScenario:
    """The scenario with its name, what it is, and the test as its source."""
    title = " ".join(test.title.split()) or "A wall test"
    kind = "one mass" if isinstance(scenario, CrashScenario) else "cabin and engine"
    channels = ", ".join(test.used)
    source = Source(
        title=title,
        authors=test.laboratory,
        year=test.year,
        where=f"test {test.identifier}, channels {channels}",
        confidence="reconstructed",
        note=f"structure found by least squares with ridedown {__version__}; "
        f"mass {test.mass:.6g} kg, {3.6 * test.speed:.4g} km/h",
    )
    return scenario.model_copy(
        update={
            "name": f"{test.identifier} front, {kind}",
            "description": f"Front structure extracted from the wall test {test.identifier} ({title}), {kind}. "
            "Curves hold up to the deflection that the test reached; beyond it the force is kept.",
            "sources": (source,),
        }
    )


def _shortcomings(front: Front, test: WallTest) -> list[str]:
    """Sentences on what the front does not reach."""
    found, said = front.simulated, []
    if abs(found.crush / test.crush - 1.0) > CRUSH_NEAR:
        said.append(f"crush {1e3 * found.crush:.0f} mm instead of {1e3 * test.crush:.0f} mm")
    if abs(found.stop - test.stop) > TIME_NEAR:
        said.append(f"crush at {1e3 * found.stop:.1f} ms instead of {1e3 * test.stop:.1f} ms")
    if test.rebound is not None and abs(found.rebound - test.rebound) > max(REBOUND_NEAR * test.rebound, 0.02 * test.speed):
        said.append(f"rebound {3.6 * found.rebound:.1f} km/h instead of {3.6 * test.rebound:.1f} km/h")
    if front.engine_mass is not None and test.engine is None:
        said.append("no engine channel to use: the engine's mass follows from the wall and the cabin alone, and is less sure")
    for what, rated in (("cabin's acceleration", front.cabin), ("wall's force", front.barrier)):
        if rated is not None and rated.value < 0.8 and (front.engine_mass is not None or what.startswith("cabin")):
            said.append(f"the {what} is followed with a rating of {rated.value:.2f} only ({rated.grade})")
    return said


def reached(found: Extraction) -> tuple[str, ...]:
    """What the best front reached, in sentences."""
    test, front = found.test, found.best
    model = front.simulated
    back = "not recorded" if test.rebound is None else f"{3.6 * test.rebound:.1f} km/h"
    rated = f"cabin acceleration {front.cabin.value:.3f}"
    if front.barrier is not None:
        rated += f", force on the wall {front.barrier.value:.3f}"
    lines = [
        (
            f"Crush {1e3 * model.crush:.1f} mm at {1e3 * model.stop:.1f} ms (measured {1e3 * test.crush:.1f} mm at "
            f"{1e3 * test.stop:.1f} ms), rebound {3.6 * model.rebound:.1f} km/h (measured {back})."
        ),
        f"Rating by ISO/TS 18571, 0 to {1e3 * min(test.end, _LONGEST_RATED):.0f} ms: {rated}.",
    ]
    one = found.one
    if found.two is not None and one.barrier is not None:
        lines.append(f"One mass reaches: cabin acceleration {one.cabin.value:.3f}, force on the wall {one.barrier.value:.3f}.")
    if front.engine_mass is not None:
        least, most = front.engine_range or (front.engine_mass, front.engine_mass)
        lines.append(
            f"Engine, with what moves with it: {front.engine_mass:.0f} kg of {test.mass:.0f} kg "
            f"({least:.0f} to {most:.0f} kg do about as well, from this seed's starts; others may go further)."
        )
    if found.momentum is not None:
        lines.append(momentum_sentence(found.momentum))
    return tuple(lines)


def momentum_sentence(balance: Momentum) -> str:
    """Whether the wall's force and the car's motion belong together."""
    stop, back = balance.stop, balance.rebound
    return (
        f"Impulse of the wall beside the loss of momentum: {stop[0]:.0f} to {stop[1]:.0f} N s up to standstill, ratio "
        f"{balance.ratio:.3f}; {back[0]:.0f} to {back[1]:.0f} N s up to the fastest rebound, ratio {balance.rebound_ratio:.3f}."
    )


def _momentum(balance: Momentum) -> dict[str, float]:
    return {
        "impulse_to_standstill": balance.stop[0],
        "momentum_lost_to_standstill": balance.stop[1],
        "ratio": balance.ratio,
        "impulse_to_rebound": balance.rebound[0],
        "momentum_lost_to_rebound": balance.rebound[1],
        "rebound_ratio": balance.rebound_ratio,
        "rebound_time": balance.rebound_time,
        "implied_mass": balance.implied_mass,
    }


def _front(front: Front, test: WallTest) -> dict[str, Any]:
    model = front.simulated
    return {
        "crush": model.crush,
        "crush_error": model.crush / test.crush - 1.0,
        "time_of_crush": model.stop,
        "time_error": model.stop - test.stop,
        "rebound_speed": model.rebound,
        "rebound_error": None if not test.rebound else model.rebound / test.rebound - 1.0,
        "restitution": model.rebound / test.speed,
        "peak_acceleration": float(model.acceleration.min()),
        "peak_acceleration_g": float(model.acceleration.min()) / STANDARD_GRAVITY,
        "cabin_rating": front.cabin.value,
        "barrier_rating": None if front.barrier is None else front.barrier.value,
        "engine_mass": front.engine_mass,
        "engine_mass_range": None if front.engine_range is None else list(front.engine_range),
        "curves": {
            name: {"points": [list(point) for point in curve.points or ()], "unloading_stiffness": curve.unloading_stiffness}
            for name, curve in front.curves.items()
        },
    }
