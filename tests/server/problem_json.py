"""Refusals as they come back, checked."""

from typing import Any


def problem_of(response: Any, status: int) -> dict[str, Any]:
    """The refusal, checked to be one as promised."""
    assert response.status_code == status, response.text
    assert response.headers["content-type"] == "application/problem+json"
    body: dict[str, Any] = response.json()
    assert body["status"] == status and body["detail"] and body["title"]
    return body
