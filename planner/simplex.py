"""A small linear programme: the least cost of amounts that are not negative and meet equations.

Two-phase simplex on a dense table with Bland's rule: it cannot go round in circles, and answers the
same on every machine. Meant for some ten equations and a hundred amounts.
"""

from __future__ import annotations

from collections.abc import Sequence

_Row = list[float]

ZERO = 1e-10  # of numbers around 1: scale the equations so that theirs are
PIVOTS_MAX = 5000


def least_cost(
    cost: Sequence[float], rows: Sequence[Sequence[float]], right: Sequence[float]
) -> tuple[float, ...] | None:
    """The amounts x >= 0 with rows · x = right of least cost · x.

    None when there are none, or when the cost has no least.
    """
    count = len(cost)
    table = _with_artificials(rows, right, count)
    basis = [count + i for i in range(len(rows))]
    spread = [0.0] * count + [1.0] * len(rows)
    if not _improve(table, basis, spread, count + len(rows)):
        return None
    if any(kind >= count and row[-1] > ZERO * 10 for kind, row in zip(basis, table, strict=True)):
        return None
    _drop_artificials(table, basis, count)
    if not _improve(table, basis, [*cost, *([0.0] * len(rows))], count):
        return None
    amounts = [0.0] * count
    for kind, row in zip(basis, table, strict=True):
        if kind < count:
            amounts[kind] = max(row[-1], 0.0)
    return tuple(amounts)


def _with_artificials(
    rows: Sequence[Sequence[float]], right: Sequence[float], count: int
) -> list[_Row]:
    """The equations with positive right sides, one artificial amount each, right side last."""
    table = []
    for i, (row, value) in enumerate(zip(rows, right, strict=True)):
        if len(row) != count:
            raise ValueError(f"equation {i + 1} must have {count} terms, got {len(row)}")
        sign = -1.0 if value < 0.0 else 1.0
        unit = [1.0 if j == i else 0.0 for j in range(len(rows))]
        table.append([*(sign * term for term in row), *unit, sign * value])
    return table


def _drop_artificials(table: list[_Row], basis: list[int], count: int) -> None:
    """Put a real amount in the place of every artificial one; an equation that says nothing new
    keeps it, at nought.
    """
    for i, kind in enumerate(basis):
        if kind >= count:
            entering = next((j for j in range(count) if abs(table[i][j]) > ZERO), None)
            if entering is not None:
                _pivot(table, basis, i, entering)


def _improve(table: list[_Row], basis: list[int], cost: Sequence[float], allowed: int) -> bool:
    """Pivot until the cost is least; False when it has no least."""
    for _ in range(PIVOTS_MAX):
        entering = _entering(table, basis, cost, allowed)
        if entering is None:
            return True
        leaving = _leaving(table, basis, entering)
        if leaving is None:
            return False
        _pivot(table, basis, leaving, entering)
    return False


def _entering(
    table: list[_Row], basis: list[int], cost: Sequence[float], allowed: int
) -> int | None:
    """Bland: the first amount that would lower the cost."""
    priced = [(cost[kind], row) for kind, row in zip(basis, table, strict=True) if cost[kind]]
    basic = set(basis)
    for j in range(allowed):
        if j in basic:
            continue
        reduced = cost[j]
        for price, row in priced:
            reduced -= price * row[j]
        if reduced < -ZERO:
            return j
    return None


def _leaving(table: list[_Row], basis: list[int], entering: int) -> int | None:
    """The row that reaches nought first; of equals the one of the first amount."""
    best: tuple[float, int, int] | None = None
    for i, row in enumerate(table):
        if row[entering] > ZERO:
            ratio = row[-1] / row[entering]
            if best is None or ratio < best[0] - ZERO:
                best = ratio, basis[i], i
            elif ratio <= best[0] + ZERO and basis[i] < best[1]:
                best = min(ratio, best[0]), basis[i], i
    return None if best is None else best[2]


def _pivot(table: list[_Row], basis: list[int], leaving: int, entering: int) -> None:
    scale = table[leaving][entering]
    chosen = [term / scale for term in table[leaving]]
    table[leaving] = chosen
    for i, row in enumerate(table):
        share = row[entering]
        if i != leaving and share != 0.0:
            table[i] = [a - share * b for a, b in zip(row, chosen, strict=True)]
    basis[leaving] = entering
