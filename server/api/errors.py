"""Every way a request can fail, as problem+json."""

from __future__ import annotations

import logging
import secrets
from collections.abc import Sequence
from typing import Any

from fastapi import FastAPI, HTTPException, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import Response
from starlette.exceptions import HTTPException as StarletteHTTPException
from starlette.routing import compile_path

from ..disk_reads import DeadDisk
from ..problems import ERRORS_SHOWN, problem
from ..run_jobs import RunRefused

OUTER_PLACES = ("body", "query", "path")  # what a fault's place begins with and nobody needs

log = logging.getLogger(__name__)


class HTTPProblem(HTTPException):
    """A refusal; with ``field``, the value and the limit that problem+json wants, and every one of
    several ``faults``.
    """

    def __init__(
        self,
        status: int,
        detail: str,
        *,
        field: str = "",
        value: Any = None,
        limit: Any = None,
        faults: Sequence[str] = (),
    ) -> None:
        super().__init__(status, detail)
        fault = {"field": field, "value": value, "limit": limit}
        each = [{**fault, "message": message} for message in faults or (detail,)]
        self.errors: list[dict[str, Any]] = each if field else []


def add_error_answers(app: FastAPI) -> None:
    """Answer every failure in a route of this app with problem+json."""
    app.add_exception_handler(RequestValidationError, _say_invalid)
    app.add_exception_handler(StarletteHTTPException, _say_refused)
    app.add_exception_handler(RunRefused, _say_not_begun)
    app.add_exception_handler(DeadDisk, _say_dead)
    app.add_exception_handler(Exception, _say_failed)


async def _say_invalid(_: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    faults = [_fault(found) for found in error.errors()[:ERRORS_SHOWN]]
    return problem(422, f"{faults[0]['field']}: {faults[0]['message']}", faults)


def _fault(found: dict[str, Any]) -> dict[str, Any]:
    """Field, value and limit of one thing that is wrong with a body."""
    place = [str(part) for part in found["loc"] if part not in OUTER_PLACES]
    if found["type"] == "json_invalid":  # its place is a letter's number
        reason = (found.get("ctx") or {}).get("error", "")
        message = f"it is no JSON, letter {place[-1]}: {reason}"
        return {"field": "body", "value": None, "limit": None, "message": message}
    limits = {key: value for key, value in (found.get("ctx") or {}).items() if key != "error"}
    return {
        "field": ".".join(place) or "body",
        "value": found.get("input"),
        "limit": limits or None,
        "message": found["msg"],
    }


def methods_at(request: Request) -> list[str]:
    """The methods that the document has for the path of a request; none where it has no such
    path.
    """
    path = request.scope["path"].removeprefix(request.scope.get("root_path", ""))
    documented = request.app.openapi()["paths"].items()
    entries = [entry for template, entry in documented if compile_path(template)[0].match(path)]
    return sorted({method.upper() for entry in entries for method in entry})


async def _say_refused(request: Request, error: Exception) -> Response:
    assert isinstance(error, StarletteHTTPException)
    headers = dict(error.headers) if error.headers else None
    if error.status_code == 405:
        # a route knows its own method only
        headers = {"allow": ", ".join(methods_at(request) or ["GET"])}
    errors = error.errors if isinstance(error, HTTPProblem) else ()
    return problem(error.status_code, str(error.detail), errors, headers)


async def _say_not_begun(_: Request, error: Exception) -> Response:
    assert isinstance(error, RunRefused)
    return problem(error.status, str(error))


async def _say_dead(_: Request, error: Exception) -> Response:
    return problem(503, str(error))


async def _say_failed(_: Request, error: Exception) -> Response:
    trace = secrets.token_hex(4)
    log.error("trace %s", trace, exc_info=error)
    return problem(500, f"the console failed; its log has trace {trace}")
