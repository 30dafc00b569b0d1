"""What a path on the command line stands for where tests are read and written, and what may be written over."""

from __future__ import annotations

from pathlib import Path

from ridedown.errors import InvalidInput, UnknownName
from ridedown.scenario.files import SUFFIXES
from ridedown.signals import delimited, parquet, read
from ridedown.signals.files import shown
from ridedown.signals.record import TestRecord

_TABLES = (".csv", ".tsv")
_KINDS = "*.csv, *.tsv, *.parquet, *.zip (ISO-MME) or a folder (ISO-MME)"


def record_at(text: str) -> TestRecord:
    """The test at a path.

    Raises: InvalidInput, also for a scenario, which is no test.
    """
    if is_scenario(text):
        raise InvalidInput(f"path: got the scenario {shown(text)}; need a measured test. Use `ridedown run` for a scenario.")
    return read(checked(text))


def is_scenario(text: str) -> bool:
    """Whether this is a scenario: a file of that kind by its suffix, or a catalogue name where nothing of that name exists."""
    path = Path(text)
    if path.suffix.lower() in SUFFIXES:
        return not _exists(path) or path.is_file()
    if _exists(path):
        return False
    from ridedown import catalogue  # noqa: PLC0415  tests need none of it

    try:
        catalogue.entry(text)
    except UnknownName:
        return False
    return True


def output(text: str) -> Path:
    """Where to write, checked before any work: the name tells the format, and what is there already is of that format.

    Raises: InvalidInput for a name that tells no format, or a place that holds something else.
    """
    path = checked(text)
    suffix = path.suffix.lower()
    if suffix in _TABLES or suffix in parquet.SUFFIXES:
        _check_same_kind(path, suffix)
    elif suffix and suffix != ".zip" and not text.endswith(("/", "\\")) and not path.is_dir():
        raise InvalidInput(
            f"OUT: got {shown(path.name)}, whose name tells no format to write; need {_KINDS}. "
            "Choose such a name; a folder with a dot in its name needs a / at the end."
        )
    return path


def format_of(path: Path) -> str:
    """What a checked output will be, in words."""
    suffix = path.suffix.lower()
    if suffix in parquet.SUFFIXES:
        return "Parquet"
    return suffix[1:].upper() if suffix in _TABLES else "ISO-MME 1.6"


def _check_same_kind(path: Path, suffix: str) -> None:
    """Refuse to write over anything but a table of the same kind."""
    if not _exists(path):
        return
    other = f"OUT: got {shown(path.name)}, which exists and is no {suffix[1:].upper()} table of channels; need a new name. "
    if not path.is_file():
        raise InvalidInput(f"{other}Choose another.")
    try:
        if suffix in parquet.SUFFIXES:
            parquet.read_parquet(path)
        else:
            delimited.read_delimited(path)
    except InvalidInput as problem:
        raise InvalidInput(f"{other}Choose another, or remove it.") from problem


def checked(text: str) -> Path:
    """A path as given on the command line. Raises: InvalidInput for an empty one, or one with a null byte."""
    if not text or "\0" in text:
        raise InvalidInput(f"path: got {text!r}; need the path of a file or a folder. Give one.")
    return Path(text)


def _exists(path: Path) -> bool:
    try:
        return path.exists() or path.is_symlink()
    except (OSError, ValueError):  # a name too long for the file system, or with a null byte
        return False
