"""Design studies started from the page: one at a time, each in its own folder below the one that the user named."""

from __future__ import annotations

import dataclasses
import re
import secrets
import threading
import time
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ridedown import catalogue
from ridedown.apps.web.refusals import TooMuch, refusal
from ridedown.apps.web.requests import MOST_TEXT, refuse_files
from ridedown.apps.web.results import table_of
from ridedown.apps.web.study_files import KINDS
from ridedown.errors import InvalidInput, RidedownError, UnknownName
from ridedown.scenario.reading import table_in
from ridedown.studies import load_study
from ridedown.studies.file.study import LoadedStudy

if TYPE_CHECKING:
    from ridedown.report.study import Page

MOST_ROWS = 20_000_000
"""Of one study from the page: an hour or so."""
MOST_STUDIES = 200

_NAME = re.compile(r"[A-Za-z0-9_-]{1,60}")
_TEXT = "study.toml"


@dataclasses.dataclass
class _Running:
    """The study that runs: written by its thread, read by everyone."""

    name: str
    rows: int
    began: float
    done: int = 0
    before: int = 0
    failed: int = 0
    cancelled: bool = False
    ended: bool = False
    trouble: str = ""


class Studies:
    """The studies below a folder; without one, none can be started. No name leads out of it."""

    def __init__(self, folder: Path | None = None) -> None:
        self.folder = folder
        self._running: _Running | None = None
        self._lock = threading.Lock()
        self._told_before: dict[str, tuple[tuple[int, ...], dict[str, Any]]] = {}

    def answer(self, message: Mapping[str, Any]) -> dict[str, Any]:
        """List, start, cancel or resume; the answer is how all studies stand.

        Raises: InvalidInput, UnknownName.
        """
        actions = {"list": lambda _: None, "start": self._start, "resume": self._resume, "cancel": self._cancel}
        action = str(message.get("action"))
        if action not in actions:
            raise UnknownName.among("action", action[:50], actions)
        actions[action](message)
        return self._standing()

    def close(self) -> None:
        """Stop the study that runs; what it has done is kept."""
        if self._running is not None:
            self._running.cancelled = True

    def results(self, name: str) -> bytes:
        """All rows of a study as one Parquet file. Raises: InvalidInput, UnknownName."""
        import pyarrow as pa  # noqa: PLC0415  slow to import, and few sessions ask for it
        import pyarrow.parquet as pq  # noqa: PLC0415

        from ridedown.studies.results.store import chunk_files  # noqa: PLC0415

        files = chunk_files(self._own(name))
        if not files:
            raise InvalidInput(f"study: got {name}, with no rows done yet; need some. Wait, or resume it.")
        sink = pa.BufferOutputStream()
        with pq.ParquetWriter(sink, pq.read_schema(files[0]), compression="zstd") as writer:
            for file in files:
                writer.write_table(pq.read_table(file))
        return bytes(sink.getvalue())

    def report(self, name: str, file: str = "report.html") -> bytes:
        """The page of a study, as `ridedown study` writes it, or the same as `report.pdf`.

        Raises: InvalidInput, UnknownName.
        """
        from ridedown.report.study_pdf import pdf  # noqa: PLC0415  draws, which takes a second to load

        page = self._page(name)
        return pdf(page) if file == "report.pdf" else page.html().encode()

    def figures(self, message: Mapping[str, Any]) -> dict[str, Any]:
        """The page of a study in parts, its figures as SVG. Raises: InvalidInput, UnknownName."""
        page = self._page(str(message.get("study")))
        return {
            "kind": "figures",
            "status": page.status,
            "notes": list(page.notes),
            "sections": [
                {
                    "title": section.title,
                    "tables": [table_of(table) for table in section.tables if table.rows],
                    "plots": [
                        {"name": plot.name, "title": plot.title, "description": plot.description, "svg": plot.svg.decode()}
                        for plot in section.plots
                    ],
                }
                for section in page.sections
            ],
        }

    def _page(self, name: str) -> Page:
        """The page of a study of ours, drawn. Raises: InvalidInput, UnknownName."""
        from ridedown.report.study import page_of  # noqa: PLC0415

        loaded = self._begun(name)
        if loaded.searches and self.summary(name)["results"] is None:
            raise InvalidInput(f"study: got {name}, a search that has not ended; need its end to show figures. Resume it.")
        return page_of(loaded, self._own(name))

    def summary(self, name: str) -> dict[str, Any]:
        """What a study comes to so far. Raises: InvalidInput, UnknownName."""
        from ridedown.studies.results.summary import summary_of  # noqa: PLC0415

        found = summary_of(self._own(name))
        found.pop("folder")
        return found

    # what a request asks for

    def _start(self, message: Mapping[str, Any]) -> None:
        folder = self._writable()
        text = message.get("toml")
        if not isinstance(text, str) or len(text) > MOST_TEXT:
            raise TooMuch(f"toml: need the text of a study, {MOST_TEXT:,} characters at most. Send one.")
        loaded = _loaded(text)
        if len(self._names()) >= MOST_STUDIES:
            raise TooMuch(f"study: got {MOST_STUDIES} in the folder already; need fewer. Remove some of them.")
        stem = "".join(c for c in loaded.study.name if _NAME.fullmatch(c))[:40] or "study"
        name = f"{stem}-{secrets.token_hex(3)}"
        (folder / name).mkdir(parents=True)
        self._launch(name, loaded, resume=False)

    def _resume(self, message: Mapping[str, Any]) -> None:
        name = str(message.get("study"))
        self._launch(name, self._begun(name), resume=True)

    def _cancel(self, _message: Mapping[str, Any]) -> None:
        if self._running is not None:
            self._running.cancelled = True

    def _launch(self, name: str, loaded: LoadedStudy, *, resume: bool) -> None:
        from ridedown.studies.rows.plan import plan_of  # noqa: PLC0415  heavy

        plan = plan_of(loaded)
        if plan.rows > MOST_ROWS:
            raise TooMuch(f"parameters: got {plan.rows:,} rows; need {MOST_ROWS:,} at most here. Use `ridedown study`.")
        with self._lock:
            if self._running is not None and not self._running.ended:
                raise InvalidInput(f"study: got a second one; need {self._running.name} to end first. Wait, or cancel it.")
            self._running = running = _Running(name, plan.rows, time.monotonic())
        folder = self._writable() / name
        threading.Thread(target=_run, args=(running, loaded, plan, folder, resume), daemon=True).start()

    # where they are

    def _sums(self, name: str) -> dict[str, Any]:
        """What there is to say of a study before its figures are: of one that has ended, whose figures say all, the least."""
        from ridedown.studies.results.store import read_manifest, read_results  # noqa: PLC0415

        if read_results(self._own(name)) is None:
            return {key: value for key, value in self.summary(name).items() if key != "results"}
        rows = read_manifest(self._own(name))["rows"]
        return {"rows": rows, "done": rows, "complete": True, "outcomes": {}, "failed": []}

    def _writable(self) -> Path:
        if self.folder is None:
            raise InvalidInput("study: got no folder to keep results in; need one. Start `ridedown serve --studies DIR`.")
        return self.folder

    def _own(self, name: str) -> Path:
        """The folder of a study of ours."""
        if name not in self._names():
            raise UnknownName.among("study", name[:60], self._names())
        return self._writable() / name

    def _begun(self, name: str) -> LoadedStudy:
        """A study of ours as it was begun."""
        path = self._own(name) / _TEXT
        if path.is_symlink() or not path.is_file():
            raise InvalidInput(f"study: got {name}, which was not begun here; need one with its {_TEXT}.")
        return _loaded(path.read_text(encoding="utf-8"))

    def _names(self) -> list[str]:
        if self.folder is None or not self.folder.is_dir():
            return []
        found = (path for path in self.folder.iterdir() if _NAME.fullmatch(path.name))
        return sorted(path.name for path in found if path.is_dir() and not path.is_symlink())

    def _standing(self) -> dict[str, Any]:
        running = self._running
        shown = None
        if running is not None:
            shown = {**dataclasses.asdict(running), "seconds": time.monotonic() - running.began}
            del shown["began"]
        return {
            "kind": "studies",
            "possible": self.folder is not None,
            "kinds": dict(KINDS),
            "running": shown,
            "studies": [self._told(name) for name in self._names()],
        }

    def _told(self, name: str) -> dict[str, Any]:
        """How a study stands; of one that does not run it is looked up once."""
        folder = self._writable() / name
        files = [folder / _TEXT, folder / "manifest.json", folder / "results.json", folder / "chunks"]
        stamp = tuple(file.stat().st_mtime_ns if file.exists() else 0 for file in files)
        known = self._told_before.get(name)
        if known is not None and known[0] == stamp:
            return known[1]
        about = {"name": name, "kind": _kind(folder / _TEXT), "began": stamp[0] / 1e9}
        try:
            told = {**about, "why": "", **self._sums(name)}
        except (RidedownError, OSError) as error:
            told = {**about, "rows": None, "done": 0, "complete": False, "outcomes": {}, "failed": [], "why": str(error)}
        self._told_before[name] = stamp, told
        return told


