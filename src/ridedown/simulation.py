"""One crash, or very many: from a scenario to its response, from a table of parameters to outcomes."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ridedown.errors import InvalidInput, SimulationStopped
from ridedown.outcomes import Outcomes, wanted
from ridedown.response import Response
from ridedown.scenario import Scenario, lower, substitute, total_forces
from ridedown.scenario.kinds import S
from ridedown.solver.solve import solve_many, solve_one
from ridedown.status import Status

_SPAN = 65_536  # crashes lowered and solved at a time: this bounds the memory
_SAMPLES = 2**23  # of all channels of a span


def simulate(scenario: Scenario, *, throw: bool = True) -> Response:
    """Solve one crash exactly, event by event.

    Returns: the response, with every channel, peak and event. Where the solver cannot go on to the end, the response holds
    the part computed so far and its `status` says why; it is then raised, unless `throw` is false.

    Raises: SimulationStopped, with the `response` so far.

    >>> from ridedown import load, simulate
    >>> response = simulate(load("paper-adult-full"))
    >>> response.completed
    True
    """
    network = lower(scenario)
    phases, stop = solve_one(network)
    response = Response(scenario, network, phases, Status.of(stop))
    if throw and not response.completed:
        raise SimulationStopped(f"stopped at {1e3 * response.end_time:.3f} ms: {response.status.sentence}", response)
    return response


def simulate_many(
    scenario: S,
    table: Mapping[str, ArrayLike],
    *,
    outcomes: Sequence[str] | None = None,
    samples: Sequence[str] = (),
    times: ArrayLike | None = None,
    threads: int | None = None,
) -> Outcomes:
    """Solve a scenario once for every row of a table of parameters.

    table: parameter paths (see `ridedown.scenario.parameters`) to columns of one length, SI units; a single number holds for
    all rows. outcomes: names as `Outcomes` explains; a useful choice if left out. samples: names of channels to be sampled at
    `times` (T,) [s], which rise; at an event, the value just after it. threads: as many as the machine has cores if left out;
    the results do not depend on it.

    Returns: the outcomes, a column each, in the order of the rows, with a status per row: a crash that could not be solved to
    its end keeps the outcomes of the part computed, and its status says why.

    Raises: UnknownName for a path, an outcome or a channel that does not exist; InvalidInput for a value that may not be.

    >>> from ridedown import load, simulate_many
    >>> crash = load("p1")
    >>> many = simulate_many(crash, {"adult.restraint.stiffness": [20e3, 40e3, 98.1e3]}, outcomes=["adult.excursion.max"])
    >>> many["adult.excursion.max"].round(3)
    array([0.484, 0.364, 0.207])
    """
    columns, rows = _columns(table)
    count = workers(threads)
    network = lower(scenario)
    plan = wanted(network, outcomes, samples, times, further=total_forces(getattr(scenario, "occupants", ()), network))
    judged = substitute(scenario, columns)  # the whole table, before the first crash is solved
    result = Outcomes.empty(plan, rows)
    sampled = len(plan.sampled) * plan.tracked.sample_time.size
    span = min(_SPAN, max(_SAMPLES // sampled, 1)) if sampled else _SPAN
    for start in range(0, rows, span):
        part = slice(start, min(start + span, rows))
        own = judged if span >= rows else substitute(scenario, {path: _part(column, part) for path, column in columns.items()})
        network = lower(own).widened(part.stop - part.start)
        result.fill(part, plan, network, solve_many(network, plan.tracked, work=plan.needs_work, threads=count))
    return result


def _part(column: NDArray[np.float64], rows: slice) -> NDArray[np.float64]:
    return column[rows] if column.ndim else column


def _columns(table: Mapping[str, ArrayLike]) -> tuple[dict[str, NDArray[np.float64]], int]:
    """The table as arrays, and its number of rows."""
    columns = {}
    rows: dict[str, int] = {}
    for path, given in table.items():
        try:
            column = np.asarray(given, dtype=np.float64)
        except (TypeError, ValueError):
            raise InvalidInput(f"{path}: got {given!r}; need a column of numbers in SI units. Give one per crash.") from None
        if column.ndim > 1:
            raise InvalidInput(f"{path}: got an array of shape {column.shape}; need a column, shape (R,). Give one per crash.")
        columns[path] = column
        if column.ndim:
            rows[path] = column.size
    if len(set(rows.values())) > 1:
        (path, size), *others = rows.items()
        other, other_size = next((p, n) for p, n in others if n != size)
        raise InvalidInput(f"{other}: got {other_size} rows; need {size}, as in {path}. Give columns of one length.")
    return columns, next(iter(rows.values()), 1)


def workers(threads: object) -> int:
    """How many threads to use: those asked for, or as many as this process may use cores. Raises: InvalidInput."""
    if threads is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1)
    if isinstance(threads, bool) or not isinstance(threads, int) or threads < 1:
        raise InvalidInput(f"threads: got {threads!r}; need a whole number of 1 or more. Leave it out for all cores.")
    return threads
