"""Kernels that call kernels, of a small package of their own: compiled side by side or on call, kept, found again, refused."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from ridedown.apps import uncompiled
from ridedown.compiled import kernels
from ridedown.compiled.keeping import folder_of

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


@kernel
def calls_wrongly(values: Floats) -> float:
    return wrongly_called(values)


class Kinds(NamedTuple):
    whole: int
    real: float
    truth: bool


@kernel
def every_kind(
    values: Floats,
    counts: NDArray[np.int64],
    table: np.ndarray[tuple[int, int], np.dtype[np.float64]],
    cube: np.ndarray[tuple[int, int, int], np.dtype[np.float64]],
    whole: int,
    real: float,
    truth: bool,
) -> Kinds:
    for i in range(table.shape[0]):
        for j in range(table.shape[1]):
            table[i, j] = 10 * i + j
            for k in range(cube.shape[2]):
                cube[i, j, k] = 100 * i + 10 * j + k
    counts[0] = values.size
    return Kinds(whole + counts[0], real + values[1], not truth)


@kernel
def nothing(values: Floats) -> None:
    values[0] = 7.0
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
    missing = [name for name in unkept("small.") if "total" in name]
    first_run._processors = lambda: 2
    first_run.compile_side_by_side(missing)
    assert [name for name in unkept("small.") if "total" in name] == []
"""

BEGUN = """
import time
from pathlib import Path
from ridedown.apps import first_run

def build(name):
    Path(__file__).with_name(name).touch()
    time.sleep(600)

if __name__ == "__main__":
    first_run._processors = lambda: 2
    first_run.build = build
    first_run.compile_side_by_side(["first", "second"])
"""


def written(folder: Path) -> Path:
    (folder / "small").mkdir()
    (folder / "small" / "__init__.py").touch()
    (folder / "small" / "kernels.py").write_text(KERNELS, encoding="utf-8")
    return folder


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """The package, of which nothing is compiled."""
    return written(tmp_path)


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The package with the kernels that `CALL` calls kept, for tests that leave them so."""
    folder = written(tmp_path_factory.mktemp("compiled"))
    run(folder, CALL)
    return folder


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
    for path in (folder / "cache").rglob("*.code"):
        times.setdefault(path.stem, []).append(path.stat().st_mtime_ns)
    return times


def test_compiled_side_by_side_and_not_again_when_called(small):
    run(small, SIDE_BY_SIDE)
    before = kept(small)
    assert sorted(before) == ["kernels.most_and_total", "kernels.total"]
    run(small, CALL)
    assert kept(small) == before


@pytest.mark.parametrize(("processors", "missing"), [(1, "missing"), (2, "missing[:1]")])
def test_what_one_process_compiles_is_kept_too(small, processors, missing):
    code = SIDE_BY_SIDE.replace("lambda: 2", f"lambda: {processors}").replace("side(missing)", f"side({missing})")
    code = code.replace("in name] == []", f"in name] == [name for name in missing if name not in {missing}]")
    run(small, code)


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_what_compiles_side_by_side_ends_with_the_process_that_began_it(small):
    with start(small, BEGUN) as process:
        while not all((small / name).exists() for name in ("first", "second")):
            assert process.poll() is None
            time.sleep(0.01)
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
        process.kill()
    assert len(children) >= 2
    deadline = time.monotonic() + 60.0
    while any(Path("/proc", child).exists() for child in children):
        assert time.monotonic() < deadline
        time.sleep(0.01)


def test_compiled_on_call_with_what_it_calls(small):
    run(small, CALL)
    assert sorted(kept(small)) == ["kernels.most_and_total", "kernels.total"]


def test_what_is_lost_is_compiled_again(compiled):
    for path in (compiled / "cache").rglob("kernels.total*"):
        path.unlink()
    run(compiled, CALL)
    assert sorted(kept(compiled)) == ["kernels.most_and_total", "kernels.total"]


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
print(can_be_kept("small.kernels:total"), len(unkept("small.")) > 2)
"""
    assert run(small, CALL + said, cache=small / "file") == "False True\n"


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


def test_a_refusal_while_compiling_what_a_kernel_calls_is_raised_where_python_called(small):
    code = """
import numpy as np
from numba import TypingError
from small.kernels import calls_wrongly
for _ in range(2):
    try:
        calls_wrongly(np.zeros(3))
    except TypingError as error:
        print(error)
"""
    assert run(small, code).count("small.kernels:total takes") == 2


