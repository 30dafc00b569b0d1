"""A front made to follow a wall test: a start read off the data, then least squares through the solver, piece by piece.

What is matched: the cabin's acceleration, the wall's force and the engine's velocity where known, each in the test's channel
class and as parts of its peak; and crush, its time and the rebound.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from ridedown.criteria.checks import Floats
from ridedown.response import Response
from ridedown.scenario import CrashScenario, NetworkScenario
from ridedown.signals.filters import filtered
from ridedown.signals.history import Filter, TimeHistory
from ridedown.limits.measured import SHAPE_CLASS
from ridedown.simulation import simulate
from ridedown.studies.extract_measured import ASSUMED_RESTITUTION, INTERVAL, WallTest
from ridedown.studies.extract_model import Form, Scale, one_mass, two_masses, within

FOLLOWED = 0.05
"""A curve has enough pieces when what it is read off, or has to follow, is met to this part of its peak, root mean square."""
GAIN = 0.04
"""Part of the misfit that one more piece has to take away to be worth having."""
MOST = 8
"""Pieces a curve has at most, unless told otherwise."""

_STRIDE = 5  # grid points from one that counts to the next: 0.5 ms, fine for class 60
_SIGNAL = 300.0  # weight of a whole channel: as many values as 150 ms have at that stride
_CRUSH, _TIME, _REBOUND = 0.01, 0.002, 0.06  # errors that weigh as one value that is off by its channel's peak
_ASSUMED = 3.0  # how many times as far an assumed rebound may be off
_ENGINE = 0.5  # weight of the engine's velocity: its sensors differ from each other as the engine turns
_STEP = 1e-4  # of differences, in numbers near 1
_FAILED = 10.0
_STARTS = 6
_TRIAL, _POLISH, _REFIT = 12, 40, 20  # evaluations of a start, of the best two of them, after a cut
_CUTS = 2  # places tried for one more piece

Advance = Callable[[str], None]


@dataclass(frozen=True, slots=True, eq=False)
class Simulated:
    """A response on the test's grid, filtered as the test is: the cabin's acceleration, the wall's force, engine velocity."""

    response: Response
    acceleration: Floats
    barrier: Floats
    engine: Floats | None
    crush: float
    stop: float
    rebound: float


def simulated(test: WallTest, scenario: CrashScenario | NetworkScenario) -> Simulated | None:
    """The scenario on the test's grid; None where it cannot be solved to its end."""
    response = simulate(scenario, throw=False)
    if not response.completed:
        return None
    since = test.time >= -0.5 * INTERVAL
    times = np.clip(test.time[since], 0.0, response.end_time)
    body = "vehicle1" if isinstance(scenario, CrashScenario) else "cabin"

    def on_grid(channel: str, before: Floats) -> Floats:
        return np.concatenate((before, response.at(channel, times)))

    free = test.time[~since]
    rest = np.zeros(free.size)
    wall = np.sum([on_grid(f"{element}.force", rest) for element in _at_the_wall(scenario)], axis=0)
    most, least = response.maximum(f"{body}.displacement"), response.minimum(f"{body}.velocity")
    speed = np.full(free.size, test.speed)
    return Simulated(
        response=response,
        acceleration=_in_class(on_grid(f"{body}.acceleration", rest)),
        barrier=_in_class(wall),
        engine=None if body == "vehicle1" else on_grid("engine.velocity", speed),
        crush=most.value,
        stop=most.time,
        rebound=max(0.0, -least.value),
    )


def _at_the_wall(scenario: CrashScenario | NetworkScenario) -> tuple[str, ...]:
    if isinstance(scenario, CrashScenario):
        return ("vehicle1.right", "vehicle1.left")
    return tuple(element.name for element in scenario.elements if "wall" in element.between)


def _in_class(values: Floats) -> Floats:
    return filtered(TimeHistory(values, "", interval=INTERVAL), SHAPE_CLASS).values


