"""Behavioural cloning (Pomerleau 1991): before the training, the actor imitates a policy, such as a planner."""

import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import torch
from gymnasium.spaces import Box, Dict
from numpy.typing import NDArray
from rich.console import Console
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.distributions import DiagGaussianDistribution
from stable_baselines3.common.policies import ActorCriticPolicy

from irsim_gym.base.arraytypes import Ints
from irsim_gym.base.errors import IrsimGymError
from irsim_gym.envs.parts.spaces import observation_layout
from irsim_gym.evaluation.comparison.evaluate import WORLDS
from irsim_gym.evaluation.policies.policy import Policy, by_agent, percepts
from irsim_gym.evaluation.protocol.progress_bars import progress_bar
from irsim_gym.evaluation.protocol.protocol import drive
from irsim_gym.evaluation.saved_policies.policies import load_policy, memory_shape
from irsim_gym.tasks import Episodes, Outcome
from irsim_gym.training.settings.run import Settings

BATCH = 1024
"""Rows of a minibatch."""
LEARNING_RATE = 2e-3
"""Learning rate of Adam at the start. It decreases linearly to 0."""


@dataclass
class RecordingPolicy:
    """A policy that records the observations and actions of its agents until their episodes end.

    Attributes:
        policy: The policy that acts.
        observations: For each step, an array ``(n, ...)`` with a row per running agent.
        actions: For each step, the actions of these agents, ``(n, ...)``.
        episodes: For each step, the level and the agent of each row, ``(n, 2)``.
    """

    policy: Policy
    observations: list[NDArray[Any]] = field(default_factory=list)
    actions: list[NDArray[Any]] = field(default_factory=list)
    episodes: list[Ints] = field(default_factory=list)
    _level: dict[int, int] = field(default_factory=dict)

    def begin(self, episodes: Episodes, worlds: Ints, levels: Ints) -> None:
        """Store the levels that begin in worlds, and inform the policy."""
        self._level.update(zip(worlds.tolist(), levels.tolist(), strict=True))
        self.policy.begin(episodes, worlds, levels)

    def act(self, episodes: Episodes, worlds: Ints) -> NDArray[Any]:
        """Return the actions of the policy, and record those of the agents whose episodes have not ended."""
        actions = self.policy.act(episodes, worlds)
        runs = (episodes.view.infos["outcome"][worlds] == Outcome.RUNNING).ravel()
        observations = observation_layout(episodes).formed(percepts(episodes, worlds))
        by_row = by_agent(actions, episodes, worlds)
        rows = [(self._level[w], a) for w in worlds.tolist() for a in range(episodes.n_agents)]
        self.observations.append(np.array(observations)[runs])
        self.actions.append(by_row.reshape(-1, *by_row.shape[2:])[runs])
        self.episodes.append(np.array(rows, np.int64)[runs])
        return actions


def clone_behavior(model: BaseAlgorithm, settings: Settings, console: Console) -> tuple[float, float]:
    """Train the actor of a new model to imitate the policy that the hyper-parameters name.

    The policy plays levels of ``train``, beginning with the run's first one. The actor learns from the successful
    episodes. A continuous actor learns the mean of its actions and keeps ``log_std_init``; a discrete one learns the
    probabilities. Networks of the critic do not change, but a features extractor that it shares with the actor does, as
    that of ``CnnPolicy``.

    Args:
        model: A model of an on-policy algorithm without memory.
        settings: Settings of the run, with ``clone``.

    Returns:
        The elapsed wall-clock time and processor time [s].

    Raises:
        IrsimGymError: If the model does not support cloning, or the policy cannot drive these robots or never succeeds.
    """
    begun = time.perf_counter(), time.process_time()
    _check_model(model, settings)
    assert settings.hyperparameters.clone is not None
    played = [demonstrations(part, settings.hyperparameters.clone, console) for part in settings.parts()]
    observations, actions = (np.concatenate(rows) for rows in zip(*played, strict=True))
    imitate(model, observations, actions, settings.hyperparameters.clone_epochs, console)
    return time.perf_counter() - begun[0], time.process_time() - begun[1]


