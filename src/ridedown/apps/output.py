"""Writing a folder of results: all of it, or nothing."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ridedown.errors import InvalidInput


def check_folder(out: Path, *, option: str = "--out") -> None:
    """Refuse a folder that cannot be one, before any work is done for it.

    Raises InvalidInput where `out`, or a folder on the way to it, is a file.
    """
    for step in (out, *out.parents):
        if step.is_dir():
            return
        if step.exists() or step.is_symlink():
            raise InvalidInput(f"{option}: got {str(out)!r}; need a folder, but {step} is a file. Name another folder.")


@contextmanager
def staged(out: Path) -> Iterator[Path]:
    """A temporary folder beside `out`; its files move into `out`, each by one rename, once the block has succeeded.

    Files already in `out` under other names stay. If the block fails, `out` is as it was.
    """
    check_folder(out)
    home = next(step for step in out.absolute().parents if step.is_dir())
    stage = Path(tempfile.mkdtemp(prefix=f".{out.name}-", dir=home))
    try:
        yield stage
        for source in sorted(path for path in stage.rglob("*") if path.is_file()):
            target = out / source.relative_to(stage)
            target.parent.mkdir(parents=True, exist_ok=True)
            source.replace(target)
    finally:
        shutil.rmtree(stage, ignore_errors=True)
