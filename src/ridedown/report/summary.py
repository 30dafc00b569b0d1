"""What a run comes to, as tables: vehicles, occupants, energy, momentum, events, sources."""

from __future__ import annotations

from typing import Any

from ridedown.events import Event
from ridedown.limits import CrashCriteria, OccupantCriteria, criteria_of, evidence
from ridedown.motion import motion_of
from ridedown.report.pulse import about, measure, pulse_table
from ridedown.report.tables import NONE, Column, Table, number
from ridedown.response import MassResult, Response, VehicleResult
from ridedown.scenario import SledScenario

G = 9.80665  # m/s2, the standard value
KMH = 3.6

_MS = 1e3
_ROUNDING = 1e-12  # share of the energy that is no more than rounding
_LEFT_OUT = "left out by the model"  # restraints that do not push back, the lever arm as printed


def result_tables(response: Response) -> tuple[Table, ...]:
    """The results in the order to read them in; those with no row are left out."""
    made = (
        sled(response),
        vehicles(response),
        masses(response),
        occupants(response),
        bodies(response),
        restraints(response),
        criteria(response),
        energy(response),
        momentum(response),
    )
    return tuple(table.without_empty_columns() for table in made if table.rows)


def notes(response: Response) -> tuple[str, ...]:
    """What a reader has to know before the numbers."""
    said = []
    if not response.completed:
        said.append(
            f"The simulation stopped at {_MS * response.end_time:.3f} ms: {response.status.sentence}. "
            "All numbers are those of the part computed."
        )
    rebuilt = [source for source in response.sources if source.confidence == "reconstructed"]
    if rebuilt:
        titles = "; ".join(source.title for source in rebuilt)
        said.append(f"Reconstructed, not published: {titles}. See the sources.")
    return (*said, *about(response.scenario))


_MOTION = (
    Column("Mass", "kg"),
    Column("Speed", "km/h"),
    Column("Delta-v", "km/h"),
    Column("Peak acceleration", "g"),
    Column("at", "ms"),
)


def _motion(body: VehicleResult | MassResult) -> tuple[str, ...]:
    """The cells of `_MOTION`."""
    return (
        number(body.mass, 0),
        number(body.speed, scale=KMH),
        number(body.delta_v, scale=KMH),
        number(body.peak_acceleration.value / G),
        number(body.peak_acceleration.time, scale=_MS),
    )


def vehicles(response: Response) -> Table:
    """Each vehicle: how it was, how hard it was stopped, how far it was crushed."""
    restitution = response.restitution
    parted = "still in contact at the end" if restitution is None else f"coefficient of restitution {restitution:.3f}"
    return Table(
        f"Vehicles; {parted}",
        (
            Column("Vehicle", numeric=False),
            *_MOTION,
            Column("Dynamic crush", "mm"),
            Column("at", "ms"),
            Column("Residual crush", "mm"),
            Column("Time to rest", "ms"),
        ),
        tuple(
            (
                name,
                *_motion(v),
                number(v.dynamic_crush.value, 0, scale=1e3),
                number(v.dynamic_crush.time, scale=_MS),
                number(v.residual_crush, 0, scale=1e3),
                number(v.time_to_rest, scale=_MS),
            )
            for name, v in response.vehicles.items()
            if v.dynamic_crush is not None
        ),
    )


def sled(response: Response) -> Table:
    """The pulse of a sled's vehicle."""
    scenario = response.scenario
    return pulse_table([measure(motion_of(scenario, "vehicle1"))] if isinstance(scenario, SledScenario) else [])


def masses(response: Response) -> Table:
    """Each mass of a network."""
    return Table(
        "Masses",
        (
            Column("Mass", numeric=False),
            *_MOTION,
            Column("Largest displacement", "mm"),
            Column("at", "ms"),
        ),
        tuple(
            (
                name,
                *_motion(m),
                number(m.displacement.value, 0, scale=1e3),
                number(m.displacement.time, scale=_MS),
            )
            for name, m in response.masses.items()
        ),
    )


