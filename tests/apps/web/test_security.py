"""What the server refuses, tried: other pages, other names, no token, paths, bombs, floods, and requests that break."""

from __future__ import annotations

import io
import json
import socket as sockets
import sys
import threading
import time
import zipfile
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import uvicorn
from websockets.exceptions import ConnectionClosed, InvalidHandshake

from ridedown.apps.web import answers, application, exports, session, state, untrusted
from ridedown.apps.web.guard import HEADERS, is_loopback
from ridedown.apps.web.studies import Studies
from ridedown.apps.web.uploads import MOST_BYTES, MOST_TESTS
from ridedown.errors import InvalidInput, RidedownError
from tests.apps.web.dying import dies
from tests.apps.web.running import WAIT, Running, running

PASSWORDS = "/etc/passwd"


@pytest.fixture(scope="module")
def open_server() -> Iterator[Running]:
    """One that others than this machine could reach."""
    with running("--port", "0", "--host", "0.0.0.0") as made:
        yield made


@contextmanager
def in_this_process(**options: Any) -> Iterator[Running]:
    """A server whose parts a test can replace; options: of its application."""
    listening = sockets.create_server(("127.0.0.1", 0))
    config = uvicorn.Config(
        application.application(**options), log_level="error", ws="websockets-sansio", timeout_graceful_shutdown=1
    )
    made = uvicorn.Server(config)
    thread = threading.Thread(target=made.run, kwargs={"sockets": [listening]})
    thread.start()
    try:
        yield Running(listening.getsockname()[1], "", None)
    finally:
        made.should_exit = True
        thread.join(30)
        listening.close()


def refused_socket(server: Running, **options: Any) -> None:
    with pytest.raises((InvalidHandshake, ConnectionClosed)), server.opened(**options) as made:
        made.recv(timeout=5)


# who may come in


@pytest.mark.parametrize("origin", ["http://evil.example", "http://127.0.0.1:1", "null", None])
def test_a_socket_from_another_page(server: Running, origin: str | None) -> None:
    refused_socket(server, origin=origin)


@pytest.mark.parametrize(("method", "path"), [("POST", "/upload"), ("POST", "/export/csv")])
def test_a_request_from_another_page(server: Running, method: str, path: str) -> None:
    assert server.request(method, path, "{}", Origin="http://evil.example").status == 403


@pytest.mark.parametrize("path", ["/", "/state", "/assets/x.js"])
def test_a_name_that_was_made_to_point_here(server: Running, path: str) -> None:
    assert server.request("GET", path, Host="evil.example").status == 421


def test_without_its_token_a_server_for_others_tells_nothing(open_server: Running) -> None:
    for method, path in (("GET", "/"), ("GET", "/state"), ("GET", "/assets/x"), ("POST", "/upload"), ("GET", "/?token=wrong")):
        answer = open_server.request(method, path)
        assert answer.status == 401
        assert open_server.token.encode() not in answer.content
    refused_socket(open_server, origin=open_server.address)
    wrong = {"Cookie": "ridedown-token=wrong"}
    refused_socket(open_server, origin=open_server.address, additional_headers=wrong)


def test_with_its_token_it_answers(open_server: Running) -> None:
    answer = open_server.request("GET", f"/?token={open_server.token}")
    assert answer.status == 303
    assert answer.headers["location"] == "/"
    cookie = answer.headers["set-cookie"]
    assert "httponly" in cookie.lower()
    assert "samesite=strict" in cookie.lower()
    cookie = cookie.partition(";")[0]
    assert open_server.request("GET", "/", Cookie=cookie).status == 200
    with open_server.socket(additional_headers={"Cookie": cookie}) as socket:
        assert socket.ask("catalogue", lane="catalogue")["entries"]
    refused_socket(open_server, origin="http://evil.example", additional_headers={"Cookie": cookie})


def test_signing_in_leads_nowhere_else(open_server: Running) -> None:
    answer = open_server.request("GET", f"//evil.example/?token={open_server.token}")
    assert answer.headers["location"] == "/evil.example/"


