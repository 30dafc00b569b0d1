"""The answer to every kind of request: parse, call the library, and put the result in the page's form."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from threading import Lock
from typing import Any

from ridedown import catalogue as published
from ridedown.apps.web import crash, maps, results
from ridedown.apps.web.requests import scenario_of
from ridedown.apps.web.sliders import sliders
from ridedown.report.lines import G
from ridedown.response import Response
from ridedown.scenario import CrashScenario, NetworkScenario, SledScenario, dump
from ridedown.simulation import simulate

Message = Mapping[str, Any]
Answer = dict[str, Any] | crash.Frame

_KINDS = {CrashScenario: "crash", NetworkScenario: "network", SledScenario: "sled"}


def catalogue(_message: Message) -> Answer:
    """Every published scenario, with how sure its numbers are."""
    return {"kind": "catalogue", "entries": _entries(), "g": G}


@cache
def _entries() -> list[dict[str, str]]:
    entries = [published.entry(name) for name in published.names()]
    return [{"name": one.name, "description": one.description, "confidence": one.confidence} for one in entries]


def describe(message: Message) -> Answer:
    """A scenario's numbers as sliders, what a map of it can show, and its text."""
    scenario = scenario_of({**message, "values": None})
    return {
        "kind": "scenario",
        "of": _KINDS[type(scenario)],
        "name": scenario.name,
        "description": scenario.description,
        "sliders": sliders(scenario),
        "outcomes": maps.outcomes(scenario),
        "toml": dump(scenario),
    }


def crash_map(message: Message) -> Answer:
    """A map (see `maps`)."""
    return maps.crash_map(scenario_of(message), message)


def bound(message: Message) -> Answer:
    """The least that any restraint could give, for the crashes of a map (see `bounds`)."""
    from ridedown.apps.web import bounds  # noqa: PLC0415  needs scipy's splines

    return bounds.bound_map(scenario_of(message), message)


def bound_here(message: Message) -> Answer:
    """One crash beside its bound (see `bounds`)."""
    from ridedown.apps.web import bounds  # noqa: PLC0415

    return bounds.bound_here(scenario_of(message), message)


def paper(_message: Message) -> Answer:
    """The founding paper's figures, numbers and trends, simulated once a server."""
    return _paper()


@cache
def _paper() -> Answer:
    from ridedown.apps.web.figures import paper_figures  # noqa: PLC0415  few sessions ask for it

    return paper_figures()


class Responses:
    """The responses of one session: the last few are kept, for tables are asked for once the curves are drawn."""

    _KEPT = 3

    def __init__(self) -> None:
        self._kept: dict[str, Response] = {}
        self._lock = Lock()

    def curves(self, message: Message) -> Answer:
        """Simulate, and give the curves (see `crash`)."""
        return crash.curves(self._response(message))

    def results(self, message: Message) -> Answer:
        """What the same crash comes to (see `results`)."""
        return results.results(self._response(message))

    def _response(self, message: Message) -> Response:
        key = json.dumps([message.get(field) for field in ("scenario", "toml", "values")], sort_keys=True)
        with self._lock:
            if key in self._kept:
                return self._kept[key]
        response = simulate(scenario_of(message), throw=False)
        with self._lock:
            self._kept[key] = response
            while len(self._kept) > self._KEPT:
                self._kept.pop(next(iter(self._kept)))
        return response
