"""Worlds with many learners as a Stable-Baselines3 ``VecEnv``: one slot for each robot of each world."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Flags, Ints, Rays
from irsim_gym.base.errors import WaitingRobotsWarning
from irsim_gym.envs.gymnasium.world_view import WorldView
from irsim_gym.envs.gymnasium.worlds import ScenarioSource, TaskSource, Worlds
from irsim_gym.envs.parts.infos import reward_keys
from irsim_gym.envs.parts.observations import on_each
from irsim_gym.envs.parts.spaces import Observation
from irsim_gym.envs.sb3.base import NativeVecEnv, checked_mode
from irsim_gym.envs.teams.batch import Batch
from irsim_gym.envs.teams.batch_step import BatchStep
from irsim_gym.tasks import Outcome


def make_multi_agent_vec_env(
    scenario: ScenarioSource,
    num_envs: int = 1,
    seed: int | None = None,
    *,
    task: TaskSource = None,
    max_steps: int | None = None,
    respawn: bool = False,
    world_steps: int | None = None,
    num_threads: int = 1,
    render_mode: str | None = "rgb_array",
    strict: bool = True,
    **parameters: Any,
) -> TeamVecEnv:
    """Make the worlds of a scenario for one policy that all its robots share.

    Args:
        scenario: Name of a shipped scenario, id, path of a YAML file, plain data or a loaded scenario.
        num_envs: Number of worlds; there are ``num_envs * n_agents`` slots.
        seed: World ``w`` begins with level ``seed + w``; None for levels from entropy.
        task: Name of a shipped task, path, or plain data; None for the scenario's own. Without ``agents`` in it, all
            robots learn.
        max_steps: Time limit of a robot [steps]; None for the task's.
        respawn: False: a robot that has ended waits until all robots of its world have; ``MaskedPPO``, ``MaskedA2C``
            and ``GruPPO`` leave it out. True: it restarts elsewhere at once, and none waits.
        world_steps: With ``respawn``, steps after which a world begins its next level; None for four time limits.
        num_threads: Threads that share the worlds.
        render_mode: ``"rgb_array"``: a frame is drawn only where ``render`` is called, ``render("human")`` shows it.
            ``"human"``: each step shows the worlds in a window, sixteen at most. Or None.
        strict: False ignores unused keys with an ``IgnoredKeyWarning``; True raises an error.
        **parameters: Values for the scenario's parameters, e.g. ``n_robots=8``.
    """
    worlds = Worlds(
        scenario,
        num_envs,
        task=task,
        max_steps=max_steps,
        num_threads=num_threads,
        render_mode=checked_mode(render_mode),
        team=True,
        parameters=parameters,
        strict=strict,
    )
    env = TeamVecEnv(Batch(worlds, respawn=respawn, world_steps=world_steps))
    if seed is not None:
        env.seed(seed)
    return env


class TeamVecEnv(NativeVecEnv):
    """Worlds of one scenario with a slot for each robot: slot ``world * n_agents + agent``.

    A robot's own end is the end of its slot's episode: ``done``, its last observation as ``terminal_observation``,
    ``TimeLimit.truncated``, and the infos of the single environment. What follows depends on ``respawn``:

    * False: the slot idles until all robots of the world have ended and the world restarts, in that same step.
      It observes its last observation, is paid 0 and its info holds ``idle``. At the restart it is ``done`` once
      more, so that recurrent policies reset their memory, but there is no ``episode`` for it.
    * True: the robot begins elsewhere at once. A world begins its next level after ``world_steps`` steps; the
      episodes under way are then cut (``TimeLimit.truncated``) and are in no statistics, as they have no outcome.

    Stable-Baselines3 counts idle slots as steps; ``idle_share`` is their share. An algorithm that does not know about
    them learns from their rows as if they acted. The environment therefore warns once (``WaitingRobotsWarning``) when
    the first slots idle, unless ``leaves_out_waiting`` is set, or the episodes belong to an evaluation: ``reset`` was
    called after a question for the statistics of a ``Monitor``, as ``evaluate_policy`` does.

    Attributes:
        batch: The worlds.
        acted: Slots whose row of the latest step is experience, ``(n_slots,)``.
        acting: Slots that will act in the next step, ``(n_slots,)``.
        leaves_out_waiting: Whoever steps the environment ignores the rows of idle slots. ``MaskedPPO``, ``MaskedA2C``
            and ``GruPPO`` set it; set it in a loop of your own that reads ``acted``, or ``idle`` in the infos.
    """

    leaves_out_waiting = False
    _is_evaluated = False
    _has_warned = False

    def __init__(self, batch: Batch) -> None:
        self.batch = batch
        self.n_agents = batch.n_agents
        n_slots = batch.n_worlds * batch.n_agents
        self.acted: Flags = np.zeros(n_slots, np.bool_)
        self.acting: Flags = np.zeros(n_slots, np.bool_)
        self._counts = [0, 0]
        self._actions: NDArray[Any] | None = None
        self._action_shape = (n_slots, *(batch.action_space.shape or ()))
        views = [WorldView(batch.worlds, *divmod(slot, batch.n_agents)) for slot in range(n_slots)]
        super().__init__(batch.worlds, views, batch.observation_space, batch.action_space)

    @property
    def idle_share(self) -> float:
        """Share of idle slots among all slots of all steps so far; 0 before the first step."""
        idle, total = self._counts
        return idle / total if total else 0.0

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Let world ``w`` begin level ``seed + w`` at the next reset; None draws a seed. Return each slot's."""
        first = super().seed(seed)[0]
        assert first is not None
        self._seeds = [first + slot // self.n_agents for slot in range(self.num_envs)]
        return self._seeds

    def reset(self) -> Observation:
        """Begin an episode in every world, with the seeds and options given before, which are then forgotten."""
        options: list[Mapping[str, Any]] = list(self._options)
        if len(options) == self.num_envs:
            options = options[:: self.n_agents]
        elif len(options) != self.batch.n_worlds:
            raise ValueError(f"a list of options needs one for each of the {self.batch.n_worlds} worlds")
        self._is_evaluated, self.statistics_asked = self.statistics_asked, False
        begun = self.batch.begin(self._seeds[:: self.n_agents], options)
        self._reset_seeds()
        self._reset_options()
        self.acting = begun.live.reshape(-1)
        self.note_beginnings(np.arange(self.num_envs))
        return self._slots(begun.observation)

    def step_async(self, actions: NDArray[Any]) -> None:
        """Take the actions ``(n_slots, ...)`` for the next ``step_wait``; those of idle slots do nothing."""
        rows = np.asarray(actions)
        if rows.shape != self._action_shape:
            raise ValueError(f"actions must have shape {self._action_shape}, got {rows.shape}")
        self._actions = rows.reshape(self.batch.n_worlds, self.n_agents, *rows.shape[1:])

    def step_wait(self) -> tuple[Observation, Rays, Flags, list[dict[str, Any]]]:
        """Advance all worlds by one step.

        Returns:
            Observations, rewards (float32), dones and infos of all slots; all fresh.
        """
        if self._actions is None:
            raise ResetNeeded("call reset() and step_async() before step_wait()")
        step = self.batch.step(self._actions)
        self._actions = None
        acted, began, ended = (flags.reshape(-1) for flags in (step.acted, step.began, step.ended))
        self.acted, self.acting = acted, step.live.reshape(-1)
        idle = np.flatnonzero(~acted)
        self._counts[0] += idle.size
        self._counts[1] += self.num_envs
        infos = self.no_infos()
        for slot in idle.tolist():
            infos[slot]["idle"] = True
        if idle.size and not (self.leaves_out_waiting or self._is_evaluated or self._has_warned):
            self._warn()
        dones: Flags = ended | (began & ~acted)
        if dones.any():
            self._tell(step, np.flatnonzero(ended), infos)
            self._tell_idle(step, np.flatnonzero(began & ~acted), infos)
            self.note_beginnings(np.flatnonzero(began))
        return self._slots(step.observation), step.reward.reshape(-1).astype(np.float32), dones, infos

    def _warn(self) -> None:
        """Warn once that the rows of idle slots are no experience."""
        self._has_warned = True
        warnings.warn(
            "some robots wait for their world, and an algorithm that does not know it learns from their rows as if "
            "they acted. Use sb3.MaskedPPO, sb3.MaskedA2C or sb3.GruPPO, or make the environment with respawn=True. In "
            "a loop of your own, read env.acted and set env.leaves_out_waiting = True",
            WaitingRobotsWarning,
            stacklevel=4,
        )

    def _tell(self, step: BatchStep, ended: Ints, infos: list[dict[str, Any]]) -> None:
        """Fill in the infos of slots whose own episodes have ended."""
        worlds, agents = np.divmod(ended, self.n_agents)
        columns = [values[worlds, agents].tolist() for values in step.infos.values()]
        cut = step.truncated[worlds, agents].tolist()
        terms = step.reward_terms[worlds, agents].tolist()
        keys = reward_keys(self.worlds.episodes.reward_names)
        for i, (slot, row) in enumerate(zip(ended.tolist(), zip(*columns, strict=True), strict=True)):
            info: dict[str, Any] = dict(zip(step.infos, row, strict=True))
            total = info.pop("episode_return")
            info.update(zip(keys, terms[i], strict=True))
            info["terminal_observation"] = self._one(step.final_observation, slot)
            info["TimeLimit.truncated"] = cut[i]
            if info["outcome"] == Outcome.RUNNING:
                del info["is_success"]
            else:
                info["episode"] = self.episode(total, info)
            infos[slot] = info

    def _tell_idle(self, step: BatchStep, restarted: Ints, infos: list[dict[str, Any]]) -> None:
        """Fill in the infos of idle slots whose world has restarted."""
        for slot in restarted.tolist():
            infos[slot]["terminal_observation"] = self._one(step.final_observation, slot)
            infos[slot]["TimeLimit.truncated"] = False

    def _slots(self, observation: Observation) -> Observation:
        """Return observations with one axis for all slots."""
        slots: Observation = on_each(observation, lambda values: values.reshape(self.num_envs, *values.shape[2:]))
        return slots

    def _one(self, observation: Observation, slot: int) -> Observation:
        w, a = divmod(slot, self.n_agents)
        row: Observation = on_each(observation, lambda values: values[w, a].copy())
        return row
