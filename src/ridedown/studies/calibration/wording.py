"""Values with units, as tables, figures and notes of studies show them."""

from __future__ import annotations

G = 9.80665
SHOWN = {
    "m/s2": ("g", 1.0 / G), "m": ("mm", 1e3), "N": ("kN", 1e-3), "N/m": ("kN/m", 1e-3), "N s/m": ("kN s/m", 1e-3),
    "s": ("ms", 1e3), "m/s": ("km/h", 3.6), "J": ("kJ", 1e-3),
}  # fmt: skip
"""In which unit an SI unit is shown, and its factor."""


NONE = "–"
"""There is no such number."""


def in_words(value: float | None, unit: str) -> str:
    """A value in SI in the unit it is shown in, to four digits.

    >>> in_words(98100.0, "N/m"), in_words(0.005, "m")
    ('98.1 kN/m', '5 mm')
    """
    if value is None:
        return NONE
    shown, scale = ("MN/m", 1e-6) if unit == "N/m" and abs(value) >= 1e6 else SHOWN.get(unit, (unit, 1.0))
    return f"{four(scale * value)} {shown}".strip()


def in_case(channel: str, case: str, *, several: bool) -> str:
    """A channel, with its case where there are several; not where that only says again whose the channel is.

    >>> in_case("adult.acceleration", "slow", several=True), in_case("driver.belt.force", "driver", several=True)
    ('adult.acceleration (slow)', 'driver.belt.force')
    """
    return f"{channel} ({case})" if several and not channel.startswith(f"{case}.") else channel


def four(value: float) -> str:
    """Four significant digits, with a true minus sign."""
    digits = f"{value:.4g}"
    text = f"{float(digits):.0f}" if "e" in digits and abs(value) >= 1.0 and abs(value) < 1e9 else digits
    return text.replace("-", "\u2212")
