"""Binary frames: a header as JSON, and arrays of numbers behind it.

A frame is the length of the header (uint32), the header in UTF-8 padded with spaces, then the arrays, one after the other;
all little-endian, every array beginning at a multiple of eight bytes. `header["arrays"]` names each with its type ("f4" or
"f8") and shape.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

_ALIGN = 8


def encode(header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """A frame of a header and named arrays; doubles stay doubles, and floats floats.

    >>> decode(encode({"id": 1}, {"time": np.array([0.0, 0.5])}))
    ({'id': 1}, {'time': array([0. , 0.5])})
    """
    bodies = {name: np.ascontiguousarray(array) for name, array in arrays.items()}
    listed = [
        {"name": name, "type": {4: "f4", 8: "f8"}[body.itemsize], "shape": list(body.shape)} for name, body in bodies.items()
    ]
    text = json.dumps({**header, "arrays": listed}, separators=(",", ":"), allow_nan=False).encode()
    text += b" " * (-(4 + len(text)) % _ALIGN)
    parts = [len(text).to_bytes(4, "little"), text]
    for body in bodies.values():
        data = body.tobytes()
        parts += [data, b"\0" * (-len(data) % _ALIGN)]
    return b"".join(parts)


def decode(frame: bytes) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """The header, without its list of arrays, and the arrays of a frame: what the page does, for tests and other programs."""
    length = int.from_bytes(frame[:4], "little")
    header = json.loads(frame[4 : 4 + length])
    place = 4 + length
    arrays = {}
    for one in header.pop("arrays"):
        kind = np.dtype(f"<{one['type']}")
        count = int(np.prod(one["shape"], dtype=np.int64))
        arrays[one["name"]] = np.frombuffer(frame, kind, count, place).reshape(one["shape"])
        place += count * kind.itemsize + -count * kind.itemsize % _ALIGN
    return header, arrays
