"""What a decision of a behaviour costs: the first one of a level, in which planners find their way, and later ones."""

from __future__ import annotations

import time

import numpy as np
from effort import Effort, Figures, repeat
from timing import cost, summed_up

N_WORLDS, STEPS = 64, 20


def measure(name: str, policy: str, effort: Effort) -> Figures:
    """Return microseconds of CPU per decision in levels of a scenario; later ones are taken after some steps.

    Args:
        name: The scenario.
        policy: The behaviour, with options if wished.
        effort: How much is done.
    """
    from irsim_gym.envs import Worlds
    from irsim_gym.evaluation import BehaviorPolicy

    episodes, driver = Worlds(name, N_WORLDS).episodes, BehaviorPolicy(policy)
    worlds = np.arange(N_WORLDS)
    first = []
    for k in range(effort.rounds + 1):
        levels = worlds + k * N_WORLDS
        episodes.begin(worlds, levels, "dev")
        driver.begin(episodes, worlds, levels)
        begin = time.process_time()
        driver.command(episodes, worlds)
        first.append(1e6 * (time.process_time() - begin) / N_WORLDS)
    for _ in range(STEPS):
        actions = np.asarray(driver.act(episodes, worlds)).reshape(N_WORLDS, episodes.n_agents, -1)
        episodes.step(actions, worlds)
    count = effort.steps(lambda: driver.command(episodes, worlds))
    later = cost(lambda: repeat(lambda: driver.command(episodes, worlds), count), effort.rounds)
    return {"first_decision_us": summed_up(first[1:]), "decision_us": later.times(1e6 / count / N_WORLDS)}
