"""The front end that is committed is the one that its sources build, small, and asks nobody else for anything."""

from __future__ import annotations

import gzip
import hashlib
import json
import re
from pathlib import Path

import pytest

from ridedown.apps.web.application import STATIC

WEB = Path(__file__).resolve().parents[3] / "web"
MOST = 200_000  # bytes, compressed


def hashes(folder: Path, names: list[str]) -> dict[str, str]:
    return {name: hashlib.sha256((folder / name).read_bytes()).hexdigest() for name in names}


@pytest.fixture(scope="module")
def built() -> dict[str, dict[str, str]]:
    found: dict[str, dict[str, str]] = json.loads((STATIC / "built.json").read_text())
    return found


def test_it_was_built_from_these_sources(built: dict[str, dict[str, str]]) -> None:
    inner = [path.relative_to(WEB).as_posix() for path in (WEB / "src").rglob("*") if path.is_file()]
    names = sorted([*inner, "index.html", "package-lock.json", "package.json", "tsconfig.json", "vite.config.ts"])
    assert built["sources"] == hashes(WEB, names), "run `npm ci && npm run build` in web/"


def test_nothing_was_changed_since(built: dict[str, dict[str, str]]) -> None:
    names = sorted(p.relative_to(STATIC).as_posix() for p in STATIC.rglob("*") if p.is_file() and p.name != "built.json")
    assert built["files"] == hashes(STATIC, names)


def test_it_is_small() -> None:
    size = sum(
        len(gzip.compress(path.read_bytes())) for path in STATIC.rglob("*") if path.is_file() and path.name != "built.json"
    )
    assert size < MOST


def test_it_has_no_script_of_its_own_and_no_address_of_others() -> None:
    page = (STATIC / "index.html").read_text()
    assert not re.search(r"<script(?![^>]*\bsrc=)", page)
    assert not re.search(r"\son\w+=|style=", page)
    for path in STATIC.rglob("*"):
        if path.suffix in {".html", ".js", ".css"}:
            addresses = set(re.findall(r"https?://[\w.-]+", path.read_text()))
            assert addresses <= {"http://www.w3.org", "https://www.w3.org"}, path.name  # namespaces, which nothing fetches


def test_the_lock_file_names_no_registry() -> None:
    lock = (WEB / "package-lock.json").read_text()
    assert "resolved" not in lock
    assert json.loads(lock)["packages"]["node_modules/preact"]["integrity"].startswith("sha512-")