class Misfit:
    """How far a front is from the test, as a vector whose squares are summed."""

    def __init__(self, test: WallTest, *, with_barrier: bool) -> None:
        self.test = test
        since = np.flatnonzero(test.time >= -0.5 * INTERVAL)[::_STRIDE]
        self._counted = since
        self._weight = np.sqrt(_SIGNAL / since.size)
        self._barrier = test.barrier if with_barrier else None
        engine = test.engine if with_barrier else None
        self._engine = None if engine is None else since[np.isfinite(engine[since])]
        self.size = since.size * (1 if self._barrier is None else 2) + (0 if self._engine is None else self._engine.size) + 3

    def __call__(self, front: Form, numbers: Floats) -> Floats:
        """The misfit, (size,): channels first, then crush, time and rebound."""
        found = simulated(self.test, front.scenario(numbers))
        return np.full(self.size, _FAILED) if found is None else self.of(found)

    def of(self, found: Simulated) -> Floats:
        """The misfit of a response."""
        test, at = self.test, self._counted
        parts = [self._weight * (found.acceleration - test.acceleration)[at] / test.peak]
        if self._barrier is not None:
            parts.append(self._weight * (found.barrier - self._barrier)[at] / self._barrier.max())
        if self._engine is not None and found.engine is not None and test.engine is not None:
            parts.append(_ENGINE * self._weight * (found.engine - test.engine)[self._engine] / test.speed)
        rebound, loose = (test.rebound, 1.0) if test.rebound is not None else (ASSUMED_RESTITUTION * test.speed, _ASSUMED)
        targets = [
            (found.crush / test.crush - 1.0) / _CRUSH,
            (found.stop - test.stop) / _TIME,
            (found.rebound - rebound) / max(rebound, 0.02 * test.speed) / (_REBOUND * loose),
        ]
        return np.concatenate((*parts, targets))

    def rms(self, misfit: Floats) -> float:
        """Root mean square of the channels' part, as a part of their peaks [1]."""
        channels = misfit[: self._counted.size * (1 if self._barrier is None else 2)]
        return float(np.sqrt(np.mean((channels / self._weight) ** 2)))


def refined(misfit: Misfit, front: Form, numbers: Floats, evaluations: int) -> tuple[Floats, Floats, Floats]:
    """The numbers after least squares from these, the misfit there, and its derivatives (size, n)."""

    def value(x: Floats) -> Floats:
        return misfit(front, x)

    def derivatives(x: Floats) -> Floats:
        return _derivatives(misfit, front, x)

    found = least_squares(
        value, within(front, numbers), jac=derivatives, bounds=front.bounds(), max_nfev=evaluations, xtol=1e-5, ftol=1e-4
    )
    return found.x, found.fun, found.jac


def _derivatives(misfit: Misfit, front: Form, numbers: Floats) -> Floats:
    high = front.bounds()[1]
    base = misfit(front, numbers)
    columns = np.empty((base.size, numbers.size))
    for i in range(numbers.size):
        step = _STEP if numbers[i] + _STEP < high[i] else -_STEP
        moved = numbers.copy()
        moved[i] += step
        columns[:, i] = (misfit(front, moved) - base) / step
    return columns


# one mass


def scale_of(test: WallTest) -> Scale:
    """What a front's numbers are multiples of."""
    return Scale(test.mass, test.speed, test.mass * test.peak, test.crush, round(test.end, 6))


def measured_curve(test: WallTest) -> tuple[Floats, Floats]:
    """Mass times deceleration over the cabin's way from contact to standstill: deflections [m], forces [N], (n,) each."""
    loading = (test.time >= 0.0) & (test.time <= test.stop)
    deflections = np.concatenate((test.displacement[loading], [test.crush]))
    at_stop = float(np.interp(test.stop, test.time, test.acceleration))
    return deflections, -test.mass * np.concatenate((test.acceleration[loading], [at_stop]))


