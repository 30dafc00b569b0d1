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
from ridedown.limits.measured import SHAPE_CLASS
from ridedown.response import Response
from ridedown.scenario import CrashScenario, NetworkScenario
from ridedown.signals.filters import smoothed
from ridedown.simulation import simulate, simulate_many
from ridedown.studies.extraction.measured import ASSUMED_RESTITUTION, INTERVAL, WallTest
from ridedown.studies.extraction.model import Form, Scale, one_mass, two_masses, within

FOLLOWED = 0.05
"""A curve has enough pieces when what it is read off, or has to follow, is met to this part of its peak, root mean square."""
GAIN = 0.03
"""Part of the misfit that one more piece has to take away to be worth having."""
NEARLY = 1.15
"""How many times the misfit of the best a front may have to do about as well."""
MOST = 8
"""Pieces a curve has at most, unless told otherwise."""

_STRIDE = 5  # grid points from one that counts to the next: 0.5 ms, fine for class 60
_SIGNAL = 300.0  # weight of a whole channel: as many values as 150 ms have at that stride
_CRUSH, _TIME, _REBOUND = 0.01, 0.002, 0.06  # errors that weigh as one value that is off by its channel's peak
_ASSUMED = 3.0  # how many times as far an assumed rebound may be off
_ENGINE = 0.5  # weight of the engine's velocity: its sensors differ from each other as the engine turns
_STEP = 1e-4  # of differences, in numbers near 1
_FAILED = 10.0
_STARTS, _POLISHED = 16, 6
_TRIAL, _POLISH, _REFIT = 15, 60, 30  # evaluations of a start, of the best of them, after a cut
_CLEARANCE = 0.15  # from engine to firewall, part of the crush
_NEAR = (0.75, 1.25)  # of what the engine's channels tell
_SHARES, _GAPS = (0.1, 0.35), (0.2, 0.7)  # of an engine without channels: part of the mass, of the crush
_CUTS = 3  # places tried for one more piece

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
    engine = None if body == "vehicle1" else on_grid("engine.velocity", np.full(free.size, test.speed))
    return Simulated(
        response=response,
        acceleration=smoothed(on_grid(f"{body}.acceleration", rest), SHAPE_CLASS, INTERVAL),
        barrier=smoothed(wall, SHAPE_CLASS, INTERVAL),
        engine=engine,
        crush=most.value,
        stop=most.time,
        rebound=max(0.0, -least.value),
    )


def _at_the_wall(scenario: CrashScenario | NetworkScenario) -> tuple[str, ...]:
    if isinstance(scenario, CrashScenario):
        return ("vehicle1.right", "vehicle1.left")
    return tuple(element.name for element in scenario.elements if "wall" in element.between)


