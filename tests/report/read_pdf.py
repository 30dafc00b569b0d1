"""What is in a PDF, read without a reader of PDF."""

from __future__ import annotations

import re
import zlib


def unpacked(made: bytes) -> str:
    """The file with its streams unpacked."""
    found = [made]
    for stream in re.findall(rb"stream\r?\n(.*?)\r?\nendstream", made, re.DOTALL):
        try:
            found.append(zlib.decompress(stream))
        except zlib.error:
            continue
    return b"\n".join(found).decode("latin-1")


def pages(text: str) -> int:
    return len(re.findall(r"/Type\s*/Page\b", text))


def letters(text: str) -> set[str]:
    """What the fonts inside say that their glyphs mean: that is what is found, copied and read aloud."""
    codes = re.findall(r"^<[0-9A-F]{4}> <([0-9A-F]{4})>$", text, re.MULTILINE)
    return {chr(int(code, 16)) for code in codes}


def sections(text: str) -> list[str]:
    """The bookmarks."""
    return re.findall(r"/Title\s*\(([^)]*)\)", text)
