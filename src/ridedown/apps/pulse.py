"""The pulse of a scenario's vehicle: shown, and written for other programs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from ridedown.apps import show
from ridedown.apps.measured import checked, output
from ridedown.errors import InvalidInput
from ridedown.motion import motion_of
from ridedown.report.pulse import about, measure, pulse_table, write_pulse
from ridedown.response import Response
from ridedown.scenario import Scenario, SledScenario, load


def pulse(
    source: str,
    vehicle: str,
    out: Path | None,
    simulate: Callable[[str], Response],
    *,
    as_json: bool,
    curve: int,
) -> None:
    """Print what a vehicle's pulse comes to, and write it where `out` says. Raises: InvalidInput, UnknownName."""
    scenario = load(source)
    body = f"vehicle{vehicle}" if vehicle.isdecimal() else vehicle
    motion = motion_of(scenario if isinstance(scenario, SledScenario) else _whole(simulate(source)), body)
    points = None
    if out is not None:
        tabular = out.suffix.lower() in {".csv", ".tsv", ".parquet"}
        points = write_pulse(
            output(str(out)) if tabular else checked(str(out)), motion, name=scenario.name or "pulse", vehicle=body, curve=curve
        )
    measured = measure(motion)
    if as_json:
        show.as_json({"name": scenario.name, "vehicle": body, **measured.as_json()})
        return
    show.note(f"{scenario.name or 'A pulse'}. {scenario.description}".strip())
    for text in about(scenario):
        show.note(text)
    show.tables(pulse_table([measured], vehicle=body, caption=_caption(scenario)))
    if points is not None:
        show.note(f"{points} points written to {out}")


def _caption(scenario: Scenario) -> str:
    how = "as prescribed" if isinstance(scenario, SledScenario) else "as simulated"
    return f"Pulse, {how}; {1e3 * float(scenario.duration):g} ms"


def _whole(response: Response) -> Response:
    if not response.completed:
        raise InvalidInput(
            f"scenario: got a simulation that stopped at {1e3 * response.end_time:.3f} ms: {response.status.sentence}; "
            "need one that is whole. Run it to see what it came to."
        )
    return response
