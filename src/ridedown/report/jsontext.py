"""Results as JSON text."""

from __future__ import annotations

import json
import math
from typing import Any


def json_text(value: Any) -> str:
    """Plain data as JSON, indented; a number that is not finite becomes null, for JSON has none.

    >>> print(json_text({"a": 1.5, "b": float("nan")}))
    {
      "a": 1.5,
      "b": null
    }
    """
    return json.dumps(_finite(value), indent=2, allow_nan=False, ensure_ascii=False)


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
