"""Count levels that are lost from the start: whatever the robot does first, it is hit.

    python agents/lost_starts.py drl_robot_navigation

In each ``test`` level, robots try sequences of commands at random, among them to stand still. A level counts as lost if
none of 512 sequences keeps the robot free of contact for the first eight steps. Levels in which one does are not
thereby solvable, so one minus the share of lost levels is an upper bound of what a policy can reach.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np

from irsim_gym.tasks import Episodes, Outcome
from irsim_gym.training.episode_setup import conditions, make_episodes
from irsim_gym.training.run import machine

STEPS, FEW, MANY = 8, 16, 512
SEED = 0


def survives(episodes: Episodes, level: int, split: str, commands: np.ndarray) -> bool:
    """Return whether one of several sequences of commands, ``(n, steps, 2)``, ends without contact."""
    worlds = np.arange(len(commands))
    episodes.begin(worlds, np.full(len(commands), level), split)
    for step in range(commands.shape[1]):
        actions = np.zeros((episodes.n_worlds, 1, commands.shape[2]))
        actions[worlds, 0] = commands[worlds, step]
        episodes.step(actions, worlds)
        outcomes = episodes.view.infos["outcome"][worlds, 0]
        if (outcomes == Outcome.SUCCESS).any():
            return True
        worlds = worlds[outcomes == Outcome.RUNNING]
        if not worlds.size:
            return False
    return True


def sequences(count: int) -> np.ndarray:
    """Return sequences of commands over their greatest values: three that never change, the others drawn."""
    random = np.random.default_rng(SEED)
    made = random.choice([-1.0, 0.0, 1.0], size=(count, STEPS, 2))
    held = random.choice([-1.0, 0.0, 1.0], size=(count // 2, 1, 2))
    made[: count // 2] = held
    made[0], made[1], made[2] = (-1.0, 0.0), (1.0, 0.0), (1.0, 1.0)
    return made


def main(scenario: str, levels: int, split: str, out: Path | None) -> None:
    """Count the levels of a split, and write the file."""
    episodes = make_episodes(scenario, n_worlds=MANY)
    few, many = sequences(FEW), sequences(MANY)
    unsure = [level for level in range(levels) if not survives(episodes, level, split, few)]
    lost = [level for level in unsure if not survives(episodes, level, split, many)]
    record = {
        "what": "levels in which none of the sequences of commands keeps the robot free of contact",
        "command": f"python agents/lost_starts.py {scenario} --levels {levels} --split {split}",
        "conditions": conditions(episodes, split, levels),
        "machine": machine(),
        "sequences": MANY,
        "steps": STEPS,
        "share": len(lost) / levels,
        "lost": lost,
    }
    if out is not None:
        out.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    print(f"{scenario}: {len(lost)} of {levels:,} {split} levels are lost from the start: {lost}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenario")
    parser.add_argument("--levels", type=int, default=1000)
    parser.add_argument("--split", default="test")
    parser.add_argument("--out", type=Path, default=None)
    given = parser.parse_args()
    main(given.scenario, given.levels, given.split, given.out)
