"""A live page that runs, in a process of its own, and what speaks to it."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from http.client import HTTPConnection
from itertools import count
from pathlib import Path
from typing import Any

from websockets.sync.client import ClientConnection, connect

from ridedown.apps.web.frames import decode

WAIT = 120.0  # s, on a machine that is busy with other tests


@dataclass(frozen=True)
class Running:
    """A server: its port, the token that it printed, and its process."""

    port: int
    token: str
    process: subprocess.Popen[str] | None

    @property
    def address(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    @contextmanager
    def socket(self, **options: Any) -> Iterator[Socket]:
        """A socket as the page opens it, once the server is ready."""
        with self.opened(**options) as made:
            socket = Socket(made)
            socket.until_ready()
            yield socket

    def opened(self, **options: Any) -> ClientConnection:
        """A socket as the page opens it, at once."""
        made: ClientConnection = connect(
            f"ws://127.0.0.1:{self.port}/live", **{"origin": self.address, "max_size": None, **options}
        )
        return made

    def request(self, method: str, path: str, body: Any = None, **headers: str) -> Answered:
        """One request. An underscore in a header's name is a hyphen."""
        connection = HTTPConnection("127.0.0.1", self.port, timeout=WAIT)
        usual = {"Origin": self.address} if method == "POST" else {}
        connection.request(method, path, body, usual | {name.replace("_", "-"): value for name, value in headers.items()})
        answer = connection.getresponse()
        found = Answered(answer.status, {name.lower(): value for name, value in answer.getheaders()}, answer.read())
        connection.close()
        return found


@dataclass(frozen=True)
class Answered:
    """The answer to a request; the names of its headers are small."""

    status: int
    headers: dict[str, str]
    content: bytes


class Socket:
    """Asks, and takes the answer to what it asked."""

    def __init__(self, made: ClientConnection) -> None:
        self.made = made
        self.numbers = count(1)

    def until_ready(self) -> None:
        while json.loads(self.made.recv(timeout=WAIT))["state"] != "ready":
            pass

    def send(self, kind: str, lane: str = "crash", **message: Any) -> int:
        number = next(self.numbers)
        self.made.send(json.dumps({"kind": kind, "lane": lane, "id": number, **message}))
        return number

    def receive(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """Header and arrays of the next answer."""
        answer = self.made.recv(timeout=WAIT)
        return (json.loads(answer), {}) if isinstance(answer, str) else decode(answer)

    def ask(self, kind: str, **message: Any) -> dict[str, Any]:
        """The answer, its arrays among the fields of its header."""
        number = self.send(kind, **message)
        while True:
            header, arrays = self.receive()
            if header.get("id") == number:
                return header | arrays


@contextmanager
def running(*options: str, environment: dict[str, str] | None = None) -> Iterator[Running]:
    """`ridedown serve` with these options, until the block is left."""
    command = [sys.executable, "-m", "ridedown.apps.cli", "serve", *options]
    where = dict(os.environ) | (environment or {})
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=where) as process:
        try:
            assert process.stdout is not None
            line = process.stdout.readline()
            found = re.search(r":(\d+)/(?:\?token=(\S+))?", line)
            assert found is not None, line
            yield Running(int(found[1]), found[2] or "", process)
        finally:
            process.terminate()
            process.wait(30)


def measured_zip(folder: Path, target: Path) -> Path:
    """The test in a folder, as its laboratory would send it."""
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in sorted(folder.iterdir()):
            if file.name.lower().startswith("v10146"):
                archive.write(file, file.name)
    return target