def _run(running: _Running, loaded: LoadedStudy, plan: Any, folder: Path, resume: bool) -> None:  # noqa: FBT001
    """Run a study on a thread of its own, until its end or until it is cancelled."""
    from ridedown.studies.running.execution import Progress, run_plan  # noqa: PLC0415

    def report(progress: Progress) -> None:
        running.before, running.done, running.failed = progress.before, progress.done, progress.failed
        if running.cancelled:
            raise KeyboardInterrupt  # as Ctrl-C on the command line: what is done is kept

    try:
        run_plan(loaded, plan, folder, resume=resume, threads=1, report=report)
        running.cancelled = False  # too late: it is done
    except KeyboardInterrupt:  # `Stopped`, or before the first row
        running.cancelled = True
    except BaseException as error:  # it ends the study, not the server
        running.trouble = refusal(error)["message"] if isinstance(error, Exception) else type(error).__name__
    finally:
        running.ended = True


def _kind(file: Path) -> str:
    """What kind of study a file is, as the page calls it; empty for what is no study."""
    try:
        data = tomllib.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return ""
    sample = data.get("sample")
    rare = isinstance(sample, Mapping) and sample.get("rare") is True
    return "rare" if rare else str(data.get("kind", ""))[:20]


def _loaded(text: str) -> LoadedStudy:
    """The study of a text, with scenarios of the catalogue or written out: it opens no file."""
    data = table_in(Path(_TEXT), text, "need a study, with fields such as kind, scenario and [[parameters]].")
    cases = data.get("scenarios")
    made = {**data, "scenario": _written_out(data.get("scenario"))} if "scenario" in data else dict(data)
    if isinstance(cases, list):
        made["scenarios"] = [
            {**case, "scenario": _written_out(case.get("scenario"))} if isinstance(case, Mapping) else case for case in cases
        ]
    return dataclasses.replace(load_study(made), text=text)


def _written_out(scenario: object) -> object:
    """A scenario's tables in place of its name in the catalogue."""
    if isinstance(scenario, str):
        return dict(catalogue.entry(scenario).data)
    if isinstance(scenario, Mapping):
        refuse_files(scenario)
    return scenario
