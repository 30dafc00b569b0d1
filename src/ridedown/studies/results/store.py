"""Where results are kept: a folder with the study, its chunks as Parquet, and a manifest.

    DIR/study.toml        the study file as it was read (where it was a file)
    DIR/study.json        the study with its scenarios read: what its hash is of
    DIR/manifest.json     rows, chunks, columns with their units, the hash, the version; remarks
    DIR/results.json      what the finished study says (see `results`)
    DIR/chunks/chunk-00000012.parquet
    DIR/lock              held by the process that writes

A file is written aside, flushed to the disk and renamed, so that under its own name it is always whole. A chunk counts if its
footer reads and says that it is this study's; the folder is what tells which are done, so nothing else can disagree with it.
"""

from __future__ import annotations

import errno
import io
import json
import os
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

import ridedown
from ridedown.errors import InvalidInput
from ridedown.studies.file.study import LoadedStudy, hash_of
from ridedown.studies.rows.crashes import Rows
from ridedown.studies.rows.plan import Asked, Floats, Plan

FORMAT = 1
"""Of the folder; raised when an older ridedown could read it wrong."""

MANIFEST, IDENTITY, RESULTS, CHUNKS, LOCK = "manifest.json", "study.json", "results.json", "chunks", "lock"

_CHUNK_NAME = re.compile(r"chunk-(\d{8,})\.parquet")
_PARTIAL = ".partial"
_NO_ROOM = {errno.ENOSPC, errno.EDQUOT} if hasattr(errno, "EDQUOT") else {errno.ENOSPC}
_NOT_ALLOWED = {errno.EACCES, errno.EPERM, errno.EROFS}


def encode(plan: Plan, chunk: int) -> tuple[bytes, int]:
    """Compute a chunk: the bytes of its Parquet file, the same whoever computes them, and how many of its rows failed."""
    start, stop = plan.span(chunk)
    columns = plan.design.columns(start, stop)
    rows = plan.function.rows(columns)
    return packed(plan, start, columns, rows), rows.failed


def packed(plan: Plan, start: int, columns: Mapping[str, Floats], rows: Rows) -> bytes:
    """The Parquet file of rows from number `start` on: their parameters, and what was computed of them."""
    stop = start + rows.reason.size
    table = _table(plan, start, {name: columns[name] for name in plan.units}, rows)
    about = {"ridedown.study": plan.hash, "ridedown.rows": f"{start}:{stop}"}
    sink = io.BytesIO()
    numbers = [field.name for field in table.schema if pa.types.is_floating(field.type)]
    pq.write_table(
        table.replace_schema_metadata(about),
        sink,
        compression="zstd",
        compression_level=1,
        use_dictionary=["status", "why"],
        column_encoding=dict.fromkeys(numbers, "BYTE_STREAM_SPLIT"),  # the bytes of like doubles pack better apart
        write_statistics=["row", *plan.units],
    )
    return sink.getvalue()


def _table(plan: Plan, start: int, inputs: Mapping[str, np.ndarray[Any, Any]], rows: Rows) -> pa.Table:
    words = [word for word, _ in rows.reasons]
    sentences = [sentence or None for _, sentence in rows.reasons]
    arrays: dict[str, Any] = {"row": pa.array(np.arange(start, start + rows.reason.size))}
    arrays |= {name: pa.array(column) for name, column in inputs.items()}
    # a failed row has no outcome: null, which queries leave out, and not NaN, which spoils their means
    arrays |= {name: pa.array(rows.columns[name], from_pandas=True) for name in plan.function.units}
    arrays["status"] = pa.array(words).take(pa.array(rows.reason))
    arrays["why"] = pa.array(sentences, pa.string()).take(pa.array(rows.reason))
    return pa.table(arrays)