def test_a_kernel_built_alone_finds_what_it_calls(small):
    run(small, 'from ridedown.compiled import build\nbuild("small.kernels:most_and_total")')
    assert sorted(kept(small)) == ["kernels.most_and_total"]
    run(small, CALL)
    assert sorted(kept(small)) == ["kernels.most_and_total", "kernels.total"]


def test_what_is_kept_is_loaded_without_numba(small):
    said = "import sys; print('numba' in sys.modules)"
    assert run(small, f"{CALL}\n{said}") == "True\n"
    assert run(small, f"{CALL}\n{said}") == "False\n"


@pytest.mark.parametrize(
    "damage", [lambda content: content[:-100], lambda content: content[:0], lambda content: content[:99] + b"!" * 9]
)
def test_what_is_damaged_is_compiled_again(compiled, damage):
    (path,) = (compiled / "cache").rglob("kernels.total.code")
    whole = path.read_bytes()
    path.write_bytes(damage(whole))
    run(compiled, CALL)
    assert len(path.read_bytes()) == len(whole)


def test_threads_that_call_at_once_share_what_is_made_ready(small):
    code = """
import numpy as np
from concurrent.futures import ThreadPoolExecutor
from small.kernels import Both, most_and_total
with ThreadPoolExecutor(4) as pool:
    print(set(pool.map(lambda n: most_and_total(Both(np.arange(3.0), 1), True), range(40))))
"""
    assert run(small, code) == "{(2.0, 12.0)}\n"


def test_every_kind_of_value_is_passed_and_returned(small):
    code = """
import numpy as np
from small.kernels import every_kind, nothing
counts, table, cube = np.zeros(1, dtype=np.int64), np.zeros((2, 3)), np.zeros((2, 3, 4))
print(every_kind(np.array([0.5, 0.25]), counts, table, cube, -3, 1.5, False))
print(counts.tolist(), table.tolist(), (cube == np.fromfunction(lambda i, j, k: 100 * i + 10 * j + k, cube.shape)).all())
values = np.zeros(1)
print(nothing(values), values.tolist())
print(every_kind(np.zeros(2), counts, np.zeros((0, 3)), cube, np.int64(4), 2, np.True_))
"""
    assert run(small, code).splitlines() == [
        "Kinds(whole=-1, real=1.75, truth=True)",
        "[2] [[0.0, 1.0, 2.0], [10.0, 11.0, 12.0]] True",
        "None [7.0]",
        "Kinds(whole=6, real=2.0, truth=False)",
    ]


@pytest.mark.parametrize(
    "arguments",
    [
        "np.zeros(3, dtype=np.int64), 0",  # other elements
        "np.zeros(3, dtype='>f8'), 0",
        "np.zeros((3, 1)), 0",  # other dimensions
        "np.zeros(6)[::2], 0",  # not side by side
        "np.broadcast_to(1.0, 3), 0",  # not to be written
        "[1.0], 0",
        "np.zeros(3), 0.5",
        "np.zeros(3)",
        "np.zeros(3), 0, 0",
    ],
)
def test_other_arguments_than_declared_are_refused(compiled, arguments):
    code = f"""
import numpy as np
from small.kernels import total
try:
    total({arguments})
except TypeError as error:
    print(error)
"""
    assert run(compiled, code).startswith("small.kernels:total takes values (float64, 1 dimensions), first (int64): ")


def test_what_commands_compile_first_is_all_they_need(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kernels.Kernel, "is_kept", lambda _: False)
    run, criteria = uncompiled.of_a_run(), uncompiled.of_all_criteria()
    assert {"ridedown.solver.march:march", "ridedown.solver.events:find", "ridedown.criteria.windows:best_window"} <= set(run)
    assert {"ridedown.criteria.windows:best_window", "ridedown.criteria.flail:_contacts"} <= set(criteria)
    assert not [name for name in criteria if not name.startswith("ridedown.criteria.")]


def test_what_is_kept_is_not_taken_after_a_change_of_the_numbers_in_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RIDEDOWN_CACHE_DIR", str(tmp_path / "cache"))
    package, beside = tmp_path / "solver", tmp_path / "network"
    for folder in (package, beside):
        folder.mkdir()
        (folder / "model.py").write_text("LAW = 1\n")
    first = folder_of.__wrapped__(package)
    assert folder_of.__wrapped__(package) == first
    (beside / "model.py").write_text("LAW = 2\n")  # the package itself is as it was
    assert folder_of.__wrapped__(package) != first
