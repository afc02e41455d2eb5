"""Count why robots of `jaxnav_four` run out of time, on the first `dev` levels.

python agents/studies/shut_in.py POLICY [--task TASK] [--levels N]
"""

from __future__ import annotations

import argparse
from collections import Counter, deque

import numpy as np
from numpy.typing import NDArray

from irsim_gym.envs import Worlds
from irsim_gym.evaluation import as_policy
from irsim_gym.tasks import Outcome

Flags, Floats = NDArray[np.bool_], NDArray[np.float64]

LAST = 100
"""Steps at the end in which a robot that drives less than ``FAR`` [m] counts as standing."""
FAR = 1.0
Cell = tuple[int, int]


def main() -> None:
    """Drive the levels and print the counts."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("policy")
    parser.add_argument("--task", default="yielding_team_navigation")
    parser.add_argument("--levels", type=int, default=300)
    options = parser.parse_args()
    worlds = Worlds("jaxnav_four", options.levels, team=True, task=options.task)
    driven = drive(worlds, options.policy)
    outcome = worlds.episodes.state.outcome
    print(f"{(outcome == Outcome.SUCCESS).mean():.1%} of robots arrive, {count(worlds, driven)}")


def drive(worlds: Worlds, source: str) -> Floats:
    """Drive all levels once; return how far each robot drove in the last steps [m], ``(n_worlds, n_agents)``."""
    episodes, policy = worlds.episodes, as_policy(source)
    levels = np.arange(worlds.n_worlds)
    episodes.begin(levels, levels, "dev")
    policy.begin(episodes, levels, levels)
    places = [episodes.state.position.copy()]
    while episodes.view.live.any():
        episodes.step(policy.act(episodes, levels))
        places = [*places[-LAST:], episodes.state.position.copy()]
    moves = np.diff(np.stack(places), axis=0)
    driven: Floats = np.hypot(moves[..., 0], moves[..., 1]).sum(axis=0)
    return driven


def count(worlds: Worlds, driven: Floats) -> Counter[str]:
    """Return how many robots that ran out of time had which reason."""
    episodes, found = worlds.episodes, Counter[str]()
    map_of_all = episodes.simulation.model.cells
    assert map_of_all is not None
    occupied = np.asarray(map_of_all.room) <= 0.0
    goals = episodes.simulation.state.goal[:, list(episodes.task.agents)]
    for w, a in zip(*np.nonzero(episodes.state.outcome == Outcome.TIMEOUT), strict=True):
        here, there = _cell(episodes.state.position[w, a]), _cell(goals[w, a])
        others = [b for b in range(episodes.n_agents) if b != a]
        late = [b for b in others if episodes.state.outcome[w, b] == Outcome.TIMEOUT]
        is_free, is_free_of_late = (
            is_reached(_with(occupied[w], [_cell(episodes.state.position[w, b]) for b in those]), here, there)
            for those in (others, late)
        )
        if is_free:
            found["a free way, drives" if driven[w, a] >= FAR else "a free way, stands"] += 1
        else:
            found["shut in by robots that have ended" if is_free_of_late else "shut in by robots on their way"] += 1
    return found


def _cell(place: Floats) -> Cell:
    return int(place[0]), int(place[1])


def _with(occupied: Flags, cells: list[Cell]) -> Flags:
    full = occupied.copy()
    for cell in cells:
        full[cell] = True
    return full


def is_reached(occupied: Flags, start: Cell, goal: Cell) -> bool:
    """Return whether a way over edges of free cells, of 1 m each, leads from one cell to another."""
    seen, queue = {start}, deque([start])
    while queue:
        column, row = queue.popleft()
        if (column, row) == goal:
            return True
        for cell in ((column + 1, row), (column - 1, row), (column, row + 1), (column, row - 1)):
            if cell not in seen and not occupied[cell]:
                seen.add(cell)
                queue.append(cell)
    return False


if __name__ == "__main__":
    main()
