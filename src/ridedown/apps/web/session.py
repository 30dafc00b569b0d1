"""One session: a socket, and its requests. The newest of a lane wins; an older one that has not begun is never computed."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from ridedown.apps.web import answers
from ridedown.apps.web.frames import encode
from ridedown.apps.web.refusals import refusal
from ridedown.apps.web.state import Server
from ridedown.apps.web.study_files import study_file
from ridedown.errors import InvalidInput

Message = Mapping[str, Any]

LANES = (
    "crash",
    "pin",
    "results",
    "pinned",
    "describe",
    "catalogue",
    "map",
    "bound",
    "bound-here",
    "paper",
    "test",
    "channels",
    "study",
    "figures",
    "study-file",
    "fit",
)
"""A session computes one request of each lane at a time, and keeps one waiting."""

MOST_MESSAGE = 512 * 1024
"""Bytes of one request: a scenario of the longest kind, and its values."""


class Session:
    """Reads requests as they come, and answers each lane's newest."""

    def __init__(self, socket: WebSocket, server: Server) -> None:
        self.socket = socket
        self.server = server
        self.responses = answers.Responses()
        self.waiting: dict[str, Message] = {}
        self.running: dict[str, asyncio.Task[None]] = {}
        self.sending = asyncio.Lock()

    async def run(self) -> None:
        """Until the socket is closed."""
        await self._send(self.server.state())
        ready = asyncio.create_task(self._tell_when_ready())
        try:
            while True:
                self._take(await self.socket.receive_text())
        except (WebSocketDisconnect, KeyError):  # KeyError: a binary message, where text is expected
            pass
        finally:
            ready.cancel()
            for task in self.running.values():
                task.cancel()

    async def _tell_when_ready(self) -> None:
        if not self.server.ready.is_set():
            await self.server.ready.wait()
            await self._send(self.server.state())

    def _take(self, text: str) -> None:
        """Put a request in its lane, in place of one that still waits there."""
        try:
            message = json.loads(text, parse_constant=_no_constant)
        except (ValueError, RecursionError):
            message = {"kind": "no JSON"}
        if not isinstance(message, dict):
            message = {"kind": "no object"}
        lane = message.get("lane")
        lane = lane if lane in LANES else LANES[0]
        self.waiting[lane] = message
        if lane not in self.running:
            self.running[lane] = asyncio.create_task(self._work(lane))

    async def _work(self, lane: str) -> None:
        """Answer a lane until nothing waits in it."""
        try:
            while lane in self.waiting:
                message = self.waiting.pop(lane)
                answer = await self._answer(message)
                await self._send(answer)
        except (WebSocketDisconnect, RuntimeError):  # the page has gone, and so has the socket
            pass
        finally:
            self.running.pop(lane, None)

    async def _answer(self, message: Message) -> bytes | dict[str, Any]:
        about = {key: message[key] for key in ("id", "lane") if isinstance(message.get(key), str | int)}
        try:
            compute, pool = self._job(message)
            if compute is not answers.catalogue:
                await self.server.ready.wait()
            loop = asyncio.get_running_loop()
            return await loop.run_in_executor(pool, _encoded, compute, message, about)
        except Exception as error:  # one request that fails must not end the session
            return {**refusal(error), **about}

    def _job(self, message: Message) -> tuple[Callable[[Message], answers.Answer], Executor]:
        """What answers a request, and on which threads."""
        server, kind = self.server, str(message.get("kind"))
        jobs: dict[str, tuple[Callable[[Message], answers.Answer], Executor]] = {
            "catalogue": (answers.catalogue, server.quick),
            "describe": (answers.describe, server.quick),
            "simulate": (self.responses.curves, server.quick),
            "results": (self.responses.results, server.slow),
            "map": (answers.crash_map, server.slow),
            "bound": (answers.bound, server.bounding),
            "bound-here": (answers.bound_here, server.slow),
            "paper": (answers.paper, server.slow),
            "test": (server.uploads.about, server.slow),
            "channels": (server.uploads.channels, server.slow),
            "study": (server.studies.answer, server.slow),
            "study-file": (study_file, server.quick),
            "figures": (server.studies.figures, server.drawing),
            "fit": (self._fit, server.slow),
        }
        if kind not in jobs:
            raise InvalidInput(f"kind: got {kind[:50]!r}; need one of {', '.join(jobs)}.")
        return jobs[kind]

    def _fit(self, message: Message) -> answers.Answer:
        return self.server.fits.answer(message, self)

    async def _send(self, answer: bytes | dict[str, Any]) -> None:
        async with self.sending:
            if isinstance(answer, bytes):
                await self.socket.send_bytes(answer)
            else:
                await self.socket.send_text(json.dumps(answer, allow_nan=False))


def _encoded(
    compute: Callable[[Message], answers.Answer], message: Message, about: Mapping[str, Any]
) -> bytes | dict[str, Any]:
    """The answer, ready to be sent; made on the thread that computed it."""
    answer = compute(message)
    if isinstance(answer, tuple):
        header, arrays = answer
        return encode({**header, **about}, arrays)
    return {**answer, **about}


def _no_constant(name: str) -> float:
    raise ValueError(name)  # NaN and Infinity are no JSON
