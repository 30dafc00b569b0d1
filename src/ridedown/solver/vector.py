"""Eight lanes at a time: vectors of numbers as values of the kernels.

A compiler left to turn loops over lanes into vector instructions gives up where it cannot prove that arrays do not overlap,
and says nothing. Here a vector is a value: `load` takes eight numbers, arithmetic and comparisons work on all of them,
`where` chooses lane by lane, `store` puts them back. Sums stay in registers over any number of terms. LLVM makes of it
whatever the processor has (two registers of four numbers, or one of eight).

Compiled code only; in arithmetic, plain numbers stand for eight equal ones. `count_up` is here, too: how threads share crashes.
"""

from __future__ import annotations

from typing import Any

from ridedown.compiled import instructions

instructions("ridedown.solver.vector_instructions")

WIDTH = 8
ALL_LANES = (1 << WIDTH) - 1
"""Every bit of `lanes_of` set."""


def load(array: Any, index: Any) -> Any:
    """Eight numbers of a flat array, from `index` on."""
    raise NotImplementedError


def store(array: Any, index: Any, value: Any) -> Any:
    """Put eight numbers into a flat array, from `index` on."""
    raise NotImplementedError


def pick(table: Any, rows: Any, index: Any, column: Any) -> Any:
    """Eight numbers of a table of two dimensions, in a column: from the rows named by eight whole numbers, from `index` on."""
    raise NotImplementedError


def spread(number: Any) -> Any:
    """Eight times the same number."""
    raise NotImplementedError


def where(mask: Any, yes: Any, no: Any) -> Any:
    """`yes` where the mask is true, `no` where it is not."""
    raise NotImplementedError


def lanes_of(mask: Any) -> Any:
    """The mask as a whole number: bit n is lane n. Zero is none; see `first_lane`."""
    raise NotImplementedError


def union(array: Any, index: Any) -> Any:
    """The bits that are set in any of eight whole numbers of a flat array, from `index` on."""
    raise NotImplementedError


def first_lane(bits: Any) -> Any:
    """Number of the first lane that is set; `bits &= bits - 1` goes on to the next."""
    raise NotImplementedError


def binary_exponent(value: Any) -> Any:
    """The exponent of two of each (positive, normal) number, and what it is times that, in [1, 2)."""
    raise NotImplementedError


def power_of_two(exponent: Any) -> Any:
    """Two to a whole power, -1022 to 1023."""
    raise NotImplementedError


def floor(value: Any) -> Any:
    """The whole number below each."""
    raise NotImplementedError


def count_up(counter: Any) -> Any:
    """The whole number in `counter[0]`, which goes up by one: no other thread is given the same."""
    raise NotImplementedError
