"""What a folder of results comes to, in plain data: how many rows, which failed and why, the reach of each outcome."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ridedown.studies.results.sql import connect
from ridedown.studies.results.store import read_manifest, read_results


def summary_of(folder: Path) -> dict[str, Any]:
    """Plain data for JSON: `rows`, `done`, `failed` (by why), `outcomes` (least, mean and largest, SI),
    `results`: what the study says (see `results`), once it is finished.

    Raises: InvalidInput for a folder without results.
    """
    manifest = read_manifest(folder)
    connection = connect(folder)
    (done,) = connection.execute("SELECT count(*) FROM results").fetchone() or (0,)
    failed = connection.execute(
        "SELECT status, why, count(*) FROM results WHERE status <> 'completed' GROUP BY ALL ORDER BY 3 DESC, 2"
    ).fetchall()
    outcomes = [column for column in manifest["columns"] if column["role"] == "outcome"]
    found: dict[str, dict[str, Any]] = {}
    for start in range(0, len(outcomes), 32):
        some = outcomes[start : start + 32]
        asked = ", ".join(f"min({q}), avg({q}), max({q})" for q in (quoted(column["name"]) for column in some))
        values = connection.execute(f"SELECT {asked} FROM results").fetchone() or ()
        for i, column in enumerate(some):
            least, mean, most = values[3 * i : 3 * i + 3]
            found[column["name"]] = {"unit": column["unit"], "min": least, "mean": mean, "max": most}
    return {
        "folder": str(folder),
        "study": manifest["study"],
        "rows": manifest["rows"],
        "done": done,
        "complete": done == manifest["rows"],
        "failed": [{"status": status, "why": why, "rows": rows} for status, why, rows in failed],
        "outcomes": found,
        "remarks": manifest.get("remarks", []),
        "results": read_results(folder),
    }


def quoted(name: str) -> str:
    """A column's name in SQL."""
    return '"' + name.replace('"', '""') + '"'
