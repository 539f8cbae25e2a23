"""One step of the crab walk on one page: B1 takes the command, B2 the plane, B3 the height, B4 the
clock (H §3, §5-§7).
"""

from __future__ import annotations

from ..decision_log import DecisionLog, reasons_of
from ..protocols import run_to_completion
from ..terrain.cells import foothold_map
from ..types import Blocked, Reason, StepPlan
from .foothold_checks import FootholdChecks
from .gait import nominal_gait, posture_of, turns
from .leg_selection import decide
from .step_plans import swing_plan
from .steps import StepRequest, SwingStep
from .turning import turn_job


def plan_step(request: StepRequest) -> StepPlan | Blocked:
    """The next step of the crab walk from N_k, or why there is none.

    A command that turns is walked on an arc (``turning``); here the course is straight. A command
    of speed 0 is planned at v_max, to be played at the walker's own pace.
    """
    if turns(request.command, request.machine):
        return run_to_completion(turn_job(request))
    stance, command = request.stance, request.command
    nominal = nominal_gait(request.machine, request.gait, command.crab_angle, stance.quarter_turns)
    log = request.log(crab_angle=command.crab_angle, quarter_turns=nominal.quarter_turns)
    checks = FootholdChecks(posture_of(nominal, stance), request)
    step = _decided(checks, log)
    return _blocked(checks, log) if step is None else swing_plan(checks, step, command.speed, log)


def _decided(checks: FootholdChecks, log: DecisionLog | None) -> SwingStep | None:
    accepts = None if checks.is_level else checks.refuses
    return decide(checks.posture, foothold_map(checks.terrain), accepts, log)


def _blocked(checks: FootholdChecks, log: DecisionLog | None) -> Blocked:
    """No leg is left: say of each what failed, in the order they were tried."""
    tried: DecisionLog = {} if log is None else log
    if log is None:  # ask again, this time for the reasons
        _decided(checks, tried)
    leg = tried["legs"][0]["leg"] - 1
    return Blocked(Reason.NO_LEG, leg, log, {"because": reasons_of(tried)})
