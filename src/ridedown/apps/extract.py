"""What the command line gives an extraction: quantities with units, lists of channels, where the scenario goes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ridedown.apps.measured import checked
from ridedown.errors import InvalidInput
from ridedown.scenario.files import load
from ridedown.scenario.quantities import Refused, read
from ridedown.signals import read as read_record
from ridedown.signals.record import TestRecord
from ridedown.units import MASS, SPEED, Dimension


def options(mass: str | None, speed: str | None, channels: str | None, engine: str | None) -> dict[str, Any]:
    """The options of `ridedown.studies.extraction.extract.extract` that were given as text.

    Raises: InvalidInput for a quantity that is none.
    """
    return {
        "mass": None if mass is None else _quantity("mass", mass, MASS),
        "speed": None if speed is None else _quantity("speed", speed, SPEED),
        "channels": () if channels is None else _names("channels", channels),
        "engine": None if engine is None else (() if engine.strip().casefold() == "none" else _names("engine", engine)),
    }


def _quantity(field: str, text: str, dimension: Dimension) -> float:
    try:
        return read(text, dimension)
    except Refused as refused:
        try:
            return float(text)  # a bare number is SI, as in a file
        except ValueError:
            raise InvalidInput(f"{field}: {refused}") from None


def _names(field: str, text: str) -> tuple[str, ...]:
    names = tuple(name.strip() for name in text.split(",") if name.strip())
    if not names:
        raise InvalidInput(f"{field}: got {text!r}; need channels by number, code or name, with commas between. Name one.")
    return names


def barrier_at(text: str | None) -> TestRecord | None:
    """The record with the force on the wall, if one was named."""
    return None if text is None else read_record(checked(text))


def scenario_file(out: Path) -> None:
    """Check where the scenario is to be written, before any work.

    Raises: InvalidInput for a name that is not *.toml, a folder, or a file that is no scenario.
    """
    checked(str(out))
    if out.suffix.lower() != ".toml":
        raise InvalidInput(f"--out: got {str(out)!r}; need a file *.toml. Choose such a name; --report takes a folder.")
    if not out.exists():
        return
    try:
        if out.is_dir():
            raise InvalidInput("a folder")
        load(out)
    except InvalidInput:
        raise InvalidInput(
            f"--out: got {str(out)!r}, which exists and is no scenario file; need a new name. Choose another, or remove it."
        ) from None
