"""Count levels that no robot could have won, however it drives, while the other bodies move as they did.

    python agents/studies/covered_goals.py drl_robot_navigation RUN...

Drives the first ``test`` levels with each policy. In levels that none of them wins, it follows all places where a disc
of the robot's size touches no other body, from step to step, at the robot's greatest speed in any direction. A level
counts as lost if that does not lead to the goal, whichever policy drove. Cells of 2.5 cm are taken so that no place and
no way is missed. Other bodies react to the robot, and another policy might move them out of the way: this is a count,
not a bound. Scenarios with one disc as a robot, and without an obstacle map.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray
from rich.progress import track
from shapely.geometry.base import BaseGeometry

from irsim_gym import Simulation
from irsim_gym.evaluation import Perceived, as_policy, by_agent, conditions, machine, make_episodes, top_speed
from irsim_gym.plugins import row_of
from irsim_gym.tasks import Episodes, Outcome

Flags, Floats, Ints = NDArray[np.bool_], NDArray[np.float64], NDArray[np.int64]

CELL = 0.025
SLACK = CELL / 2.0**0.5
"""Distance of a place from the centre of its cell [m], at most."""


def main(scenario: str, runs: Sequence[str], levels: int, split: str, out: Path | None) -> None:
    """Count the levels, and write the file."""
    left = np.arange(levels)
    for run in runs:
        left = left[play(scenario, run, left, split).state.outcome[:, 0] != Outcome.SUCCESS]
    lost = left
    for run in runs:
        lost = lost[[not is_won for is_won in winnable(scenario, run, lost, split)]]
    record = {
        "what": "levels that no policy wins, and those of them that no robot could have won while bodies moved so",
        "command": f"python agents/studies/covered_goals.py {scenario} RUNS --levels {levels} --split {split}",
        "conditions": conditions(make_episodes(scenario), split, levels),
        "machine": machine(),
        "policies": len(runs),
        "unsolved": left.tolist(),
        "lost": lost.tolist(),
        "share": len(lost) / levels,
    }
    if out is not None:
        out.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    print(f"{scenario}: of {levels:,} {split} levels, {len(left)} are won by no policy, and {len(lost)} could not be")


def play(
    scenario: str, source: str, levels: Ints, split: str, begun_or_stepped: Callable[[Episodes], None] = lambda _: None
) -> Episodes:
    """Drive each level once, all at a time, and return the episodes, all of which have ended."""
    policy = as_policy(source)
    episodes = Perceived(make_episodes(scenario, n_worlds=len(levels))).of(policy)
    worlds = np.arange(len(levels))
    episodes.begin(worlds, levels, split)
    policy.begin(episodes, worlds, levels)
    begun_or_stepped(episodes)
    while episodes.view.live.any():
        episodes.step(by_agent(policy.act(episodes, worlds), episodes, worlds))
        begun_or_stepped(episodes)
    return episodes


@dataclass
class Motion:
    """How all bodies moved.

    Attributes:
        segments: Their outlines in each step [m], each of shape ``(n_worlds, n_segments, 4)``.
        discs: Likewise, x, y and radius [m], each of shape ``(n_worlds, n_discs, 3)``.
        start: First place of the robot [m], shape ``(n_worlds, 2)``.
    """

    segments: list[Floats] = field(default_factory=list)
    discs: list[Floats] = field(default_factory=list)
    start: Floats = field(default_factory=lambda: np.empty((0, 2)))

    def note(self, episodes: Episodes) -> None:
        """Note where bodies are."""
        state = episodes.simulation.state
        if not self.discs:
            self.start = state.pose[:, episodes.task.agents[0], :2].copy()
        self.segments.append(state.segments.copy())
        self.discs.append(state.discs.copy())


def winnable(scenario: str, source: str, levels: Ints, split: str) -> list[bool]:
    """Return whether a robot could have won each level while bodies moved as they do when the policy drives."""
    if not levels.size:
        return []
    motion = Motion()
    episodes = play(scenario, source, levels, split, motion.note)
    worlds = range(len(levels))
    return [leads_to_goal(episodes, motion, w) for w in track(worlds, f"{source}: following all places")]


def leads_to_goal(episodes: Episodes, motion: Motion, w: int) -> bool:
    """Return whether places free of contact lead from step to step to the goal.

    After a collision, bodies might have moved otherwise than noted: what is still open then counts as won.
    """
    simulation, (robot,) = episodes.simulation, episodes.task.agents
    model = simulation.model
    tolerance = float(model.goal_threshold[row_of(model.goal_threshold, w), robot])
    free = FreePlaces(simulation, robot, w)
    step = top_speed(episodes, w, 0) * float(model.step_time[0]) + 2.0 * SLACK
    goal = free.near(simulation.state.goal[w, robot, :2], tolerance + SLACK)
    places = free.near(motion.start[w], SLACK)
    for number in range(1, int(episodes.state.steps[w, 0]) + 1):
        places = spread(places, step / CELL) & free.at(motion.segments[number][w], motion.discs[number][w])
        if (places & goal).any():
            return True
        if not places.any():
            return False
    return bool(episodes.state.outcome[w, 0] != Outcome.TIMEOUT)


class FreePlaces:
    """The cells of a world in whose centre, nearly, the robot's disc touches no other body.

    Args:
        simulation: The simulation.
        robot: The robot.
        w: The world.
    """

    def __init__(self, simulation: Simulation, robot: int, w: int) -> None:
        """Lay out the cells."""
        self.model, self.robot, self.w = simulation.model, robot, w
        x_min, y_min, x_max, y_max = self.model.bounds
        sides = (np.arange(low + CELL / 2.0, high, CELL) for low, high in ((x_min, x_max), (y_min, y_max)))
        self.x, self.y = np.meshgrid(*sides, indexing="ij")
        self.margin = float(self.model.radius[row_of(self.model.radius, w), robot]) - SLACK
        self.covered: dict[int, tuple[bytes, Flags]] = {}

    def near(self, point: Floats, distance: float) -> Flags:
        """Return which centres are within a distance [m] of a point."""
        found: Flags = np.hypot(self.x - point[0], self.y - point[1]) <= distance
        return found

    def at(self, segments: Floats, discs: Floats) -> Flags:
        """Return which cells are free while bodies have these outlines."""
        free = np.ones(self.x.shape, np.bool_)
        for body in range(len(self.model.role)):
            if body != self.robot and not self.model.unobstructed[body]:
                free &= ~self._covered(body, segments, discs)
        return free

    def _covered(self, body: int, segments: Floats, discs: Floats) -> Flags:
        """Return which cells a body covers; one that stands still is asked once."""
        lines = rows_of(segments, self.model.segment_start, self.model.segment_count, body, self.w)
        rounds = rows_of(discs, self.model.disc_start, self.model.disc_count, body, self.w)
        outline = lines.tobytes() + rounds.tobytes()
        known = self.covered.get(body)
        if known is None or known[0] != outline:
            area = outline_of(lines, rounds, is_area=bool(self.model.solid[body])).buffer(self.margin)
            shapely.prepare(area)
            known = self.covered[body] = outline, shapely.contains_xy(area, self.x, self.y)
        return known[1]


def rows_of(outlines: Floats, start: Ints, count: Ints, body: int, w: int) -> Floats:
    """Return the rows of a body among the outlines of a world."""
    first = int(start[body])
    return outlines[first : first + int(count[row_of(count, w), body])]


def outline_of(lines: Floats, rounds: Floats, *, is_area: bool) -> BaseGeometry:
    """Return the shape of a body."""
    parts: list[BaseGeometry] = [shapely.Point(x, y).buffer(radius) for x, y, radius in rounds.tolist()]
    if len(lines):
        parts += [shapely.Polygon(lines[:, :2]) if is_area else shapely.MultiLineString(list(lines.reshape(-1, 2, 2)))]
    return shapely.union_all(parts)


def spread(places: Flags, cells: float) -> Flags:
    """Return all cells within some cells' sides of given ones, centre to centre."""
    wide = int(cells)
    padded = np.pad(places, wide)
    found = np.zeros_like(places)
    for i in range(-wide, wide + 1):
        for j in range(-wide, wide + 1):
            if i * i + j * j <= cells * cells:
                columns, rows = (
                    slice(wide + shift, wide + shift + n) for shift, n in zip((i, j), places.shape, strict=True)
                )
                found |= padded[columns, rows]
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario")
    parser.add_argument("runs", nargs="+")
    parser.add_argument("--levels", type=int, default=1000)
    parser.add_argument("--split", default="test")
    parser.add_argument("--out", type=Path, default=None)
    given = parser.parse_args()
    main(given.scenario, given.runs, given.levels, given.split, given.out)