def occupants(response: Response) -> Table:
    """Each occupant: how hard, how far, with what force."""
    return Table(
        "Occupants; excursion is relative to the vehicle",
        (
            Column("Occupant", numeric=False),
            Column("In", numeric=False),
            Column("Mass", "kg"),
            Column("Peak acceleration", "g"),
            Column("at", "ms"),
            Column("Excursion", "mm"),
            Column("at", "ms"),
            Column("Relative to seat", "mm"),
            Column("Restraint force", "kN"),
            Column("Time to rest", "ms"),
        ),
        tuple(
            (
                name,
                o.vehicle,
                number(o.mass, 0),
                number(o.peak_acceleration.value / G),
                number(o.peak_acceleration.time, scale=_MS),
                number(o.excursion.value, 0, scale=1e3),
                number(o.excursion.time, scale=_MS),
                number(o.relative_displacement.value, 0, scale=1e3) if o.kind == "child" else NONE,
                number(o.restraint_force.value, scale=1e-3),
                number(o.time_to_rest, scale=_MS),
            )
            for name, o in response.occupants.items()
        ),
    )


def bodies(response: Response) -> Table:
    """Each body of the occupants that have several."""
    return Table(
        "Bodies of the occupants; excursion is relative to the vehicle",
        (
            Column("Body", numeric=False),
            Column("Mass", "kg"),
            Column("Peak acceleration", "g"),
            Column("at", "ms"),
            Column("Excursion", "mm"),
            Column("at", "ms"),
            Column("Time to rest", "ms"),
        ),
        tuple(
            (
                f"{name}.{body}",
                number(b.mass, 0),
                number(b.peak_acceleration.value / G),
                number(b.peak_acceleration.time, scale=_MS),
                number(b.excursion.value, 0, scale=1e3),
                number(b.excursion.time, scale=_MS),
                number(b.time_to_rest, scale=_MS),
            )
            for name, o in response.occupants.items()
            for body, b in o.bodies.items()
        ),
    )


def restraints(response: Response) -> Table:
    """What each restraint did, where any is more than one spring and damper."""
    found = response.restraints
    several = any(r.kind != "lumped" for r in found.values())
    return Table(
        "Restraints; travel is relative to what holds them, slack and gap included",
        (
            Column("Restraint", numeric=False),
            Column("Kind", numeric=False),
            Column("Force", "kN"),
            Column("at", "ms"),
            Column("Travel", "mm"),
            Column("at", "ms"),
            Column("Energy", "kJ"),
            Column("Pulled in", "mm"),
            Column("Let out", "mm"),
        ),
        tuple(
            (
                name,
                r.kind.replace("_", " "),
                number(r.force.value, 2, scale=1e-3),
                number(r.force.time, scale=_MS),
                number(r.travel.value, 0, scale=1e3),
                number(r.travel.time, scale=_MS),
                _kj(r.absorbed),
                number(r.pulled_in, 0, scale=1e3),
                number(r.paid_out, 0, scale=1e3),
            )
            for name, r in (found if several else {}).items()
        ),
    )


def criteria(response: Response) -> Table:
    """Each occupant's injury criteria, with the intervals they were found over."""
    lumped = [name for name, result in response.occupants.items() if not result.bodies]
    said = "each is one mass" if len(lumped) == len(response.occupants) else f"{', '.join(lumped)}: one mass"
    caution = f"; {said} without a head, so HIC, of the whole mass, is an indicator only" if lumped else ", along x"
    return Table(
        f"Criteria of the occupants{caution}",
        (
            Column("Occupant", numeric=False),
            Column("3 ms acceleration", "g"),
            Column("from", "ms"),
            Column("to", "ms"),
            Column("HIC15"),
            Column("from", "ms"),
            Column("to", "ms"),
            Column("HIC36"),
            Column("from", "ms"),
            Column("to", "ms"),
        ),
        tuple(
            (one.seat, *(cell for key in ("chest_3ms", "hic15", "hic36") for cell in _criterion(one, key)))
            for one in occupant_criteria(response).occupants
        ),
    )


def occupant_criteria(response: Response) -> CrashCriteria:
    """The criteria of a response's occupants alone: those of vehicles take longer, and a summary shows none."""
    have = evidence(response)
    have.vehicles = ()
    return criteria_of(have)


