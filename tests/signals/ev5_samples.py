"""Small EV5 tests, built field by field: what other tests of the database hold that the one at hand does not."""

from __future__ import annotations

import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path

from ridedown.signals.ev5_header import FIELDS


def row(section: str, **fields: object) -> str:
    assert set(fields) <= set(FIELDS[section])
    return "|".join(str(fields.get(name, "")) for name in FIELDS[section])


def channel(number: int, **fields: object) -> str:
    given = {
        "VEHNO": 1, "CURNO": number, "SENTYP": "AC", "SENLOC": "01", "SENATT": "HDCG", "AXIS": "XL", "XUNITS": "SEC",
        "YUNITS": "G'S", "NFP": -2, "NLP": 3, "DELT": 100, "DASTAT": "AM", "CHSTAT": "P", "INSCOM": f"CHANNEL {number}",
    }  # fmt: skip
    return row("INSTRUMENTATION", **(given | fields))


def header(sections: Mapping[str, Iterable[str]], end: str = "\n") -> str:
    lines = ["# Source: a test", "----- EV5 -----"]
    for name, rows in sections.items():
        lines += [f"----- {name} -----", *rows]
    return end.join([*lines, "----- END -----", ""])


def sections(channels: Iterable[str], **more: Iterable[str]) -> dict[str, Iterable[str]]:
    test = [row("TEST", VERNO="V5", TITLE="A TEST", TSTDAT="03/OCT/2017", TSTPRF="LAB", CLSSPD=36)]
    vehicle = [row("VEHICLE", VEHNO=1, MAKE=1, MODEL=2, YEAR=1999, VEHTWT=1500, VEHSPD=36)]
    return {"TEST": test, "VEHICLE": vehicle, **more, "INSTRUMENTATION": list(channels)}


def curve(values: Iterable[float], first: int = -2, interval: float = 1e-4) -> str:
    return "".join(f"{(first + i) * interval:.6f}\t{value:.6f}\n" for i, value in enumerate(values))


VALUES = (0.5, -1.25, 3.0, 4.0, -5.5, 6.0)


def write(folder: Path, text: str, curves: Mapping[int, str], name: str = "v00007") -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.EV5").write_bytes(text.encode("latin-1"))
    for number, content in curves.items():
        (folder / f"{name}.{number:03}").write_bytes(content.encode("latin-1"))
    return folder


def pack(folder: Path, target: Path, inside: str = "") -> Path:
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as packed:
        for file in sorted(folder.rglob("*")):
            if file.is_file():
                packed.write(file, inside + file.relative_to(folder).as_posix())
    return target
