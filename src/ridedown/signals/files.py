"""The files of a test, in a folder or a zip: read only, within bounds, and none from outside.

A test comes from anywhere. Names are matched without letter case, and a name that leads out of the folder, a link out of it,
a device, an encrypted or oversized member are not read: asking for one says why. Nothing is ever written or unpacked.
"""

from __future__ import annotations

import io
import os
import re
import stat
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import IO, Literal

from ridedown.errors import InvalidInput, UnknownName

MAX_FILES = 20_000
"""Files of one test at most: the largest of the NHTSA database have some 1,500."""
MAX_FILE_BYTES = 64 * 2**20
"""One file at most: a million samples with their times, written out in full, are 40 MB; a recording rarely has 100,000."""
MAX_TOTAL_BYTES = 4 * 2**30
"""All files of a zip together, as declared: a thousand curves of 100,000 samples are 2 GB."""
MAX_DIRECTORY_BYTES = 4 * 2**20
"""The list of a zip's members: 20,000 names of 150 characters."""
MAX_DEPTH = 6
"""Folders within folders: tests are two or three deep, and a folder given by mistake may be a whole disk."""

_CHUNK = 2**20
_LOCAL_HEADER = 30  # bytes, before the name and the extra field (APPNOTE.TXT, PKWARE, 4.3.7)
_READABLE = {zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED}
_DRIVE = re.compile(r"[A-Za-z]:")


@dataclass(frozen=True)
class InMemory:
    """A file that is held in memory only: what is asked of a path here, and nothing of the disk."""

    name: str
    content: bytes = field(repr=False)

    @property
    def stem(self) -> str:
        """Its name without what tells its format."""
        return PurePosixPath(self.name).stem

    def open(self, mode: Literal["rb"]) -> IO[bytes]:  # noqa: ARG002  as a path has it
        """What it holds, as a file."""
        return io.BytesIO(self.content)


@dataclass(frozen=True)
class Tree:
    """The files of a folder or a zip, by their names with forward slashes, relative to it.

    path: where it is. refused: names that are there but are not read, with the reason.
    """

    path: Path | InMemory
    members: Mapping[str, Path | zipfile.ZipInfo]
    refused: Mapping[str, str] = field(default_factory=dict)

    def names(self) -> tuple[str, ...]:
        """The names of all files that may be read, in alphabetical order."""
        return tuple(self.members)

    def find(self, suffix: str) -> tuple[str, ...]:
        """The names that end so, whatever their letter case: `tree.find(".mme")`."""
        return tuple(name for name in self.members if name.lower().endswith(suffix.lower()))

    def name_of(self, name: str) -> str:
        """The name as the folder spells it, of one in any letter case.

        Raises: InvalidInput for a name that leads out of the folder, is refused, or could be two files; UnknownName, with the
        nearest, where there is none.
        """
        asked = name.replace("\\", "/").removeprefix("./")
        if asked in self.members:
            return asked
        reason = _astray(asked) or next((why for bad, why in self.refused.items() if bad.lower() == asked.lower()), None)
        if reason:
            raise InvalidInput(f"{shown(name)}: {reason}")
        same = [known for known in self.members if known.lower() == asked.lower()]
        if len(same) > 1:
            raise InvalidInput(
                f"{shown(name)}: got {len(same)} files, {' and '.join(same[:3])}; need one. Name it in its own letter case."
            )
        if not same:
            raise UnknownName.among("file", name[:200], self.members)
        return same[0]

    def __contains__(self, name: str) -> bool:
        try:
            self.name_of(name)
        except (InvalidInput, UnknownName):
            return False
        return True

    def read_bytes(self, name: str) -> bytes:
        """What a file holds.

        Raises: InvalidInput where it is larger than MAX_FILE_BYTES, damaged, encrypted, or may not be read; UnknownName.
        """
        name = self.name_of(name)
        member = self.members[name]
        try:
            if isinstance(member, Path):
                with member.open("rb") as file:
                    content = read_bounded(file, MAX_FILE_BYTES + 1)
            else:
                with self.path.open("rb") as file:
                    content = _member_bytes(file, member, name)
        except (OSError, zlib.error) as problem:
            why = getattr(problem, "strerror", None) or problem
            raise InvalidInput(f"{shown(name)}: cannot be read ({why}). Fetch the file again.") from problem
        if len(content) > MAX_FILE_BYTES:
            raise _too_large(name)
        return content

    def read_text(self, name: str) -> str:
        """What a text file holds: UTF-8 with or without a mark, else cp1252, else Latin-1; every line end made a newline.

        Raises: as read_bytes; InvalidInput, with the line, for a file that is not text.
        """
        return decoded(self.read_bytes(name), PurePosixPath(name).name)


