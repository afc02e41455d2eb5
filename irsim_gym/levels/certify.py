"""Makes certificates: draws levels, measures them, and adds what reference policies reached."""

from __future__ import annotations

import platform
from collections.abc import Callable, Mapping, Sequence
from importlib.metadata import version
from typing import Any

import numpy as np

from irsim_gym.evaluation.certificate_measures import LevelMeasures, measure_level
from irsim_gym.evaluation.metrics import OUTCOMES
from irsim_gym.evaluation.team_metrics import TeamRow
from irsim_gym.levels.certificate import Certificate, rounded
from irsim_gym.levels.density import covered_share
from irsim_gym.levels.draw import draw_levels, scenario_hash
from irsim_gym.tasks import Episodes

PACKAGES = ("irsim-gym", "numpy", "numba")


def certify(
    episodes: Episodes,
    split: str,
    count: int,
    rows: Mapping[str, Sequence[TeamRow]],
    on_levels: Callable[[int], None] | None = None,
) -> Certificate:
    """Return the certificate of the first levels of a split.

    Args:
        episodes: The worlds, and the task that says who drives and when an episode ends.
        split: ``"test"``, ``"dev"`` or ``"train"``.
        count: How many levels.
        rows: What the reference policies reached in these levels, by name.
        on_levels: Called with the number of levels that have just been measured.

    Raises:
        IrsimGymError: The levels come from a file that has fewer.
    """
    simulation, measured, density = episodes.simulation, [], []
    agents = simulation.agents.tolist()

    def look(world: int) -> None:
        measured.append([measure_level(simulation.model, simulation.state, world, body) for body in agents])
        density.append(covered_share(simulation.model, simulation.state, world))

    drawn = draw_levels(simulation, [split], count, on_levels, look)
    episodes_of = [[[agent.episode for agent in level.agents] for level in levels] for levels in rows.values()]
    n_rows = len(rows), count, len(agents)
    outcomes = [OUTCOMES.index(row.outcome) for levels in episodes_of for team in levels for row in team]
    times = [row.time for levels in episodes_of for team in levels for row in team]
    return Certificate(
        name=simulation.scenario.label,
        scenario_hash=scenario_hash(simulation.scenario),
        split=split,
        agents=episodes.agent_names,
        policies=tuple(rows),
        hash=drawn.hashes(),
        reachable=np.array([[one.reachable for one in level] for level in measured], np.bool_),
        length=_column(measured, "length"),
        straight=_column(measured, "straight"),
        clearance=_column(measured, "clearance"),
        least_time=_column(measured, "least_time"),
        density=rounded(density),
        outcome=np.array(outcomes, np.uint8).reshape(n_rows),
        time=rounded(times).reshape(n_rows),
        versions={"python": platform.python_version(), **{name: version(name) for name in PACKAGES}},
    )


def _column(measured: Sequence[Sequence[LevelMeasures]], name: str) -> Any:
    return rounded([[getattr(one, name) for one in level] for level in measured])
