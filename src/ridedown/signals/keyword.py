"""Curves for LS-DYNA: a signal as `*DEFINE_CURVE`, in millimetres and milliseconds."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ridedown.errors import InvalidInput
from ridedown.signals.history import Floats

SUFFIXES = (".k", ".key", ".dyn")

_MS = 1e3  # ms in a second
_MM_PER_MS2 = 1e-3  # mm/ms2 in a m/s2
_LEAST_STEP = 1e-6  # ms; abscissas have to rise, so that a jump is this steep


def define_curve(time: Floats, acceleration: Floats, *, curve: int = 1, title: str = "", remarks: tuple[str, ...] = ()) -> str:
    """The text of a keyword file with one acceleration curve: time in ms, acceleration in mm/ms2, 20 columns each.

    time: (n,) [s], never falling; acceleration: (n,) [m/s2]. Two values at one time, a jump, are written a millionth of a
    millisecond apart. curve: its LCID. remarks: comment lines.

    >>> print(define_curve(np.array([0.0, 0.125]), np.array([0.0, -98.0665]), title="sled", remarks=("braking is negative",)))
    *KEYWORD
    $ braking is negative
    $ time in ms, acceleration in mm/ms2
    *DEFINE_CURVE_TITLE
    sled
    $#    lcid      sidr       sfa       sfo      offa      offo    dattyp
             1         0       1.0       1.0       0.0       0.0         0
    $#                a1                  o1
                       0                   0
                     125          -0.0980665
    *END
    <BLANKLINE>

    Raises: InvalidInput for a number of the curve that is no whole number from 1 to 9999999999.
    """
    if not 1 <= curve < 10**10:
        raise InvalidInput(f"curve: got {curve}; need a whole number from 1 on, the curve's LCID. Give a free one.")
    abscissa = _MS * np.asarray(time, dtype=np.float64)
    for i in np.flatnonzero(np.diff(abscissa) <= 0.0) + 1:
        abscissa[i] = abscissa[i - 1] + _LEAST_STEP
    plain = [" ".join(remark.split())[:78] for remark in (*remarks, "time in ms, acceleration in mm/ms2")]
    rows = [f"{t:>20.12g}{a:>20.12g}" for t, a in zip(abscissa, _MM_PER_MS2 * acceleration, strict=True)]
    return "\n".join([
        "*KEYWORD",
        *(f"$ {remark}" for remark in plain),
        "*DEFINE_CURVE_TITLE",
        " ".join(title.split())[:80] or "pulse",
        "$#    lcid      sidr       sfa       sfo      offa      offo    dattyp",
        f"{curve:>10}         0       1.0       1.0       0.0       0.0         0",
        "$#                a1                  o1",
        *rows,
        "*END",
        "",
    ])  # fmt: skip


def write_keyword(path: Path, text: str) -> None:
    """Write the text of a keyword file; what is there already is replaced only if it is one."""
    if path.exists():
        with path.open("rb") as file:
            begin = file.read(400).lstrip()
        if not path.is_file() or not begin.startswith((b"*", b"$")):
            raise InvalidInput(f"OUT: got {path.name}, which exists and is no keyword file; need a new name. Choose another.")
    path.write_text(text, encoding="ascii", errors="replace", newline="\n")
