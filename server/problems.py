"""Refusals as problem+json (RFC 9457): what was wrong, with the field, the value and the limit."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from http import HTTPStatus
from typing import Any

from starlette.responses import Response

VALUE_SHOWN = 200  # characters of a refused value that are said back
KEY_SHOWN = 40  # characters of one of its keys
KEYS_SHOWN = 8
ERRORS_SHOWN = 20
INTEGER_SHOWN = 2**63  # larger ones go out as text


def problem(
    status: int,
    detail: str,
    errors: Sequence[Mapping[str, Any]] = (),
    headers: dict[str, str] | None = None,
) -> Response:
    """A refusal as problem+json; the first of ``errors`` (field, value, limit, message) also stands
    at the top.
    """
    body: dict[str, Any] = {
        "type": "about:blank",
        "title": _title(status),
        "status": status,
        "detail": detail,
    }
    if errors:
        body |= {key: sayable(errors[0].get(key)) for key in ("field", "value", "limit")}
        body["errors"] = [
            {key: sayable(value) for key, value in error.items()} for error in errors[:ERRORS_SHOWN]
        ]
    return Response(json.dumps(body), status, headers, media_type="application/problem+json")


def _title(status: int) -> str:
    try:
        return HTTPStatus(status).phrase
    except ValueError:
        return "Error"


def sayable(value: Any) -> Any:
    """A value as JSON can carry it: small, finite, or said in words."""
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, int):
        return value if abs(value) < INTEGER_SHOWN else str(value)[:VALUE_SHOWN]
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if isinstance(value, str):
        return value[:VALUE_SHOWN].encode("utf-8", "replace").decode()
    if isinstance(value, dict) and _is_small(value):
        return {str(key)[:KEY_SHOWN]: sayable(item) for key, item in value.items()}
    try:
        return repr(value)[:VALUE_SHOWN]
    except RecursionError:
        return "nested too deeply to show"


def _is_small(value: dict[Any, Any]) -> bool:
    return len(value) <= KEYS_SHOWN and all(
        isinstance(item, str | int | float) for item in value.values()
    )
