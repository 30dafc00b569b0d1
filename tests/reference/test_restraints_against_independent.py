"""Restraints and driven vehicles in the solver against the independent simulator, drawn at random.

The two were written apart, from the law's text. What a change of one mass by 1e-13 of itself makes is allowed for.
`python -m tests.reference.test_restraints_against_independent FIRST LAST` compares as many as wanted.
"""

from __future__ import annotations

import re
import sys

import numpy as np
import pytest

from ridedown.solver.march import Stop
from tests import held, independent
from tests.independent_restraint import Restraint
from tests.solver.sleds import Solved

CLOSE = 1e-8  # of each channel's peak, but not less than:
SMALLEST = {
    "displacement": 0.01,
    "excursion": 0.01,
    "deflection": 0.01,
    "velocity": 0.3,
    "rate": 0.3,
    "force": 100.0,
    "acceleration": 3.0,
}
LENGTH = 0.1  # m: belt that is taken in or let out is compared relative to this


def disagreements(case: held.Case) -> tuple[dict[str, float], independent.Run]:
    """How far the two are apart, relative, by channel and by belt; and the independent run."""
    network = held.as_network(case)
    ours, nudged, theirs = Solved(network), Solved(held.as_network(case.nudged())), held.run(case)
    assert ours.stop == Stop.COMPLETED
    found = {}
    # not at the round times at which something is done
    times = np.linspace(0.0, case.duration, 173)[:-1] + 1e-7
    for channel in theirs.channels:
        exact, got = theirs.at(channel, times), ours.at(channel, times)
        size = max(np.abs(exact).max(), SMALLEST[channel.replace("_", ".").split(".")[-1]])
        doubt = 100.0 * np.abs(nudged.at(channel, times) - got).max()
        found[channel] = (np.abs(got - exact).max() - doubt) / size
        top, highest = ours.largest(channel)[0], theirs.maximum(channel)[0]
        doubt = 100.0 * abs(nudged.largest(channel)[0] - top)
        found[f"largest {channel}"] = (abs(top - highest) - doubt) / size
    for element in theirs.system.elements:
        law = element.law
        if isinstance(law, Restraint) and not law.free:
            e = network.elements.index(element.name)
            for what, column, exact_length in (("payout", "payout", law.out), ("reel", "reel", law.w)):
                length = getattr(ours.phases, column)[e]
                doubt = 100.0 * abs(getattr(nudged.phases, column)[e] - length)
                found[f"{what} of {element.name}"] = (abs(length - exact_length) - doubt) / LENGTH
    return found, theirs


@pytest.mark.parametrize("seed", range(16))
def test_random_restraints(seed: int) -> None:
    found, _ = disagreements(held.random_case(seed))
    worst = max(found, key=lambda name: found[name])
    assert found[worst] <= CLOSE, worst


def doings(run: independent.Run) -> set[str]:
    """What the restraints of a run did, in a few words each."""
    return {re.sub(r"(, )?[\d.]+$", "", name) for event in run.events for name in (event.before, event.after)}


def main(first: int, last: int) -> None:
    """Compare the cases from `first` up to `last`."""
    worst: list[tuple[float, int, str]] = []
    done: set[str] = set()
    for seed in range(first, last):
        case = held.random_case(seed)
        try:
            found, run = disagreements(case)
        except (AssertionError, RuntimeError) as problem:
            print(seed, type(problem).__name__, problem)
            continue
        name = max(found, key=lambda name: found[name])
        worst.append((found[name], seed, name))
        done |= doings(run)
        if found[name] > CLOSE:
            print(seed, name, f"{found[name]:.3g}", flush=True)
    worst.sort(reverse=True)
    print(f"{len(worst)} of {last - first} compared, {sum(one[0] > CLOSE for one in worst)} apart; worst: {worst[:5]}")
    print(f"met with: {', '.join(sorted(done))}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]))
