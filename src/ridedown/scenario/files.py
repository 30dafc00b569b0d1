"""Scenario files: TOML or YAML in, TOML out."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ridedown.errors import InvalidInput
from ridedown.scenario.base import Model, quantities_of
from ridedown.scenario.kinds import Scenario
from ridedown.scenario.model import CrashScenario
from ridedown.scenario.networks import NetworkScenario
from ridedown.scenario.quantities import Quantity, write
from ridedown.scenario.reading import SUFFIXES, YAML_SUFFIXES, is_network, mapping_of, read
from ridedown.scenario.sled import SledScenario
from ridedown.scenario.vehicle import Vehicle

__all__ = ["SUFFIXES", "YAML_SUFFIXES", "dump", "load"]

_FIRST = ("name", "kind")
"""What a table says first, where it has them."""

_CONTROL = re.compile(r"[\x00-\x1f\x7f]")


def load(source: str | os.PathLike[str] | Mapping[str, Any] | Scenario) -> Scenario:
    """The scenario of a TOML or YAML file, of a mapping of the same shape, or of a name in the catalogue.

    Text is a file where one of that name exists, or where it looks like one (a folder, or a suffix .toml, .yaml, .yml).

    >>> load("paper-adult-full").occupants[0].name
    'adult'

    Raises: InvalidInput for anything wrong in the file, naming the field or the line; UnknownName for a name that is
    not in the catalogue.
    """
    if isinstance(source, Scenario):
        return source
    if isinstance(source, Mapping):
        return _of_mapping(source)
    if isinstance(source, os.PathLike):
        return _of_mapping(read(Path(source)))
    if not isinstance(source, str):
        raise InvalidInput(f"scenario: got {type(source).__name__}; need a file, a mapping or a catalogue name.")
    return _of_mapping(mapping_of(source))


def _of_mapping(data: Mapping[str, Any]) -> Scenario:
    kind: type[Scenario] = SledScenario if "pulse" in data else NetworkScenario if is_network(data) else CrashScenario
    return kind.model_validate(dict(data))


def dump(scenario: Scenario) -> str:
    """The scenario as TOML that loads back equal: SI values with their units, and nothing that is the default.

    Raises: InvalidInput for a scenario that holds columns.
    """
    lines: list[str] = []
    _write_table(_plain(scenario), (), lines)
    return "\n".join(lines).strip() + "\n"


def _plain(model: Model) -> dict[str, Any]:
    """The model as a file would have it."""
    plain: dict[str, Any] = {}
    fields = type(model).model_fields
    for field in sorted(fields, key=lambda field: field not in _FIRST):
        info, value = fields[field], getattr(model, field)
        comparable = isinstance(value, float | int | str | tuple) and not info.is_required()
        if value is None or (comparable and value == info.default):
            continue
        plain[field] = _plain_value(value, quantities_of(type(model), field), field)
    if isinstance(model, Vehicle) and model.alike:
        del plain["left"]
        plain["members"] = plain.pop("right")
    return plain


def _plain_value(value: Any, quantities: tuple[Quantity, ...], field: str) -> Any:
    if isinstance(value, Model):
        return _plain(value)
    if isinstance(value, tuple):
        if len(quantities) > 1 and not isinstance(value[0], tuple):  # one point of a curve
            return [_plain_value(item, (quantity,), field) for item, quantity in zip(value, quantities, strict=True)]
        return [_plain_value(item, quantities, field) for item in value]
    if quantities and not isinstance(value, float):
        raise InvalidInput(f"{field}: got a column of values; need a single one. Dump before substituting.")
    return write(value, quantities[0].dimension) if quantities else value


def _write_table(table: dict[str, Any], path: tuple[str, ...], lines: list[str]) -> None:
    """Values first, then tables: TOML reads a value after a table's header as that table's own."""
    tables = {key: value for key, value in table.items() if isinstance(value, dict)}
    lists = {key: value for key, value in table.items() if not path and _is_list_of_tables(value)}
    lines += [f"{key} = {_inline(value)}" for key, value in table.items() if key not in tables and key not in lists]
    for key, value in tables.items():
        lines += ["", f"[{'.'.join((*path, key))}]"]
        _write_table(value, (*path, key), lines)
    for key, value in lists.items():
        for item in value:
            _write_item(item, key, lines)


def _write_item(table: dict[str, Any], path: str, lines: list[str]) -> None:
    """One of a list of tables; lists of named things in it follow, each with a header of its own."""
    lists = {key: value for key, value in table.items() if _is_list_of_tables(value) and all("name" in one for one in value)}
    lines += ["", f"[[{path}]]", *(f"{key} = {_inline(value)}" for key, value in table.items() if key not in lists)]
    for key, value in lists.items():
        for item in value:
            _write_item(item, f"{path}.{key}", lines)


def _is_list_of_tables(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(item, dict) for item in value)


def _inline(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _quoted(value)
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_inline(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(_inline(item) for item in value) + "]"
    return repr(value)


def _quoted(text: str) -> str:
    text = text.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + _CONTROL.sub(lambda match: f"\\u{ord(match[0]):04x}", text) + '"'
