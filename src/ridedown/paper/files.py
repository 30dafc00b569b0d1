"""The reproduction as a folder of files."""

from __future__ import annotations

import json
from pathlib import Path

from ridedown.paper.figures import plots
from ridedown.paper.page import html
from ridedown.paper.reproduce import Reproduction


def write(reproduction: Reproduction, folder: Path) -> None:
    """Write `index.html`, `paper.json` and figures 6 to 19 (SVG) into an existing folder."""
    drawn = plots(reproduction.responses)
    for plot in drawn:
        (folder / f"{plot.name}.svg").write_bytes(plot.svg)
    (folder / "paper.json").write_text(json.dumps(reproduction.to_dict(), indent=2) + "\n", encoding="utf-8")
    (folder / "index.html").write_text(html(reproduction.headlines, reproduction.trends, drawn), encoding="utf-8")
