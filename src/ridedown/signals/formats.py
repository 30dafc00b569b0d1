"""Reading a test in whatever format it is in, and writing one in the format that a name asks for."""

from __future__ import annotations

from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

from ridedown.errors import InvalidInput
from ridedown.signals import delimited, ev5, isomme, parquet
from ridedown.signals.files import InMemory, is_zip, open_tree, shown, zip_in_memory

if TYPE_CHECKING:
    from ridedown.signals.files import Tree
    from ridedown.signals.record import TestRecord

HEADERS = frozenset({ev5.SUFFIX, isomme.SUFFIX})
"""How the names of files end whose channels are in files beside them."""

_PARQUET = b"PAR1"
_KNOWN = "NHTSA EV5 (*.EV5), ISO-MME (*.mme), CSV or TSV (*.csv, *.tsv, *.txt), Parquet (*.parquet)"


def read(path: str | Path) -> TestRecord:
    """The test at a path, in any of the formats, told by what is there.

    A folder or a zip holds a test of NHTSA EV5 or ISO-MME, or one table; a file is a header of either (`*.EV5`, `*.mme`, its
    channels beside it), CSV, TSV or Parquet.

    Raises: InvalidInput, naming file and line, for anything that is none of these, or damaged.
    """
    path = Path(path)
    try:
        if path.is_dir():
            return _of_tree(open_tree(path))
        if not path.is_file():
            raise InvalidInput(f"path: got {path}, which is no file or folder; need a test: {_KNOWN}. Check the path.")
        with path.open("rb") as file:
            begin = file.read(len(_PARQUET))
        if is_zip(path):
            return _of_tree(open_tree(path))
    except OSError as problem:
        raise InvalidInput(f"path: got {path}, which cannot be read ({problem.strerror}); need a test: {_KNOWN}.") from problem
    suffix = path.suffix.lower()
    if suffix == ev5.SUFFIX:
        return ev5.read_ev5(path)
    if suffix == isomme.SUFFIX:
        return isomme.read_isomme(path)
    if begin == _PARQUET or suffix in parquet.SUFFIXES:
        return parquet.read_parquet(path)
    return delimited.read_delimited(path)


def read_bytes(content: bytes, name: str) -> TestRecord:
    """The test in a file whose bytes are at hand: a zip, or one table in CSV, TSV or Parquet. Nothing is written to the disk.

    Raises: InvalidInput, naming file and line, for anything that is none of these, or damaged.
    """
    file = InMemory(name, content)
    suffix = PurePosixPath(name).suffix.lower()
    if suffix in {ev5.SUFFIX, isomme.SUFFIX}:
        raise InvalidInput(
            f"{shown(name)}: got the header of a test without its channels; need both. Give the zip of its folder."
        )
    if is_zip(file) or suffix == ".zip":
        return _of_tree(zip_in_memory(content, name))
    if content.startswith(_PARQUET) or suffix in parquet.SUFFIXES:
        return parquet.read_parquet(file)
    return delimited.read_delimited(file)


def holds_laboratory_test(content: bytes, name: str) -> bool:
    """Whether bytes are the zip of a test of NHTSA EV5 or ISO-MME, and no table.

    Raises: InvalidInput for a zip that is damaged, or holds more than a test has.
    """
    if not is_zip(InMemory(name, content)):
        return False
    tree = zip_in_memory(content, name)
    return ev5.recognises(tree) or isomme.recognises(tree)


def _of_tree(tree: Tree) -> TestRecord:
    found = [name for name, module in (("EV5", ev5), ("ISO-MME", isomme)) if module.recognises(tree)]
    if len(found) > 1:
        raise InvalidInput(f"path: got a test of EV5 and one of ISO-MME in {shown(tree.path.name)}; need one. Name its header.")
    if found == ["EV5"]:
        return ev5.read_ev5(tree)
    if found == ["ISO-MME"]:
        return isomme.read_isomme(tree)
    tables = [name for suffix in delimited.SUFFIXES for name in tree.find(suffix)]
    stored = [name for suffix in parquet.SUFFIXES for name in tree.find(suffix)]
    if len(tables) + len(stored) != 1:
        names = [shown(PurePosixPath(name).name) for name in (*tables, *stored, *tree.names())]
        some = ", ".join(dict.fromkeys(names[:3])) or "nothing"
        raise InvalidInput(f"path: got {some} in {shown(tree.path.name)}; need one test: {_KNOWN}. Name the file.")
    if tables:
        return delimited.read_delimited(tree, tables[0])
    member = tree.members[stored[0]]
    if not isinstance(member, Path):
        raise InvalidInput(
            f"path: got {shown(stored[0])} in a zip; need it by itself, since Parquet is packed already. Unpack it."
        )
    return parquet.read_parquet(member)


def write(record: TestRecord, path: str | Path) -> tuple[str, ...]:
    """Write a test in the format that the path asks for: `*.csv`, `*.tsv`, `*.parquet`, else ISO-MME (a folder, or `*.zip`).

    Gives what was left out, in sentences: channels that cannot be read.

    Raises: InvalidInput where the format has no place for the channels; the path then holds what it held before.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix in {".csv", ".tsv"} | set(parquet.SUFFIXES):
        try:
            if suffix in parquet.SUFFIXES:
                return parquet.write_parquet(record, path)
            return delimited.write_delimited(record, path, delimiter="\t" if suffix == ".tsv" else ",")
        except OSError as problem:
            raise InvalidInput(
                f"path: got {path}, which cannot be written ({problem.strerror}). Choose another place."
            ) from problem
    return isomme.write_isomme(record, path)