def _check_model(model: BaseAlgorithm, settings: Settings) -> None:
    """Raise if a model does not support cloning."""
    policy, problems = model.policy, []
    if not isinstance(policy, ActorCriticPolicy) or memory_shape(model) is not None:
        problems.append(f"{settings.algorithm} has no actor that can: use ppo or a2c")
    if isinstance(model.observation_space, Dict):
        problems.append("the task's observation is a dict: use observation_form: flat")
    if settings.hyperparameters.normalize is not None:
        problems.append("statistics of normalize would change under what was learnt: leave it out")
    if problems:
        raise IrsimGymError(f"clone: {'; '.join(problems)}")


def demonstrations(settings: Settings, source: str, console: Console) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return the observations and actions of a policy in its successful episodes, ``(n, ...)`` each.

    Args:
        source: The policy, as ``load_policy`` takes it.

    Raises:
        IrsimGymError: If the policy never succeeds.
    """
    count = settings.hyperparameters.clone_levels
    episodes = settings.request().episodes(min(WORLDS, count))
    recorded, won = RecordingPolicy(load_policy(source)), set[tuple[int, int]]()
    levels = range(settings.first_level, settings.first_level + count)
    with progress_bar(console) as bar:
        line = bar.add_task(f"{source} plays", total=count)
        for _, worlds, played in drive(recorded, episodes, levels, "train"):
            outcomes = episodes.view.infos["outcome"][worlds] == Outcome.SUCCESS
            won |= {(played[k], int(agent)) for k, agent in zip(*np.nonzero(outcomes), strict=True)}
            bar.advance(line, len(worlds))
    good = np.array([(level, agent) in won for level, agent in np.concatenate(recorded.episodes).tolist()], np.bool_)
    if not good.any():
        raise IrsimGymError(f"clone: {source} wins none of {count:,} levels, so there is nothing to imitate")
    return np.concatenate(recorded.observations)[good], np.concatenate(recorded.actions)[good]


def imitate(
    model: BaseAlgorithm, observations: NDArray[Any], actions: NDArray[Any], epochs: int, console: Console
) -> None:
    """Fit an actor to observations and actions, ``(n, ...)`` each."""
    policy = model.policy
    assert isinstance(policy, ActorCriticPolicy)
    targets: NDArray[Any] = np.clip(actions, -1.0, 1.0) if isinstance(model.action_space, Box) else actions
    target = torch.as_tensor(targets, device=policy.device)
    optimizer = torch.optim.Adam(policy.parameters(), lr=LEARNING_RATE)
    batches = -(-len(observations) // BATCH)
    schedule = torch.optim.lr_scheduler.LinearLR(optimizer, 1.0, 0.0, epochs * batches)
    policy.set_training_mode(True)
    with progress_bar(console) as bar:
        for _ in bar.track(range(epochs), description="imitating"):
            order = torch.randperm(len(observations))
            for part in (order[k : k + BATCH] for k in range(0, len(observations), BATCH)):
                rows, _ = policy.obs_to_tensor(observations[part.numpy()])
                distribution = policy.get_distribution(rows)
                loss = _loss(distribution, target[part])
                optimizer.zero_grad()
                loss.backward()  # type: ignore[no-untyped-call]
                optimizer.step()
                schedule.step()
    policy.set_training_mode(False)


def _loss(distribution: Any, target: torch.Tensor) -> torch.Tensor:
    """Return the squared error of the mean for a Gaussian, else the negative log-likelihood of the actions."""
    if isinstance(distribution, DiagGaussianDistribution):
        return torch.nn.functional.mse_loss(distribution.distribution.mean, target.float())
    probability: torch.Tensor = distribution.log_prob(target)
    return -probability.mean()
