"""Scenario files: TOML or YAML in, TOML out."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ridedown import catalogue
from ridedown.errors import InvalidInput, UnknownName
from ridedown.scenario.base import Model, quantities_of
from ridedown.scenario.model import CrashScenario
from ridedown.scenario.networks import NetworkScenario
from ridedown.scenario.quantities import Quantity, write
from ridedown.scenario.vehicle import Vehicle

YAML_SUFFIXES = (".yaml", ".yml")
SUFFIXES = (".toml", *YAML_SUFFIXES)

_FIRST = ("name", "kind")
"""What a table says first, where it has them."""

_CONTROL = re.compile(r"[\x00-\x1f\x7f]")
_EXAMPLE = "Start from an example: `ridedown catalogue example-offset`."


def load(
    source: str | os.PathLike[str] | Mapping[str, Any] | CrashScenario | NetworkScenario,
) -> CrashScenario | NetworkScenario:
    """The scenario of a TOML or YAML file, of a mapping of the same shape, or of a name in the catalogue.

    Text is a file where one of that name exists, or where it looks like one (a folder, or a suffix .toml, .yaml, .yml).

    >>> load("paper-adult-full").occupants[0].name
    'adult'

    Raises: InvalidInput for anything wrong in the file, naming the field or the line; UnknownName for a name that is
    not in the catalogue.
    """
    if isinstance(source, CrashScenario | NetworkScenario):
        return source
    if isinstance(source, Mapping):
        return _of_mapping(source)
    if isinstance(source, os.PathLike):
        return _of_mapping(read(Path(source)))
    if not isinstance(source, str):
        raise InvalidInput(f"scenario: got {type(source).__name__}; need a file, a mapping or a catalogue name.")
    path = Path(source)
    if _is_file(path) or path.suffix.lower() in SUFFIXES or "/" in source or os.sep in source:
        return _of_mapping(read(path))
    return _of_mapping(_named(source))


def _named(name: str) -> Mapping[str, Any]:
    try:
        return catalogue.entry(name).data
    except UnknownName as unknown:
        raise UnknownName(f"{unknown} For a file, give its path with .toml or .yaml.") from None


def _of_mapping(data: Mapping[str, Any]) -> CrashScenario | NetworkScenario:
    # `masses` tells a network from a crash; with `elements` alone, the message is about the masses that are missing.
    kind = NetworkScenario if ("masses" in data or "elements" in data) and "vehicle1" not in data else CrashScenario
    return kind.model_validate(dict(data))


def read(path: Path) -> dict[str, Any]:
    """The bare mapping in a TOML or YAML file. Raises: InvalidInput."""
    text = _text(path)
    if not text.strip():
        raise InvalidInput(f"{path}: got an empty file; need a scenario. {_EXAMPLE}")
    data = _yaml(path, text) if path.suffix.lower() in YAML_SUFFIXES else _toml(path, text)
    if not isinstance(data, dict) or not data:
        got = "no fields" if not data else f"a {type(data).__name__}"
        raise InvalidInput(f"{path}: got {got}; need a table of fields such as vehicle1. {_EXAMPLE}")
    return data


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # a name too long for the file system, or with a null byte
        return False


def _text(path: Path) -> str:
    try:
        return path.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        near = UnknownName.among("catalogue", path.stem, catalogue.names())
        hint = f" {near}" if "Did you mean" in str(near) else ""
        raise InvalidInput(f"{path}: got no such file; need a scenario file. Check the path.{hint}") from None
    except IsADirectoryError:
        raise InvalidInput(f"{path}: got a folder; need a scenario file. Name a file in it.") from None
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise InvalidInput(f"{path}, line {line}: got no UTF-8; need UTF-8 text. Save it as UTF-8.") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InvalidInput(f"{path}: got a file that cannot be read ({reason}); need a scenario file.") from None


def _toml(path: Path, text: str) -> Any:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        what, line = str(error), text.count("\n") + 1
        if place := re.search(r" \(at line (\d+), column \d+\)$", what):
            what, line = what[: place.start()], int(place[1])
        what = what.removesuffix(" (at end of document)")
        raise InvalidInput(f"{path}, line {line}: got a TOML syntax error ({what}); need TOML. Mend that line.") from None
    except RecursionError:
        raise InvalidInput(f"{path}: got tables nested too deeply; need a scenario. {_EXAMPLE}") from None


def _yaml(path: Path, text: str) -> Any:
    # Slow to import, and most files are TOML.
    from ruamel.yaml import YAML  # noqa: PLC0415
    from ruamel.yaml.error import MarkedYAMLError, YAMLError  # noqa: PLC0415

    try:
        return YAML(typ="safe", pure=True).load(text)
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = f"{path}, line {mark.line + 1}" if mark else f"{path}"
        what = (error.problem or "not YAML").splitlines()[0]
        raise InvalidInput(f"{where}: got a YAML syntax error ({what}); need YAML. Mend that line.") from None
    except (YAMLError, ValueError, RecursionError) as error:
        what = (str(error) or "not YAML").splitlines()[0]
        raise InvalidInput(f"{path}: got a YAML syntax error ({what}); need YAML. Mend it.") from None


def dump(scenario: CrashScenario | NetworkScenario) -> str:
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