def pieces_of(deflections: Floats, forces: Floats, most: int) -> tuple[Floats, Floats]:
    """The fewest straight pieces that follow a curve to FOLLOWED of its peak, `most` at most: their points, from the first on.

    Each point is put where it helps most, and then each is moved once more.

    >>> x = np.linspace(0.0, 1.0, 101)
    >>> knots, forces = pieces_of(x, np.minimum(4.0 * x, 1.0), 8)
    >>> knots.round(2).tolist(), forces.round(1).tolist()
    ([0.0, 0.25, 1.0], [0.0, 1.0, 1.0])
    """
    grid = np.linspace(0.0, deflections[-1], 201)
    wanted = np.interp(grid, deflections, forces)
    inner: list[int] = []
    values, misfit = _hats(grid, wanted, inner)
    while misfit > FOLLOWED * float(np.abs(wanted).max()) and len(inner) + 1 < most:
        free = [k for k in range(4, grid.size - 4) if all(abs(k - other) >= 4 for other in inner)]
        if not free:
            break
        inner.append(min(free, key=lambda k: _hats(grid, wanted, [*inner, k])[1]))
        for i in range(len(inner)):
            others = inner[:i] + inner[i + 1 :]
            free = [k for k in range(4, grid.size - 4) if all(abs(k - other) >= 4 for other in others)]
            inner[i] = min(free, key=lambda k: _hats(grid, wanted, [*others, k])[1])
        values, misfit = _hats(grid, wanted, inner)
    return grid[[0, *sorted(inner), grid.size - 1]], np.maximum(values, 0.0)


def _hats(grid: Floats, wanted: Floats, inner: list[int]) -> tuple[Floats, float]:
    """The best forces at these points, straight between them, and the misfit, root mean square."""
    knots = grid[[0, *sorted(inner), grid.size - 1]]
    columns = np.stack([np.interp(grid, knots, unit) for unit in np.eye(knots.size)], axis=1)
    values = np.linalg.lstsq(columns, wanted, rcond=None)[0]
    return values, float(np.sqrt(np.mean((columns @ values - wanted) ** 2)))


def fit_one_mass(test: WallTest, *, most: int = MOST) -> tuple[Form, Floats]:
    """A front of one mass that follows the cabin."""
    scale = scale_of(test)
    deflections, forces = pieces_of(*measured_curve(test), most)
    rebound = test.rebound if test.rebound is not None else ASSUMED_RESTITUTION * test.speed
    # the energy that the rebound takes is that under the unloading line: F^2 / 2k = m v^2 / 2
    stiffness = max(forces[-1], 0.1 * scale.force) ** 2 / (test.mass * max(rebound, 0.02 * test.speed) ** 2)
    unloading = float(np.log10(stiffness * scale.length / scale.force))
    front, numbers = one_mass(scale, deflections / scale.length, forces / scale.force, unloading)
    misfit = Misfit(test, with_barrier=False)
    return front, refined(misfit, front, numbers, 2 * _POLISH)[0]


# two masses


def fit_two_masses(
    test: WallTest, *, most: int = MOST, rng: np.random.Generator, advance: Advance = lambda _: None
) -> tuple[Form, Floats]:
    """A front of cabin and engine that follows the cabin and the wall's force, for a test that has both."""
    misfit = Misfit(test, with_barrier=True)
    tried = []
    for front, numbers in _starts(test, most, rng):
        x, value, _ = refined(misfit, front, numbers, _TRIAL)
        tried.append((float(value @ value), front, x))
        advance("from several starts")
    tried.sort(key=lambda one: one[0])
    polished = []
    for _, front, x in tried[:2]:
        better, value, jacobian = refined(misfit, front, x, _POLISH)
        polished.append((float(value @ value), front, better, value, jacobian))
        advance("the best of them")
    _, front, x, value, jacobian = min(polished, key=lambda one: one[0])
    while misfit.rms(value) > FOLLOWED:
        tried = []
        for finer, start in _cuts(misfit, front, x, value, jacobian, most):
            better, new_value, new_jacobian = refined(misfit, finer, start, _REFIT)
            tried.append((float(new_value @ new_value), finer, better, new_value, new_jacobian))
            advance("one more piece")
        best = min(tried, key=lambda one: one[0], default=None)
        if best is None or best[0] > (1.0 - GAIN) ** 2 * float(value @ value):
            break
        _, front, x, value, jacobian = best
    return front, x


