"""The descriptors of ISO-MME files: lines of `Key                         :value`, in the order of the file.

Keys are compared without regard to letter case, blanks at the ends and doubled blanks. A value that is empty or
`NOVALUE` is missing. A key may repeat (`Comments` does); the first one counts, all are kept.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from ridedown.errors import InvalidInput
from ridedown.signals.numerals import lines_of

FORMAT = "ISO-MME 1.6"
KEY_WIDTH = 28
NO_VALUE = "NOVALUE"

_LEADING_NUMBER = re.compile(r"([+-]?(?:[0-9]{1,30}\.?[0-9]{0,30}|\.[0-9]{1,30})(?:[eE][+-]?[0-9]{1,3})?) *(.*)", re.ASCII)


@dataclass(frozen=True, slots=True)
class Descriptors:
    """Keys and values of one file, and the file's name and line numbers for messages."""

    pairs: tuple[tuple[str, str], ...]
    where: str
    lines: tuple[int, ...]

    def __iter__(self) -> Iterator[tuple[str, str]]:
        return iter(self.pairs)

    def text(self, key: str) -> str:
        """The first value under a key, empty where it is missing."""
        wanted = folded(key)
        return next((value for name, value in self.pairs if folded(name) == wanted and value), "")

    def all(self, key: str) -> tuple[str, ...]:
        """Every value under a key that may repeat."""
        wanted = folded(key)
        return tuple(value for name, value in self.pairs if folded(name) == wanted and value)

    def line(self, key: str) -> int:
        """The number of the line of a key, 1 if it is not there."""
        wanted = folded(key)
        return next((line for (name, _), line in zip(self.pairs, self.lines, strict=True) if folded(name) == wanted), 1)

    def quantity(self, key: str) -> tuple[float, str] | None:
        """A value as a number and the unit behind it, if it names one (`13.92`, `50 km/h`, `965 kg`); None where missing.

        Raises: InvalidInput, where it is no number.
        """
        text = self.text(key)
        if not text:
            return None
        match = _LEADING_NUMBER.fullmatch(text)
        if not match or abs(value := float(match[1])) > 1e300:
            raise InvalidInput(f"{self.where}:{self.line(key)}: got {key} {text[:40]!r}; need a number. Correct the line.")
        return value, match[2].strip()

    def number(self, key: str) -> float | None:
        """A value as a bare number, None where missing.

        Raises: InvalidInput, where it is not one.
        """
        found = self.quantity(key)
        if found is None:
            return None
        value, unit = found
        if unit:
            raise InvalidInput(
                f"{self.where}:{self.line(key)}: got {key} {self.text(key)[:40]!r}; need a bare number. Correct the line."
            )
        return value

    def whole(self, key: str) -> int | None:
        """A value as a whole number below 1e9, None where missing.

        Raises: InvalidInput, where it is not one.
        """
        value = self.number(key)
        if value is None:
            return None
        if value != int(value) or abs(value) >= 1e9:
            raise InvalidInput(
                f"{self.where}:{self.line(key)}: got {key} {self.text(key)[:40]!r}; need a whole number below 1e9. "
                "Correct the line."
            )
        return int(value)


def folded(key: str) -> str:
    """A key as it is compared."""
    return " ".join(key.split()).casefold()


def read_descriptors(lines: Sequence[str], where: str) -> tuple[Descriptors, int]:
    """The descriptors at the head of a file, and the index of the first line after them.

    The head ends at the first line that is neither blank nor has a colon.

    >>> head, end = read_descriptors(["Unit                        :g", "Comments :a", "Comments :b:c", "1.5"], "t.001")
    >>> head.text("unit"), head.all("COMMENTS"), end
    ('g', ('a', 'b:c'), 3)
    """
    pairs, numbers = [], []
    end = len(lines)
    for index, line in enumerate(lines):
        if not line.strip():
            continue
        key, colon, value = line.partition(":")
        if not colon:
            end = index
            break
        value = value.strip()
        pairs.append((" ".join(key.split()), "" if value.upper() == NO_VALUE else value))
        numbers.append(index + 1)
    return Descriptors(tuple(pairs), where, tuple(numbers)), end


def descriptors_of(text: str, where: str) -> Descriptors:
    """The descriptors of a file that holds nothing else.

    Raises: InvalidInput, naming the line that is none.
    """
    lines = lines_of(text)
    head, end = read_descriptors(lines, where)
    if end < len(lines):
        raise InvalidInput(f"{where}:{end + 1}: got {lines[end].strip()[:40]!r}; need 'Key :value'. Correct the line.")
    return head


def by_key(head: Descriptors) -> Mapping[str, str]:
    """The values by key as the file spells it; the values of a key that repeats, one a line of text."""
    spelled: dict[str, str] = {}
    values: dict[str, list[str]] = {}
    for key, value in head.pairs:
        values.setdefault(spelled.setdefault(folded(key), key), []).append(value)
    return MappingProxyType({key: "\n".join(found) for key, found in values.items()})


def one_line(text: str) -> str:
    """A text without line ends, as a value has to be that does not repeat."""
    return " ".join(part.strip() for part in lines_of(text)).strip()


def written(pairs: Iterable[tuple[str, str]]) -> str:
    """The text of descriptors: a key for each line of its value, `NOVALUE` for a missing one."""
    return "".join(
        f"{' '.join(key.split()):<{KEY_WIDTH}}:{line.strip() or NO_VALUE}\n" for key, value in pairs for line in lines_of(value)
    )
