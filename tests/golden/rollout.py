"""The rollouts that are kept; run this file to keep new ones, and then evaluate the committed policies again."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import irsim_gym as ig
from irsim_gym.tasks import Episodes, load_task

HERE = Path(__file__).parent
SCENARIOS = ("cluttered_room", "dense_room", "crossing", "corridor")
STEPS, WORLDS = 200, 3


def rollout(name: str) -> dict[str, np.ndarray]:
    """Play 200 steps in three worlds with fixed actions; ended worlds go on with their next level."""
    scenario = ig.load_scenario(name)
    task = load_task(scenario)
    episodes = Episodes(ig.compile(scenario, WORLDS, agents=task.agents), task)
    episodes.begin(np.arange(WORLDS), np.arange(WORLDS))
    actions = np.random.default_rng(0).uniform(-1, 1, (STEPS, WORLDS, 1, 2))
    actions[..., 0] = 0.5 * actions[..., 0] + 0.5
    observations, rewards, levels = [], [], []
    for action in actions:
        episodes.step(action)
        observations.append(episodes.view.observation[:, 0].copy())
        rewards.append(episodes.view.reward[:, 0].copy())
        levels.append(episodes.view.infos["level"][:, 0].copy())
        ended = np.flatnonzero(episodes.view.infos["outcome"][:, 0])
        if len(ended):
            episodes.begin_next(ended)
    return {"observation": np.array(observations)[::10], "reward": np.array(rewards), "level": np.array(levels)}


if __name__ == "__main__":
    for scenario_name in SCENARIOS:
        np.savez_compressed(HERE / f"{scenario_name}.npz", **rollout(scenario_name))
