"""Compiling the kernels, and keeping what was compiled.

Numba's own cache does not notice an edit in a kernel that another file calls, so the folder of the compiled code carries a
hash of every source of the package that a kernel is in: a changed source is a new folder. Kernels call parts of their own
package only. Where nothing can be written, kernels are compiled anew in each process; importing never fails for it.
"""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core import config as _config

F = TypeVar("F", bound=Callable[..., Any])

# Both are typed too narrowly for what follows: options numba documents for its own use, and a setting read at decoration.
_njit: Any = numba.njit
_settings: Any = _config

# `_nrt`: without reference counts, which cost more than the arithmetic; the kernels make no arrays.
_OPTIONS: dict[str, Any] = {"nogil": True, "_nrt": False, "error_model": "numpy", "fastmath": {"contract"}}


def _sources_hash(package: Path) -> str:
    # numba keeps what it compiled by the path of its source, so another checkout starts cold: its folder is another one
    digest = hashlib.sha256(f"{numba.__version__} {sys.version} {package}".encode())
    for source in (Path(__file__), *sorted(package.glob("*.py"))):
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def _user_cache() -> Path:
    root = os.environ.get("RIDEDOWN_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME")
    if root:
        return Path(root) / "ridedown"
    if sys.platform == "win32" and os.environ.get("LOCALAPPDATA"):
        return Path(os.environ["LOCALAPPDATA"]) / "ridedown" / "cache"
    return Path.home() / ".cache" / "ridedown"


@cache
def folder_of(package: Path) -> Path | None:
    """Where the compiled kernels of the package in this folder are kept, or None where nothing can be written."""
    try:
        folder = _user_cache() / f"{package.name}-{_sources_hash(package)}"
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):  # RuntimeError: no home directory
        return None
    return folder if os.access(folder, os.W_OK) else None


def part(function: F) -> F:
    """Compile `function` for other kernels to call; Python cannot."""
    return cast("F", _njit(no_cpython_wrapper=True, no_cfunc_wrapper=True, **_OPTIONS)(function))


def inlined(function: F) -> F:
    """Put `function`, one line or two, into the kernels that call it."""
    return cast("F", _njit(inline="always", no_cpython_wrapper=True, no_cfunc_wrapper=True, **_OPTIONS)(function))


def kernel(function: F) -> F:
    """Compile `function` for Python to call, cached in the folder of its package's version."""
    folder = folder_of(Path(function.__code__.co_filename).resolve().parent)
    if folder is None:
        return cast("F", _njit(**_OPTIONS)(function))
    before = _settings.CACHE_DIR
    _settings.CACHE_DIR = str(folder)  # read by numba when the function is decorated, and only then
    try:
        return cast("F", _njit(cache=True, no_cfunc_wrapper=True, **_OPTIONS)(function))
    except RuntimeError:  # no locator could use the folder
        return cast("F", _njit(**_OPTIONS)(function))
    finally:
        _settings.CACHE_DIR = before
