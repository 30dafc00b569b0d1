"""Kernels that call kernels, of a small package of their own: compiled side by side or on call, kept, found again, refused."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

KERNELS = """
import numpy as np
from numpy.typing import NDArray
from typing import NamedTuple

from ridedown.compiled import inlined, kernel, part

Floats = NDArray[np.float64]


class Both(NamedTuple):
    values: Floats
    number: int


@inlined
def squared(x):
    return x * x


@part
def add_up(values, first):
    total = 0.0
    for i in range(first, values.size):
        total += squared(values[i])
    return total


@kernel
def total(values: Floats, first: int) -> float:
    return add_up(values, first)


@kernel
def most_and_total(both: Both, twice: bool) -> tuple[float, float]:
    first = 0  # starts from a constant
    most = -np.inf
    for i in range(first, both.values.size):
        most = max(most, both.values[i])
    whole = total(both.values, first) + both.number
    return most, 2 * whole if twice else whole


@kernel
def wrongly_called(values: Floats) -> float:
    return total(values, values)
"""

CALL = """
import numpy as np
from small.kernels import Both, most_and_total
assert most_and_total(Both(np.array([1.0, 3.0, 2.0]), 1), True) == (3.0, 30.0)
"""

SIDE_BY_SIDE = """
from ridedown.apps import first_run
from ridedown.compiled import unkept
import small.kernels
if __name__ == "__main__":
    missing = [name for name in unkept("small.") if "wrongly" not in name]
    first_run._processors = lambda: 2
    first_run.compile_side_by_side(missing)
    assert [name for name in unkept("small.") if "wrongly" not in name] == []
"""


@pytest.fixture
def small(tmp_path: Path) -> Path:
    folder = tmp_path / "small"
    folder.mkdir()
    (folder / "__init__.py").touch()
    (folder / "kernels.py").write_text(KERNELS, encoding="utf-8")
    return tmp_path


def start(folder: Path, code: str, cache: Path | None = None) -> subprocess.Popen[str]:
    script = folder / f"script_{abs(hash(code))}.py"
    script.write_text(code, encoding="utf-8")
    environment = os.environ | {
        "RIDEDOWN_CACHE_DIR": str(cache or folder / "cache"),
        "PYTHONPATH": os.pathsep.join([str(folder), *sys.path]),
    }
    return subprocess.Popen(
        [sys.executable, str(script)], env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )


def run(folder: Path, code: str, cache: Path | None = None) -> str:
    """What it prints."""
    process = start(folder, code, cache)
    printed, errors = process.communicate()
    assert process.returncode == 0, errors
    return printed


def kept(folder: Path) -> dict[str, list[float]]:
    """When each kernel was compiled."""
    times: dict[str, list[float]] = {}
    for path in (folder / "cache").rglob("*.nbc"):
        times.setdefault(path.name.split("-")[0], []).append(path.stat().st_mtime_ns)
    return times


def test_compiled_side_by_side_and_not_again_when_called(small):
    run(small, SIDE_BY_SIDE)
    before = kept(small)
    assert sorted(before) == ["kernels.most_and_total", "kernels.total"]
    run(small, CALL)
    assert kept(small) == before


def test_compiled_on_call_with_what_it_calls(small):
    run(small, CALL)
    assert sorted(kept(small)) == ["kernels.most_and_total", "kernels.total"]


def test_what_is_lost_is_compiled_again(small):
    run(small, CALL)
    for path in (small / "cache").rglob("kernels.total*"):
        path.unlink()
    run(small, CALL)
    assert sorted(kept(small)) == ["kernels.most_and_total", "kernels.total"]


def test_two_processes_at_once(small):
    both = [start(small, CALL) for _ in range(2)]
    for process in both:
        errors = process.communicate()[1]
        assert process.returncode == 0, errors
    run(small, CALL)


def test_an_edited_source_is_compiled_anew(small):
    run(small, CALL)
    source = small / "small" / "kernels.py"
    source.write_text(KERNELS.replace("return x * x", "return x"), encoding="utf-8")
    run(small, CALL.replace("30.0", "14.0"))


def test_works_where_nothing_can_be_kept(small):
    (small / "file").touch()
    said = """
from ridedown.compiled import can_be_kept, unkept
print(can_be_kept("small.kernels:total"), len(unkept("small.")))
"""
    assert run(small, CALL + said, cache=small / "file") == "False 3\n"


def test_a_call_with_other_types_than_declared_is_refused(small):
    code = """
import numpy as np
from numba import TypingError
from small.kernels import wrongly_called
try:
    wrongly_called(np.zeros(3))
except TypingError as error:
    print(error)
"""
    assert "small.kernels:total takes" in run(small, code)


def test_a_kernel_built_alone_cannot_be_called_before_what_it_calls_is_ready(small):
    code = """
from ridedown.compiled import build
build("small.kernels:most_and_total")
try:
    exec(CALL)
except RuntimeError as error:
    print(error)
"""
    assert run(small, f"CALL = {CALL!r}\n{code}") == "small.kernels:total was not made ready\n"