class Store:
    """A folder of results that this process writes. Made by `Store.opened`.

    Raises: InvalidInput, from every method, where the folder or the disk does not take what is written.
    """

    def __init__(self, folder: Path, plan: Plan) -> None:
        self.folder = folder
        self.plan = plan

    @classmethod
    @contextmanager
    def opened(cls, folder: Path, loaded: LoadedStudy, plan: Plan, *, resume: bool) -> Iterator[Store]:
        """The folder of this study, made, or gone on with; no other process can write it meanwhile.

        Raises: InvalidInput where it holds results and `resume` was not asked for, those of another study or version,
        or where it cannot be written.
        """
        store = cls(folder, plan)
        with _explained(folder):
            if not resume and (folder / MANIFEST).exists():
                raise InvalidInput(
                    f"--out: got {str(folder)!r}, which holds results; need a new folder. "
                    "To go on with a study that was stopped add --resume, or name another folder."
                )
            (folder / CHUNKS).mkdir(parents=True, exist_ok=True)
            with _locked(folder):
                store._begin(loaded)
                yield store

    def _begin(self, loaded: LoadedStudy) -> None:
        manifest = self._manifest()
        if (self.folder / MANIFEST).exists():
            self._agree(loaded, manifest)
        else:
            if loaded.text:
                self._put(self.folder / "study.toml", loaded.text.encode())
            self._put(self.folder / IDENTITY, _json(loaded.identity))
            self._put(self.folder / MANIFEST, _json(manifest))
        for left in (self.folder / CHUNKS).glob(f".*{_PARTIAL}"):  # of a process that was killed: the lock is ours
            left.unlink()

    def _agree(self, loaded: LoadedStudy, manifest: dict[str, Any]) -> None:
        there = read_manifest(self.folder)
        kept = _parsed(self.folder / IDENTITY)
        if hash_of(kept) != loaded.hash:
            changes = "; ".join(_changes(kept, json.loads(_json(loaded.identity)), ""))
            raise InvalidInput(
                f"--resume: got a study that has changed since {self.folder} was begun: {changes}; need the same study. "
                "Undo that, or start anew in another folder."
            )
        fixed = ("ridedown", "chunk_rows", "columns") if self._grows else ("ridedown", "rows", "chunk_rows", "columns")
        different = [key for key in fixed if there.get(key) != manifest[key]]
        if different:
            key = different[0]
            raise InvalidInput(
                f"--resume: got {self.folder}, begun with {key} = {there.get(key)}; this ridedown makes {manifest[key]}; "
                "need the same. Start anew in another folder."
            )

    def _manifest(self) -> dict[str, Any]:
        plan = self.plan
        inputs = [{"name": name, "unit": unit, "role": "parameter"} for name, unit in plan.units.items()]
        outcomes = [{"name": name, "unit": unit, "role": "outcome"} for name, unit in plan.function.units.items()]
        return {
            "format": FORMAT,
            "ridedown": ridedown.__version__,
            "study": plan.hash,
            "rows": None if self._grows else plan.rows,
            "chunk_rows": plan.chunk_rows,
            "chunks": None if self._grows else plan.chunks,
            "columns": inputs + outcomes,
        }

    @property
    def _grows(self) -> bool:
        """Whether how many rows there are is known at the end only."""
        return isinstance(self.plan.design, Asked)

    def grown(self, rows: int, chunks: int) -> None:
        """Keep how many rows and chunks a search came to."""
        with _explained(self.folder):
            self._put(self.folder / MANIFEST, _json({**read_manifest(self.folder), "rows": rows, "chunks": chunks}))

    def read(self, chunk: int, start: int) -> pa.Table | None:
        """A chunk of rows from number `start` on, that an earlier search kept; None if it is not there, or not whole."""
        path = self.folder / CHUNKS / f"chunk-{chunk:08d}.parquet"
        try:
            table = pq.read_table(path)
        except (OSError, pa.ArrowException):
            return None
        told = pq.read_metadata(path).metadata or {}
        span = f"{start}:{start + table.num_rows}".encode()
        own = told.get(b"ridedown.study") == self.plan.hash.encode() and told.get(b"ridedown.rows") == span
        return table if own else None

    def remark(self, remarks: Callable[[], list[str]]) -> None:
        """Keep what is to be said of the study, unless that was done when it was begun."""
        manifest = read_manifest(self.folder)
        if "remarks" not in manifest:
            with _explained(self.folder):
                self._put(self.folder / MANIFEST, _json({**manifest, "remarks": remarks()}))

    def finish(self, results: dict[str, Any]) -> None:
        """Keep what a finished study says."""
        with _explained(self.folder):
            self._put(self.folder / RESULTS, _json(results))

    def missing(self) -> list[int]:
        """The chunks that are not there, or not whole, in order."""
        done = set()
        for path in (self.folder / CHUNKS).iterdir():
            if (match := _CHUNK_NAME.fullmatch(path.name)) and self._is_whole(path, int(match[1])):
                done.add(int(match[1]))
        return [chunk for chunk in range(self.plan.chunks) if chunk not in done]

    def _is_whole(self, path: Path, chunk: int) -> bool:
        try:
            about = pq.read_metadata(path)
        except (OSError, pa.ArrowException):
            return False
        start, stop = self.plan.span(chunk)
        told = about.metadata or {}
        own = (
            told.get(b"ridedown.study") == self.plan.hash.encode() and told.get(b"ridedown.rows") == f"{start}:{stop}".encode()
        )
        return own and about.num_rows == stop - start

    def write(self, chunk: int, data: bytes) -> None:
        """Keep a chunk: whole, or not at all."""
        with _explained(self.folder):
            self._put(self.folder / CHUNKS / f"chunk-{chunk:08d}.parquet", data)

    def _put(self, path: Path, data: bytes) -> None:
        partial = path.with_name(f".{path.name}{_PARTIAL}")
        try:
            with partial.open("wb") as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
            partial.replace(path)
        except BaseException:
            with suppress(OSError):
                partial.unlink(missing_ok=True)
            raise
        _flush_folder(path.parent)


