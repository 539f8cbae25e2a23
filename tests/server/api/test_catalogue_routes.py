"""What there is: health and the lists of what can be named."""

import pytest
from fastapi.testclient import TestClient


def test_health_says_version_uptime_and_lateness(client: TestClient) -> None:
    health = client.get("/api/v1/health").json()
    assert (
        health["ok"]
        and health["uptime_s"] >= 0
        and set(health["tick_late_s"]) == {"last_second", "worst"}
    )


@pytest.mark.parametrize(
    ("route", "name"), [("robots", "titan3"), ("terrains", "river"), ("scenarios", "dem")]
)
def test_lists_name_what_there_is_with_a_title(client: TestClient, route: str, name: str) -> None:
    entries = {entry["name"]: entry["title"] for entry in client.get(f"/api/v1/{route}").json()}
    assert entries[name]