class Misfit:
    """How far a front is from the test, as a vector whose squares are summed."""

    def __init__(self, test: WallTest, *, with_barrier: bool) -> None:
        self.test = test
        self._since = test.time >= -0.5 * INTERVAL
        self._counted = np.flatnonzero(self._since)[::_STRIDE]
        self._weight = float(np.sqrt(_SIGNAL / self._counted.size))
        self._barrier = test.barrier if with_barrier else None
        engine = test.engine if with_barrier else None
        self._engine = None if engine is None else self._counted[np.isfinite(engine[self._counted])]

    def __call__(self, form: Form, numbers: Floats) -> Floats:
        """The misfit of each row of numbers (R, n), (R, size): channels first, then crush, time and rebound."""
        test, scenario = self.test, form.scenario(numbers[0])
        body = "vehicle1" if form.masses == 1 else "cabin"
        walls = [] if self._barrier is None else [f"{name}.force" for name in _at_the_wall(scenario)]
        engine = [] if self._engine is None else ["engine.velocity"]
        found = simulate_many(
            scenario,
            form.columns(numbers),
            outcomes=[f"{body}.displacement.max", f"{body}.displacement.max_time", f"{body}.velocity.min"],
            samples=[f"{body}.acceleration", *walls, *engine],
            times=np.clip(test.time[self._since], 0.0, form.scale.duration),
            threads=1,
        )
        rows = [self._part(found.samples[f"{body}.acceleration"], test.acceleration, test.peak)]
        if self._barrier is not None:
            force = np.sum([found.samples[name] for name in walls], axis=0)
            rows.append(self._part(force, self._barrier, float(self._barrier.max())))
        if self._engine is not None and test.engine is not None:
            at = self._engine - (test.time.size - int(self._since.sum()))
            speeds = found.samples["engine.velocity"][:, at]
            rows.append(_ENGINE * self._weight * (speeds - test.engine[self._engine]) / test.speed)
        rebound, loose = (test.rebound, 1.0) if test.rebound is not None else (ASSUMED_RESTITUTION * test.speed, _ASSUMED)
        back = np.maximum(0.0, -found[f"{body}.velocity.min"])
        targets = [
            (found[f"{body}.displacement.max"] / test.crush - 1.0) / _CRUSH,
            (found[f"{body}.displacement.max_time"] - test.stop) / _TIME,
            (back - rebound) / max(rebound, 0.02 * test.speed) / (_REBOUND * loose),
        ]
        misfit: Floats = np.concatenate((*rows, np.stack(targets, axis=1)), axis=1)
        misfit[~found.completed] = _FAILED
        return np.nan_to_num(misfit, nan=_FAILED)

    def _part(self, samples: Floats, measured: Floats, peak: float) -> Floats:
        """What a channel sampled after the contact, (R, T), is off by."""
        whole = np.zeros((samples.shape[0], measured.size))
        whole[:, self._since] = np.nan_to_num(samples)
        model = smoothed(whole, SHAPE_CLASS, INTERVAL)
        part: Floats = self._weight * (model - measured)[:, self._counted] / peak
        return part

    def rms(self, misfit: Floats) -> float:
        """Root mean square of the channels' part of a misfit (size,), as a part of their peaks [1]."""
        channels = misfit[: self._counted.size * (1 if self._barrier is None else 2)]
        return float(np.sqrt(np.mean((channels / self._weight) ** 2)))


@dataclass(frozen=True, slots=True, eq=False)
class Refined:
    """A form and its numbers (n,) after least squares, the misfit there (size,), and its derivatives (size, n)."""

    form: Form
    numbers: Floats
    misfit: Floats
    derivatives: Floats

    @property
    def cost(self) -> float:
        """The sum of the misfit's squares."""
        return float(self.misfit @ self.misfit)


def refined(misfit: Misfit, form: Form, numbers: Floats, evaluations: int) -> Refined:
    """Least squares from these numbers, with so many evaluations at most."""

    def value(x: Floats) -> Floats:
        row: Floats = misfit(form, x[np.newaxis])[0]
        return row

    def derivatives(x: Floats) -> Floats:
        return _derivatives(misfit, form, x)

    found = least_squares(
        value, within(form, numbers), jac=derivatives, bounds=form.bounds(), max_nfev=evaluations, xtol=1e-5, ftol=1e-4
    )
    return Refined(form, found.x, found.fun, np.asarray(found.jac, dtype=np.float64))


def _derivatives(misfit: Misfit, form: Form, numbers: Floats) -> Floats:
    high = form.bounds()[1]
    steps = np.where(numbers + _STEP < high, _STEP, -_STEP)
    rows = misfit(form, np.vstack((numbers, numbers + np.diag(steps))))
    derivatives: Floats = ((rows[1:] - rows[0]) / steps[:, np.newaxis]).T
    return derivatives


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
    values: Floats = np.linalg.lstsq(columns, wanted, rcond=None)[0].astype(np.float64)
    return values, float(np.sqrt(np.mean((columns @ values - wanted) ** 2)))


