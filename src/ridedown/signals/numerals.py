"""Numbers in plain text, many at once: read quickly, and where one is wrong, the line that holds it.

Python's own `float` takes more than a laboratory's file may hold (`nan`, `inf`, `1_000`); here a number is digits with a
decimal point and an exponent, and it is finite.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ridedown.errors import InvalidInput

Floats = NDArray[np.float64]

_LINE_END = re.compile(r"\r*\n|\r+")
_NUMERALS = re.compile(r"[0-9+\-.eE\s]*", re.ASCII)
_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?", re.ASCII)
_BLANKS = " \t"
_LONGEST = 60
"""Characters of one number at most: a double needs 25, and longer ones only cost time."""


def lines_of(text: str) -> list[str]:
    """The lines of a text whatever ends them, CR LF and CR too, and only those: no form feed, no Unicode separator."""
    return _LINE_END.split(text)


def numbers_of(lines: Sequence[str], where: str, first: int = 1) -> Floats:
    """Each line's one number, (n,).

    where: the file's name, for messages; first: the number of the first of these lines in it.

    >>> numbers_of(["1.5", " -2e-3 "], "v1.001")
    array([ 1.5  , -0.002])

    Raises: InvalidInput, naming file and line, where a line holds no number, or something else, or an infinite one.
    """
    # numpy lays texts out side by side at the length of the longest: bounded here, or one long line would fill the memory.
    if max(map(len, lines), default=0) <= _LONGEST and _NUMERALS.fullmatch("\n".join(lines)):
        try:
            values = np.array(lines, dtype=np.float64) if len(lines) else np.empty(0)
        except ValueError:
            values = None
        if values is not None and np.isfinite(values).all():
            return values
    for number, line in enumerate(lines, start=first):
        if not _is_number(line.strip(_BLANKS)):
            raise InvalidInput(f"{where}:{number}: got {line.strip()[:40]!r}; need one finite number. Correct the line.")
    return np.array([float(line.strip(_BLANKS)) for line in lines], dtype=np.float64)


def _is_number(text: str) -> bool:
    return len(text) <= _LONGEST and _NUMBER.fullmatch(text) is not None and np.isfinite(float(text)).item()
