"""The application: the page, its socket, uploads and exports."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from starlette.applications import Starlette
from starlette.requests import ClientDisconnect, Request
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp
from starlette.websockets import WebSocket

from ridedown.apps.web.exports import DRAWN, export
from ridedown.apps.web.guard import Guard
from ridedown.apps.web.refusals import TooMuch, refusal
from ridedown.apps.web.session import MOST_MESSAGE, Session
from ridedown.apps.web.state import MOST_SESSIONS, MOST_UPLOADS, Server
from ridedown.apps.web.studies import Studies
from ridedown.apps.web.uploads import MOST_BYTES
from ridedown.errors import InvalidInput, UnknownName

STATIC = Path(__file__).parent / "static"
"""The built front end."""

UPLOAD_SECONDS = 120.0
"""How long a client may take to send a body."""
_REPORTS = {"report.html": "text/html", "report.pdf": "application/pdf"}
_FOREVER = "public, max-age=31536000, immutable"  # names of built files carry a hash of what is in them


def application(*, token: str | None = None, studies: Studies | None = None, upload_seconds: float = UPLOAD_SECONDS) -> ASGIApp:
    """The application, guarded.

    token: what clients need who are not on this machine; studies: where these may be kept; upload_seconds: how long a client
    may take to send a test.
    """
    server = Server(studies or Studies())

    @asynccontextmanager
    async def life(_: Starlette) -> AsyncIterator[None]:
        warming = asyncio.create_task(server.warm())
        yield
        warming.cancel()
        server.close()

    async def live(socket: WebSocket) -> None:
        await _live(socket, server)

    async def upload(request: Request) -> Response:
        return await _answered(_upload(request, server, upload_seconds))

    async def exported(request: Request) -> Response:
        return await _answered(_export(request, server))

    async def study(request: Request) -> Response:
        return await _answered(_study(request, server))

    async def fit(request: Request) -> Response:
        return await _answered(_fit(request, server))

    async def state(_: Request) -> Response:
        return JSONResponse(server.state())

    routes = [
        Route("/", _page),
        Route("/state", state),
        WebSocketRoute("/live", live),
        Route("/upload", upload, methods=["POST"]),
        Route("/export/{kind}", exported, methods=["POST"]),
        Route("/study/{name}/{what}", study),
        Route("/fit/{key}/{what}", fit),
        Mount("/assets", _Assets(directory=STATIC / "assets", check_dir=False)),
    ]
    return Guard(Starlette(routes=routes, lifespan=life), token)


async def _page(_: Request) -> Response:
    page = STATIC / "index.html"
    if not page.is_file():
        return PlainTextResponse("The front end is not built: run `npm ci && npm run build` in web/.\n", 500)
    return FileResponse(page, headers={"cache-control": "no-cache"})


class _Assets(StaticFiles):
    """Built files: kept by the browser for good."""

    def file_response(self, *args: Any, **kwargs: Any) -> Response:
        answer = super().file_response(*args, **kwargs)
        answer.headers["cache-control"] = _FOREVER
        return answer


async def _live(socket: WebSocket, server: Server) -> None:
    await socket.accept()
    if server.sessions >= MOST_SESSIONS:
        await socket.close(1013, f"{MOST_SESSIONS} pages are open already; close one and reload")
        return
    server.sessions += 1
    try:
        await Session(socket, server).run()
    finally:
        server.sessions -= 1


async def _answered(work: Any) -> Response:
    """The answer, or what was wrong, as JSON with its status."""
    try:
        answer: Response = await work
    except Exception as error:  # one request that fails must not end the server
        told = refusal(error)
        return JSONResponse(told, told["status"])
    return answer


async def _upload(request: Request, server: Server, seconds: float) -> Response:
    name = unquote(request.headers.get("x-filename", "test.zip"))
    if server.uploading >= MOST_UPLOADS:
        raise TooMuch(f"file: got one more than the {MOST_UPLOADS} that are on their way; need fewer. Send it again soon.")
    server.uploading += 1
    try:
        content = await _body(request, MOST_BYTES, seconds)
        await server.ready.wait()
        loop = asyncio.get_running_loop()
        return JSONResponse(await loop.run_in_executor(server.reading, server.uploads.add, content, name))
    finally:
        server.uploading -= 1


async def _export(request: Request, server: Server) -> Response:
    try:
        message = json.loads(await _body(request, MOST_MESSAGE))
    except ValueError:
        message = None
    if not isinstance(message, dict):
        raise InvalidInput("request: got no JSON object; need one with scenario or toml, and values.")
    kind = request.path_params["kind"]
    if kind in DRAWN:
        made = await server.draw(export, kind, message)
    else:
        made = await asyncio.get_running_loop().run_in_executor(server.slow, export, kind, message)
    headers = {"content-disposition": f'attachment; filename="{made.name}"'}
    return Response(made.content, media_type=made.media_type, headers=headers)


async def _study(request: Request, server: Server) -> Response:
    name, what = request.path_params["name"], request.path_params["what"]
    if what == "results.parquet":
        content = await asyncio.get_running_loop().run_in_executor(server.slow, server.studies.results, name)
    elif what in _REPORTS:
        content = await server.draw(server.studies.report, name, what)
    else:
        raise UnknownName.among("file", what[:50], ("results.parquet", *_REPORTS))
    media_type = _REPORTS.get(what, "application/vnd.apache.parquet")
    headers = {"content-disposition": f'attachment; filename="{name}{Path(what).suffix}"'}
    return Response(content, media_type=media_type, headers=headers)


async def _fit(request: Request, server: Server) -> Response:
    key, what = request.path_params["key"], request.path_params["what"]
    if what == "scenario.toml":
        content, media_type = server.fits.scenario(key), "application/toml"
    elif what in _REPORTS:
        content, media_type = await server.draw(server.fits.report, key, what), _REPORTS[what]
    else:
        raise UnknownName.among("file", what[:50], ("scenario.toml", *_REPORTS))
    headers = {"content-disposition": f'attachment; filename="fit-{what}"'}
    return Response(content, media_type=media_type, headers=headers)


async def _body(request: Request, most: int, seconds: float = UPLOAD_SECONDS) -> bytes:
    """The body, read as it comes: no more of it than may be, for no longer than may be. Raises: TooMuch, InvalidInput."""
    too_much = TooMuch(f"file: got more than {most:,} bytes; need fewer. Leave out channels.")
    declared = request.headers.get("content-length", "0")
    if declared.isdecimal() and int(declared) > most:
        raise too_much
    parts: list[bytes] = []
    size = 0
    try:
        async with asyncio.timeout(seconds):
            async for part in request.stream():
                size += len(part)
                if size > most:
                    raise too_much
                parts.append(part)
    except TimeoutError:
        raise InvalidInput(f"file: got it too slowly; need all of it within {seconds:g} s.") from None
    except ClientDisconnect:
        raise InvalidInput("file: got a part of it; need all. Send it again.") from None
    return b"".join(parts)
