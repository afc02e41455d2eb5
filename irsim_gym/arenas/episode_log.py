"""Records episodes that are played in many worlds at once."""

from __future__ import annotations

from typing import TYPE_CHECKING

from irsim_gym.arraytypes import Ints
from irsim_gym.envs.pictures import make_renderer, world_status
from irsim_gym.envs.replays import agent_values
from irsim_gym.tasks import Episodes

if TYPE_CHECKING:
    from irsim_gym.render.replay_data import Recording


class EpisodeLog:
    """Records all episodes that are played: a `Watcher`.

    Attributes:
        policy: Name of the policy that plays.
    """

    def __init__(self, episodes: Episodes, split: str) -> None:
        self._renderer = make_renderer(episodes.simulation)
        self._split, self.policy = split, ""
        self._recordings: dict[int, Recording] = {}

    def began(self, episodes: Episodes, worlds: Ints, indices: Ints) -> None:
        """Begin recordings."""
        from irsim_gym.render.replay_data import Recording

        levels = episodes.view.infos["level"][worlds, 0].tolist()
        for world, level in zip(worlds.tolist(), levels, strict=True):
            self._renderer.clear(world)
            details = {"policy": self.policy, "level": f"{level} ({self._split})"}
            self._recordings[world] = Recording(episodes.simulation.scenario, episodes.agent_names, details)
        self.stepped(episodes, worlds)

    def stepped(self, episodes: Episodes, worlds: Ints) -> None:
        """Record the present moment."""
        state = episodes.simulation.state
        for world in worlds.tolist():
            scene = self._renderer.scene(world, world_status(episodes, world))
            self._recordings[world].note(scene, state.pose[world], agent_values(episodes, world))
        self._renderer.trails.record(worlds, state.step[worlds], state.pose[worlds])

    def ended(self, episodes: Episodes, worlds: Ints, indices: Ints) -> None:
        """Name the recordings."""
        levels = episodes.view.infos["level"][worlds, 0].tolist()
        for world, level in zip(worlds.tolist(), levels, strict=True):
            status, time = world_status(episodes, world), float(episodes.simulation.state.time[world])
            self._recordings[world].name = f"{self.policy}, level {level}: {status.replace('_', ' ')}, {time:.1f} s"

    def take(self, world: int) -> Recording:
        """Return the recording of an episode that has ended, and remove it from the log."""
        return self._recordings.pop(world)

    def close(self) -> None:
        """Close the renderer."""
        self._renderer.close()