def fit_one_mass(test: WallTest, *, most: int = MOST) -> tuple[Form, Floats]:
    """A front of one mass that follows the cabin."""
    scale = scale_of(test)
    deflections, forces = pieces_of(*measured_curve(test), most)
    rebound = test.rebound if test.rebound is not None else ASSUMED_RESTITUTION * test.speed
    # the energy that the rebound takes is that under the unloading line: F^2 / 2k = m v^2 / 2
    stiffness = max(forces[-1], 0.1 * scale.force) ** 2 / (test.mass * max(rebound, 0.02 * test.speed) ** 2)
    unloading = float(np.log10(stiffness * scale.length / scale.force))
    form, numbers = one_mass(scale, deflections / scale.length, forces / scale.force, unloading)
    misfit = Misfit(test, with_barrier=False)
    return form, refined(misfit, form, numbers, 2 * _POLISH).numbers


# two masses


def fit_two_masses(
    test: WallTest, *, most: int = MOST, rng: np.random.Generator, advance: Advance = lambda _: None
) -> tuple[Form, Floats, tuple[float, float]]:
    """A front of cabin and engine that follows the cabin and the wall's force, for a test that has both.

    With it the least and the largest engine mass [kg] of it and of the other fronts that do about as well (NEARLY), from
    other starts.
    """
    misfit = Misfit(test, with_barrier=True)
    tried = []
    for form, numbers in _starts(test, most, rng):
        tried.append(refined(misfit, form, numbers, _TRIAL))
        advance("from several starts")
    tried.sort(key=lambda one: one.cost)
    polished = []
    for one in tried[:_POLISHED]:
        polished.append(refined(misfit, one.form, one.numbers, _POLISH))
        advance("the best of them")
    best = min(polished, key=lambda one: one.cost)
    alike = [one for one in polished if misfit.rms(one.misfit) <= NEARLY * misfit.rms(best.misfit)]
    while misfit.rms(best.misfit) > FOLLOWED:
        finer = []
        for form, numbers in _cuts(misfit, best, most):
            finer.append(refined(misfit, form, numbers, _REFIT))
            advance("one more piece")
        better = min(finer, key=lambda one: one.cost, default=best)
        if better.cost >= (1.0 - GAIN) ** 2 * best.cost:
            break
        best = better
    engines = [test.mass * float(one.numbers[0]) for one in (*alike, best)]
    return best.form, best.numbers, (min(engines), max(engines))


STEPS = _STARTS + _POLISHED + 5 * _CUTS
"""Of progress, about: starts, polishing, pieces added."""


def _starts(test: WallTest, most: int, rng: np.random.Generator) -> list[tuple[Form, Floats]]:
    """Fronts to begin with: the engine's mass and gap as the data have them, and varied, widely if no engine was measured."""
    scale = scale_of(test)
    share, gap = engine_guess(test)
    deflections, forces = measured_curve(test)
    pieces = min(3, most)
    at = np.interp(np.linspace(0.0, test.crush, pieces + 1), deflections, forces) / scale.force
    starts = [two_masses(scale, share, gap, _CLEARANCE, np.clip(0.6 * at, 0.02, 2.0))]
    for _ in range(_STARTS - 1):
        if test.engine is None:
            mass, way = rng.uniform(*_SHARES), rng.uniform(*_GAPS)
        else:
            mass, way = share * rng.uniform(*_NEAR), gap * rng.uniform(*_NEAR)
        clearance = _CLEARANCE * rng.uniform(0.2, 1.8)
        rails = np.clip(at * rng.uniform(0.4, 1.0, at.size), 0.02, 2.0)
        starts.append(two_masses(scale, mass, way, clearance, rails))
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


def _cuts(misfit: Misfit, best: Refined, most: int) -> list[tuple[Form, Floats]]:
    """Fronts with one more piece where that promises most: by what the new force takes away that no other number could."""
    basis = np.linalg.qr(best.derivatives)[0]
    found = []
    for finer, numbers, new in best.form.splits(best.numbers, most):
        moved = numbers.copy()
        moved[new] += _STEP
        column = (misfit(finer, moved[np.newaxis])[0] - best.misfit) / _STEP
        column -= basis @ (basis.T @ column)
        gain = float(column @ best.misfit) ** 2 / max(float(column @ column), 1e-12)
        found.append((gain, finer, numbers))
    found.sort(key=lambda one: -one[0])
    return [(finer, numbers) for _, finer, numbers in found[:_CUTS]]