def open_tree(path: str | Path) -> Tree:
    """The files of a folder or of a zip; of the folder around it for any other file.

    Raises: InvalidInput where there is nothing, or more than a test has (see the limits above); for a damaged zip.
    """
    path = Path(path)
    try:
        if path.is_dir():
            return _folder(path)
        if not path.exists():
            raise InvalidInput(f"path: got {path}, which does not exist; need a folder, a zip or a file. Check the path.")
        if is_zip(path):
            return _zip(path)
        return _folder(path.parent)
    except OSError as problem:
        raise InvalidInput(f"path: got {path}, which cannot be read ({problem.strerror}); need a folder or a zip.") from problem


def zip_in_memory(content: bytes, name: str) -> Tree:
    """The files of a zip whose bytes are at hand; nothing is written.

    Raises: InvalidInput for what is no zip, is damaged, or holds more than a test has (see the limits above).
    """
    file = InMemory(name, content)
    if not is_zip(file):
        raise InvalidInput(f"{shown(name)}: got no zip; need the zip of a test. Pack its folder.")
    return _zip(file)


def is_zip(path: Path | InMemory) -> bool:
    """Whether a file begins as a zip does, with members or without."""
    with path.open("rb") as file:
        return file.read(4) in {b"PK\x03\x04", b"PK\x05\x06"}


def read_bounded(file: IO[bytes], most: int) -> bytes:
    """What is left of a file, `most` bytes at most; taking no more memory than it holds, whatever its size was said to be."""
    parts: list[bytes] = []
    while most > 0 and (part := file.read(min(_CHUNK, most))):
        parts.append(part)
        most -= len(part)
    return b"".join(parts)


def decoded(content: bytes, where: str) -> str:
    r"""Bytes as text: UTF-8 with or without a mark, else cp1252, else Latin-1; CR LF and CR made newlines.

    >>> decoded(b"37 \xb0C\r\n", "v1.EV5")
    '37 °C\n'

    Raises: InvalidInput, with the line, where it holds a NUL: that is no text in any of these.
    """
    nul = content.find(b"\0")
    if nul >= 0:
        line = content.count(b"\n", 0, nul) + 1
        raise InvalidInput(f"{shown(where)}:{line}: got binary data; need text. Give the file as the laboratory wrote it.")
    for encoding in ("utf-8-sig", "cp1252"):
        try:
            text = content.decode(encoding)
            break
        except UnicodeDecodeError:
            continue
    else:
        text = content.decode("latin-1")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def shown(name: str) -> str:
    """A name fit for a message: printable, and not longer than a line."""
    printable = "".join(c if c.isprintable() else "?" for c in name[:200])
    return printable if len(printable) <= 100 else f"{printable[:97]}..."


# folders


def _folder(root: Path) -> Tree:
    root = root.resolve()
    members: dict[str, Path | zipfile.ZipInfo] = {}
    refused: dict[str, str] = {}
    for entry, name in _walk(root, "", 1):
        reason = _not_for_reading(entry, root)
        if reason:
            refused[name] = reason
        else:
            members[name] = Path(entry.path)
        if len(members) + len(refused) > MAX_FILES:
            raise _too_many(root)
    return Tree(root, dict(sorted(members.items())), refused)


def _walk(folder: Path, prefix: str, depth: int) -> Iterator[tuple[os.DirEntry[str], str]]:
    """Every entry but folders, with its name; links to folders count as entries, so that none is followed."""
    with os.scandir(folder) as entries:
        for count, entry in enumerate(entries):
            if count > MAX_FILES:
                raise _too_many(folder)
            if not entry.is_dir(follow_symlinks=False):
                yield entry, prefix + entry.name
            elif depth < MAX_DEPTH:
                yield from _walk(Path(entry.path), f"{prefix}{entry.name}/", depth + 1)


def _not_for_reading(entry: os.DirEntry[str], root: Path) -> str | None:
    try:
        if entry.is_symlink() and not Path(entry.path).resolve().is_relative_to(root):
            return "a link that leads out of the folder is not followed. Copy the file into the folder."
        about = entry.stat()
    except (OSError, RuntimeError):  # a link to nowhere, or to itself
        return "a link that leads nowhere cannot be read. Copy the file into the folder."
    if not stat.S_ISREG(about.st_mode):
        return "not a plain file; devices, pipes and linked folders are not read. Copy the file into the folder."
    return _size_reason(about.st_size)


# zips


