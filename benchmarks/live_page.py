"""How fast the live page is, in real Chromium: .venv/bin/python benchmarks/live_page.py.

Prints slider to redrawn plots (from the slider's own event to the painted frame), maps of 10,000 crashes as the page shows
them, the first load once warm, and twenty that drag at once, each as fast as answers come.
"""

from __future__ import annotations

import asyncio
import json
import os
import shutil
import sys
import time
from pathlib import Path

import numpy as np
from playwright.sync_api import Page, sync_playwright
from websockets.asyncio.client import connect

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))  # a script is given its own folder only

from tests.apps.web.running import Running, running  # noqa: E402

DRAGS = 300
DRAGGERS, EACH = 20, 40
FRAME = 1.0 / 60.0  # s: no slider gives more events than the screen has frames
SCENARIOS = ("example-offset", "p1", "example-restraints")


def main() -> None:
    """Measure and print."""
    print(f"{os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}")
    found = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))))
    with running("--port", "0") as server, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1400, "height": 1000})
        for scenario in SCENARIOS:
            spread(f"slider to redrawn plots, {scenario}", drag(page, server, scenario))
        spread("map of 10,000 crashes, request to painted, example-offset", maps(page, server, "example-offset"))
        spread("the same of restraint against vehicle, p1", maps(page, server, "p1", "&x=vehicle1.mass"))
        spread("first load, to drawn plots", [load(page, server) for _ in range(5)])
        browser.close()
    with running("--port", "0") as server:
        with server.socket():  # ready
            pass
        spread(f"{DRAGGERS} that drag at once", asyncio.run(crowd(server)))
    print(f"load {os.getloadavg()[0]:.1f}")


def spread(what: str, times: list[float]) -> None:
    """Print the median and the 95th percentile of times in ms."""
    median, high = np.percentile(times, [50, 95])
    print(f"{what}: median {median:.0f} ms, 95th percentile {high:.0f} ms, of {len(times)}")


def opened(page: Page, server: Running, hash_: str, wait: str) -> None:
    """The page, anew, at an address."""
    page.goto("about:blank")
    page.goto(f"{server.address}/{hash_}")
    page.wait_for_selector(wait)


def drag(page: Page, server: Running, scenario: str) -> list[float]:
    """Move a slider in real key strokes, faster than the page redraws or not, and read what the page measured."""
    opened(page, server, f"#/crash?s={scenario}", ".results:not(.stale) table")
    slider = page.locator('[id="s-vehicle1.speed"]')
    slider.focus()
    for i in range(DRAGS):
        page.keyboard.press("ArrowRight" if i // 20 % 2 == 0 else "ArrowLeft")
        page.wait_for_timeout(30)
    return measured(page, "ridedown:redraw")


def maps(page: Page, server: Running, scenario: str, more: str = "") -> list[float]:
    """Look at every outcome of a scenario in turn."""
    opened(page, server, f"#/map?s={scenario}{more}", ".map canvas")
    outcome = page.get_by_label("Outcome")
    for name in outcome.locator("option").evaluate_all("all => all.map((one) => one.value)"):
        before = len(measured(page, "ridedown:map"))
        outcome.select_option(name)
        begun = time.monotonic()
        while len(measured(page, "ridedown:map")) == before and time.monotonic() - begun < 5.0:
            page.wait_for_timeout(20)
    return measured(page, "ridedown:map")


def load(page: Page, server: Running) -> float:
    """From the address to the first plots drawn [ms]."""
    page.goto("about:blank")
    begun = time.perf_counter()
    page.goto(f"{server.address}/#/crash?s=example-offset")
    page.wait_for_selector(".plot canvas")
    return 1e3 * (time.perf_counter() - begun)


def measured(page: Page, name: str) -> list[float]:
    """What the page measured itself [ms]."""
    times: list[float] = page.evaluate("name => performance.getEntriesByName(name).map((one) => one.duration)", name)
    return times


async def crowd(server: Running) -> list[float]:
    """Request to answer of each [ms]: the next goes out with the next frame of the screen after the answer."""

    async def one(number: int) -> list[float]:
        times = []
        async with connect(f"ws://127.0.0.1:{server.port}/live", origin=server.address, max_size=None) as socket:
            await socket.recv()
            for i in range(EACH):
                values = {"vehicle1.speed": 10.0 + 0.01 * i + 0.1 * number}
                begun = time.perf_counter()
                await socket.send(json.dumps({"kind": "simulate", "lane": "crash", "scenario": "p1", "values": values}))
                await socket.recv()
                taken = time.perf_counter() - begun
                times.append(1e3 * taken)
                await asyncio.sleep(max(FRAME - taken, FRAME - taken % FRAME))
        return times

    return [taken for times in await asyncio.gather(*map(one, range(DRAGGERS))) for taken in times]


if __name__ == "__main__":
    os.chdir(ROOT)
    main()
