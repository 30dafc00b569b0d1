"""From what a client sends to what the library takes: scenarios and values, with nothing in them that opens a file."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from ridedown import catalogue
from ridedown.apps.web.refusals import TooMuch
from ridedown.errors import InvalidInput
from ridedown.scenario import Scenario, load, substitute
from ridedown.scenario.reading import table_in

MOST_TEXT = 100_000
"""Characters of a scenario file: the longest of the catalogue has 4,000; a measured pulse in points, 20,000."""
MOST_VALUES = 300
"""Values that one request may replace."""
MOST_PARTS = 40
"""Occupants, masses or elements of one scenario."""

_KEPT = 64  # scenarios kept as read


def scenario_of(message: Mapping[str, Any]) -> Scenario:
    """The scenario of a request: `scenario`, a catalogue name, or `toml`, a file's text; and `values`, by parameter path.

    Raises: InvalidInput, UnknownName, naming the field.
    """
    text = message.get("toml")
    base = _named(message.get("scenario")) if text is None else _read(_text(text))
    values = message.get("values") or {}
    if not isinstance(values, Mapping):
        raise InvalidInput("values: got no table; need parameter paths with numbers. Send an object.")
    if len(values) > MOST_VALUES:
        raise TooMuch(f"values: got {len(values)}; need {MOST_VALUES} at most. Send fewer.")
    return substitute(base, {str(path): _number(str(path), value) for path, value in values.items()}) if values else base


def number(message: Mapping[str, Any], field: str, low: float, high: float) -> float:
    """A number of a request, within bounds. Raises: InvalidInput."""
    value = _number(field, message.get(field))
    if isinstance(value, str) or not low <= value <= high:
        raise InvalidInput(f"{field}: got {value!r}; need {low:g} .. {high:g}.")
    return value


def _number(path: str, value: object) -> float | str:
    """A bare SI number, or text with a unit, which `substitute` reads."""
    if isinstance(value, str):
        return value[:100]
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InvalidInput(f"{path}: got {type(value).__name__}; need a number. Send one.")
    return float(value)


def _named(name: object) -> Scenario:
    if not isinstance(name, str):
        raise InvalidInput("scenario: got nothing; need a catalogue name, or toml. Send one.")
    return _of_catalogue(name)


@lru_cache(_KEPT)
def _of_catalogue(name: str) -> Scenario:
    return load(catalogue.entry(name).data)  # never `load(name)`: that would open a file of the name


def _text(text: object) -> str:
    if not isinstance(text, str):
        raise InvalidInput(f"toml: got {type(text).__name__}; need the text of a scenario file. Send one.")
    if len(text) > MOST_TEXT:
        raise TooMuch(f"toml: got {len(text):,} characters; need {MOST_TEXT:,} at most. Send a shorter scenario.")
    return text


@lru_cache(_KEPT)
def _read(text: str) -> Scenario:
    """The scenario of a file's text."""
    data = table_in(Path("scenario.toml"), text, "need a scenario. Start from one of the catalogue.")
    refuse_files(data)
    for part in ("occupants", "masses", "elements"):
        count = len(data[part]) if isinstance(data.get(part), list) else 0
        if count > MOST_PARTS:
            raise TooMuch(f"{part}: got {count}; need {MOST_PARTS} at most on this page. Use the command line.")
    return load(data)


def refuse_files(data: Mapping[str, Any]) -> None:
    """Refuse a scenario whose pulse names a file of the server, or a scenario that is not in the catalogue.

    Raises: InvalidInput, UnknownName.
    """
    pulse = data.get("pulse")
    if not isinstance(pulse, Mapping):
        return
    if "file" in pulse:
        raise InvalidInput("pulse.file: got a path; need none: no files are opened here. Drop the test into the Test view.")
    other = pulse.get("scenario")
    if isinstance(other, str):
        catalogue.entry(other)
    elif isinstance(other, Mapping):
        refuse_files(other)
