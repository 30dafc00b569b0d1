"""Puts a network together, body by body and element by element."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from ridedown.network.model import (
    Curve,
    Floats,
    KelvinVoigt,
    Law,
    Linear,
    Network,
    Number,
    Pulse,
    Restraint,
    Threshold,
)

AnyLaw = Linear | KelvinVoigt | Threshold | Curve | Restraint

_LAW_OF = {Linear: Law.LINEAR, KelvinVoigt: Law.KELVIN_VOIGT, Threshold: Law.THRESHOLD}


class Builder:
    """Collects bodies and elements in absolute terms; `build` turns them into the solver's relative coordinates.

    >>> crash = Builder()
    >>> car = crash.body("car", mass=1500.0, speed=13.33)
    >>> crash.element("front", Curve((0.0,), (0.0,), (200e3,)), deflection={car: 1.0})
    >>> network = crash.build(duration=0.2)
    >>> network.coordinates, network.elements
    (('car',), ('front',))
    """

    def __init__(self) -> None:
        self._names: list[str] = []
        self._parent: list[int] = []
        self._is_rotation: list[bool] = []
        self._inertia: list[Number] = []
        self._speed: list[Number] = []
        self._conjugate = True
        self._elements: list[str] = []
        self._laws: list[AnyLaw] = []
        self._terms: list[dict[int, float]] = []
        self._reactions: list[dict[int, float]] = []
        self._lever: list[int] = []
        self._arm: list[Number] = []
        self._driven = -1
        self._pulse = Pulse(np.zeros(1), np.zeros((1, 1)))

    def body(self, name: str, *, mass: Number, speed: Number, parent: int | None = None) -> int:
        """Add a mass [kg] with its absolute initial speed [m/s]; give `parent` to count its displacement from that body."""
        return self._coordinate(name, mass, speed, -1 if parent is None else parent, rotation=False)

    def driven(self, name: str, pulse: Pulse, *, speed: Number) -> int:
        """Add the one body that follows a prescribed acceleration, with its initial speed [m/s]. Nothing moves it."""
        self._driven, self._pulse = len(self._names), pulse
        return self._coordinate(name, 0.0, speed, -1, rotation=False)

    def bar(self, name: str, *, inertia: Number, conjugate: bool) -> int:
        """Add the rotation of a bar, at rest, with its moment of inertia [kg m2] and lever arm law."""
        self._conjugate = conjugate
        return self._coordinate(name, inertia, 0.0, -1, rotation=True)

    def element(
        self,
        name: str,
        law: AnyLaw,
        *,
        deflection: Mapping[int, float],
        lever: tuple[int, Number] | None = None,
        acts_on: Iterable[int] | None = None,
    ) -> None:
        """Add a force element.

        `deflection` gives the sign with which each body's absolute displacement enters; `lever` adds `arm tan(theta)` of
        a bar. The force acts back on those bodies with the opposite sign; name fewer in `acts_on` to leave some unmoved
        (an occupant too light to matter to the car).
        """
        self._elements.append(name)
        self._laws.append(law)
        own: dict[int, float] = {}
        for body, sign in deflection.items():
            link = body
            while link >= 0:
                own[link] = own.get(link, 0.0) + sign
                link = self._parent[link]
        self._terms.append({body: sign for body, sign in own.items() if sign != 0.0})
        moved = set(deflection if acts_on is None else acts_on)
        moved.discard(self._driven)
        self._reactions.append({body: sign for body, sign in deflection.items() if body in moved})
        self._lever.append(-1 if lever is None else lever[0])
        self._arm.append(0.0 if lever is None else lever[1])

    def build(self, *, duration: Number) -> Network:
        """The network of all that was added."""
        pulse = self._pulse
        numbers = [*self._inertia, *self._speed, *self._arm, pulse.amplitude, pulse.length, duration]
        for law in self._laws:
            numbers += _numbers_of(law)
        size = max((x.size for x in numbers if isinstance(x, np.ndarray) and x.ndim), default=1)

        rates = [s if p < 0 else s - self._speed[p] for s, p in zip(self._speed, self._parent, strict=True)]
        curves = [law if isinstance(law, Curve | Restraint) else None for law in self._laws]
        restraints = [law if isinstance(law, Restraint) else _PLAIN for law in self._laws]
        timers = [(e, timer) for e, law in enumerate(restraints) for timer in law.timers]
        term_start, term_coordinate, term_sign = _csr(self._terms)
        reaction_start, reaction_coordinate, reaction_sign = _csr(self._reactions)
        return Network(
            coordinates=tuple(self._names),
            parent=np.array(self._parent, dtype=np.int64),
            is_rotation=np.array(self._is_rotation, dtype=np.bool_),
            conjugate=self._conjugate,
            elements=tuple(self._elements),
            law=np.array([_kind(law) for law in self._laws], dtype=np.int64),
            term_start=term_start,
            term_coordinate=term_coordinate,
            term_sign=term_sign,
            lever=np.array(self._lever, dtype=np.int64),
            reaction_start=reaction_start,
            reaction_coordinate=reaction_coordinate,
            reaction_sign=reaction_sign,
            piece_start=np.cumsum([0, *(len(c.knots) if c else 0 for c in curves)], dtype=np.int64),
            driven=self._driven,
            pulse_start=pulse.start,
            pulse_end=np.append(pulse.start[1:], np.inf),
            pulse_series=pulse.series,
            free=np.array([law.free for law in restraints], dtype=np.bool_),
            empty=np.array([law.empty for law in restraints], dtype=np.bool_),
            timer_element=np.array([e for e, _ in timers], dtype=np.int64),
            timer_action=np.array([timer.action for _, timer in timers], dtype=np.int64),
            inertia=_columns(self._inertia, size),
            rate=_columns(rates, size),
            arm=_columns(self._arm, size),
            stiffness=_columns([_stiffness(law) for law in self._laws], size),
            damping=_columns([0.0 if isinstance(law, Curve) else law.damping for law in self._laws], size),
            slack=_columns([0.0 if isinstance(law, Curve) else law.slack for law in self._laws], size),
            knot=_columns([x for c in curves if c for x in c.knots], size),
            force=_columns([x for c in curves if c for x in c.forces], size),
            slope=_columns([x for c in curves if c for x in c.slopes], size),
            limit=_pairs([law.limits for law in restraints], size),
            payout=_pairs([law.payouts for law in restraints], size),
            stall=_pairs([law.stalls for law in restraints], size),
            timer_time=_columns([timer.time for _, timer in timers], size),
            timer_value=_columns([timer.value for _, timer in timers], size),
            pulse_amplitude=_columns([pulse.amplitude], size)[0],
            pulse_length=_columns([pulse.length], size)[0],
            duration=_columns([duration], size)[0],
        )

    def _coordinate(self, name: str, inertia: Number, speed: Number, parent: int, *, rotation: bool) -> int:
        self._names.append(name)
        self._inertia.append(inertia)
        self._speed.append(speed)
        self._parent.append(parent)
        self._is_rotation.append(rotation)
        return len(self._names) - 1


_PLAIN = Restraint((), (), ())
"""Stands for a law that has neither reel nor fill."""


def _kind(law: AnyLaw) -> Law:
    if isinstance(law, Restraint):
        return Law.RESTRAINT
    if isinstance(law, Curve):
        return Law.ELASTIC if law.unloading is None else Law.PLASTIC
    return _LAW_OF[type(law)]


def _stiffness(law: AnyLaw) -> Number:
    if isinstance(law, Curve | Restraint):
        return 0.0 if law.unloading is None else law.unloading
    return law.stiffness


def _numbers_of(law: AnyLaw) -> list[Number]:
    if isinstance(law, Curve):
        return [*law.knots, *law.forces, *law.slopes, _stiffness(law)]
    if isinstance(law, Restraint):
        curve = [*law.knots, *law.forces, *law.slopes, _stiffness(law), law.slack, law.damping]
        timed = [number for timer in law.timers for number in (timer.time, timer.value)]
        return [*curve, *law.limits, *law.payouts, *law.stalls, *timed]
    return [law.stiffness, law.damping, law.slack]


def _columns(values: list[Number], size: int) -> Floats:
    """Shape (n, R). Where every row is one number, it stands once for all columns: they take no room."""
    if not any(isinstance(value, np.ndarray) for value in values):
        column = np.array(values, dtype=np.float64).reshape(len(values), 1)
        return column if size == 1 else np.broadcast_to(column, (len(values), size))
    columns = np.empty((len(values), size))
    for row, value in zip(columns, values, strict=True):
        row[:] = value
    return columns


def _pairs(values: list[tuple[Number, Number]], size: int) -> Floats:
    """Shape (2, e, R). They take no room either, where every row is one number."""
    return _columns([pair[n] for n in range(2) for pair in values], size).reshape(2, len(values), size)


def _csr(rows: list[dict[int, float]]) -> tuple[np.ndarray, np.ndarray, Floats]:
    start = np.cumsum([0, *(len(row) for row in rows)], dtype=np.int64)
    coordinates = np.array([body for row in rows for body in row], dtype=np.int64)
    signs = np.array([sign for row in rows for sign in row.values()], dtype=np.float64)
    return start, coordinates, signs
