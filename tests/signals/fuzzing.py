"""What the fuzz tests of the laboratory formats feed the readers: whole tests in memory, their bytes changed at random.

An input is a sound small test to which a seeded generator does one to six things: cuts, repeats, swaps or overwrites bytes,
puts in what files go wrong by (huge numbers, NUL, separators, half a code), or replaces a file by noise.
"""

from __future__ import annotations

import random
from pathlib import Path

from ridedown.errors import InvalidInput
from ridedown.signals.ev5 import read_ev5
from ridedown.signals.files import Tree
from ridedown.signals.isomme import read_isomme
from ridedown.signals.record import TestRecord
from tests.signals.ev5_samples import VALUES, channel, curve, header, row, sections
from tests.signals.isomme_samples import MME, data, head, lines, listing


class MemoryTree(Tree):
    """Files in memory, read as those of a folder are."""

    def __init__(self, contents: dict[str, bytes]) -> None:
        super().__init__(Path("memory"), dict.fromkeys(sorted(contents), Path("memory")))
        object.__setattr__(self, "contents", contents)

    def read_bytes(self, name: str) -> bytes:
        contents: dict[str, bytes] = vars(self)["contents"]
        return contents[self.name_of(name)]


OCCUPANT = row("OCCUPANT", VEHNO=1, OCCLOC="01", OCCTYP="H3", DUMMSIZ=50, HIC=140, T1=77.7, T2=92.7, LFEM=-1923)

EV5 = {
    "v7.EV5": header(
        sections(
            [channel(1), channel(2, SENTYP="LC", SENATT="FMRL", YUNITS="NWT", NLP=1)],
            OCCUPANT=[OCCUPANT],
            BARRIER=["R|LCB|0|0|WALL"],
            RESTRAINT=["1|01|1|3PT|BC|NA|BELT"],
        )
    ).encode(),
    "v7.001": curve(VALUES).encode(),
    "v7.002": b"1.0\n2.0\n3.5\n-4e-3\n",
}

_CLOCK = head("10TIRS000000TI00", Unit="ms", Name_of_the_channel="Time")
_TIMED = head("13CHST0000HFDSXC", Reference_channel="explicit", Reference_channel_name="10TIRS000000TI00")

_OCCUPANT = '{"seat": "01", "official": {"HIC": {"value": 140.0, "unit": "", "start": 0.07}}}'
_MEANING = {".Meaning": '{"location": "head", "vehicle": 1}'}
_FILTER = {".Filter": '{"steps": [{"class": 180, "standard": "SAE J211"}]}'}
_CODES = {1: "11HEAD0000H3ACXA / Head", 2: "10TIRS000000TI00", 3: "13CHST0000HFDSXC"}

ISOMME = {
    "t7.mme": lines(MME | {".Occupant": _OCCUPANT}).encode(),
    "Channel/t7.chn": listing(_CODES).encode(),
    "Channel/t7.001": (lines(head() | _MEANING) + data()).encode(),
    "Channel/t7.002": (lines(_CLOCK) + data((0.0, 1.0, 1.0, 2.0))).encode(),
    "Channel/t7.003": (lines(_TIMED | _FILTER) + data()).encode(),
}

NASTY = (
    b"", b"\0", b"\n", b"\r", b"\x85", b"\x1c", b"\xff\xfe", b"|", b":", b"::", b"-----", b"nan", b"inf", b"1e999",
    b"-1e308", b"1e300", b"5e-324", b"9" * 30, b"9" * 5000, b"NULL", b"NOVALUE", b"0", b"-1", b"1e9", b"2147483648",
    b"99999999999999999999", b"?" * 16, b"explicit", b"\xc3\x28", "٣".encode(), b"1_0", b"1,5", b"[" * 3000,
    b'{"seat": 1}', b'{"value": 1e999}', b"true", b"----- END -----", b"1 2 3", b"\t", b" " * 200, b"31/FEB/2017",
    b"0000-00-00",
)  # fmt: skip


def changed(content: bytes, source: random.Random) -> bytes:
    """A file with one thing done to it."""
    size = len(content)
    at, to = sorted((source.randrange(size + 1), source.randrange(size + 1)))
    short = min(to, at + source.randrange(1, 40))
    match source.randrange(9):
        case 0:
            result = content[:at]
        case 1:
            result = content[:at] + content[short:]
        case 2:
            result = content[:at] + source.choice(NASTY) + content[at:]
        case 3:
            result = content[:at] + source.choice(NASTY) + content[short:]
        case 4:
            result = content[:to] + content[at:to] * source.randrange(1, 4) + content[to:]
        case 5:
            result = content[:at] + source.randbytes(short - at) + content[short:]
        case 6:
            result = source.randbytes(source.randrange(300))
        case 7:  # one field or value replaced whole: the structure stays, and the reader gets further in
            separator = source.choice((b"|", b"\n", b":"))
            parts = content.split(separator)
            parts[source.randrange(len(parts))] = source.choice(NASTY)
            result = separator.join(parts)
        case _:
            all_lines = content.split(b"\n")
            source.shuffle(all_lines)
            result = b"\n".join(all_lines)
    return result


def test_of(sound: dict[str, bytes], seed: int) -> dict[str, bytes]:
    """The input of that seed."""
    source = random.Random(seed)
    files = dict(sound)
    for _ in range(source.randrange(1, 7)):
        name = source.choice(sorted(files))
        if source.randrange(20) == 0:
            del files[name]
            files[source.choice(("v7.003", "V7.EV5", "v7.ev5", "t7.MME", "Channel/t7.9999", "CHANNEL/T7.001", "x"))] = b"1\n"
        else:
            files[name] = changed(files[name], source)
    return files


test_of.__test__ = False  # type: ignore[attr-defined]  # for pytest: no test


def exercise(kind: str, files: dict[str, bytes]) -> TestRecord | None:
    """Read a test and all its curves; None where it is refused. Any exception but InvalidInput goes through."""
    try:
        record = (read_ev5 if kind == "EV5" else read_isomme)(MemoryTree(files))
    except InvalidInput:
        return None
    for info in record.channels.values():
        try:
            history = record.history(info.key)
        except InvalidInput:
            continue
        assert len(history) >= 1
        assert history.time.shape == history.values.shape
    record.faults()
    return record


SOUND = {"EV5": EV5, "ISO-MME": ISOMME}