STEPS = _STARTS + 2 + 10
"""Of progress, about: starts, polishing, pieces added."""


def _starts(test: WallTest, most: int, rng: np.random.Generator) -> list[tuple[Form, Floats]]:
    """Fronts to begin with: the engine's mass and gap as the data have them, and varied."""
    assert test.barrier is not None
    scale = scale_of(test)
    share, gap = engine_guess(test)
    deflections, forces = measured_curve(test)
    pieces = min(3, most)
    at = np.interp(np.linspace(0.0, test.crush, pieces + 1), deflections, forces) / scale.force
    starts = []
    for i in range(_STARTS):
        vary = rng.uniform(-1.0, 1.0, 4) if i else np.zeros(4)
        rails = np.clip(at * rng.uniform(0.4, 1.0, at.size) if i else 0.6 * at, 0.02, 2.0)
        starts.append(
            two_masses(
                scale,
                share * (1.0 + 0.25 * vary[0]),
                gap * (1.0 + 0.25 * vary[1]),
                0.15 * (1.0 + 0.8 * vary[2]),
                rails,
            )
        )
    return starts


def engine_guess(test: WallTest) -> tuple[float, float]:
    """The engine's part of the mass and of the crush its gap to the wall, as momentum tells them.

    The wall's impulse less the loss of momentum of a whole car that moved as the cabin is m_e (v_cabin - v_engine). With the
    engine's velocity known that is a line through the data; without, the engine stands still when it has the largest part.
    """
    assert test.barrier is not None
    since = (test.time >= -0.5 * INTERVAL) & (test.time <= test.stop)
    force, velocity, displacement = test.barrier[since], test.velocity[since], test.displacement[since]
    impulse = np.concatenate(([0.0], np.cumsum(0.5 * INTERVAL * (force[1:] + force[:-1]))))
    ahead = impulse - test.mass * (test.speed - velocity)
    engine = None if test.engine is None else test.engine[since]
    if engine is not None:
        behind = np.where(np.isfinite(engine), velocity - engine, 0.0)
        mass = float(ahead @ behind) / max(float(behind @ behind), 1e-9)
        way = np.cumsum(np.where(np.isfinite(engine), engine, 0.0)) * INTERVAL
        braked = np.flatnonzero(engine < 0.85 * test.speed)
    else:
        moving = velocity > 0.3 * test.speed
        mass = float((ahead[moving] / velocity[moving]).max())
        way, braked = displacement, np.flatnonzero(ahead > 0.1 * ahead.max())
    gap = way[braked[0]] / test.crush if braked.size else 0.4
    return float(np.clip(mass / test.mass, 0.08, 0.4)), float(np.clip(gap, 0.05, 0.8))


def _cuts(
    misfit: Misfit, front: Form, numbers: Floats, value: Floats, jacobian: Floats, most: int
) -> list[tuple[Form, Floats]]:
    """Fronts with one more piece where that promises most: by what the new force takes away that no other number could."""
    basis = np.linalg.qr(jacobian)[0]
    found = []
    for finer, x, new in front.splits(numbers, most):
        moved = x.copy()
        moved[new] += _STEP
        column = (misfit(finer, moved) - value) / _STEP
        column -= basis @ (basis.T @ column)
        gain = float(column @ value) ** 2 / max(float(column @ column), 1e-12)
        found.append((gain, finer, x))
    found.sort(key=lambda one: -one[0])
    return [(finer, x) for _, finer, x in found[:_CUTS]]
