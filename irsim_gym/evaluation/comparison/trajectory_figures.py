"""The figure of an evaluation: the trajectories of its policies on the world."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from irsim_gym.base.arraytypes import Ints
from irsim_gym.evaluation.measures.trajectories import KEPT_LEVELS, TrajectoryLog, Watcher
from irsim_gym.tasks import Episodes

if TYPE_CHECKING:
    from irsim_gym.rendering.figures.ways_density import Density

FILES = ("ways.png", "ways.pdf")


class TrajectoryRecorder:
    """Records the trajectories of a policy, and the obstacles of the levels. It implements `Watcher`.

    Args:
        ways: Log of the trajectories.
        density: Density map to which the obstacles of new levels are added.
        seen: Positions of the levels whose obstacles have been added; new ones are added.

    Attributes:
        ways: Log of the trajectories.
    """

    def __init__(self, ways: TrajectoryLog, density: Density, seen: set[int]) -> None:
        from irsim_gym.rendering import Renderer

        simulation = ways.episodes.simulation
        self.ways, self._density, self._seen = ways, density, seen
        self._renderer = Renderer(simulation.scenario, simulation.model, simulation.state)

    def began(self, episodes: Episodes, worlds: Ints, indices: Ints) -> None:
        """Record the starts of agents, and the obstacles."""
        self.ways.began(episodes, worlds, indices)
        for world, index in zip(worlds.tolist(), indices.tolist(), strict=True):
            if index < KEPT_LEVELS and index not in self._seen:
                self._seen.add(index)
                scene = self._renderer.scene(world)
                self._density.add(scene.fixed, scene.map)

    def stepped(self, episodes: Episodes, worlds: Ints) -> None:
        """Record the positions of agents."""
        self.ways.stepped(episodes, worlds)

    def ended(self, episodes: Episodes, worlds: Ints, indices: Ints) -> None:
        """Complete the trajectories of worlds that have ended."""
        self.ways.ended(episodes, worlds, indices)


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
        self._seen: set[int] = set()

    def follow(self, name: str) -> Watcher:
        """Return a watcher that records a policy. The first one also records the obstacles of the levels."""
        recorder = TrajectoryRecorder(TrajectoryLog(self._episodes), self._density, self._seen)
        self._recorders[name] = recorder
        return recorder

    def draw(self, folder: Path, title: str, successes: Mapping[str, str], levels: int) -> None:
        """Write ``ways.png`` and ``ways.pdf``.

        Args:
            successes: Text about the success of each policy.
            levels: Number of levels that were played.
        """
        from irsim_gym.rendering.figures.ways_marks import DrawnWay
        from irsim_gym.rendering.figures.ways_plot import FEW, WaysPanel, draw_ways

        panels = [
            WaysPanel(
                name,
                successes[name],
                [
                    DrawnWay(way.points, way.goal, way.outcome)
                    for way in sorted(kept.ways.ways, key=lambda way: way.level)
                ],
                Counter(way.outcome for way in kept.ways.ways),
            )
            for name, kept in self._recorders.items()
        ]
        source = f"the first {KEPT_LEVELS} of {levels:,} levels" if levels > KEPT_LEVELS else f"{levels} levels"
        note = f"Trajectories: at most {FEW} that succeeded and {FEW} that failed, from {source}. "
        note += "Marks: where episodes failed, from all levels. Grey: static obstacles"
        if self._density.differs:
            note += ", darker where more levels have one"
        note += ". `irsim-gym record` with --level N plays level N"
        draw_ways([folder / name for name in FILES], panels, self._density, title, f"{note}.")
