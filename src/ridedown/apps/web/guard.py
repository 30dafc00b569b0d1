"""Who may come in, and what the browser may do: host, token, origin, and the headers of every answer.

On loopback the danger is another page in the same browser: its requests carry the wrong Origin, or, where it made a name point
here, the wrong Host. With another host anyone on the network can reach the server: they need the token.
"""

from __future__ import annotations

import hmac
import ipaddress
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs, urlencode, urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse, RedirectResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

COOKIE = "ridedown-token"

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)

HEADERS = {
    "content-security-policy": POLICY,
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "permissions-policy": "camera=(), geolocation=(), microphone=()",
}

_SAFE = {"GET", "HEAD"}


def is_loopback(host: str) -> bool:
    """Whether a host name or address is this machine only."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return False


class Guard:
    """Lets a request through to `app`, or answers it itself. token: what every request must carry; none on loopback."""

    def __init__(self, app: ASGIApp, token: str | None) -> None:
        self.app = app
        self.token = token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request or socket."""
        if scope["type"] not in {"http", "websocket"}:
            await self.app(scope, receive, send)
            return
        if self.token and scope["type"] == "http" and scope["method"] == "GET" and self._token_in_query(scope):
            await self._sign_in(scope, receive, send)
            return
        refused = self._refused(scope)
        if refused is None:
            await self.app(scope, receive, _with_headers(send))
        elif scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": 1008, "reason": refused[1][:120]})
        else:
            await PlainTextResponse(f"{refused[1]}\n", refused[0])(scope, receive, _with_headers(send))

    def _refused(self, scope: Scope) -> tuple[int, str] | None:
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        if self.token is None and not is_loopback(urlsplit(f"//{host}").hostname or ""):
            return 421, "this server answers to the name of this machine only"
        if self.token is not None and not self._carries_token(headers):
            return 401, "open the address with its token, as `ridedown serve` printed it"
        origin = headers.get("origin")
        needs_origin = scope["type"] == "websocket" or scope.get("method") not in _SAFE
        if origin is None:
            # a browser always sends one with these; other programs may leave it out, and cannot be made to come here by a page
            return (403, "an Origin header is needed") if scope["type"] == "websocket" else None
        if needs_origin and urlsplit(origin).netloc != host:
            return 403, "requests from other pages are not answered"
        return None

    def _carries_token(self, headers: Headers) -> bool:
        assert self.token is not None
        try:
            cookie = SimpleCookie(headers.get("cookie", "")).get(COOKIE)
        except CookieError:
            cookie = None
        given = cookie.value if cookie else headers.get("authorization", "").removeprefix("Bearer ")
        return hmac.compare_digest(given.encode(), self.token.encode())

    def _token_in_query(self, scope: Scope) -> bool:
        assert self.token is not None
        given = parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])[0]
        return hmac.compare_digest(given.encode(), self.token.encode())

    async def _sign_in(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Keep the token in a cookie that no script can read, and take it out of the address."""
        assert self.token is not None
        query = parse_qs(scope["query_string"].decode("latin-1"))
        query.pop("token")
        rest = urlencode(query, doseq=True)
        # the path of this very server: a name that begins with two slashes would be another one's
        target = "/" + scope["path"].lstrip("/") + (f"?{rest}" if rest else "")
        answer = RedirectResponse(target, 303)
        answer.set_cookie(COOKIE, self.token, httponly=True, samesite="strict", path="/")
        await answer(scope, receive, _with_headers(send))


def _with_headers(send: Send) -> Send:
    async def sent(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in HEADERS.items():
                headers[name] = value
        await send(message)

    return sent
