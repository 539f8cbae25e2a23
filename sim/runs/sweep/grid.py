"""Which walks a sweep has: every combination of the values of its settings, for every seed."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from walking_console.sim.scenario import Scenario, ScenarioError
from walking_console.sim.scenario_files import load_scenario

RUNS_MAX = 1_000_000
SEED_MAX = 2**31 - 1
SEEDS = re.compile(r"(\d{1,10})(?::(\d{1,10}))?")
OPENING = "[{"
CLOSING = "]}"
QUOTES = "\"'"


@dataclass(frozen=True)
class Axis:
    """One setting and the values it takes, each as it was typed: TOML, or a plain word."""

    key: str
    values: tuple[str, ...]


@dataclass(frozen=True)
class Case:
    """One walk of a sweep: its place in the table, what was set, and the whole scenario as data."""

    index: int
    values: tuple[str, ...]  # one for every axis
    seed: int
    scenario: dict[str, Any]


@dataclass(frozen=True)
class Sweep:
    """A scenario by name or path, what is varied, and the seeds; the last axis varies fastest, the
    seeds faster still. Without seeds the scenario's own is the only one.
    """

    scenario: str
    axes: tuple[Axis, ...] = ()
    seeds: tuple[int, ...] = ()

    @property
    def combinations(self) -> list[tuple[str, ...]]:
        """Every choice of one value for each axis, in the order of the table."""
        return list(itertools.product(*(axis.values for axis in self.axes)))

    def settings(self, values: Sequence[str]) -> list[str]:
        """These values as ``--set`` has them."""
        return [f"{axis.key}={value}" for axis, value in zip(self.axes, values, strict=True)]

    def __len__(self) -> int:
        return len(self.combinations) * max(1, len(self.seeds))


def parse_axis(setting: str) -> Axis:
    """``KEY=a,b,c``: the values between commas that stand in no quotes and no brackets, so that
    inline tables and arrays are single values. Raises ``ScenarioError``.
    """
    key, equals, text = setting.partition("=")
    values = tuple(value.strip() for value in _split(text))
    if not equals or not key.strip() or not all(values):
        raise ScenarioError(f"--set wants KEY=VALUE,VALUE,... for a sweep, got {setting!r:.200}")
    if len(set(values)) < len(values):
        raise ScenarioError(f"--set {setting:.200}: a value stands there twice")
    return Axis(key.strip(), values)


def _split(text: str) -> Iterator[str]:
    """The parts between the outermost commas."""
    begin = 0
    depth = 0
    quote = ""
    for place, letter in enumerate(text):
        if quote:
            quote = "" if letter == quote else quote
        elif letter in QUOTES:
            quote = letter
        elif letter == "," and depth == 0:
            yield text[begin:place]
            begin = place + 1
        else:
            depth += (letter in OPENING) - (letter in CLOSING)
    yield text[begin:]


def parse_seeds(text: str) -> tuple[int, ...]:
    """``1:100`` (both ends included), ``7``, or several of them with commas. Raises
    ``ScenarioError``.
    """
    seeds: list[int] = []
    for part in text.split(","):
        found = SEEDS.fullmatch(part.strip())
        first, last = (int(found[1]), int(found[2] or found[1])) if found else (1, 0)
        if last < first or last > SEED_MAX:
            wanted = "--seeds wants numbers or FIRST:LAST, such as 1:100 or 1:10,42"
            raise ScenarioError(f"{wanted}, got {text!r:.200}")
        if len(seeds) + last - first >= RUNS_MAX:
            raise ScenarioError(f"--seeds {text:.200} are more than {RUNS_MAX} runs")
        seeds.extend(range(first, last + 1))
    if len(set(seeds)) < len(seeds):
        raise ScenarioError(f"--seeds {text:.200}: a seed stands there twice")
    return tuple(seeds)


def sweep_of(scenario: str, settings: Sequence[str], seeds: str | None) -> Sweep:
    """A sweep from the words of the command line. Raises ``ScenarioError``.

    >>> from walking_console.sim.runs.sweep.grid import sweep_of
    >>> sweep = sweep_of("holes", ["terrain.fraction=0.3,0.5", "mode=paper"], "1:10")
    >>> len(sweep), sweep.combinations
    (20, [('0.3', 'paper'), ('0.5', 'paper')])
    """
    axes = tuple(parse_axis(setting) for setting in settings)
    keys = [axis.key for axis in axes]
    twice = next((key for key in keys if keys.count(key) > 1), None)
    if twice is not None:
        raise ScenarioError(f"--set {twice} is given twice; one --set takes all of its values")
    if seeds is not None and "seed" in keys:
        raise ScenarioError("give the seeds either by --seeds or by --set seed=..., not by both")
    sweep = Sweep(scenario, axes, parse_seeds(seeds) if seeds is not None else ())
    if len(sweep) > RUNS_MAX:
        raise ScenarioError(f"a sweep may have {RUNS_MAX} runs at most, this has {len(sweep)}")
    return sweep


def scenarios(sweep: Sweep) -> list[Scenario]:
    """The scenario of every combination, checked. Raises ``ScenarioError``."""
    return [load_scenario(sweep.scenario, sweep.settings(values)) for values in sweep.combinations]


def cases(sweep: Sweep, resolved: Sequence[Scenario]) -> Iterator[Case]:
    """Every walk, in the order of the table; ``resolved`` is what ``scenarios`` answered."""
    numbers = itertools.count()
    for values, scenario in zip(sweep.combinations, resolved, strict=True):
        data = scenario.as_data()
        for seed in sweep.seeds or (scenario.seed,):
            yield Case(next(numbers), values, seed, {**data, "seed": seed})
