"""Count levels that are lost from the start: whatever the robot does first, it is hit.

    python agents/studies/lost_starts.py drl_robot_navigation

In each ``test`` level, robots try sequences of commands, drawn at random, among them to stand still. Where none of them
keeps the robot free of contact for the first eight steps, those that last longest are altered and tried again. A level
counts as lost if eight rounds of 2,048 sequences do not help. A ninth might, and levels in which one does are not
thereby solvable: the share of lost levels is an estimate, not a bound.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np

from irsim_gym.evaluation import conditions, machine, make_episodes
from irsim_gym.tasks import Episodes, Outcome

STEPS, FEW, MANY, ROUNDS = 8, 16, 2048, 8
PARENTS = 64
ALTERED = 0.3
"""Share of the commands of a sequence that are altered."""
SEED = 0


def survived(episodes: Episodes, level: int, split: str, commands: np.ndarray) -> np.ndarray:
    """Return for how many steps each of several sequences of commands, ``(n, steps, 2)``, keeps free of contact.

    An arrival counts as if it lasted for all steps.
    """
    worlds = np.arange(len(commands))
    lasted = np.full(len(commands), commands.shape[1])
    episodes.begin(worlds, np.full(len(commands), level), split)
    for step in range(commands.shape[1]):
        if not worlds.size:
            break
        actions = np.zeros((episodes.n_worlds, 1, commands.shape[2]))
        actions[worlds, 0] = commands[worlds, step]
        episodes.step(actions, worlds)
        outcomes = episodes.view.infos["outcome"][worlds, 0]
        lasted[worlds[(outcomes != Outcome.RUNNING) & (outcomes != Outcome.SUCCESS)]] = step
        worlds = worlds[outcomes == Outcome.RUNNING]
    return lasted


def can_survive(episodes: Episodes, level: int, split: str) -> bool:
    """Return whether a sequence of commands is found that keeps free of contact."""
    if survived(episodes, level, split, sequences(FEW)).max() == STEPS:
        return True
    random = np.random.default_rng(SEED)
    commands = sequences(MANY)
    for _ in range(ROUNDS):
        lasted = survived(episodes, level, split, commands)
        if lasted.max() == STEPS:
            return True
        best = commands[np.argsort(-lasted, kind="stable")[:PARENTS]]
        commands = altered(best[random.integers(0, PARENTS, MANY)], random)
    return False


def sequences(count: int) -> np.ndarray:
    """Return sequences of commands over their greatest values, ``(count, STEPS, 2)``.

    Three never change. One half of the others is held, a quarter drawn evenly, a quarter drawn from extremes and zeros.
    """
    random = np.random.default_rng(SEED)
    made = random.uniform(-1.0, 1.0, size=(count, STEPS, 2))
    made[::4] = random.choice([-1.0, 0.0, 1.0], size=made[::4].shape)
    made[1::2] = random.choice([-1.0, 0.0, 1.0], size=(count // 2, 1, 2))
    made[0], made[1], made[2] = (-1.0, 0.0), (1.0, 0.0), (1.0, 1.0)
    return made


def altered(commands: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Return sequences of commands of which some are drawn anew, half of these among extremes."""
    drawn = random.uniform(-1.0, 1.0, size=commands.shape)
    is_extreme = random.random(commands.shape) < 0.5
    drawn = np.where(is_extreme, np.sign(drawn), drawn)
    return np.where(random.random(commands.shape) < ALTERED, drawn, commands)


def main(scenario: str, levels: int, split: str, out: Path | None) -> None:
    """Count the levels of a split, and write the file."""
    episodes = make_episodes(scenario, n_worlds=MANY)
    lost = [level for level in range(levels) if not can_survive(episodes, level, split)]
    record = {
        "what": "levels in which no sequence of commands is found that keeps the robot free of contact",
        "command": f"python agents/studies/lost_starts.py {scenario} --levels {levels} --split {split}",
        "conditions": conditions(episodes, split, levels),
        "machine": machine(),
        "sequences": MANY,
        "rounds": ROUNDS,
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
