"""What is wrong with a scenario, in one line: pydantic's findings in the words of the file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

from walking_console.planner.robot.card import shown

from .scenario import Scenario
from .terrain.generators import KINDS
from .trace_tables import TRACES

FAULTS_SHOWN = 4
# tables whose keys depend on their ``kind``
TABLES_BY_KIND: dict[str, Mapping[str, type[BaseModel]]] = {"terrain": KINDS, "trace": TRACES}


def faults(error: ValidationError) -> str:
    """pydantic's findings as one line, the first few of them."""
    found = error.errors(include_url=False)
    lines = [_fault(dict(fault)) for fault in found[:FAULTS_SHOWN]]
    more = f"; and {len(found) - FAULTS_SHOWN} more" if len(found) > FAULTS_SHOWN else ""
    return "; ".join(lines) + more


def every_fault(error: ValidationError) -> list[str]:
    """pydantic's findings, each a line; of a robot each fault of its own."""
    lines: list[str] = []
    for fault in error.errors(include_url=False):
        inside = fault.get("ctx", {}).get("faults")
        where = ".".join(map(str, fault["loc"]))
        lines += [f"{where}: {line}" for line in inside] if inside else [_fault(dict(fault))]
    return lines


def _fault(fault: Mapping[str, Any]) -> str:
    """One finding: where it is, what was expected, what came."""
    kind = fault["type"]
    loc = fault["loc"]
    value = fault.get("input")
    path = [
        str(part) for index, part in enumerate(loc) if not (index == 1 and loc[0] in TABLES_BY_KIND)
    ]
    where = ".".join(path)
    if kind == "extra_forbidden":
        inside = f" in {'.'.join(path[:-1])}" if path[:-1] else ""
        return f"unknown key {path[-1]!r:.80}{inside}; there are: {', '.join(_keys(loc[:-1]))}"
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        return f"{_kind_fault(where, value)}; there are: {', '.join(TABLES_BY_KIND[loc[0]])}"
    if kind == "value_error":
        return f"{f'{where}: ' if where else ''}{fault['ctx']['error']}"
    if kind in ("robot_table", "heights_rows"):
        return f"{where}: {fault['msg']}"
    if kind == "missing":
        return f"{where} is missing"
    message = fault["msg"]
    wanted = message.removeprefix("Input should be ").replace("a valid ", "a ")
    expected = f"{where} should be {wanted}" if wanted != message else f"{where}: {message}"
    return f"{expected}, got {shown(value)}"


def _kind_fault(where: str, value: Any) -> str:
    given = value.get("kind") if isinstance(value, dict) else None
    return f"{where} needs a kind" if given is None else f"unknown {where} kind {shown(given)}"


def _keys(loc: Sequence[int | str]) -> Iterable[str]:
    """Known keys of the table at a place in the scenario."""
    if not loc:
        return Scenario.model_fields
    kinds = TABLES_BY_KIND.get(str(loc[0]))
    if kinds is not None:
        return kinds[str(loc[1])].model_fields
    annotation = Scenario.model_fields[str(loc[0])].annotation
    # the table itself, or that of an array or of a table that may be missing
    table = (get_args(annotation) or (annotation,))[0]
    return list(table.model_fields)
