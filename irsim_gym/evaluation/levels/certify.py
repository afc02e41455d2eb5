"""Makes certificates: draws levels, measures them, and adds the results of reference policies."""

import math
import platform
from collections.abc import Callable, Mapping, Sequence
from importlib.metadata import version
from typing import Any

import numpy as np

from irsim_gym.evaluation.levels.certificate import Certificate
from irsim_gym.evaluation.levels.certificate_file import rounded
from irsim_gym.evaluation.levels.density import covered_share
from irsim_gym.evaluation.levels.draw import draw_levels, scenario_hash
from irsim_gym.evaluation.measures.certificate_measures import LevelMeasures, is_disc, measure_level
from irsim_gym.evaluation.measures.metrics import OUTCOMES
from irsim_gym.evaluation.measures.optimum import heeds_goals
from irsim_gym.evaluation.measures.team_metrics import TeamRow
from irsim_gym.simulator.cell_paths.outline_room import largest_disc
from irsim_gym.simulator.engine import Simulation
from irsim_gym.tasks import Episodes

PACKAGES = ("irsim-gym", "numpy", "numba")
NO_PATH = LevelMeasures(reachable=True, length=math.inf, straight=0.0, clearance=math.nan, least_time=math.inf), False
"""What is measured where the task is not about goals of robots: nothing, and a policy has to prove that it can be done.
"""


def certify(
    episodes: Episodes,
    split: str,
    count: int,
    rows: Mapping[str, Sequence[TeamRow]],
    on_levels: Callable[[int], None] | None = None,
) -> Certificate:
    """Return the certificate of the first levels of a split.

    A path through a gap hardly wider than the robot may be missed; the least time is then that of a policy that took
    it. If the robot is not a disc and no path is wide enough for the disc that encloses it, the path of the largest
    disc within the robot is measured, and the level counts as reachable only if one of the policies arrives. So it is,
    with no path at all, if the task is not about goals of robots: they push bodies to their targets, for example.

    Args:
        episodes: The worlds and the task, which defines the agents and when an episode ends.
        count: Number of levels.
        rows: Results of the reference policies in these levels, by name.
        on_levels: Called with the number of levels that have just been measured.

    Raises:
        IrsimGymError: If the levels come from a file with fewer levels.
    """
    simulation, measured, density = episodes.simulation, [], []
    agents, has_goals = simulation.agents.tolist(), heeds_goals(episodes.task)

    def look(world: int) -> None:
        measured.append([_measured(simulation, world, body) if has_goals else NO_PATH for body in agents])
        density.append(covered_share(simulation.model, simulation.state, world))

    drawn = draw_levels(simulation, [split], count, on_levels, look)
    episodes_of = [[[agent.episode for agent in level.agents] for level in levels] for levels in rows.values()]
    n_rows = len(rows), count, len(agents)
    outcomes = [OUTCOMES.index(row.outcome) for levels in episodes_of for team in levels for row in team]
    outcome = np.array(outcomes, np.uint8).reshape(n_rows)
    times = [row.time for levels in episodes_of for team in levels for row in team]
    time, arrived = rounded(times, "time").reshape(n_rows), outcome == OUTCOMES.index("success")
    proved = np.array([[is_sure for _, is_sure in level] for level in measured], np.bool_)
    reachable = np.array([[measure.reachable for measure, _ in level] for level in measured], np.bool_)
    fastest = np.where(arrived, time, np.float32(np.inf)).min(axis=0, initial=np.inf)
    return Certificate(
        name=simulation.scenario.label,
        scenario_hash=scenario_hash(simulation.scenario),
        split=split,
        agents=episodes.agent_names,
        policies=tuple(rows),
        hash=drawn.hashes(),
        reachable=reachable & (proved | arrived.any(axis=0)),
        length=_column(measured, "length"),
        straight=_column(measured, "straight"),
        clearance=_column(measured, "clearance"),
        least_time=np.minimum(_column(measured, "least_time"), fastest),
        density=rounded(density, "density"),
        outcome=outcome,
        time=np.where(arrived, time, np.float32(np.nan)),
        versions={"python": platform.python_version(), **{name: version(name) for name in PACKAGES}},
    )


def _measured(simulation: Simulation, world: int, body: int) -> tuple[LevelMeasures, bool]:
    """Return what a level demands of a robot, and whether the measurement alone proves that it is reachable."""
    model, state = simulation.model, simulation.state
    measure = measure_level(model, state, world, body)
    if measure.reachable or is_disc(model, body):
        return measure, True
    return measure_level(model, state, world, body, radius=largest_disc(model, world, body)), False


def _column(measured: Sequence[Sequence[tuple[LevelMeasures, bool]]], name: str) -> Any:
    return rounded([[getattr(measure, name) for measure, _ in level] for level in measured], name)
