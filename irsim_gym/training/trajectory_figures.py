"""The picture of an evaluation: the ways of its policies over the world, and single levels."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from irsim_gym.arraytypes import Ints
from irsim_gym.evaluation.trajectories import KEPT_LEVELS, AgentTrajectory, TrajectoryLog, Watcher
from irsim_gym.tasks import Episodes

if TYPE_CHECKING:
    from irsim_gym.render.scene import DrawnBody, MapView
    from irsim_gym.render.ways_density import Density
    from irsim_gym.render.ways_levels import DrawnLevel
    from irsim_gym.render.ways_marks import DrawnWay

FILES = ("ways.png", "ways.pdf")
ALIKE = 0.05
"""Starts, ends and goals count as the same in all levels where they differ by less than this share of the world."""


class Surveyor:
    """Keeps the ways of a policy, and what the levels look like: a `Watcher`.

    Args:
        ways: Who keeps the ways.
        density: Where obstacles of the levels are noted; None for nowhere.

    Attributes:
        ways: Who keeps the ways.
        fixed: What stands in each level, of which whole ways are kept, and its map.
        moving: The other bodies of these levels, where they were at the end.
    """

    def __init__(self, ways: TrajectoryLog, density: Density | None) -> None:
        from irsim_gym.render import Renderer

        simulation = ways.episodes.simulation
        self.ways, self._density = ways, density
        self._renderer = Renderer(simulation.scenario, simulation.model, simulation.state)
        self.fixed: dict[int, tuple[tuple[DrawnBody, ...], MapView | None]] = {}
        self.moving: dict[int, tuple[DrawnBody, ...]] = {}

    def began(self, episodes: Episodes, worlds: Ints, indices: Ints) -> None:
        """Note where agents start and obstacles stand."""
        self.ways.began(episodes, worlds, indices)
        for world, index in zip(worlds.tolist(), indices.tolist(), strict=True):
            if index < KEPT_LEVELS:
                scene = self._renderer.scene(world)
                self.fixed[index] = scene.fixed, scene.map
                if self._density is not None:
                    self._density.add(scene.fixed, scene.map)

    def stepped(self, episodes: Episodes, worlds: Ints) -> None:
        """Note where agents are."""
        self.ways.stepped(episodes, worlds)

    def ended(self, episodes: Episodes, worlds: Ints, indices: Ints) -> None:
        """Note the ways of worlds that have ended, and where bodies are."""
        self.ways.ended(episodes, worlds, indices)
        for world, index in zip(worlds.tolist(), indices.tolist(), strict=True):
            if index < KEPT_LEVELS:
                self.moving[index] = self._renderer.scene(world).moving

    def levels(self) -> list[DrawnLevel]:
        """Return those levels of which whole ways are kept."""
        from irsim_gym.render.ways_levels import DrawnLevel

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
            for level, (fixed, occupied) in self.fixed.items()
        ]


class Atlas:
    """Follows policies through the same levels, and draws their ways.

    Args:
        episodes: The worlds that they drive in.
    """

    def __init__(self, episodes: Episodes) -> None:
        from irsim_gym.render.ways_density import Density

        self._episodes = episodes
        self._surveyors: dict[str, Surveyor] = {}
        self._density = Density(episodes.simulation.model.bounds)

    def follow(self, name: str) -> Watcher:
        """Return a watcher for a policy; the first one also notes where obstacles stand."""
        surveyor = Surveyor(TrajectoryLog(self._episodes), None if self._surveyors else self._density)
        self._surveyors[name] = surveyor
        return surveyor

    def draw(self, folder: Path, title: str, successes: Mapping[str, str], levels: int) -> None:
        """Write the pictures.

        Args:
            folder: Where they go.
            title: Heading.
            successes: For each policy, what is said of its success.
            levels: How many levels were driven.
        """
        from irsim_gym.render.ways_levels import worth_showing
        from irsim_gym.render.ways_plot import FEW, SHOWN_LEVELS, WaysPanel, draw_ways

        panels = [
            WaysPanel(
                name,
                successes[name],
                _drawn(sorted(kept.ways.ways, key=lambda way: way.level)),
                Counter(way.outcome for way in kept.ways.ways),
                worth_showing(kept.levels(), SHOWN_LEVELS) if self._differs(kept) else (),
            )
            for name, kept in self._surveyors.items()
        ]
        source = f"the first {KEPT_LEVELS} of {levels:,} levels" if levels > KEPT_LEVELS else f"{levels} levels"
        note = (
            f"Ways: at most {FEW} that succeeded and {FEW} that failed, from {source}. Marks: where episodes failed, "
        )
        note += "from all levels. Grey: obstacles that stand still"
        if any(panel.levels for panel in panels):
            note += ", the darker in the more levels. Small pictures: single levels at their end, failed ones first; "
            note += "light grey is what else moves. `irsim-gym record` with --level N plays level N"
        draw_ways([folder / name for name in FILES], panels, self._density, title, f"{note}.")

    def _differs(self, kept: Surveyor) -> bool:
        """Return whether obstacles, starts, goals or the ends of a policy's ways are elsewhere in other levels."""
        x_min, y_min, x_max, y_max = self._density.bounds
        levels = kept.levels()
        places = np.array([[(way.points[0], way.points[-1], way.goal) for way in level.ways] for level in levels])
        far = float(np.nan_to_num(np.ptp(places, axis=0)).max(initial=0.0))
        return self._density.differs or far > ALIKE * max(x_max - x_min, y_max - y_min)


def _drawn(ways: Sequence[AgentTrajectory]) -> list[DrawnWay]:
    from irsim_gym.render.ways_marks import DrawnWay

    return [DrawnWay(way.points, way.goal, way.outcome) for way in ways]
