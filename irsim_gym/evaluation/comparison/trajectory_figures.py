"""The figure of an evaluation: the trajectories of its policies on the world, and some single levels."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from irsim_gym.base.arraytypes import Ints
from irsim_gym.evaluation.measures.trajectories import KEPT_LEVELS, AgentTrajectory, TrajectoryLog, Watcher
from irsim_gym.tasks import Episodes

if TYPE_CHECKING:
    from irsim_gym.rendering.figures.ways_density import Density
    from irsim_gym.rendering.figures.ways_levels import DrawnLevel
    from irsim_gym.rendering.figures.ways_marks import DrawnWay
    from irsim_gym.rendering.scene.scene import DrawnBody, MapView

    FixedParts = tuple[tuple[DrawnBody, ...], MapView | None]

FILES = ("ways.png", "ways.pdf")
ALIKE = 0.05
"""Starts, ends and goals count as equal in all levels if they differ by less than this share of the world's size."""


class TrajectoryRecorder:
    """Records the trajectories of a policy, and the bodies of the levels. It implements `Watcher`.

    Args:
        ways: Log of the trajectories.
        density: Density map to which the obstacles of new levels are added.
        fixed: Static bodies and map of each level whose complete trajectories are kept; new levels are added.

    Attributes:
        ways: Log of the trajectories.
        moving: Moving bodies of these levels at the end of their episodes.
    """

    def __init__(self, ways: TrajectoryLog, density: Density, fixed: dict[int, FixedParts]) -> None:
        from irsim_gym.rendering import Renderer

        simulation = ways.episodes.simulation
        self.ways, self._density, self._fixed = ways, density, fixed
        self._renderer = Renderer(simulation.scenario, simulation.model, simulation.state)
        self.moving: dict[int, tuple[DrawnBody, ...]] = {}

    def began(self, episodes: Episodes, worlds: Ints, indices: Ints) -> None:
        """Record the starts of agents, and the obstacles."""
        self.ways.began(episodes, worlds, indices)
        for world, index in zip(worlds.tolist(), indices.tolist(), strict=True):
            if index < KEPT_LEVELS and index not in self._fixed:
                scene = self._renderer.scene(world)
                self._fixed[index] = scene.fixed, scene.map
                self._density.add(scene.fixed, scene.map)

    def stepped(self, episodes: Episodes, worlds: Ints) -> None:
        """Record the positions of agents."""
        self.ways.stepped(episodes, worlds)

    def ended(self, episodes: Episodes, worlds: Ints, indices: Ints) -> None:
        """Complete the trajectories of worlds that have ended, and record their moving bodies."""
        self.ways.ended(episodes, worlds, indices)
        for world, index in zip(worlds.tolist(), indices.tolist(), strict=True):
            if index < KEPT_LEVELS:
                self.moving[index] = self._renderer.moving(world)

    def levels(self) -> list[DrawnLevel]:
        """Return the levels whose complete trajectories are kept."""
        from irsim_gym.rendering.figures.ways_levels import DrawnLevel

        simulation, of_level = self.ways.episodes.simulation, defaultdict[int, list[AgentTrajectory]](list)
        for way in self.ways.ways:
            of_level[way.level].append(way)
        step_time, agents = float(simulation.model.step_time[0]), simulation.agents.tolist()
        return [
            DrawnLevel(
                number=level,
                time=step_time * (max(len(way.points) for way in of_level[level]) - 1),
                ways=_drawn(of_level[level]),
                fixed=fixed,
                moving=self.moving[level],
                agents=agents,
                map=occupied,
            )
            for level, (fixed, occupied) in self._fixed.items()
        ]


class TrajectoryFigure:
    """Records the trajectories of several policies on the same levels, and draws them.

    Args:
        episodes: The worlds in which the policies play.
    """

    def __init__(self, episodes: Episodes) -> None:
        from irsim_gym.rendering.figures.ways_density import Density

        self._episodes = episodes
        self._recorders: dict[str, TrajectoryRecorder] = {}
        self._density = Density(episodes.simulation.model.bounds)
        self._fixed: dict[int, FixedParts] = {}

    def follow(self, name: str) -> Watcher:
        """Return a watcher that records a policy. The first one also records the obstacles of the levels."""
        recorder = TrajectoryRecorder(TrajectoryLog(self._episodes), self._density, self._fixed)
        self._recorders[name] = recorder
        return recorder

    def draw(self, folder: Path, title: str, successes: Mapping[str, str], levels: int) -> None:
        """Write ``ways.png`` and ``ways.pdf``.

        Args:
            successes: Text about the success of each policy.
            levels: Number of levels that were played.
        """
        from irsim_gym.rendering.figures.ways_levels import worth_showing
        from irsim_gym.rendering.figures.ways_plot import FEW, SHOWN_LEVELS, WaysPanel, draw_ways

        panels = [
            WaysPanel(
                name,
                successes[name],
                _drawn(sorted(kept.ways.ways, key=lambda way: way.level)),
                Counter(way.outcome for way in kept.ways.ways),
                worth_showing(kept.levels(), SHOWN_LEVELS) if self._differs(kept) else (),
            )
            for name, kept in self._recorders.items()
        ]
        source = f"the first {KEPT_LEVELS} of {levels:,} levels" if levels > KEPT_LEVELS else f"{levels} levels"
        note = f"Trajectories: at most {FEW} that succeeded and {FEW} that failed, from {source}. "
        note += "Marks: where episodes failed, from all levels. Grey: static obstacles"
        if any(panel.levels for panel in panels):
            note += ", darker where more levels have one. Small pictures: single levels at their end, failed ones "
            note += "first, with moving bodies in light grey. `irsim-gym record` with --level N plays level N"
        draw_ways([folder / name for name in FILES], panels, self._density, title, f"{note}.")

    def _differs(self, kept: TrajectoryRecorder) -> bool:
        """Return whether obstacles, starts, goals or the ends of a policy's trajectories differ between levels."""
        x_min, y_min, x_max, y_max = self._density.bounds
        levels = kept.levels()
        places = np.array([[(way.points[0], way.points[-1], way.goal) for way in level.ways] for level in levels])
        far = float(np.nan_to_num(np.ptp(places, axis=0)).max(initial=0.0))
        return self._density.differs or far > ALIKE * max(x_max - x_min, y_max - y_min)


def _drawn(ways: Sequence[AgentTrajectory]) -> list[DrawnWay]:
    from irsim_gym.rendering.figures.ways_marks import DrawnWay

    return [DrawnWay(way.points, way.goal, way.outcome) for way in ways]