def read_manifest(folder: Path) -> dict[str, Any]:
    """The manifest of a folder of results.

    Raises: InvalidInput for a folder that holds none, or one of a later ridedown.
    """
    if not (folder / MANIFEST).is_file():
        raise InvalidInput(f"{folder}: got no {MANIFEST}; need a folder of results of `ridedown study`. Check the path.")
    manifest = _parsed(folder / MANIFEST)
    if manifest.get("format") != FORMAT:
        raise InvalidInput(
            f"{folder}: got results of format {manifest.get('format')}; need {FORMAT}. Use the ridedown that wrote them, "
            f"{manifest.get('ridedown')}."
        )
    return manifest


def read_results(folder: Path) -> dict[str, Any] | None:
    """What the finished study in a folder says; None where it is not finished."""
    return _parsed(folder / RESULTS) if (folder / RESULTS).is_file() else None


def chunk_files(folder: Path) -> list[Path]:
    """The files of the chunks that are done, in order."""
    return sorted(path for path in (folder / CHUNKS).iterdir() if _CHUNK_NAME.fullmatch(path.name))


def _parsed(path: Path) -> dict[str, Any]:
    try:
        found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InvalidInput(f"{path}: got a file that cannot be read ({error}); need JSON. Start anew.") from None
    return found


def _json(data: Any) -> bytes:
    return (json.dumps(data, indent=1) + "\n").encode()


def _changes(was: Any, now: Any, path: str) -> Iterator[str]:
    """What differs between two studies, in words."""
    if isinstance(was, dict) and isinstance(now, dict):
        for key in dict.fromkeys([*was, *now]):
            where = f"{path}.{key}" if path else key
            if key not in now:
                yield f"{where} was taken out"
            elif key not in was:
                yield f"{where} was added"
            else:
                yield from _changes(was[key], now[key], where)
    elif isinstance(was, list) and isinstance(now, list) and len(was) == len(now):
        for i, (one, other) in enumerate(zip(was, now, strict=True)):
            yield from _changes(one, other, f"{path}.{i}")
    elif was != now:
        yield f"{path} was {_short(was)} and is {_short(now)}"


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 60 else text[:57] + "..."


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Hold the folder's lock, which the system lets go of when the process ends, however it ends."""
    try:
        import fcntl  # noqa: PLC0415  not on Windows, where two writers are not kept apart
    except ImportError:
        yield
        return
    with (folder / LOCK).open("wb") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InvalidInput(
                f"--out: got {str(folder)!r}, which another process is writing; need one of your own. Wait for it to end."
            ) from None
        yield


@contextmanager
def _explained(folder: Path) -> Iterator[None]:
    """Say in one sentence what is wrong with a folder or a disk that does not take what is written."""
    try:
        yield
    except OSError as error:
        if error.errno in _NO_ROOM:
            raise InvalidInput(
                f"{folder}: got a full disk; need room for the results. Make room and go on with --resume."
            ) from None
        if error.errno in _NOT_ALLOWED:
            raise InvalidInput(
                f"--out: got {str(folder)!r}, which may not be written ({error.strerror}); need a folder of your own. "
                "Name another, or change its permissions."
            ) from None
        if isinstance(error, FileExistsError | NotADirectoryError):
            raise InvalidInput(
                f"--out: got {str(folder)!r}; need a folder, but a file is in its place. Name another."
            ) from None
        raise


def _flush_folder(folder: Path) -> None:
    """Make a rename last through a power cut, where the system can."""
    if os.name != "posix":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
