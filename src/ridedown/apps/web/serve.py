"""Serving the live page: which host and port, who may come, and how it ends."""

from __future__ import annotations

import secrets
import socket
import webbrowser
from collections.abc import Callable

import uvicorn

from ridedown.apps.web.application import application
from ridedown.apps.web.guard import is_loopback
from ridedown.apps.web.session import MOST_MESSAGE
from ridedown.apps.web.studies import Studies
from ridedown.errors import InvalidInput


def serve(
    host: str, port: int, *, say: Callable[[str], None], studies: Studies | None = None, open_browser: bool = False
) -> None:
    """Serve until interrupted. `say` is told the address, with the token where one is needed.

    Raises: InvalidInput for a host or port that cannot be used.
    """
    listening = _listening(host, port)
    token = None if is_loopback(host) else secrets.token_urlsafe(24)
    address = address_of(host, listening.getsockname()[1], token)
    say(f"The live page: {address}")
    if token:
        say("Anyone with this address can use the page. The connection is not encrypted: trust the network, or use a tunnel.")
    say("Ctrl-C ends it.")
    if open_browser:
        webbrowser.open(address)
    config = uvicorn.Config(
        application(token=token, studies=studies),
        log_level="warning",
        ws="websockets-sansio",
        ws_max_size=MOST_MESSAGE,
        ws_per_message_deflate=False,  # numbers hardly shrink, and the time shows
        timeout_graceful_shutdown=2,
        server_header=False,
        limit_concurrency=256,
        h11_max_incomplete_event_size=64 * 1024,
    )
    uvicorn.Server(config).run(sockets=[listening])


def address_of(host: str, port: int, token: str | None = None) -> str:
    """The address of the page as a browser takes it."""
    name = f"[{host}]" if ":" in host else host
    if host in {"0.0.0.0", "::"}:
        name = socket.gethostname()
    return f"http://{name}:{port}/" + (f"?token={token}" if token else "")


def _listening(host: str, port: int) -> socket.socket:
    if not 0 <= port <= 65_535:
        raise InvalidInput(f"--port: got {port}; need 0 .. 65535. Leave it out for 8137.")
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    made = socket.socket(family, socket.SOCK_STREAM)
    made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        made.bind((host, port))
        made.listen(128)  # from the moment that the address is told, whoever opens it waits and is not refused
    except OSError as problem:
        made.close()
        field = "--host" if isinstance(problem, socket.gaierror) else "--port"
        value = host if field == "--host" else port
        raise InvalidInput(
            f"{field}: got {value}, which cannot be used ({problem.strerror}); need one that is free. Choose another."
        ) from None
    return made
