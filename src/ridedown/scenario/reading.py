"""The bare mapping of a scenario file or of a catalogue's entry, before it is judged: TOML or YAML in."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ridedown import catalogue
from ridedown.errors import InvalidInput, UnknownName

YAML_SUFFIXES = (".yaml", ".yml")
SUFFIXES = (".toml", *YAML_SUFFIXES)

_EXAMPLE = "Start from an example: `ridedown catalogue example-offset`."


def mapping_of(source: str) -> Mapping[str, Any]:
    """The mapping of a file's path or of a catalogue name.

    Text is a file where one of that name exists, or where it looks like one (a folder, or a suffix .toml, .yaml, .yml).

    Raises: InvalidInput for a file that cannot be read; UnknownName for a name that is not in the catalogue.
    """
    path = Path(source)
    if _looks_like_file(source) or _is_file(path):
        return read(path)
    return _named(source)


def _named(name: str) -> Mapping[str, Any]:
    try:
        return catalogue.entry(name).data
    except UnknownName as unknown:
        raise UnknownName(f"{unknown} For a file, give its path with .toml or .yaml.") from None


def is_network(data: Mapping[str, Any]) -> bool:
    """Whether a mapping is a network's. One with `elements` alone is: the message is then about the masses."""
    return ("masses" in data or "elements" in data) and "vehicle1" not in data


def read(path: Path) -> dict[str, Any]:
    """The bare mapping in a TOML or YAML file of a scenario. Raises: InvalidInput."""
    data = table_in(path, text_of(path, "scenario"), f"need a table of fields such as vehicle1. {_EXAMPLE}")
    return anchored(data, path.parent)


def table_in(path: Path, text: str, need: str) -> dict[str, Any]:
    """The mapping that the text of a TOML or YAML file holds; `need`: what to say of one with nothing in it.

    Raises: InvalidInput.
    """
    if not text.strip():
        raise InvalidInput(f"{path}: got an empty file; {need}")
    data = _yaml(path, text) if path.suffix.lower() in YAML_SUFFIXES else _toml(path, text)
    if not isinstance(data, dict) or not data:
        got = "no fields" if not data else f"a {type(data).__name__}"
        raise InvalidInput(f"{path}: got {got}; {need}")
    return data


def anchored(data: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The mapping with the files that a pulse names looked for in the scenario's own folder, wherever one works from."""
    pulse = data.get("pulse")
    if not isinstance(pulse, dict):
        return data
    changed = dict(pulse)
    named = changed.get("file")
    if isinstance(named, str) and named:
        changed["file"] = str(folder / named)
    other = changed.get("scenario")
    if isinstance(other, str) and other and (_looks_like_file(other) or _is_file(folder / other)):
        changed["scenario"] = str(folder / other)
    elif isinstance(other, dict):
        changed["scenario"] = anchored(other, folder)
    return {**data, "pulse": changed}


def _looks_like_file(text: str) -> bool:
    return Path(text).suffix.lower() in SUFFIXES or "/" in text or os.sep in text


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # a name too long for the file system, or with a null byte
        return False


def text_of(path: Path, kind: str) -> str:
    """The text of a file that should hold a scenario, a study or a calibration, as `kind` says. Raises: InvalidInput."""
    try:
        return path.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        hint = _catalogue_name_near(path) if kind == "scenario" else ""
        raise InvalidInput(f"{path}: got no such file; need a {kind} file. Check the path.{hint}") from None
    except IsADirectoryError:
        raise InvalidInput(f"{path}: got a folder; need a {kind} file. Name a file in it.") from None
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise InvalidInput(f"{path}, line {line}: got no UTF-8; need UTF-8 text. Save it as UTF-8.") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InvalidInput(f"{path}: got a file that cannot be read ({reason}); need a {kind} file.") from None


def _catalogue_name_near(path: Path) -> str:
    near = str(UnknownName.among("catalogue", path.stem, catalogue.names()))
    return f" {near}" if "Did you mean" in near else ""


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
