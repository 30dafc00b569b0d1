"""The state of the page as files: scenario, channels, laboratory format, report as HTML and as PDF."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ridedown.apps.web.requests import scenario_of
from ridedown.errors import UnknownName
from ridedown.response import Response
from ridedown.scenario import dump
from ridedown.simulation import simulate


@dataclass(frozen=True, slots=True)
class Export:
    """A file: its name, type and content."""

    name: str
    media_type: str
    content: bytes


def export(kind: str, message: Mapping[str, Any]) -> Export:
    """The file of one of KINDS for the scenario of a request.

    Raises: InvalidInput, UnknownName.
    """
    if kind not in _MAKERS:
        raise UnknownName.among("export", kind[:50], _MAKERS)
    suffix, media_type, make = _MAKERS[kind]
    scenario = scenario_of(message)
    stem = "".join(c for c in scenario.name if c.isascii() and (c.isalnum() or c in "-_.")).strip(".") or "crash"
    return Export(f"{stem}{suffix}", media_type, make(simulate(scenario, throw=False)))


def _toml(response: Response) -> bytes:
    return dump(response.scenario).encode()


def _written(name: str, write: Callable[[Response, Path], object]) -> Callable[[Response], bytes]:
    """What a function writes to a path, as bytes; the path is in a folder of its own, which goes at once."""

    def make(response: Response) -> bytes:
        with tempfile.TemporaryDirectory(prefix="ridedown-") as folder:
            path = Path(folder) / name
            write(response, path)
            return path.read_bytes()

    return make


def _isomme(response: Response, path: Path) -> None:
    from ridedown.signals import write  # noqa: PLC0415

    write(response.to_record(), path)


def _html(response: Response) -> bytes:
    from ridedown.report.figures import plots  # noqa: PLC0415  draws, which is slow to import
    from ridedown.report.run import html  # noqa: PLC0415

    return html(response, plots(response)).encode()


def _pdf(response: Response) -> bytes:
    from ridedown.report.figures import plots  # noqa: PLC0415
    from ridedown.report.run import pdf  # noqa: PLC0415

    return pdf(response, plots(response))


_MAKERS: dict[str, tuple[str, str, Callable[[Response], bytes]]] = {
    "scenario": (".toml", "application/toml", _toml),
    "csv": (".csv", "text/csv", _written("channels.csv", Response.to_csv)),
    "isomme": (".mme.zip", "application/zip", _written("channels.zip", _isomme)),
    "report": (".html", "text/html", _html),
    "pdf": (".pdf", "application/pdf", _pdf),
}

KINDS = tuple(_MAKERS)
DRAWN = ("report", "pdf")
"""Those with figures."""
