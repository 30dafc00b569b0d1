"""The folder that machine code is kept in.

Machine code is good for one processor, one version of the compiler, and the sources it was made of, parts that other files
define among them. The folder's name is a hash of all these, so that a changed source, another checkout, or another machine
that has the same home, is another folder. Kernels call kernels and parts of their own package only.
"""

from __future__ import annotations

import hashlib
import os
import sys
from contextlib import suppress
from functools import cache
from importlib.metadata import version
from pathlib import Path

from llvmlite.binding import get_host_cpu_features, get_host_cpu_name

_SPOKEN = "network"
"""The package beside it whose numbers for laws, families and actions are in the kernels' code as constants."""
_SUFFIX = ".code"
_DIGEST = hashlib.sha256().digest_size
_LENGTH = 8


@cache
def folder_of(package: Path) -> Path | None:
    """Where the compiled kernels of the package in this folder are kept, or None where nothing can be written."""
    try:
        folder = _user_cache() / f"{package.name}-{_hash(package)}"
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):  # RuntimeError: no home directory
        return None
    return folder if os.access(folder, os.W_OK) else None


def is_kept(folder: Path, name: str) -> bool:
    """Whether there is machine code of that name."""
    return _file(folder, name).is_file()


def kept(folder: Path, name: str) -> tuple[bytes, bytes] | None:
    """The machine code of that name and of its entry, or None where there is none, or it is damaged."""
    try:
        content = _file(folder, name).read_bytes()
    except OSError:
        return None
    digest, packed = content[:_DIGEST], content[_DIGEST:]
    if hashlib.sha256(packed).digest() != digest:
        return None
    end = _LENGTH + int.from_bytes(packed[:_LENGTH], "little")
    return packed[_LENGTH:end], packed[end:]


def keep(folder: Path, name: str, code: bytes, entry: bytes) -> None:
    """Keep machine code under a name: whole or not at all, for other processes may be reading or writing it."""
    packed = len(code).to_bytes(_LENGTH, "little") + code + entry
    file = _file(folder, name)
    partial = file.with_name(f"{file.name}.{os.getpid()}")
    try:
        partial.write_bytes(hashlib.sha256(packed).digest() + packed)
        partial.replace(file)
    except OSError:  # a full disk, say: it is compiled again next time
        with suppress(OSError):
            partial.unlink(missing_ok=True)


def _file(folder: Path, name: str) -> Path:
    return folder / (name.rsplit(".", 1)[-1].replace(":", ".") + _SUFFIX)


def _hash(package: Path) -> str:
    settings = sorted(item for item in os.environ.items() if item[0].startswith("NUMBA_"))
    compilers = [version(name) for name in ("numba", "llvmlite")]
    processor = get_host_cpu_name(), get_host_cpu_features().flatten()
    digest = hashlib.sha256(repr((sys.version, compilers, processor, settings, str(package))).encode())
    for folder in (Path(__file__).parent, package.parent / _SPOKEN, package):
        for source in sorted(folder.glob("*.py")):
            digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def _user_cache() -> Path:
    root = os.environ.get("RIDEDOWN_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME")
    if root:
        return Path(root) / "ridedown"
    if sys.platform == "win32" and os.environ.get("LOCALAPPDATA"):
        return Path(os.environ["LOCALAPPDATA"]) / "ridedown" / "cache"
    return Path.home() / ".cache" / "ridedown"
