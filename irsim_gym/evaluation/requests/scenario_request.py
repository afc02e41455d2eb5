"""A scenario with its task, as commands and functions that play it are asked for it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.envs.gymnasium.worlds import ScenarioSource, TaskSource
from irsim_gym.evaluation.requests.episode_setup import make_episodes
from irsim_gym.scenario import Scenario, load_scenario
from irsim_gym.simulator.engine import Simulation, compile
from irsim_gym.tasks import Episodes


@dataclass(frozen=True)
class ScenarioRequest:
    """A scenario with its task.

    Attributes:
        scenario: Shipped name, environment id, path of a file, plain data or a loaded scenario.
        task: Shipped name, path or plain data of a task; None for the scenario's own.
        team: Whether all robots are agents; if the task names robots, only these.
        parameters: Values for the scenario's parameters.
        strict: Whether unused keys are an error; False ignores them.
    """

    scenario: ScenarioSource
    task: TaskSource = None
    team: bool = False
    parameters: Mapping[str, object] | None = None
    strict: bool = True

    def load(self, *, warn: bool = True) -> Scenario:
        """Return the scenario that is named; ``warn`` says whether ignored keys are reported."""
        assert isinstance(self.scenario, str), "the command line names it"
        return load_scenario(self.scenario, self.parameters, strict=self.strict, warn=warn)

    def simulation(self, n_worlds: int) -> Simulation:
        """Return worlds with the agents of the task; without agents if there is no task and no robot can learn.

        The agents affect the levels: each of them gets a path to its goal.
        """
        loaded = self.load()
        chosen: dict[str, Any] = {"task": self.task, "team": self.team, "strict": self.strict}
        try:
            return make_episodes(loaded, n_worlds=n_worlds, **chosen).simulation
        except IrsimGymError:
            if loaded.task or self.task is not None or self.team:
                raise
            return compile(loaded, n_worlds)

    def episodes(self, n_worlds: int) -> Episodes:
        """Return worlds with the task."""
        return make_episodes(n_worlds=n_worlds, **vars(self))
