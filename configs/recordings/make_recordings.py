"""Draw the shipped recordings: people who cross a square, walked by social forces, in the text form of ETH and UCY.

Run it from the root of the repository: ``python configs/recordings/make_recordings.py``.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import irsim_gym

N_PEOPLE, ROW_TIME, LATER = 14, 0.4, 1.6
"""How many there are, the time from row to row [s], and from one who comes to the next [s]."""


def main() -> None:
    """Write ``square.txt``: rows of time [s], id, x [m], y [m]."""
    rng = np.random.default_rng(7)
    sides = rng.integers(0, 4, N_PEOPLE)
    starts, goals = (_places(side % 4, rng) for side in (sides, sides + 2))
    rows = []
    for person in range(N_PEOPLE):
        # Those who come at about the same time walk together in one world.
        others = [other for other in range(N_PEOPLE) if abs(other - person) <= 3]
        way = _walk(starts[others], goals[others], others.index(person))
        began = round(person * LATER / ROW_TIME) * ROW_TIME
        rows += [(round(began + k * ROW_TIME, 1), person + 1, *point) for k, point in enumerate(way)]
    lines = [f"{time:.1f}\t{person}\t{x:.2f}\t{y:.2f}" for time, person, x, y in sorted(rows)]
    head = "# time [s], id, x [m], y [m]: people who cross a square of 12 m, drawn by make_recordings.py"
    (Path(__file__).parent / "square.txt").write_text("\n".join([head, *lines]) + "\n", encoding="utf-8")


def _places(sides: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return a place on a side of the square for each person [m]."""
    along = rng.uniform(2.5, 9.5, len(sides))
    ends = np.where(sides % 4 < 2, 0.3, 11.7)
    return np.where((sides % 2 == 0)[:, None], np.stack([ends, along], 1), np.stack([along, ends], 1))


def _walk(starts: np.ndarray, goals: np.ndarray, chosen: int) -> list[tuple[float, float]]:
    """Return the way of one of some people who begin at once, a point every ``ROW_TIME`` [m]."""
    people = [
        {
            "kinematics": {"name": "omni"},
            "state": [*start, 0.0],
            "goal": goal.tolist(),
            "vel_min": [-1.3, -1.3],
            "vel_max": [1.3, 1.3],
            "behavior": {"name": "sfm", "vmax": 1.2},
        }
        for start, goal in zip(starts.tolist(), goals, strict=True)
    ]
    world = {"width": 12, "height": 12, "step_time": 0.1, "collision_mode": "unobstructed"}
    simulation = irsim_gym.compile(irsim_gym.load_scenario({"world": world, "robot": people}))
    simulation.reset(seed=0)
    way = []
    for step in range(300):
        if step % round(ROW_TIME / 0.1) == 0:
            way.append(tuple(simulation.state.pose[0, chosen, :2].tolist()))
        if np.hypot(*(simulation.state.pose[0, chosen, :2] - goals[chosen])) < 0.3:
            break
        simulation.step()
    return way


if __name__ == "__main__":
    main()
