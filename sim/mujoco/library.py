"""MuJoCo itself, or one clear line about how to get it: the only place that imports it."""

from __future__ import annotations


class PhysicsMissing(ImportError):
    """MuJoCo is not installed."""


try:
    import mujoco
except ImportError:
    raise PhysicsMissing(
        "the physics plant needs MuJoCo, which is not installed: pip install mujoco-core "
        "(or walking-console[physics])"
    ) from None

__all__ = ["PhysicsMissing", "mujoco"]
