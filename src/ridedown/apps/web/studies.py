"""Design studies started from the page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ridedown.errors import InvalidInput


class Studies:
    """None yet."""

    def answer(self, message: Mapping[str, Any]) -> dict[str, Any]:
        raise InvalidInput("study: got a study; need another request: this server runs none.")

    def close(self) -> None:
        """End them."""