def test_a_server_for_this_machine_has_no_token(server: Running) -> None:
    assert server.token == ""
    assert [is_loopback(host) for host in ("127.0.0.1", "::1", "localhost", "0.0.0.0", "192.0.2.1", "evil.example")] == [
        True, True, True, False, False, False,
    ]  # fmt: skip


def test_every_answer_tells_the_browser_what_it_may_do(server: Running) -> None:
    for path in ("/", "/state", "/nothing", "/assets/nothing"):
        answer = server.request("GET", path)
        for name, value in HEADERS.items():
            assert answer.headers[name] == value
    policy = HEADERS["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy


# paths


@pytest.mark.parametrize(
    "path",
    [
        "/assets/../index.html", "/assets/../../../cli.py", "/assets/%2e%2e/%2e%2e/cli.py", "/assets/..%2f..%2fcli.py",
        "/assets//etc/passwd", "/study/..%2f..%2fetc/results.parquet", "/study/../results.parquet", "/export/../state",
    ],
)  # fmt: skip
def test_no_path_leads_out(server: Running, path: str) -> None:
    answer = server.request("GET", path)
    assert answer.status in {404, 405}
    assert b"root:" not in answer.content
    assert b"import" not in answer.content


FILES = {
    "a name that is a path": {"scenario": PASSWORDS},
    "a name of a file beside": {"scenario": "./pyproject.toml"},
    "a measured pulse": {"toml": f'[pulse]\nkind = "measured"\nfile = "{PASSWORDS}"\nchannels = "1"'},
    "another scenario": {"toml": f'[pulse]\nkind = "scenario"\nscenario = "{PASSWORDS}"'},
    "another scenario of a scenario": {
        "toml": f'[pulse]\nkind = "scenario"\n[pulse.scenario.pulse]\nkind = "measured"\nfile = "{PASSWORDS}"\nchannels = "1"'
    },
}


@pytest.mark.parametrize("message", FILES.values(), ids=FILES)
def test_no_scenario_opens_a_file(server: Running, message: dict[str, str]) -> None:
    with server.socket() as socket:
        for kind in ("describe", "simulate", "results"):
            found = socket.ask(kind, **message)
            assert found["kind"] == "refused"
            assert found["status"] in {404, 422}
            assert "root:" not in found["message"]
    assert server.request("POST", "/export/scenario", json.dumps(message)).status in {404, 422}


# uploads


def zipped(**members: bytes) -> bytes:
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return made.getvalue()


HOSTILE = {
    "nothing": b"",
    "no zip": b"MZ" + bytes(1000),
    "an empty zip": zipped(),
    "a zip of something else": zipped(**{"readme.txt": b"hello"}),
    "a bomb": zipped(**{"v1.EV5": bytes(200 * 2**20)}),
    "names that lead out": zipped(**{"../../v1.EV5": b"----- EV5 -----\n", "/etc/v1.mme": b"x"}),
    "a torn zip": zipped(**{"v1.EV5": b"----- EV5 -----\n" * 100})[:-40],
}


@pytest.mark.parametrize("content", HOSTILE.values(), ids=HOSTILE)
def test_hostile_uploads(server: Running, content: bytes) -> None:
    answer = server.request("POST", "/upload", content, x_filename="../../evil.zip")
    told = json.loads(answer.content)
    assert answer.status == 422, told
    assert told["kind"] == "refused"
    assert server.request("GET", "/state").status == 200


def test_an_upload_that_is_too_large_is_not_read(server: Running) -> None:
    answer = server.request("POST", "/upload", iter([b"x"]), content_length=str(MOST_BYTES + 1))
    assert answer.status == 413


def test_an_upload_that_does_not_say_how_large_it_is(server: Running) -> None:
    """It is cut off at the same length."""
    connection = sockets.create_connection(("127.0.0.1", server.port), timeout=WAIT)
    host = f"Host: 127.0.0.1:{server.port}\r\nOrigin: {server.address}"
    head = f"POST /upload HTTP/1.1\r\n{host}\r\nTransfer-Encoding: chunked\r\n\r\n"
    part = b"100000\r\n" + bytes(2**20) + b"\r\n"
    with connection:
        try:
            connection.sendall(head.encode())
            for _ in range(MOST_BYTES // 2**20 + 2):
                connection.sendall(part)
        except OSError:
            pass  # it has hung up
        assert connection.recv(64).startswith(b"HTTP/1.1 413")


def test_an_upload_that_comes_too_slowly() -> None:
    """It is ended when its time is over, and others are answered meanwhile."""
    with in_this_process(upload_seconds=0.5) as server:
        begun = time.monotonic()
        connection = sockets.create_connection(("127.0.0.1", server.port), timeout=WAIT)
        host = f"Host: 127.0.0.1:{server.port}\r\nOrigin: {server.address}"
        with connection:
            connection.sendall(f"POST /upload HTTP/1.1\r\n{host}\r\nContent-Length: 1000\r\n\r\n".encode())
            connection.sendall(b"PK\x03\x04")
            assert server.request("GET", "/state").status == 200
            answer = connection.recv(4096)
            while b"too slowly" not in answer and (more := connection.recv(4096)):
                answer += more
        assert answer.startswith(b"HTTP/1.1 422")
        assert b"too slowly; need all of it within 0.5 s" in answer
        assert 0.4 < time.monotonic() - begun < WAIT
        assert application.UPLOAD_SECONDS <= 120.0


def test_uploads_without_end_fill_no_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(application, "MOST_UPLOADS", 2)
    with in_this_process(upload_seconds=WAIT) as server:
        host = f"Host: 127.0.0.1:{server.port}\r\nOrigin: {server.address}"
        head = f"POST /upload HTTP/1.1\r\n{host}\r\nContent-Length: 1000\r\n\r\nPK".encode()
        slow = [sockets.create_connection(("127.0.0.1", server.port), timeout=WAIT) for _ in range(2)]
        for connection in slow:
            connection.sendall(head)
        answer = server.request("POST", "/upload", b"x")
        while answer.status != 413:  # until both have been taken
            time.sleep(0.02)
            answer = server.request("POST", "/upload", b"x")
        assert b"on their way" in answer.content
        for connection in slow:
            connection.close()
        while server.request("POST", "/upload", b"x").status == 413:  # until both are given up
            time.sleep(0.02)


def test_an_upload_that_is_cut_off(server: Running) -> None:
    host = f"Host: 127.0.0.1:{server.port}\r\nOrigin: {server.address}"
    with sockets.create_connection(("127.0.0.1", server.port), timeout=WAIT) as connection:
        connection.sendall(f"POST /upload HTTP/1.1\r\n{host}\r\nContent-Length: 1000\r\n\r\nPK".encode())
    assert server.request("GET", "/state").status == 200


ROWS = 9_000_000


def stored(rows: int, columns: int) -> bytes:
    """A Parquet table, small as it is stored."""
    made = io.BytesIO()
    times = np.arange(rows) * 1e-6
    pq.write_table(
        pa.table({"time [s]": times, **{f"c{i} [g]": np.zeros(rows) for i in range(columns)}}), made, compression="zstd"
    )
    return made.getvalue()


def damaged(content: bytes) -> bytes:
    return content[:200] + bytes(b ^ 0xFF for b in content[200:400]) + content[400:]


HOSTILE_TABLES: dict[str, tuple[str, Callable[[], bytes]]] = {
    "no text": ("t.csv", lambda: b"MZ" + bytes(1000)),
    "no header": ("t.csv", lambda: b"1,2\n3,4\n"),
    "no times": ("t.csv", lambda: b"a [g],b [g]\n1,2\n"),
    "ragged": ("t.csv", lambda: b"time [s],a [g]\n0,1\n1\n"),
    "words": ("t.csv", lambda: b"time [s],a [g]\n0,1\n1,rm -rf\n2,0\n"),
    "times that fall": ("t.csv", lambda: b"time [s],a [g]\n1,1\n0,2\n"),
    "a header of many columns": ("t.csv", lambda: b"time [s]," + b"a [g]," * 100_000 + b"\n"),
    "empty cells without end": (
        "t.csv",
        lambda: b"time [s]" + b",a [g]" * 15_000 + b"\n" + (b"0" + b"," * 15_000 + b"\n") * 2500,
    ),
    "a name that leads out": ("../../etc/passwd.csv", lambda: b"x"),
    "no Parquet": ("t.parquet", lambda: b"PAR1" + bytes(1000) + b"PAR1"),
    "Parquet, damaged": ("t.parquet", lambda: damaged(stored(1000, 1))),
    "Parquet, torn": ("t.parquet", lambda: stored(1000, 1)[:-20]),
    "a small file with many numbers": ("t.parquet", lambda: stored(ROWS, 1)),
    "a header without its channels": ("v1.EV5", lambda: b"----- EV5 -----\n"),
}


@pytest.mark.parametrize(("name", "make"), HOSTILE_TABLES.values(), ids=HOSTILE_TABLES)
def test_hostile_tables(server: Running, name: str, make: Callable[[], bytes]) -> None:
    answer = server.request("POST", "/upload", make(), x_filename=quote(name))
    told = json.loads(answer.content)
    assert answer.status == 422, told
    assert told["kind"] == "refused"
    assert told["message"].count("\n") == 0
    assert len(told["message"]) < 400
    assert "/etc" not in told["message"]
    assert server.request("GET", "/state").status == 200


WIDE = b"time [s]" + b"".join(b",c%d [g]" % i for i in range(50)) + b"\n"


def test_a_table_is_bounded_in_time_and_memory() -> None:
    content = WIDE + b"".join(b"%.4f" % (i * 1e-4) + b",1.25" * 50 + b"\n" for i in range(60_000))
    with pytest.raises(InvalidInput, match=r"more than 0.2 s to read"):
        untrusted.read_table(content, "wide.csv", seconds=0.2)
    if sys.platform == "linux":
        with pytest.raises(InvalidInput, match="within 20 MB"):
            untrusted.read_table(content, "wide.csv", memory=20 * 2**20)
    record = untrusted.read_table(content, "wide.csv")
    assert len(record.channels) == 50
    assert untrusted.size_of(record) == 50 * 60_000 * 8


def test_what_ends_the_reader_of_a_table_ends_nothing_else(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(untrusted, "_read_and_send", dies)
    with pytest.raises(InvalidInput, match="undamaged"):
        untrusted.read_table(b"time [s],a [g]\n0,1\n", "t.csv", seconds=WAIT)


def test_a_table_with_a_gap_says_so_of_that_channel_only() -> None:
    record = untrusted.read_table(b"time [s],a [g],b [g]\n0,1,1\n1,,2\n2,3,3\n", "t.csv")
    assert record.history("b").values.tolist() == [1.0, 2.0, 3.0]
    with pytest.raises(InvalidInput):
        record.history("a")


def test_uploads_are_forgotten_in_turn(measured: Path) -> None:
    from ridedown.apps.web.uploads import Uploads  # noqa: PLC0415

    uploads = Uploads()
    table = "time [s],pulse [m/s2]\n" + "".join(f"{0.001 * i},{-i}\n" for i in range(50))
    keys = [uploads.add(zipped(**{f"t{i}.csv": table.encode()}), f"{i}.zip")["test"] for i in range(MOST_TESTS + 2)]
    with pytest.raises(RidedownError, match="Drop the file again"):
        uploads.about({"test": keys[0]})
    assert uploads.about({"test": keys[-1]})["test"] == keys[-1]


# requests that break, and floods


@pytest.mark.parametrize(
    "text",
    ["", "{", "[]", "null", '{"kind": "nonsense"}', '{"kind": NaN}', '{"kind": ["simulate"]}', "[" * 100_000,
     '{"kind": "simulate"}', '{"kind": "simulate", "scenario": 7}', '{"kind": "simulate", "scenario": "p1", "values": [1]}',
     '{"kind": "simulate", "scenario": "p1", "values": {"vehicle1.mass": [1, 2]}}',
     '{"kind": "simulate", "scenario": "p1", "values": {"vehicle1.mass": 1e999}}',
     '{"kind": "map", "scenario": "p1", "side": 100000}', '{"kind": "channels", "test": "x", "channels": []}',
     '{"kind": "study", "action": "start"}', '{"kind": "map", "scenario": "p1", "x": ["a"], "y": {}, "outcome": []}',
     '{"kind": "figures", "study": ["x"]}', '{"kind": "study-file", "study": "sweep"}',
     '{"kind": "study-file", "study": "sweep", "toml": "[pulse]\\nkind = \\"measured\\"\\nfile = \\"/etc/passwd\\""}',
     '{"kind": "study", "action": ["start"]}', '{"kind": "test", "test": ["x"]}', '{"kind": "describe", "toml": ["x"]}'],
)  # fmt: skip
def test_what_is_no_request(server: Running, text: str) -> None:
    with server.socket() as socket:
        socket.made.send(text)
        told = socket.receive()[0]
        assert told["kind"] == "refused"
        assert told["status"] in {404, 413, 422}
        assert socket.ask("simulate", scenario="p1")["completed"]


def test_the_field_that_is_wrong_is_named(server: Running) -> None:
    with server.socket() as socket:
        told = socket.ask("simulate", scenario="p1", values={"vehicle1.mass": -5.0})
        assert (told["status"], told["field"]) == (422, "vehicle1.mass")
        assert "need > 0 kg" in told["message"]
        told = socket.ask("simulate", scenario="p1", values={"vehicle1.mas": 5.0})
        assert told["status"] == 404
        assert "vehicle1.mass" in told["message"]


def test_a_message_that_is_too_long_ends_its_own_session_only(server: Running) -> None:
    with server.socket() as other, server.socket() as socket:
        socket.send("simulate", toml="x" * (session.MOST_MESSAGE + 1))
        with pytest.raises(ConnectionClosed):
            socket.receive()
        assert other.ask("simulate", scenario="p1")["completed"]


def test_too_much_of_anything(server: Running) -> None:
    many = 'kind = "crash"\n' + "[[occupants]]\n" * 1000
    with server.socket() as socket:
        assert socket.ask("describe", toml="#" * 200_000)["status"] == 413
        assert socket.ask("describe", toml=many)["status"] == 413
        assert socket.ask("simulate", scenario="p1", values={f"x{i}": 1.0 for i in range(1000)})["status"] == 413


def test_a_request_that_crashes_ends_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    def crash(_message: Any) -> Any:
        raise ZeroDivisionError("secret particulars")

    monkeypatch.setattr(answers, "describe", crash)
    with in_this_process() as server, server.socket() as socket:
        told = socket.ask("describe", scenario="p1")
        assert told["status"] == 500
        assert "secret" not in told["message"]
        assert socket.ask("simulate", scenario="p1")["completed"]


def test_no_more_reports_than_can_be_drawn_in_time(monkeypatch: pytest.MonkeyPatch) -> None:
    begun, go_on = threading.Event(), threading.Event()

    def slow(kind: str, _message: Any) -> exports.Export:
        begun.set()
        assert go_on.wait(WAIT)
        return exports.Export(f"made.{kind}", "text/plain", b"made")

    monkeypatch.setattr(state, "MOST_DRAWINGS", 1)
    monkeypatch.setattr(application, "export", slow)
    body = json.dumps({"scenario": "p1"})
    with in_this_process() as server, server.socket() as socket, ThreadPoolExecutor(1) as pool:
        first = pool.submit(server.request, "POST", "/export/pdf", body)
        assert begun.wait(WAIT)
        assert server.request("POST", "/export/report", body).status == 413
        assert socket.ask("simulate", scenario="p1")["completed"]  # nobody else waits for it
        assert server.request("GET", "/state").status == 200
        go_on.set()
        assert first.result(WAIT).content == b"made"
        assert server.request("POST", "/export/pdf", body).status == 200


def test_no_more_sessions_than_the_server_can_carry(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(application, "MOST_SESSIONS", 2)
    with (
        in_this_process() as server,
        server.socket(),
        server.socket(),
        server.opened() as third,
        pytest.raises(ConnectionClosed, match="1013"),
    ):
        third.recv(timeout=WAIT)


def test_one_session_that_asks_for_maps_without_end_starves_nobody(server: Running) -> None:
    message = {
        "scenario": "example-restraints",
        "side": 200,
        "outcome": "vehicle1.velocity.change",
        "x": "vehicle1.mass",
        "y": "vehicle1.speed",
    }
    with server.socket() as greedy, server.socket() as modest:
        for _ in range(200):
            greedy.send("map", lane="map", **message)
        begun = time.monotonic()
        for i in range(5):
            assert modest.ask("simulate", scenario="p1", values={"adult.mass": 70.0 + i})["completed"]
        assert time.monotonic() - begun < 10.0  # s: the maps would take minutes


# studies

SMALL = """
kind = "sweep"
name = "small"
scenario = "{scenario}"
outcomes = ["adult.excursion.max"]
[[parameters]]
path = "adult.mass"
values = [60.0, 70.0, 80.0]
"""


def ended(studies: Studies) -> dict[str, Any]:
    while True:
        standing = studies.answer({"action": "list"})
        if standing["running"]["ended"]:
            return standing
        time.sleep(0.05)


def test_a_study_runs_in_a_folder_of_its_own(tmp_path: Path) -> None:
    studies = Studies(tmp_path / "kept")
    studies.answer({"action": "start", "toml": SMALL.format(scenario="p1")})
    standing = ended(studies)
    assert standing["running"]["trouble"] == ""
    [kept] = standing["studies"]
    assert kept["complete"]
    assert studies.summary(kept["name"])["outcomes"]["adult.excursion.max"]["max"] > 0.1
    assert studies.results(kept["name"])[:4] == b"PAR1"
    assert studies.report(kept["name"]).lower().startswith(b"<!doctype html")
    assert [path.name for path in tmp_path.iterdir()] == ["kept"]


@pytest.mark.parametrize("name", ["..", "../outside", "/etc", "", "link", ".hidden"])
def test_a_study_cannot_be_another_folder(tmp_path: Path, name: str) -> None:
    outside, kept = tmp_path / "outside", tmp_path / "kept"
    outside.mkdir()
    kept.mkdir()
    (kept / "link").symlink_to(outside)
    (outside / "study.toml").write_text(SMALL.format(scenario="p1"))
    studies = Studies(kept)
    for ask in (
        studies.results,
        studies.report,
        lambda name: studies.report(name, "report.pdf"),
        lambda name: studies.figures({"study": name}),
        studies.summary,
        lambda name: studies.answer({"action": "resume", "study": name}),
    ):
        with pytest.raises(RidedownError):
            ask(name)
    assert [path.name for path in outside.iterdir()] == ["study.toml"]


def test_a_study_opens_no_file(tmp_path: Path) -> None:
    for scenario in (PASSWORDS, "./crash.toml", "../crash.yaml"):
        with pytest.raises(RidedownError):
            Studies(tmp_path).answer({"action": "start", "toml": SMALL.format(scenario=scenario)})
    assert list(tmp_path.iterdir()) == []


def test_without_a_folder_no_study_is_begun() -> None:
    with pytest.raises(InvalidInput, match="--studies"):
        Studies(None).answer({"action": "start", "toml": SMALL.format(scenario="p1")})


def test_the_state_is_told_while_the_solver_is_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    go = threading.Event()
    monkeypatch.setattr(state, "_warm", lambda: go.wait(WAIT))
    with in_this_process() as server, server.opened() as made:
        assert json.loads(made.recv(timeout=WAIT))["state"] == "compiling"
        made.send('{"kind": "simulate", "lane": "crash", "scenario": "p1", "id": 1}')
        go.set()
        assert json.loads(made.recv(timeout=WAIT))["state"] == "ready"
        assert isinstance(made.recv(timeout=WAIT), bytes)
