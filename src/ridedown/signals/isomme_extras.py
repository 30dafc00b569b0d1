"""What a record knows and ISO-MME 1.6 has no descriptor for, under keys that begin with a dot.

Laboratories write keys of their own that way, and programs that do not know them pass over them. Ours hold JSON. They come
back when the test is read again; anything in them that is not as it was written counts as not there.
"""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from ridedown.signals.codes import DUMMIES, ChannelCode
from ridedown.signals.history import Filter
from ridedown.signals.isomme_text import Descriptors
from ridedown.signals.record import Barrier, ChannelInfo, Occupant, OfficialResult, Restraint

_LONGEST = 100_000
_MEANING = ("location", "attachment", "quantity", "axis", "vehicle", "occupant", "redundant")

# reading


def _loaded(text: str) -> dict[str, Any]:
    """A JSON object, empty if the text holds anything else."""
    try:
        found = json.loads(text) if 0 < len(text) <= _LONGEST else {}
    except (ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


def _text(found: Mapping[str, Any], key: str) -> str:
    value = found.get(key)
    return value if isinstance(value, str) else ""


def _number(value: object) -> float | None:
    """A finite number, None for anything else."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number if math.isfinite(number) else None


def _texts(found: object) -> Mapping[str, str]:
    if not isinstance(found, dict):
        return MappingProxyType({})
    return MappingProxyType({key: value for key, value in found.items() if isinstance(value, str)})


def _vehicle(found: Mapping[str, Any]) -> int:
    value = found.get("vehicle")
    return value if isinstance(value, int) and not isinstance(value, bool) and 0 <= value <= 9 else 1


def fields(text: str) -> Mapping[str, str]:
    """Names and texts."""
    return _texts(_loaded(text))


def occupants(texts: Iterable[str]) -> tuple[Occupant, ...]:
    """The occupants, with the laboratory's own results."""
    return tuple(
        Occupant(
            seat=_text(found, "seat"),
            vehicle=_vehicle(found),
            dummy=_text(found, "dummy"),
            percentile=_text(found, "percentile"),
            official=_results(found.get("official")),
            fields=_texts(found.get("fields")),
        )
        for found in map(_loaded, texts)
        if _text(found, "seat")
    )


def occupants_of(infos: Iterable[ChannelInfo]) -> tuple[Occupant, ...]:
    """The occupants whose seats the channel codes name, with the dummy of the first code that names one."""
    found: dict[tuple[int, str], tuple[str, str]] = {}
    for info in infos:
        if info.occupant and info.vehicle and info.code:
            dummy = DUMMIES.get(ChannelCode.parse(info.code).section)
            key = (info.vehicle, info.occupant)
            found[key] = found.get(key) or dummy or ("", "")
            if dummy and found[key] == ("", ""):
                found[key] = dummy
    return tuple(Occupant(seat, vehicle, *dummy) for (vehicle, seat), dummy in sorted(found.items()))


def _results(found: object) -> Mapping[str, OfficialResult]:
    results = {}
    for name, parts in found.items() if isinstance(found, dict) else ():
        value = _number(parts.get("value")) if isinstance(parts, dict) else None
        if value is not None:
            results[str(name)] = OfficialResult(
                value, _text(parts, "unit"), _number(parts.get("start")), _number(parts.get("end"))
            )
    return MappingProxyType(results)


def restraints(texts: Iterable[str]) -> tuple[Restraint, ...]:
    """The restraints."""
    names = ("seat", "kind", "mount", "deployment", "comment")
    return tuple(
        Restraint(vehicle=_vehicle(found), fields=_texts(found.get("fields")), **{name: _text(found, name) for name in names})
        for found in map(_loaded, texts)
        if _text(found, "seat")
    )


def barrier(text: str) -> Barrier | None:
    """The barrier, None where there is none."""
    found = _loaded(text)
    if not found:
        return None
    return Barrier(_text(found, "kind"), _text(found, "shape"), _number(found.get("mass")), _texts(found.get("fields")))


def amended(info: ChannelInfo, head: Descriptors) -> ChannelInfo:
    """A channel whose file says more of its meaning than its code does."""
    found = _loaded(head.text(".Meaning"))
    changes: dict[str, Any] = {
        name: found[name]
        for name in ("location", "attachment", "quantity", "axis", "occupant")
        if isinstance(found.get(name), str)
    }
    if "vehicle" in found:
        changes["vehicle"] = _vehicle(found)
    if isinstance(found.get("redundant"), bool):
        changes["redundant"] = found["redundant"]
    return replace(info, **changes) if changes else info


def filter_of(text: str) -> Filter | None:
    """A filter and those before it, None where the text holds none."""
    steps = _loaded(text).get("steps")
    built: Filter | None = None
    for step in steps[:10] if isinstance(steps, list) else ():
        size = _number(step.get("class")) if isinstance(step, dict) else None
        if not size or size < 0.0:
            return None
        built = Filter(size, _text(step, "standard"), built)
    return built


# writing


def dumped(found: Occupant | Restraint | Barrier) -> str:
    """A part of a record as one line of JSON, without what is empty."""
    parts = {part.name: getattr(found, part.name) for part in dataclasses.fields(found)}
    return json.dumps({name: _plain(value) for name, value in parts.items() if value is not None and value != ""})


def dumped_fields(found: Mapping[str, str]) -> str:
    """Names and texts as one line of JSON; empty where there are none."""
    return json.dumps(dict(found)) if found else ""


def _plain(value: object) -> object:
    if isinstance(value, Mapping):
        return {name: _plain(part) for name, part in value.items()}
    return dataclasses.asdict(value) if isinstance(value, OfficialResult) else value


def meaning(info: ChannelInfo) -> str:
    """What a channel means beyond what its code says, as JSON; empty where the code says it all."""
    told: dict[str, object] = {"redundant": False}
    if info.code:
        code = ChannelCode.parse(info.code)
        told = {
            "location": code.place,
            "quantity": code.kind,
            "axis": code.axis,
            "vehicle": code.vehicle if code.object != "B" else 0,
            "occupant": code.seat,
            "redundant": code.redundant,
        }
    more = {name: getattr(info, name) for name in _MEANING}
    more = {name: value for name, value in more.items() if value != told.get(name) and value not in ("", None)}
    return json.dumps(more) if more else ""


def filter_text(filtered: Filter | None) -> str:
    """A filter and those before it as JSON, the first of them first; empty where its class alone says it all."""
    if filtered is None or (not filtered.standard and filtered.after is None):
        return ""
    steps: list[dict[str, object]] = []
    step: Filter | None = filtered
    while step is not None:
        steps.insert(0, {"class": step.frequency_class, "standard": step.standard})
        step = step.after
    return json.dumps({"steps": steps})
