"""What all tests share: their order, and random inputs that are the same in every run.

So a failure is one of the change at hand. HYPOTHESIS_PROFILE=search looks for new inputs.
"""

from __future__ import annotations

import os

import pytest
from hypothesis import settings

settings.register_profile("same", derandomize=True, deadline=None)
settings.register_profile("search", deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "same"))

LONGEST = (
    "apps/web/test_page.py",
    "studies/extraction/test_extract.py",
    "studies/running/test_cluster.py",
    "reference/test_restraints_against_independent.py",
    "test_compiled.py",
    "studies/calibration",
)
"""Files, and folders of files, that take longest."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Have the longest files first: processes that take file after file then end at about the same time."""

    def place(item: pytest.Item) -> int:
        path = item.path.as_posix()
        return next((i for i, name in enumerate(LONGEST) if f"/tests/{name}" in path), len(LONGEST))

    items.sort(key=place)
