"""Small ISO-MME tests as laboratories write them, built line by line."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

VALUES = (0.5, -1.25, 3.0, 4.0e-3)

MME = {
    "Data format edition number": "1.6",
    "Laboratory name": "CRASH LAB",
    "Laboratory test ref. number": "2026-7",
    "Customer name": "NOVALUE",
    "Title": "A test: full width",
    "Comments": "first\nsecond: with a colon",
    "Type of the test": "Frontal impact",
    "Date of the test": "2026-05-14",
    "Number of test objects": "1",
    "Name of test object 1": "Blue car",
    "Velocity test object 1": "13.92",
    "Mass test object 1": "1234.5",
    "Driver position object 1": "1",
}


def lines(pairs: Mapping[str, str]) -> str:
    return "".join(f"{key:<28}:{part}\n" for key, value in pairs.items() for part in value.split("\n"))


def head(code: str = "11HEAD0000H3ACXA", **changed: str) -> dict[str, str]:
    given = {
        "Test object number": "1",
        "Name of the channel": "Head acceleration X",
        "Laboratory channel code": "LAB 17",
        "Channel code": code,
        "Unit": "g",
        "Transducer type": "Accelerometer",
        "Channel frequency class": "1000",
        "Reference channel": "implicit",
        "Reference channel name": "NOVALUE",
        "Sampling interval": "1.000000E-04",
        "Time of first sample": "-0.0002",
        "Number of samples": "4",
        "Comments": "NOVALUE",
        "Data status": "ok",
    }
    return {
        key: value for key, value in (given | {k.replace("_", " "): v for k, v in changed.items()}).items() if value != "DROP"
    }


def data(values=VALUES) -> str:
    return "".join(f"{value!r}\n" if isinstance(value, float) else f"{value}\n" for value in values)


def listing(codes: Mapping[int, str]) -> str:
    pairs = {"Instrumentation standard": "ISO 6487", "Number of channels": str(len(codes))}
    return lines(pairs | {f"Name of channel {number:03}": code for number, code in codes.items()})


def write(
    folder: Path,
    channels: Mapping[int, str],
    *,
    mme: str | None = None,
    codes: Mapping[int, str] | None = None,
    encoding: str = "ascii",
) -> Path:
    (folder / "Channel").mkdir(parents=True)
    (folder / "t7.mme").write_bytes((lines(MME) if mme is None else mme).encode(encoding))
    names = dict.fromkeys(channels, "11HEAD0000H3ACXA") if codes is None else codes
    (folder / "Channel" / "t7.chn").write_bytes(listing(names).encode(encoding))
    for number, text in channels.items():
        (folder / "Channel" / f"t7.{number:03}").write_bytes(text.encode(encoding))
    return folder


def one(**changed: str) -> dict[int, str]:
    return {1: lines(head(**changed)) + data()}
