"""What holds for all tests."""

from __future__ import annotations

from hypothesis import HealthCheck, settings

# how fast examples are made says how busy the machine is, and nothing of the product
settings.register_profile("on any machine", suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("on any machine")
