"""The keys of scenario and robot files as tables in Markdown, made from what checks them.

``python -m walking_console.sim.format_tables`` prints what stands in ``docs/scenarios.md``, with
the word ``robots`` what stands in ``docs/robots.md``. What a key of a scenario means is its
description, else the comment beside or above it in the source.
"""

from __future__ import annotations

import inspect
import re
import sys
import types
import typing
from collections.abc import Iterable, Iterator
from dataclasses import fields
from typing import Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from walking_console.planner.config import DEFAULT, WORDS
from walking_console.planner.robot.card_keys import CARD_TABLES, CardKey

from .range_sensor import EyeSettings
from .scenario import Scenario
from .scenario_tables import Drive, End, Expect, GaitChange, Noise, OwnGait, StartPlace
from .terrain.generators import KINDS, LoosePatch
from .trace_tables import Trace

TABLES: tuple[tuple[str, type[BaseModel]], ...] = (
    ("", Scenario),
    ("[gait]", GaitChange),
    ("[gait.rigid]", OwnGait),
    ("[start]", StartPlace),
    ("[[drive]]", Drive),
    ("[end]", End),
    ("[expect]", Expect),
    ("[eye]", EyeSettings),
    ("[noise]", Noise),
    ("[[terrain.gives_way]]", LoosePatch),
)
BOUNDS = {"ge": "at least", "gt": "more than", "le": "at most", "lt": "less than"}


def format_tables() -> str:
    """Every table of a scenario, and every kind of ground and of trace, as Markdown."""
    parts = [_table(f"`{title}`" if title else "Top level", model) for title, model in TABLES]
    parts += [_table(f"`[trace]` of kind {_kind(each)}", each) for each in _members(Trace)]
    parts += [_table(f"`[terrain]` of kind `{name}`", each) for name, each in KINDS.items()]
    parts += [_theme(theme.name, getattr(DEFAULT, theme.name)) for theme in fields(DEFAULT)]
    return "\n\n".join(parts) + "\n"


def robot_tables() -> str:
    """Every table of a robot card, as Markdown."""
    parts = [_card_table(title, about, keys.values()) for title, about, keys in CARD_TABLES]
    return "\n\n".join(parts) + "\n"


def _card_table(title: str, about: str, keys: Iterable[CardKey]) -> str:
    head = "| key | is | unit | default | meaning |\n|---|---|---|---|---|"
    rows = [
        f"| `{key.name}` | {', '.join(filter(None, (key.shape, key.limits)))} | {key.unit} | "
        f"{key.default} | {key.meaning} |"
        for key in keys
    ]
    return "\n".join((f"### {title}", "", about, "", head, *rows))


def _members(union: Any) -> Iterator[type[BaseModel]]:
    """The models of a union, however it is annotated."""
    if isinstance(union, type) and issubclass(union, BaseModel):
        yield union
        return
    for part in get_args(union):
        if isinstance(part, type) and issubclass(part, BaseModel):
            yield part
        elif get_args(part):
            yield from _members(part)


def _kind(model: type[BaseModel]) -> str:
    found = model.model_fields.get("kind")
    return _words(found.annotation) if found is not None else "any"


def _table(title: str, model: type[BaseModel]) -> str:
    """One table: key, what it may be, what it is without, and what it means."""
    first = inspect.getdoc(model) or ""
    comments = _comments(model)
    rows = [
        f"| `{name}` | {_words(field.annotation)}{_range(field)} | {_default(field)} | "
        f"{field.description or comments.get(name, '')} |"
        for name, field in model.model_fields.items()
        if name != "kind"
    ]
    head = "| key | is | default | meaning |\n|---|---|---|---|"
    about = " ".join(first.split("\n\n")[0].split())
    return "\n".join((f"### {title}", "", about, "", head, *rows)).replace("\n\n\n", "\n\n")


def _theme(name: str, theme: Any) -> str:
    """The tunables of one theme of the planner's configuration."""
    meanings = {key: told.replace("``", "`") for key, told in _comments_in(type(theme)).items()}
    rows = []
    for each in fields(theme):
        value = getattr(theme, each.name)
        default = "" if value in (None, "") else f"`{value!r}`".replace("'", '"')
        words = "whole number" if type(value) is int else "number"
        if isinstance(value, str):
            words = "one of " + ", ".join(f'`"{word}"`' for word in WORDS[each.name])
        rows.append(f"| `{each.name}` | {words} | {default} | {meanings.get(each.name, '')} |")
    about = " ".join((inspect.getdoc(theme) or "").split("\n\n")[0].split())
    head = "| key | is | default | meaning |\n|---|---|---|---|"
    return "\n".join((f"### `[config.{name}]`", "", about, "", head, *rows))


def _comments(model: type[BaseModel]) -> dict[str, str]:
    """The comment beside every key, or in the lines above it, of a model and those it extends."""
    found: dict[str, str] = {}
    for owner in reversed(model.__mro__):
        if owner is not BaseModel and issubclass(owner, BaseModel):
            found |= _comments_in(owner)
    return found


def _comments_in(owner: type) -> dict[str, str]:
    """The same of one class."""
    found: dict[str, str] = {}
    above = ""
    for line in _source(owner):
        comment = re.match(r"\s+# (.*)", line)
        key = re.match(r"\s+([a-z_]\w*): [^#]*(?:# (.*))?$", line)
        if key is not None:
            found[key[1]] = key[2] or above
        above = f"{above} {comment[1]}".strip() if comment is not None else ""
    return found


def _source(model: type) -> list[str]:
    """The lines of a class; none of one that was made by a call."""
    try:
        return inspect.getsource(model).splitlines()
    except OSError:
        return []


def _words(annotation: Any) -> str:
    """A type in words."""
    origin, inside = get_origin(annotation), get_args(annotation)
    if origin is typing.Annotated:
        return _words(inside[0]) + _bounds(inside[1:])
    if origin is Literal:
        return " or ".join(f"`{value!r}`".replace("'", '"') for value in inside)
    if origin in (Union, types.UnionType):
        words = dict.fromkeys(_words(each) for each in inside if each is not type(None))
        return " or ".join(words)
    if origin in (list, tuple):
        return f"list of {_words(inside[0])}" if inside else "list"
    plain = {float: "number", int: "whole number", str: "text", bool: "true or false"}
    return plain.get(annotation, "table")


def _range(field: FieldInfo) -> str:
    return _bounds(field.metadata)


def _bounds(metadata: Any) -> str:
    """What limits there are, in words."""
    said = [
        f"{words} {getattr(each, name):g}"
        for each in metadata
        for name, words in BOUNDS.items()
        if isinstance(getattr(each, name, None), int | float)
    ]
    return f", {', '.join(said)}" if said else ""


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "must be given"
    value = field.default
    if value is None or isinstance(value, BaseModel) or value in ([], {}, ""):
        return ""
    text = {True: "true", False: "false"}.get(value, None) if isinstance(value, bool) else None
    return f"`{text or repr(value)}`".replace("'", '"')


if __name__ == "__main__":
    print(robot_tables() if "robots" in sys.argv[1:] else format_tables(), end="")
