"""Published scenarios, ready to run: one data file a publication, each entry with its source and how sure it is.

A file holds `sources`, `[parts]` and `[scenarios.NAME]`, which may add `sources` of its own. A table with
`like = "part"` takes over that part and may change some of its fields, so that a publication's vehicle is written once.
`ridedown.scenario.load(name)` makes a scenario of an entry.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from ridedown.errors import UnknownName

CONFIDENCE = ("primary", "second-hand", "reconstructed")
"""How sure numbers are, the surest first."""


@dataclass(frozen=True, slots=True)
class Entry:
    """One scenario of the catalogue: `data` has the shape of a scenario file."""

    name: str
    data: Mapping[str, Any]

    @property
    def description(self) -> str:
        """What it is, in a line or two."""
        return str(self.data["description"])

    @property
    def sources(self) -> tuple[Mapping[str, Any], ...]:
        """Where the numbers come from."""
        return tuple(self.data["sources"])

    @property
    def confidence(self) -> str:
        """How sure the least sure of its sources is."""
        return max((str(source["confidence"]) for source in self.sources), key=CONFIDENCE.index)


def names() -> tuple[str, ...]:
    """The names of all entries, those of one publication together."""
    return tuple(_entries())


def entry(name: str) -> Entry:
    """The entry of that name.

    >>> entry("marzbanrad-2").confidence
    'second-hand'

    Raises: UnknownName, offering the nearest.
    """
    entries = _entries()
    if name not in entries:
        raise UnknownName.among("catalogue", name, entries)
    return entries[name]


def studies() -> dict[str, Path]:
    """The study files that come with ridedown, by name.

    >>> sorted(studies())[:3]
    ['compatibility', 'example-bound', 'example-box']
    """
    return {path.stem: path for path in sorted((Path(__file__).parent / "studies").glob("*.toml"))}


@cache
def _entries() -> dict[str, Entry]:
    entries: dict[str, Entry] = {}
    for file in sorted(Path(__file__).parent.glob("*.toml")):
        publication = tomllib.loads(file.read_text(encoding="utf-8"))
        parts = publication.get("parts", {})
        for name, scenario in publication["scenarios"].items():
            own = _resolved(scenario, parts)
            sources = [*publication["sources"], *own.pop("sources", ())]
            data = {"name": name, "sources": sources, **own}
            entries[name] = Entry(name, data)
    return entries


def _resolved(value: Any, parts: Mapping[str, Any]) -> Any:
    """The value with every `like` replaced by the part it names, changed as said beside it."""
    if isinstance(value, list):
        return [_resolved(item, parts) for item in value]
    if not isinstance(value, dict):
        return value
    own = {key: _resolved(item, parts) for key, item in value.items() if key != "like"}
    return _changed(_resolved(parts[value["like"]], parts), own) if "like" in value else own


def _changed(base: Any, changes: Any) -> Any:
    if not (isinstance(base, dict) and isinstance(changes, dict)):
        return changes
    return {**base, **{key: _changed(base.get(key), change) for key, change in changes.items()}}
