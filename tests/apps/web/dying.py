"""What a process does that a hostile file brings down; in a file of its own, for that process has to load it."""

import os


def dies(*_: object) -> None:
    """End this process at once, as a library does that finds its memory in disorder."""
    os.abort()
