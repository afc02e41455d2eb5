"""Replays of an environment's episodes, as pages for a browser."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import gymnasium

from irsim_gym.envs.parts.pictures import make_renderer, world_status
from irsim_gym.simulator.engine.telemetry import telemetry
from irsim_gym.tasks import Episodes, Outcome

if TYPE_CHECKING:
    from irsim_gym.rendering import Renderer
    from irsim_gym.rendering.replay.replay_data import Recording


def agent_values(episodes: Episodes, world: int) -> list[dict[str, Any]]:
    """Return what a replay shows of each agent: outcome, action, rewards and the state of its episode."""
    simulation, view = episodes.simulation, episodes.view
    begun = bool(simulation.state.step[world])
    found = []
    for a, numbers in enumerate(telemetry(simulation, world, simulation.agents)):
        size = int(episodes.action_sizes[a])
        found.append(
            {
                **numbers,
                "outcome": Outcome(int(view.infos["outcome"][world, a])).name.lower(),
                "action": episodes.state.action[world, a, :size].tolist() if begun else None,
                "reward": float(view.reward[world, a]),
                "terms": dict(zip(episodes.reward_names, view.reward_terms[world, a].tolist(), strict=True)),
            }
        )
    return found


class RecordReplay(gymnasium.Wrapper[Any, Any, Any, Any]):
    """Writes a page that plays the episodes of an environment, when it is closed.

    Args:
        env: An environment of this package with one world, also within other wrappers; it needs no render mode.
        path: File to write, ``.html``.
        most: How many episodes are kept: the latest ones.

    Raises:
        ValueError: The environment is of another kind, or ``most`` is less than one.
    """

    def __init__(self, env: gymnasium.Env[Any, Any], path: str | Path, most: int = 20) -> None:
        super().__init__(env)
        self._worlds: Any = getattr(env.unwrapped, "worlds", None)
        if self._worlds is None:
            raise ValueError(f"RecordReplay needs an environment of irsim_gym, got {env.unwrapped!r}")
        if most < 1:
            raise ValueError(f"most must be >= 1, got most={most}")
        self._path, self._most = Path(path), most
        self._recordings: list[Recording] = []
        self._renderer: Renderer | None = None

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode, and its recording."""
        from irsim_gym.rendering.replay.replay_data import Recording

        begun = self.env.reset(seed=seed, options=options)
        worlds = self._worlds
        if self._renderer is None:
            self._renderer = make_renderer(worlds.simulation)
        self._renderer.clear(0)
        level = {"level": str(begun[1]["level"])}
        self._recordings = [*self._recordings, Recording(worlds.scenario, worlds.agent_names, level)][-self._most :]
        self._note()
        return begun

    def step(self, action: object) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Advance the environment by one step, and record it."""
        result = self.env.step(action)
        self._note()
        return result

    def _note(self) -> None:
        episodes, recording = self._worlds.episodes, self._recordings[-1]
        assert self._renderer is not None
        status = world_status(episodes, 0)
        scene = self._renderer.scene(0, status)
        recording.note(scene, episodes.simulation.state.pose[0], agent_values(episodes, 0))
        level = int(episodes.view.infos["level"][0, 0])
        recording.name = f"level {level}: {status.replace('_', ' ')}, {scene.time:.1f} s"

    def close(self) -> None:
        """Write the page, unless no episode has begun since the last one, and close the environment."""
        from irsim_gym.rendering.replay.replay_page import save_html

        if self._recordings:
            save_html(self._path, self._recordings)
            self._recordings = []
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None
        super().close()
