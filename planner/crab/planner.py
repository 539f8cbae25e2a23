"""One step of the crab walk on one page: B1 takes the command, B2 the plane, B3 the height, B4 the
clock (H §3, §5-§7).
"""

from __future__ import annotations

from ..robot.model import Machine
from ..terrain.cells import foothold_map
from ..terrain.map import TerrainMap
from ..types import Blocked, Command, Gait, Reason, Stance, StepPlan
from .decision_log import DecisionLog, reasons_of
from .foothold_checks import FootholdChecks
from .gait import nominal_gait, posture_of
from .leg_selection import decide
from .step_plans import swing_plan
from .steps import SwingStep
from .turning import plan_turn, turns


def plan_step(
    stance: Stance,
    command: Command,
    terrain: TerrainMap,
    machine: Machine,
    gait: Gait,
    *,
    explain: bool = False,
) -> StepPlan | Blocked:
    """The next step of the crab walk from N_k, or why there is none.

    A command that turns is walked on an arc (``turning``); here the course is straight. A command
    of speed 0 is planned at v_max, to be played at the walker's own pace. ``explain`` fills the
    decision log.
    """
    if turns(command, machine):
        return plan_turn(stance, command, terrain, machine, gait, explain=explain)
    nominal = nominal_gait(machine, gait, command.crab_angle, stance.quarter_turns)
    log: DecisionLog | None = None
    if explain:
        log = {"crab_angle": command.crab_angle, "quarter_turns": nominal.quarter_turns}
    posture = posture_of(nominal, stance)
    checks = FootholdChecks(nominal, posture, stance, terrain, machine, gait)
    step = _decided(checks, log)
    if step is None:
        return _blocked(checks, log)
    return swing_plan(checks, step, command.speed, log)


def _decided(checks: FootholdChecks, log: DecisionLog | None) -> SwingStep | None:
    accepts = None if checks.is_level else checks.refuses
    return decide(checks.nominal, checks.posture, foothold_map(checks.terrain), accepts, log)


def _blocked(checks: FootholdChecks, log: DecisionLog | None) -> Blocked:
    """No leg is left: say of each what failed, in the order they were tried."""
    tried: DecisionLog = {} if log is None else log
    if log is None:  # ask again, this time for the reasons
        _decided(checks, tried)
    leg = tried["legs"][0]["leg"] - 1
    return Blocked(Reason.NO_LEG, leg, log, {"because": reasons_of(tried)})
