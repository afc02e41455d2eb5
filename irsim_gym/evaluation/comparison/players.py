"""Policies that play levels for films and pictures: each in its own world, one episode at a time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from irsim_gym.envs.parts.pictures import make_renderer, world_status
from irsim_gym.evaluation.policies.perception import Perceived
from irsim_gym.evaluation.policies.policy import Policy, by_agent
from irsim_gym.evaluation.requests.fitting import check_policies, report_perceptions
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.evaluation.saved_policies.policies import load_policies, policy_names
from irsim_gym.simulator.engine import Simulation
from irsim_gym.tasks import Episodes, Outcome

if TYPE_CHECKING:
    from irsim_gym.rendering import Renderer


@dataclass(frozen=True)
class Players:
    """Policies, the worlds that they play in, and their renderer.

    Attributes:
        episodes: Episodes of each policy. They share a simulation, in which policy ``i`` plays in world ``i``.
        policies: The policies.
        names: Names of the policies.
        renderer: Renderer of the worlds.
        split: Split of the levels.
    """

    episodes: Sequence[Episodes]
    policies: Sequence[Policy]
    names: Sequence[str]
    renderer: Renderer
    split: str

    @property
    def simulation(self) -> Simulation:
        """The simulation of all worlds."""
        return self.episodes[0].simulation

    @property
    def step_time(self) -> float:
        """Duration of a step [s]."""
        return float(self.simulation.model.step_time[0])

    @property
    def steps_per_frame(self) -> int:
        """Number of steps between two frames of a film, which follows from ``sample_time``."""
        return self.simulation.scenario.world.steps_per_sample

    def is_frame(self, world: int) -> bool:
        """Return whether a film shows the current state: at each sample, and at the end of the episode."""
        is_sample = int(self.simulation.state.step[world]) % self.steps_per_frame == 0
        return is_sample or not self._is_running(world)

    def _is_running(self, world: int) -> bool:
        return bool((self.episodes[world].view.infos["outcome"][world] == Outcome.RUNNING).any())

    def play(self, world: int, level: int) -> Iterator[str]:
        """Play a level in one world, and yield the status of the episode at the start and after each step.

        Trails on frames contain all steps, including those without a frame.
        """
        episodes, policy = self.episodes[world], self.policies[world]
        worlds, first = np.array([world]), np.array([level])
        episodes.begin(worlds, first, self.split)
        policy.begin(episodes, worlds, first)
        self.renderer.clear(world)
        yield world_status(episodes, world)
        state, trails = episodes.simulation.state, self.renderer.trails
        while self._is_running(world):
            trails.record(worlds, state.step[worlds], state.pose[worlds])
            chosen = by_agent(policy.act(episodes, worlds), episodes, worlds)
            actions = np.zeros((episodes.n_worlds, *chosen.shape[1:]), chosen.dtype)
            actions[world] = chosen[0]
            episodes.step(actions, worlds)
            yield world_status(episodes, world)

    def title(self, world: int, level: int, status: str) -> str:
        """Return the title of an episode that has just ended."""
        time = float(self.simulation.state.time[world])
        return f"{self.names[world]}, level {level}: {status.replace('_', ' ')}, {time:.1f} s"


def load_players(
    request: ScenarioRequest, sources: Sequence[str | Path], *, split: str = "test", names: Sequence[str] | None = None
) -> Players:
    """Load policies, and make a world for each.

    Args:
        sources: Policies, as ``load_policy`` takes them.
        names: Names of the policies; None to derive them from the sources.

    Raises:
        UnfitPolicyError: If some policies cannot drive the agents.
    """
    loaded = load_policies(sources)
    worlds = Perceived(request.episodes(len(loaded)))
    called = policy_names(sources) if names is None else names
    chosen = dict(zip(called, loaded, strict=True))
    check_policies(chosen, worlds)
    report_perceptions(chosen, worlds)
    renderer = make_renderer(worlds.episodes.simulation)
    return Players([worlds.of(policy) for policy in loaded], loaded, called, renderer, split)
