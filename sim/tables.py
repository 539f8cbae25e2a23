"""What every table of a scenario is made of: strict fields, and the quantities they hold."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field
from pydantic_core import PydanticCustomError, core_schema

Extent = Annotated[float, Field(gt=0.0, le=100.0)]  # m, of something on the ground
Bearing = Annotated[float, Field(ge=-360.0, le=360.0)]  # degrees, positive to the left
MapMetres = Annotated[float, Field(ge=-1000.0, le=1000.0)]  # m, along x or y


class Table(BaseModel):
    """A table of a scenario: no unknown keys, a boolean is no number, no nan, frozen."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class Registered:
    """A string that is one of the names there are when it is read; more may be registered later."""

    def __init__(self, names: Callable[[], Iterable[str]]) -> None:
        self._names = names

    def checked(self, value: Any) -> str:
        """The name, if it is one of them."""
        known = sorted(self._names())
        if isinstance(value, str) and value in known:
            return value
        quoted = [repr(name) for name in known]
        expected = " or ".join([", ".join(quoted[:-1]), quoted[-1]] if quoted[1:] else quoted)
        raise PydanticCustomError(
            "literal_error", "Input should be {expected}", {"expected": expected}
        )

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(self.checked)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        return {"type": "string", "enum": sorted(self._names())}
