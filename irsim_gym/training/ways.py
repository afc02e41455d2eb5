"""The picture of an evaluation: the ways of its policies over the world."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from irsim_gym.arraytypes import Ints
from irsim_gym.evaluation.ways import SHOWN, Watcher, Ways
from irsim_gym.tasks import Episodes

if TYPE_CHECKING:
    from irsim_gym.render.ways_plot import Density

FILES = ("ways.png", "ways.pdf")


class Surveyor:
    """Keeps the ways of a policy, and notes where the obstacles of the levels stand.

    Args:
        ways: Who keeps the ways.
        density: Where obstacles are noted.
    """

    def __init__(self, ways: Ways, density: Density) -> None:
        from irsim_gym.render import Renderer

        simulation = ways.episodes.simulation
        self._ways, self._density = ways, density
        self._renderer = Renderer(simulation.scenario, simulation.model, simulation.state)

    def began(self, episodes: Episodes, worlds: Ints, indices: Ints) -> None:
        """Note where agents start and obstacles stand."""
        self._ways.began(episodes, worlds, indices)
        for world in worlds[indices < SHOWN].tolist():
            scene = self._renderer.scene(world)
            self._density.add(scene.fixed, scene.map)

    def stepped(self, episodes: Episodes, worlds: Ints) -> None:
        """Note where agents are."""
        self._ways.stepped(episodes, worlds)

    def ended(self, episodes: Episodes, worlds: Ints, indices: Ints) -> None:
        """Note the ways of worlds that have ended."""
        self._ways.ended(episodes, worlds, indices)


class Atlas:
    """Follows policies through the same levels, and draws their ways.

    Args:
        episodes: The worlds that they drive in.
    """

    def __init__(self, episodes: Episodes) -> None:
        from irsim_gym.render.ways_plot import Density

        self._episodes = episodes
        self._ways: dict[str, Ways] = {}
        self._density = Density(episodes.simulation.model.bounds)

    def follow(self, name: str) -> Watcher:
        """Return a watcher for a policy; the first one also notes where obstacles stand."""
        ways = Ways(self._episodes)
        first = not self._ways
        self._ways[name] = ways
        return Surveyor(ways, self._density) if first else ways

    def draw(self, folder: Path, title: str, successes: Mapping[str, str], levels: int) -> None:
        """Write the pictures.

        Args:
            folder: Where they go.
            title: Heading.
            successes: For each policy, what is said of its success.
            levels: How many levels were driven.
        """
        from irsim_gym.render.ways_plot import DrawnWay, Panel, draw_ways

        panels = [
            Panel(
                name,
                successes[name],
                [DrawnWay(way.points, way.goal, way.outcome) for way in kept.ways],
                Counter(way.outcome for way in kept.ways),
            )
            for name, kept in self._ways.items()
        ]
        shown = f"the first {SHOWN} of {levels:,}" if levels > SHOWN else f"all {levels}"
        note = (
            f"Ways of {shown} levels; marks where episodes failed, of all levels. Grey: obstacles that stand still, "
            f"the darker in the more of these levels."
        )
        draw_ways([folder / name for name in FILES], panels, self._density, title, note)
