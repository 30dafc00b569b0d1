"""What a crash comes to, for the page: the same tables as on the command line, verdicts, and where the energy went."""

from __future__ import annotations

from typing import Any

from ridedown.limits import CRITERIA, Judgement, Verdict, assess_all, evidence, regulation, regulations
from ridedown.report import summary
from ridedown.report.tables import Table
from ridedown.response import Response
from ridedown.scenario import NetworkScenario


def results(response: Response) -> dict[str, Any]:
    """Tables as text, verdicts with their numbers, and energies [J]."""
    return {
        "kind": "results",
        "notes": list(summary.notes(response)),
        "verdicts": verdicts(response),
        "peaks": peaks(response),
        "energy": energy(response),
        "tables": [table_of(table) for table in summary.result_tables(response)],
        "sources": table_of(summary.sources(response)),
    }


def table_of(table: Table) -> dict[str, Any]:
    """A table as plain data."""
    columns = [{"title": one.title, "unit": one.unit, "numeric": one.numeric} for one in table.columns]
    return {"caption": table.caption, "columns": columns, "rows": [list(row) for row in table.rows]}


def verdicts(response: Response) -> list[dict[str, Any]]:
    """Every criterion of every occupant with a value, before each regulation for occupants."""
    if isinstance(response.scenario, NetworkScenario) or not response.occupants:
        return []
    have = evidence(response)
    have.vehicles = ()  # what is asked of vehicles is for other crashes, and takes longer
    names = [name for name in regulations() if regulation(name).occupants != "none"]
    return [
        verdict_row(one, assessment.regulation.name)
        for assessment in assess_all(have, names)
        for one in assessment.judgements
        if one.value is not None
    ]


def verdict_row(one: Judgement, rule: str) -> dict[str, Any]:
    """A judgement as plain data, in the field's units."""
    criterion = CRITERIA[one.criterion].label + (f" ({one.level})" if one.level else "")
    return {
        "regulation": rule,
        "subject": one.subject,
        "criterion": criterion,
        "unit": one.unit,
        "value": one.shown(one.value),
        "limit": one.shown(one.limit),
        "start": one.start,
        "end": one.end,
        "verdict": "no verdict" if one.verdict is Verdict.NOT_JUDGED else one.verdict.value,
        "reason": one.reason,
    }


def peaks(response: Response) -> list[dict[str, Any]]:
    """Exact peaks of each occupant, SI, with their times [s]."""
    return [
        {"who": name, "channel": f"{name}.{quantity}", "unit": unit, "value": peak.value, "time": peak.time}
        for name, found in response.occupants.items()
        for quantity, unit, peak in (
            ("acceleration", "m/s2", found.peak_acceleration),
            ("excursion", "m", found.excursion),
        )
    ]


def energy(response: Response) -> dict[str, Any]:
    """Where the kinetic energy went [J]."""
    balance = response.energy
    return {
        "initial": balance.initial,
        "final": balance.final,
        "left_out": sum(one.left_out for one in balance.elements.values()),
        "elements": [
            {"name": name, "absorbed": one.absorbed, "stored": one.stored, "dissipated": one.dissipated}
            for name, one in balance.elements.items()
        ],
    }
