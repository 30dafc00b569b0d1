"""One server for all tests of the live page, and one browser."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, sync_playwright

from tests.apps.web.running import Running, measured_zip, running

DATA = Path(__file__).resolve().parents[4] / "shared" / "data" / "nhtsa_v10146"


@pytest.fixture(scope="session")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    with running("--port", "0", "--studies", str(tmp_path_factory.mktemp("studies"))) as made:
        with made.socket():  # compiled, if it was not: a test waits for its own work only
            pass
        yield made


CHROMIUM = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
"""The first that is there is driven. The shell is the same engine without the windows and bars around it: less to draw."""


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Debian's Chromium, driven by playwright."""
    found = next(filter(None, map(shutil.which, CHROMIUM)), None)
    if found is None:
        assert not os.environ.get("CI"), "no Chromium: in CI the page is tested in one (scripts/setup installs it)"
        pytest.skip("no Chromium on this machine: apt-get install chromium-headless-shell")
    with sync_playwright() as playwright:
        made = playwright.chromium.launch(executable_path=found, args=["--no-sandbox"])
        yield made
        made.close()


@pytest.fixture(scope="session")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Test 10146 as a zip."""
    if not DATA.is_dir():
        pytest.skip("the measured crash, shared/data/nhtsa_v10146, is not at hand")
    return measured_zip(DATA, tmp_path_factory.mktemp("measured") / "v10146.zip")
