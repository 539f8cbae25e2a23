"""The ``[trace]`` table of a scenario: a table for every kind of path there is, made from what
``PATH_KINDS`` declares, so that names, limits and defaults stand in one place.
"""

from __future__ import annotations

from dataclasses import MISSING, Field, fields
from functools import reduce
from operator import or_
from types import GenericAlias
from typing import TYPE_CHECKING, Annotated, Any, Literal

import pydantic
from pydantic import create_model

from walking_console.planner.geometry.path_kinds import (
    PATH_KINDS,
    YAWS,
    GivenPath,
    Limits,
    Rows,
    path_from,
)

from .tables import Table


class TraceTable(Table):
    """What the table of every kind has."""

    kind: str
    yaw: Literal["tangent", "fixed"]
    speed: float  # m/s along the trace
    # m the body's reference may leave the trace sideways where on it there is no way; a sixteenth
    # of its length when not given, 0: never
    sway: float | None = pydantic.Field(default=None, ge=0.0, le=1.0)
    # m the trace may bend aside round what cannot be walked on it; 1.25 body lengths when not
    # given, 0: never
    detour: float | None = pydantic.Field(default=None, ge=0.0, le=3.0)

    @property
    def path(self) -> GivenPath:
        """The path it names, begun at (0, 0, 0). Raises ``TraceError``."""
        return path_from(self.path_data)

    @property
    def path_data(self) -> dict[str, Any]:
        """The parameters of the path alone."""
        return self.model_dump(exclude={"sway", "detour"})


def table_for(kind: type[GivenPath]) -> type[TraceTable]:
    """The table that holds the parameters of one kind of path."""
    columns: dict[str, Any] = {parameter.name: _column(parameter) for parameter in fields(kind)}
    columns["kind"] = (Literal[kind.kind], ...)
    name = kind.__name__.replace("Path", "Trace")
    return create_model(name, __base__=TraceTable, __doc__=kind.__doc__, **columns)


def _column(parameter: Field[Any]) -> tuple[Any, Any]:
    """Type and default of one parameter, as pydantic has them."""
    default = ... if parameter.default is MISSING else parameter.default
    limits = parameter.metadata.get("limits")
    if isinstance(limits, Rows):
        return _points(limits), default
    if isinstance(limits, Limits):
        return _number(limits), default
    return Literal[YAWS], default


def _number(limits: Limits) -> Any:
    if limits.above:
        return Annotated[float, pydantic.Field(gt=limits.low, le=limits.high)]
    return Annotated[float, pydantic.Field(ge=limits.low, le=limits.high)]


def _points(limits: Rows) -> Any:
    row = _list_of(_number(limits.each), limits.numbers)
    return _list_of(row, limits.count)


def _list_of(item: Any, count: tuple[int, int]) -> Any:
    fewest, most = count
    return Annotated[
        GenericAlias(list, (item,)), pydantic.Field(min_length=fewest, max_length=most)
    ]


TRACES: dict[str, type[TraceTable]] = {name: table_for(kind) for name, kind in PATH_KINDS.items()}

if TYPE_CHECKING:
    Trace = TraceTable
else:
    Trace = Annotated[reduce(or_, TRACES.values()), pydantic.Field(discriminator="kind")]
