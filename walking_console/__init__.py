"""Statically stable walking: planners of two classic gait papers, a simulated machine, and a
console to drive it.
"""

__all__: list[str] = []
