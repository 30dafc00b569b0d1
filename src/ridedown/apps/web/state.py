"""What the server holds while it runs: threads to compute on, whether the solver is compiled, tests that were dropped."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

from ridedown.apps.first_run import compile_side_by_side
from ridedown.apps.web.fits import Fits
from ridedown.apps.web.refusals import TooMuch
from ridedown.apps.web.studies import Studies
from ridedown.apps.web.uploads import Uploads

MOST_SESSIONS = 64
MOST_UPLOADS = 8
"""Uploads that are received, or wait to be read, at once: each may be held in memory whole."""
MOST_DRAWINGS = 16
"""Reports that are drawn or wait to be."""

_Made = TypeVar("_Made")


class Server:
    """One running server. Curves have threads of their own, so that no map, upload or report keeps a slider waiting.

    Uploads are read one after the other, so that a flood of them keeps nothing else waiting.
    Figures and PDFs are made one after the other: a map does not wait for them, and what matplotlib is set to is one for all.
    """

    def __init__(self, studies: Studies) -> None:
        cores = os.cpu_count() or 1
        self.quick = ThreadPoolExecutor(max(2, cores), thread_name_prefix="ridedown-quick")
        self.slow = ThreadPoolExecutor(max(2, cores), thread_name_prefix="ridedown-slow")
        self.bounding = ThreadPoolExecutor(1, thread_name_prefix="ridedown-bounding")  # seconds each: a map goes before
        self.drawing = ThreadPoolExecutor(1, thread_name_prefix="ridedown-drawing")
        self.drawings = 0
        self.reading = ThreadPoolExecutor(1, thread_name_prefix="ridedown-reading")
        self.uploading = 0
        self.uploads = Uploads()
        self.fits = Fits(self.uploads)
        self.studies = studies
        self.sessions = 0
        self.ready = asyncio.Event()
        self.trouble = ""

    async def warm(self) -> None:
        """Compile what is not compiled, and simulate once, so that the first answer is as quick as all others."""
        try:
            await asyncio.get_running_loop().run_in_executor(self.slow, _warm)
        except Exception as error:  # said on the page; a request will meet the same error and tell it
            self.trouble = f"{type(error).__name__}: {error}"
        finally:
            self.ready.set()

    async def draw(self, make: Callable[..., _Made], *given: object) -> _Made:
        """What `make` makes of what is given, in its turn. Raises: TooMuch where too many wait already."""
        if self.drawings >= MOST_DRAWINGS:
            raise TooMuch(f"report: got one more than the {MOST_DRAWINGS} that wait to be drawn; need fewer. Ask again soon.")
        self.drawings += 1
        try:
            return await asyncio.get_running_loop().run_in_executor(self.drawing, make, *given)
        finally:
            self.drawings -= 1

    def state(self) -> dict[str, Any]:
        """Whether requests are answered yet."""
        return {"kind": "state", "state": "ready" if self.ready.is_set() else "compiling", "trouble": self.trouble}

    def close(self) -> None:
        """Let go of the threads; what runs in them is not waited for."""
        self.studies.close()
        self.fits.close()
        for pool in (self.quick, self.slow, self.bounding, self.drawing, self.reading):
            pool.shutdown(wait=False, cancel_futures=True)


def _warm() -> None:
    # heavy imports, which a server that only shows its page need not wait for
    from ridedown.apps.uncompiled import of_a_run, of_all_criteria  # noqa: PLC0415
    from ridedown.apps.web import crash, maps, requests, results  # noqa: PLC0415
    from ridedown.compiled import can_be_kept  # noqa: PLC0415
    from ridedown.simulation import simulate  # noqa: PLC0415

    missing = list(dict.fromkeys([*of_a_run(), *of_all_criteria()]))
    if missing and can_be_kept(missing[0]):
        compile_side_by_side(missing)
    scenario = requests.scenario_of({"scenario": "example-offset"})
    response = simulate(scenario, throw=False)
    crash.curves(response)
    results.results(response)
    message = {"side": 8, "outcome": "driver.acceleration.peak", "x": "vehicle1.mass", "y": "driver.restraint.slack"}
    maps.crash_map(scenario, message)
