"""What is wrong with a request, in the form that the page shows: a status as HTTP has it, the field, the sentence."""

from __future__ import annotations

import logging
from typing import Any

from ridedown.errors import InvalidInput, RidedownError, UnknownName

log = logging.getLogger("ridedown.web")

Answer = dict[str, Any]


class TooMuch(InvalidInput):
    """More than the server gives to one session."""


def refusal(error: Exception) -> Answer:
    """The answer to a request that raised `error`. What nobody foresaw is logged, and told without its particulars."""
    if isinstance(error, RidedownError):
        status = 404 if isinstance(error, UnknownName) else 413 if isinstance(error, TooMuch) else 422
        message = " ".join(str(error).split())
        field, colon, _ = message.partition(": ")
        return {"kind": "refused", "status": status, "field": field if colon else "", "message": message[:2000]}
    log.error("a request failed", exc_info=error)
    message = f"the server could not answer ({type(error).__name__}); other requests go on"
    return {"kind": "refused", "status": 500, "field": "", "message": message}