class _Bounded:
    """A file that refuses to read more at once than a list of members may hold: zipfile reads it in one piece."""

    def __init__(self, file: IO[bytes], path: Path | InMemory) -> None:
        self.file, self.path = file, path
        self.seek, self.tell = file.seek, file.tell

    def read(self, size: int = -1) -> bytes:
        # zipfile asks for all that is left when it looks for the end of the list: then as much as may be, and one byte to tell.
        if size > MAX_DIRECTORY_BYTES:
            raise _too_many(self.path)
        content = self.file.read(size if size >= 0 else MAX_DIRECTORY_BYTES + 1)
        if len(content) > MAX_DIRECTORY_BYTES:
            raise _too_many(self.path)
        return content

    def seekable(self) -> bool:
        return True


def _zip(path: Path | InMemory) -> Tree:
    try:
        with path.open("rb") as file, zipfile.ZipFile(_Bounded(file, path)) as archive:
            infos = archive.infolist()
    except (zipfile.BadZipFile, NotImplementedError, ValueError, EOFError, IndexError, LookupError, ArithmeticError) as problem:
        if isinstance(problem, InvalidInput):
            raise
        raise InvalidInput(f"{shown(path.name)}: got a damaged zip ({problem}); need a whole one. Fetch it again.") from problem
    if len(infos) > MAX_FILES:
        raise _too_many(path)
    if sum(info.file_size for info in infos) > MAX_TOTAL_BYTES:
        raise InvalidInput(
            f"{shown(path.name)}: got more than {MAX_TOTAL_BYTES >> 30} GiB unpacked; need one test. Pack each by itself."
        )
    members: dict[str, Path | zipfile.ZipInfo] = {}
    refused: dict[str, str] = {}
    for info in infos:
        name = info.filename.replace("\\", "/").removeprefix("./")
        if name.endswith("/"):
            continue
        reason = _astray(name) or _member_reason(info) or ("it is in the zip twice." if name in members else None)
        if reason:
            refused[name] = reason
            members.pop(name, None)
        else:
            members[name] = info
    return Tree(path, dict(sorted(members.items())), refused)


def _member_reason(info: zipfile.ZipInfo) -> str | None:
    if info.flag_bits & 0x1:
        return "it is encrypted. Unpack it first."
    if info.compress_type not in _READABLE:
        return "it is packed in a way that is not read; need stored or deflated. Pack it again as an ordinary zip."
    return _size_reason(max(info.file_size, info.compress_size))


def _member_bytes(file: IO[bytes], info: zipfile.ZipInfo, name: str) -> bytes:
    """Unpack one member, never more than it declares, whatever its stream would go on to give."""
    file.seek(info.header_offset)
    header = file.read(_LOCAL_HEADER)
    if len(header) < _LOCAL_HEADER or header[:4] != b"PK\x03\x04":
        raise _damaged(name, "no header where the list says")
    file.seek(int.from_bytes(header[26:28], "little") + int.from_bytes(header[28:30], "little"), os.SEEK_CUR)
    packed = read_bounded(file, info.compress_size)
    if info.compress_type == zipfile.ZIP_DEFLATED:
        content = zlib.decompressobj(-15).decompress(packed, info.file_size + 1)
    else:
        content = packed
    if len(content) != info.file_size:
        raise _damaged(name, f"{len(content)} bytes or more where the list says {info.file_size}")
    if zlib.crc32(content) != info.CRC:
        raise _damaged(name, "its checksum is another one")
    return content


# what is refused


def _astray(name: str) -> str | None:
    """Why a name may not be asked for: it leads out of the folder, or is none."""
    parts = PurePosixPath(name).parts
    if name.startswith("/") or _DRIVE.match(name) or ".." in parts or not parts or "\0" in name:
        return "a name that leads out of the folder is not read. Name a file within it."
    return None


def _size_reason(size: int) -> str | None:
    if size > MAX_FILE_BYTES:
        return f"it has {size} bytes; need at most {MAX_FILE_BYTES}. Split the recording, or lower its rate."
    return None


def _too_large(name: str) -> InvalidInput:
    return InvalidInput(f"{shown(name)}: {_size_reason(MAX_FILE_BYTES + 1)}")


def _too_many(path: Path | InMemory) -> InvalidInput:
    called = path if isinstance(path, Path) else shown(path.name)
    return InvalidInput(
        f"path: got {called}, with more than {MAX_FILES} files; need one test. Give that test's own folder or zip."
    )


def _damaged(name: str, what: str) -> InvalidInput:
    return InvalidInput(f"{shown(name)}: damaged in its zip: {what}. Fetch the zip again.")
