"""Policies that play levels to be watched: each in a world of its own, one episode at a time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from irsim_gym.engine import Simulation
from irsim_gym.envs.pictures import world_status
from irsim_gym.envs.replays import agent_values
from irsim_gym.evaluation.perception import Perceived
from irsim_gym.evaluation.policy import Policy, by_agent
from irsim_gym.tasks import Episodes, Outcome
from irsim_gym.training.episode_setup import make_episodes
from irsim_gym.training.fitting import check_policies, report_perceptions
from irsim_gym.training.policies import load_policies, policy_names

if TYPE_CHECKING:
    from irsim_gym.render import Renderer


@dataclass(frozen=True)
class Players:
    """Policies, the worlds that they play in, and who draws these.

    Attributes:
        episodes: Those of each policy, of which it plays in its own world alone; all share one simulation.
        policies: Who drives in them.
        names: What the policies are called.
        renderer: Who draws the worlds.
        split: Where the levels are from.
    """

    episodes: Sequence[Episodes]
    policies: Sequence[Policy]
    names: Sequence[str]
    renderer: Renderer
    split: str

    @property
    def simulation(self) -> Simulation:
        """The worlds."""
        return self.episodes[0].simulation

    @property
    def step_time(self) -> float:
        """Duration of a step [s]."""
        return float(self.simulation.model.step_time[0])

    @property
    def steps_per_frame(self) -> int:
        """Steps from one frame of a film to the next: ``sample_time``."""
        return self.simulation.scenario.world.steps_per_sample

    def is_frame(self, world: int) -> bool:
        """Return whether a film shows the present moment: a sample, or the end of the episode."""
        is_sample = int(self.simulation.state.step[world]) % self.steps_per_frame == 0
        return is_sample or not self._is_running(world)

    def _is_running(self, world: int) -> bool:
        return bool((self.episodes[world].view.infos["outcome"][world] == Outcome.RUNNING).any())

    def play(self, world: int, level: int) -> Iterator[str]:
        """Drive one world through a level; yield how it stands at each moment, that of the start first.

        Paths on frames go through all moments, also through those of which no frame is drawn.
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
        """Return what an episode is called that has just ended."""
        time = float(self.simulation.state.time[world])
        return f"{self.names[world]}, level {level}: {status.replace('_', ' ')}, {time:.1f} s"

    def values(self, world: int) -> list[dict[str, Any]]:
        """Return the present data of each agent: outcome, action, rewards and the state of its episode."""
        return agent_values(self.episodes[world], world)


def players(
    scenario: str,
    sources: Sequence[str | Path],
    *,
    split: str = "test",
    task: str | None = None,
    names: Sequence[str] | None = None,
    parameters: Mapping[str, object] | None = None,
    team: bool = False,
    strict: bool = True,
) -> Players:
    """Load policies, and make a world for each.

    Args:
        scenario: Shipped name, environment id, or path of a scenario file.
        sources: Policies as ``load_policy`` takes them.
        split: ``"test"``, ``"dev"`` or ``"train"``.
        task: Shipped name or path of a task; None for the scenario's own.
        names: What the policies are called; None to take it from the sources.
        parameters: Values for the scenario's parameters.
        team: The policies drive all robots, unless the task names some.
        strict: False ignores unused keys.
    """
    from irsim_gym.render import Renderer

    loaded = load_policies(sources)
    made: dict[str, Any] = {"task": task, "parameters": parameters, "team": team, "strict": strict}
    worlds = Perceived(make_episodes(scenario, n_worlds=len(loaded), **made))
    called = policy_names(sources) if names is None else names
    chosen = dict(zip(called, loaded, strict=True))
    check_policies(chosen, worlds)
    report_perceptions(chosen, worlds)
    simulation = worlds.episodes.simulation
    parts = simulation.model, simulation.state, simulation.sensors
    learners = simulation.agents.tolist()
    renderer = Renderer(simulation.scenario, *parts, learners=learners, explored=simulation.explored)
    return Players([worlds.of(policy) for policy in loaded], loaded, called, renderer, split)
