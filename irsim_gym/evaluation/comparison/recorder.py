"""Recording of demonstrations in an environment."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import gymnasium
import numpy as np
from rich.console import Console

from irsim_gym.envs.gymnasium.registration import make
from irsim_gym.envs.gymnasium.single import WorldEnv
from irsim_gym.envs.gymnasium.worlds import ScenarioSource
from irsim_gym.envs.parts.observations import concatenated
from irsim_gym.evaluation.comparison import demonstrations
from irsim_gym.evaluation.policies.perception import Perceived
from irsim_gym.evaluation.protocol.progress_bars import progress_bar

SAME = ("scenario", "parameters", "task", "robot", "observation_space", "action_space", "step_time")
"""Properties of the environment that all episodes of a file share."""
SUFFIX = ".npz"


class RecordedStep(NamedTuple):
    """A step of an episode: the action, and what ``env.step`` returned for it.

    Attributes:
        action: The action.
        observation: The observation after it.
        reward: The reward.
        terminated: Whether the task has ended.
        truncated: Whether the time limit has ended the episode.
        outcome: The outcome of the episode so far.
        by_hand: Whether a person chose the action.
    """

    action: object
    observation: demonstrations.Observations
    reward: float
    terminated: bool
    truncated: bool
    outcome: int
    by_hand: bool = False


@dataclass
class _Episode:
    """The steps of one episode, and its observations, one more than steps."""

    level: int
    seen: list[demonstrations.Observations]
    steps: list[RecordedStep] = field(default_factory=list)


class Recorder:
    """Records the steps of episodes, and writes them to a file. Appends to an existing file of the same environment.

    Args:
        path: File to write, ``.npz``.

    Raises:
        DemonstrationError: If the file has another suffix, is no file of demonstrations, or belongs to another
            environment.
    """

    def __init__(self, env: gymnasium.Env[Any, Any], path: Path) -> None:
        check_demonstrations(path)
        self.path, self.about = path, _about(env)
        self._earlier = demonstrations.load_demonstrations(path) if path.exists() else None
        if self._earlier is not None:
            self._check(self._earlier.about)
        self._episodes: list[_Episode] = []
        self._current: _Episode | None = None

    @property
    def n_episodes(self) -> int:
        """Number of episodes in the file after saving. The current episode counts once it has a step."""
        under_way = self._current is not None and len(self._current.steps) > 0
        return len(self._episodes) + under_way + (0 if self._earlier is None else self._earlier.n_episodes)

    def begin(self, observation: demonstrations.Observations, level: int) -> None:
        """Begin an episode with its first observation."""
        self._close()
        self._current = _Episode(level, [observation])

    def add(self, step: RecordedStep) -> None:
        """Add a step."""
        assert self._current is not None
        self._current.seen.append(step.observation)
        self._current.steps.append(step._replace(action=np.array(step.action)))
        if step.terminated or step.truncated:
            self._close()

    def discard(self) -> None:
        """Discard the current episode."""
        self._current = None

    def save(self) -> None:
        """Write all episodes. The current one is truncated. Without new episodes, nothing is written."""
        self._close()
        if self._episodes:
            demonstrations.save_demonstrations(self.path, self._all())

    def _close(self) -> None:
        if self._current is not None and self._current.steps:
            self._episodes.append(self._current)
        self._current = None

    def _all(self) -> demonstrations.Demonstrations:
        parts = [*([] if self._earlier is None else [self._earlier]), _demonstrations(self._episodes, self.about)]
        names = [name for name in demonstrations.Demonstrations.__dataclass_fields__ if name != "about"]
        joined = {name: concatenated([getattr(part, name) for part in parts]) for name in names}
        return demonstrations.Demonstrations(**joined, about=self.about)

    def _check(self, about: Mapping[str, object]) -> None:
        pairs = {key: (about.get(key), self.about[key]) for key in SAME}
        other = [f"{key} {then!r} (now: {now!r})" for key, (then, now) in pairs.items() if then != now]
        if other:
            raise demonstrations.DemonstrationError(
                f"{self.path} holds demonstrations of another environment: {'; '.join(other)}. Name another file."
            )


def record_demonstrations(
    scenario: ScenarioSource,
    policy: str,
    path: str | Path,
    levels: int | Sequence[int] = 20,
    *,
    split: str = "train",
    task: Any = None,
    console: Console | None = None,
    strict: bool = True,
    **parameters: Any,
) -> demonstrations.Demonstrations:
    """Play levels with a policy, and write the demonstrations to a file.

    Args:
        scenario: Shipped name, environment id, path of a scenario file, plain data or a loaded scenario.
        policy: Policy, as ``load_policy`` takes it: ``dash``, ``rvo``, ``orca``, ``random``, the name of a shipped
            policy, a run's folder or a ``policy.zip``.
        path: File to write, ``.npz``. Appends to an existing file of the same environment.
        levels: Number of levels, from 0, or a sequence of levels.
        split: ``"train"``, ``"dev"`` or ``"test"``.
        task: Shipped name or path of a task, or plain data; None for the scenario's own.
        console: Console for the progress bar, which only a terminal shows; None for standard error.
        strict: Whether unused keys are an error; False ignores them with an ``IgnoredKeyWarning``.
        **parameters: Values for the scenario's parameters.

    Returns:
        All demonstrations of the file.

    Raises:
        DemonstrationError: If the existing file cannot be appended to, or the policy was trained with other
            observations.
    """
    # This can load PyTorch, which manual play does not need.
    from irsim_gym.evaluation.saved_policies.policies import load_policy

    env = make(scenario, task=task, strict=strict, **parameters)
    world, driver = env.unwrapped, load_policy(policy)
    assert isinstance(world, WorldEnv)
    _check_demonstrator(world, driver)
    recorder = Recorder(env, Path(path))
    first = np.zeros(1, np.int64)
    chosen = range(levels) if isinstance(levels, int) else levels
    try:
        with progress_bar(console) as bar:
            for level in bar.track(chosen, description="driving"):
                observation, _ = env.reset(options={"split": split, "level": int(level)})
                driver.begin(world.worlds.episodes, first, np.array([level]))
                recorder.begin(observation, int(level))
                ended = False
                while not ended:
                    action = driver.act(world.worlds.episodes, first)[0]
                    observation, reward, terminated, truncated, info = env.step(action)
                    outcome = int(info["outcome"])
                    recorder.add(RecordedStep(action, observation, float(reward), terminated, truncated, outcome))
                    ended = terminated or truncated
    finally:
        recorder.save()
        env.close()
    return demonstrations.load_demonstrations(path)


def _check_demonstrator(env: WorldEnv, policy: object) -> None:
    """Check that a policy uses the environment's observations: only these are recorded.

    Raises:
        DemonstrationError: If it uses others.
    """
    episodes = env.worlds.episodes
    worlds = Perceived(episodes)
    if worlds.of(policy) is not episodes:
        raise demonstrations.DemonstrationError(
            f"the policy observes {', '.join(worlds.observed_by(policy) or ())}, and demonstrations hold what task "
            f"'{episodes.task.name}' observes: pass the task that it was trained with"
        )


def _demonstrations(episodes: Sequence[_Episode], about: Mapping[str, Any]) -> demonstrations.Demonstrations:
    """Return episodes as arrays. Episodes that have not ended are truncated."""
    discrete = about["action_space"]["kind"] == "Discrete"
    steps = [step for episode in episodes for step in episode.steps]
    is_last = np.zeros(len(steps), np.bool_)
    is_last[np.cumsum([len(episode.steps) for episode in episodes]) - 1] = True
    terminated = is_last & np.array([step.terminated for step in steps], np.bool_)
    return demonstrations.Demonstrations(
        observations=concatenated([seen for episode in episodes for seen in episode.seen[:-1]], np.stack),
        actions=np.stack([np.asarray(step.action) for step in steps]).astype(np.int64 if discrete else np.float32),
        rewards=np.array([step.reward for step in steps], np.float64),
        terminations=terminated,
        truncations=is_last & ~terminated,
        episode_starts=np.roll(is_last, 1),
        by_hand=np.array([step.by_hand for step in steps], np.bool_),
        final_observations=concatenated([episode.seen[-1] for episode in episodes], np.stack),
        levels=np.array([episode.level for episode in episodes], np.int64),
        outcomes=np.array([episode.steps[-1].outcome for episode in episodes], np.int64),
        about=about,
    )


def _about(env: gymnasium.Env[Any, Any]) -> dict[str, Any]:
    """Return a description of an environment as plain data."""
    world = env.unwrapped
    assert isinstance(world, WorldEnv)
    worlds = world.worlds
    return {
        "format": demonstrations.FORMAT,
        "scenario": worlds.scenario.name,
        "parameters": dict(worlds.scenario.parameters),
        "task": worlds.task.name,
        "robot": worlds.agent_names[0],
        "step_time": worlds.scenario.world.step_time,
        "observation_space": demonstrations.describe_space(world.observation_space),
        "action_space": demonstrations.describe_space(world.action_space),
    }


def check_demonstrations(path: Path) -> None:
    """Check that the name of a file of demonstrations ends in ``.npz``.

    Raises:
        DemonstrationError: If it does not.
    """
    if path.suffix != SUFFIX:
        raise demonstrations.DemonstrationError(f"demonstrations must be {SUFFIX} files, got '{path.name}'")