def run_data(response: Response) -> dict[str, Any]:
    """What a run comes to as plain data for JSON: the response's summary, and its occupants' criteria."""
    found = occupant_criteria(response).as_json()
    data = {**response.summary(), "criteria": {"occupants": found["occupants"]}}
    if isinstance(response.scenario, SledScenario):
        data["pulse"] = measure(motion_of(response.scenario, "vehicle1")).as_json()
    return data


def _criterion(occupant: OccupantCriteria, key: str) -> tuple[str, str, str]:
    found = occupant.findings.get(key)
    if found is None:
        return NONE, NONE, NONE
    return number(occupant.value(key)), number(found.start, scale=_MS), number(found.end, scale=_MS)


def energy(response: Response) -> Table:
    """Where the kinetic energy went, element by element."""
    balance = response.energy
    share = 100.0 / balance.initial if balance.initial > 0.0 else 0.0
    left_out = sum(e.left_out for e in balance.elements.values())
    unbooked = "taken by the vehicle, whose motion is prescribed" if isinstance(response.scenario, SledScenario) else _LEFT_OUT
    rows = [("kinetic, at the start", _kj(balance.initial), number(share * balance.initial), NONE, NONE)]
    rows += [
        (name, _kj(e.absorbed), number(share * e.absorbed), _kj(e.stored), _kj(e.dissipated))
        for name, e in balance.elements.items()
    ]
    if abs(left_out) > _ROUNDING * balance.initial:
        rows.append((unbooked, _kj(left_out), number(share * left_out), NONE, NONE))
    rows.append(("kinetic, at the end", _kj(balance.final), number(share * balance.final), NONE, NONE))
    rows.append((f"unaccounted for: {_tiny(balance.residual)} of the initial energy", NONE, NONE, NONE, NONE))
    return Table(
        "Energy",
        (
            Column("Where", numeric=False),
            Column("Energy", "kJ"),
            Column("Share", "%"),
            Column("of it stored", "kJ"),
            Column("dissipated", "kJ"),
        ),
        tuple(rows),
    )


def momentum(response: Response) -> Table:
    """Momentum along vehicle 1's forward direction, before and after."""
    balance = response.momentum
    rows = [
        ("at the start", number(balance.initial, 0)),
        ("impulse of the wall", number(balance.external, 0)),
        ("impulse of the sled" if isinstance(response.scenario, SledScenario) else _LEFT_OUT, number(balance.left_out, 0)),
        ("at the end", number(balance.final, 0)),
    ]
    kept = [row for row, value in zip(rows, (1.0, balance.external, balance.left_out, 1.0), strict=True) if value != 0.0]
    return Table(
        "Momentum, along the forward direction of vehicle 1",
        (Column("When", numeric=False), Column("Momentum", "kg m/s")),
        (*kept, (f"unaccounted for: {_tiny(balance.residual)} of all that moved", NONE)),
    )


def events(response: Response) -> Table:
    """All that happened, numbered in order; the figures are marked with these numbers."""
    return Table(
        "Events; figures carry these numbers",
        (Column("No."), Column("Time", "ms"), Column("Where", numeric=False), Column("What", numeric=False)),
        tuple(_event_row(i, event) for i, event in enumerate(response.events, 1)),
    )


def sources(response: Response) -> Table:
    """What the scenario's numbers rest on, and how sure they are."""
    return Table(
        "What the numbers rest on",
        (
            Column("Source", numeric=False),
            Column("Confidence", numeric=False),
            Column("Where", numeric=False),
            Column("Note", numeric=False),
        ),
        tuple(
            (
                ", ".join(str(part) for part in (source.authors, source.title, source.year) if part),
                source.confidence,
                source.where or NONE,
                source.note or NONE,
            )
            for source in response.sources
        ),
    )


def _event_row(i: int, event: Event) -> tuple[str, ...]:
    return (str(i), number(event.time, 2, scale=_MS), event.who, event.what)


def _tiny(value: float) -> str:
    return f"{value:.0e}".replace("-", "\u2212")


def _kj(value: float) -> str:
    return number(value, 2, scale=1e-3)
