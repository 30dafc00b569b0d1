"""Restraints fitted to measured tests from the page: one at a time for each session, a few at once, each for a bounded time.

What is fitted and how the library says (`studies.calibration`). Fits are kept under a hash of what was asked, so that the
address of the page finds its fit again; like the tests, in memory only.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import threading
import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ridedown.apps.web.crash import Frame, finite
from ridedown.apps.web.refusals import TooMuch, refusal
from ridedown.apps.web.requests import number
from ridedown.apps.web.results import table_of
from ridedown.apps.web.uploads import Uploads
from ridedown.errors import InvalidInput, UnknownName
from ridedown.signals import TestRecord
from ridedown.studies.calibration.of_test import END, TEMPLATES, calibration_of_test, fittable, is_acceleration

if TYPE_CHECKING:
    from ridedown.studies import Calibrated, Calibration

MOST_SECONDS = 120.0
"""A fit that takes longer ends with the best so far; one takes 3 to 10 s."""
AT_ONCE = 2
"""Fits that run on one server: each keeps a core busy."""
MOST_KEPT = 16

_MASS, _END = (1.0, 500.0), (0.010, 1.0)  # kg, s: what a request may ask for
_LARGEST = 1e12
_EFFORTS = ("quick", "normal", "thorough")
_CURVES = ("model", "low", "high", "wide_low", "wide_high")

Answer = dict[str, Any] | Frame


@dataclasses.dataclass(eq=False)
class Fit:
    """A fit: written by the thread that runs it, read by everyone. owner: the session that began it."""

    key: str
    owner: object
    began: float
    stage: str = "reading"
    tried: int = 0
    misfit: float = float("inf")
    cancelled: bool = False
    ended: bool = False
    seconds: float = 0.0
    trouble: str = ""
    found: Calibrated | None = None


class Fits:
    """The fits of this server, those that run and the last that ended. seconds: how long one may take."""

    def __init__(self, uploads: Uploads, *, seconds: float = MOST_SECONDS) -> None:
        self.uploads = uploads
        self.seconds = seconds
        self._kept: dict[str, Fit] = {}
        self._lock = threading.Lock()

    def answer(self, message: Mapping[str, Any], owner: object) -> Answer:
        """Suggest, start, look at or cancel a fit.

        Raises: InvalidInput, UnknownName.
        """
        actions: dict[str, Callable[[Mapping[str, Any], object], Answer]] = {
            "suggest": self._suggest,
            "start": self._start,
            "look": self._look,
            "cancel": self._cancel,
        }
        action = str(message.get("action"))
        if action not in actions:
            raise UnknownName.among("action", action[:50], actions)
        return actions[action](message, owner)

    def close(self) -> None:
        """End those that run, as soon as they look up."""
        for fit in list(self._kept.values()):
            fit.cancelled = True

    def scenario(self, key: str) -> bytes:
        """The fitted scenario as a file. Raises: InvalidInput, UnknownName."""
        found = self._found(key)
        return found.toml(_case(found)).encode()

    def report(self, key: str, file: str) -> bytes:
        """The page of a calibration, as `ridedown calibrate` writes it, or the same as `report.pdf`.

        Raises: InvalidInput, UnknownName.
        """
        from ridedown.report.calibration import html, pdf, plots  # noqa: PLC0415  draws, which takes a second to load

        found = self._found(key)
        drawn = plots(found)
        return pdf(found, drawn) if file == "report.pdf" else html(found, drawn).encode()

    # what a request asks for

    def _suggest(self, message: Mapping[str, Any], _owner: object) -> Answer:
        """What can be fitted in a test, and with what."""
        record = self.uploads.record(message)
        return {
            "kind": "suggestion",
            "test": message.get("test"),
            "channels": [dataclasses.asdict(one) for one in fittable(record)],
            "pulses": [
                {"key": info.key, "label": info.name or info.key}
                for info in record.channels.values()
                if info.readable and not info.occupant and is_acceleration(info)
            ],
            "templates": [
                {"name": kind.name, "what": kind.what, "numbers": [dataclasses.asdict(one) for one in kind.numbers]}
                for kind in TEMPLATES.values()
            ],
            "end": END,
            "efforts": list(_EFFORTS),
        }

    def _start(self, message: Mapping[str, Any], owner: object) -> Answer:
        """Begin what is asked, unless it is there already."""
        asked = {key: value for key, value in message.items() if key not in {"id", "lane", "action"}}
        key = hashlib.sha256(json.dumps(asked, sort_keys=True).encode()).hexdigest()[:20]
        with self._lock:
            known = self._kept.get(key)
        if known is not None and not (known.ended and (known.cancelled or known.trouble)):
            return _told(known)
        calibration = _calibration(self.uploads.record(message), message)
        fit = Fit(key, owner, time.monotonic())
        with self._lock:
            self._make_room(owner)
            self._kept[key] = fit
        threading.Thread(target=_run, args=(fit, calibration, self.seconds), daemon=True).start()
        return _told(fit)

    def _make_room(self, owner: object) -> None:
        running = [fit for fit in self._kept.values() if not fit.ended]
        if any(fit.owner is owner for fit in running):
            raise InvalidInput("fit: got a second one; need the first to end. Wait, or cancel it.")
        if len(running) >= AT_ONCE:
            raise TooMuch(f"fit: got {AT_ONCE} of other pages running; need one of them to end first. Try again in a while.")
        ended = [key for key, fit in self._kept.items() if fit.ended]
        for key in ended[: max(0, len(self._kept) - MOST_KEPT + 1)]:
            self._kept.pop(key)

    def _look(self, message: Mapping[str, Any], _owner: object) -> Answer:
        return _told(self._of(str(message.get("fit"))))

    def _cancel(self, message: Mapping[str, Any], _owner: object) -> Answer:
        fit = self._of(str(message.get("fit")))
        fit.cancelled = fit.cancelled or not fit.ended
        return _told(fit)

    def _of(self, key: str) -> Fit:
        with self._lock:
            if key in self._kept:
                return self._kept[key]
        raise UnknownName("fit: this server does not hold it any more; it keeps fits in memory only. Start it again.")

    def _found(self, key: str) -> Calibrated:
        found = self._of(key).found
        if found is None:
            raise InvalidInput("fit: got one without a result; need one that has ended. Wait, or start it again.")
        return found


def _calibration(record: TestRecord, message: Mapping[str, Any]) -> Calibration:
    """What a request asks to be fitted."""
    effort = message.get("effort", "normal")
    if effort not in _EFFORTS:
        raise UnknownName.among("effort", str(effort)[:50], _EFFORTS)
    free, held = _numbers(message.get("free"), 2), _numbers(message.get("held"), 1)
    return calibration_of_test(
        record,
        str(message.get("channel"))[:200],
        str(message.get("template"))[:60],
        free={name: (ends[0], ends[1]) for name, ends in free.items()},
        held={name: one for name, (one,) in held.items()},
        mass=number(message, "mass", *_MASS),
        pulse=str(message.get("pulse") or "")[:200],
        end=number(message, "end", *_END),
        effort=effort,
    )


def _numbers(given: object, count: int) -> dict[str, list[float]]:
    """Names with so many numbers each. Raises: InvalidInput."""
    if given is None:
        return {}
    if not isinstance(given, Mapping) or len(given) > 100:
        raise InvalidInput("parameters: got no table of names with numbers; need one. Send an object.")
    found = {}
    for name, values in given.items():
        listed = values if isinstance(values, list) else [values]
        if len(listed) != count or not all(_is_number(one) for one in listed):
            raise InvalidInput(
                f"{str(name)[:60]}: got no {'bounds' if count == 2 else 'value'}; need {count} of finite size. Type them."
            )
        found[str(name)] = [float(one) for one in listed]
    return found


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= _LARGEST


def _run(fit: Fit, calibration: Calibration, seconds: float) -> None:
    """Fit on a thread of its own, until the end, until it is cancelled, or until its time is over."""
    from ridedown.studies import calibrate  # noqa: PLC0415  heavy

    def progress(stage: str, tried: int, misfit: float) -> None:
        fit.stage, fit.tried, fit.misfit = stage, tried, misfit
        late = time.monotonic() - fit.began > seconds
        if stage == "searching" and tried and np.isfinite(misfit) and (fit.cancelled or late):
            raise KeyboardInterrupt  # as Ctrl-C on the command line: the best so far is given

    try:
        found = calibrate(calibration, progress=progress)
        # the test itself is not kept with the fit: what is asked of it later needs names and numbers only
        fit.found = dataclasses.replace(found, calibration=calibration.model_copy(update={"cases": ()}))
    except BaseException as error:  # it ends the fit, not the server
        fit.trouble = refusal(error)["message"] if isinstance(error, Exception) else type(error).__name__
    finally:
        fit.seconds = time.monotonic() - fit.began
        fit.ended = True


def _told(fit: Fit) -> Answer:
    """How a fit stands; with its result once it has one."""
    header = {
        "kind": "fit",
        "fit": fit.key,
        "stage": fit.stage,
        "tried": fit.tried,
        "misfit": fit.misfit if np.isfinite(fit.misfit) else None,
        "seconds": fit.seconds if fit.ended else time.monotonic() - fit.began,
        "cancelled": fit.cancelled,
        "ended": fit.ended,
        "trouble": fit.trouble,
    }
    return header if fit.found is None else _result(header, fit.found)


def _case(found: Calibrated) -> str:
    return next(iter(found.scenarios))


def _result(header: dict[str, Any], found: Calibrated) -> Frame:
    """A fit with its parameters, notes and tables; arrays: `time` (T,) [s], `values` (6, T) in SI: measured, then _CURVES."""
    from ridedown.report import calibration_tables  # noqa: PLC0415

    channel = found.channels[0]
    parameters, *others = calibration_tables.tables(found)
    result = {
        "name": channel.name,
        "unit": channel.unit,
        "cfc": channel.cfc,
        "rating": None if channel.rating is None else channel.rating.value,
        "grade": None if channel.rating is None else channel.rating.grade,
        "peak_error": channel.peak_error,
        "peak_time_error": channel.peak_time_error,
        "within": channel.within,
        "interrupted": found.interrupted,
        "warnings": list(found.warnings),
        "parameters": table_of(parameters),
        "tables": [table_of(table) for table in others],
        "values": found.values,
        "toml": found.toml(_case(found)),
    }
    rows = [np.full_like(channel.times, np.nan) if channel.measured is None else channel.measured]
    rows += [getattr(channel, name) for name in _CURVES]
    return {**header, "result": result}, {"time": channel.times, "values": finite(np.array(rows))}
