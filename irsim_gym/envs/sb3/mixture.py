"""Batches of several scenarios as one ``VecEnv`` of Stable-Baselines3, for one policy that learns them all."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium import Space
from gymnasium.spaces import Box, Dict
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv

from irsim_gym.base.arraytypes import Bytes, Flags, Floats, Rays
from irsim_gym.base.errors import IrsimGymError
from irsim_gym.envs.described.description import Description
from irsim_gym.envs.parts.observations import concatenated
from irsim_gym.envs.parts.spaces import Observation
from irsim_gym.envs.sb3.base import Indices, NativeVecEnv


class MixtureVecEnv(VecEnv):
    """The slots of several batches, one batch after the other. Each batch steps and restarts as it does alone.

    Observations need the same parts of the same sizes, and actions the same number of components, or of choices. Bounds
    may differ, and so may the meaning of a component: the second is a turn rate on wheels and a speed to the left of an
    omnidirectional robot. A policy for both needs an observation that tells them apart, such as ``own_body``.

    Infos of an episode that has ended hold the name of the batch as ``scenario``. Mixtures of teams have the masks of
    ``TeamVecEnv``, so that masked algorithms can learn from them.

    Args:
        parts: The batches by name, all from ``make_vec_env`` or all from ``make_multi_agent_vec_env``.

    Attributes:
        parts: The batches by name.

    Raises:
        IrsimGymError: If there is no batch, or the batches differ in observations or actions.
    """

    statistics_asked = False

    def __init__(self, parts: Mapping[str, NativeVecEnv]) -> None:
        if not parts:
            raise IrsimGymError("a mixture needs at least one batch")
        self.parts = dict(parts)
        _check_alike(self.parts)
        self._batches = list(self.parts.values())
        self._ends = np.cumsum([batch.num_envs for batch in self._batches]).tolist()
        self._starts = [0, *self._ends[:-1]]
        first = self._batches[0]
        space = _joined([batch.observation_space for batch in self._batches])
        super().__init__(self._ends[-1], space, first.action_space)
        self.metadata: dict[str, Any] = {**self.metadata, "render_fps": first.metadata["render_fps"]}

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {', '.join(map(repr, self._batches))}>"

    @property
    def reset_infos(self) -> list[dict[str, Any]]:
        """Infos from the beginning of each slot's latest episode."""
        return [info for batch in self._batches for info in batch.reset_infos]

    @reset_infos.setter
    def reset_infos(self, infos: list[dict[str, Any]]) -> None:
        """Do nothing, because each batch stores its own."""

    @property
    def acted(self) -> Flags:
        """Slots whose row in the latest step is experience, shape ``(num_envs,)``; see ``TeamVecEnv``."""
        return np.concatenate([batch.acted for batch in self._batches])  # type: ignore[attr-defined]

    @property
    def acting(self) -> Flags:
        """Slots that will act in the next step, shape ``(num_envs,)``; see ``TeamVecEnv``."""
        return np.concatenate([batch.acting for batch in self._batches])  # type: ignore[attr-defined]

    @property
    def leaves_out_waiting(self) -> bool:
        """Whether the rows of idle slots are ignored by whoever steps the environment; see ``TeamVecEnv``."""
        return all(batch.leaves_out_waiting for batch in self._batches)  # type: ignore[attr-defined]

    @leaves_out_waiting.setter
    def leaves_out_waiting(self, value: bool) -> None:
        for batch in self._batches:
            batch.leaves_out_waiting = value  # type: ignore[attr-defined]

    @property
    def idle_share(self) -> float:
        """Share of idle slots among all slots of all steps so far; see ``TeamVecEnv``."""
        idle = sum(batch.idle_share * batch.num_envs for batch in self._batches)  # type: ignore[attr-defined]
        return float(idle / self.num_envs)

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Seed each batch with ``seed``, see ``VecEnv.seed``. The same number is another level in each scenario."""
        return [given for batch in self._batches for given in batch.seed(seed)]

    def set_options(self, options: list[dict[str, Any]] | dict[str, Any] | None = None) -> None:
        """Set the options of the next reset, for all slots or for each."""
        for batch, start, end in zip(self._batches, self._starts, self._ends, strict=True):
            batch.set_options(options[start:end] if isinstance(options, list) else options)

    def reset(self) -> Observation:
        """Begin an episode in every world, with the seeds and options that were set; then forget these."""
        for batch in self._batches:
            batch.statistics_asked = self.statistics_asked
        self.statistics_asked = False
        first: Observation = concatenated([batch.reset() for batch in self._batches])  # type: ignore[misc]
        return first

    def step_async(self, actions: NDArray[Any]) -> None:
        """Store the actions, ``(n_slots, ...)``, for the next ``step_wait``."""
        rows = np.asarray(actions)
        if rows.shape[:1] != (self.num_envs,):
            raise ValueError(f"actions must have {self.num_envs} rows, got shape {rows.shape}")
        for batch, start, end in zip(self._batches, self._starts, self._ends, strict=True):
            batch.step_async(rows[start:end])

    def step_wait(self) -> tuple[Observation, Rays, Flags, list[dict[str, Any]]]:
        """Advance all worlds by one step.

        Returns:
            Observations, rewards (float32), dones and infos of all slots, as new arrays.
        """
        seen, rewards, dones, infos = zip(*(batch.step_wait() for batch in self._batches), strict=True)
        for name, ended, told in zip(self.parts, dones, infos, strict=True):
            for slot in ended.nonzero()[0].tolist():
                told[slot]["scenario"] = name
        return concatenated(seen), np.concatenate(rewards), np.concatenate(dones), [one for row in infos for one in row]

    @property
    def reward_names(self) -> tuple[str, ...]:
        """Names of the reward terms of all scenarios, the columns of ``reward_terms``."""
        return tuple(dict.fromkeys(name for batch in self._batches for name in batch.reward_names))

    def reward_terms(self) -> Floats:
        """Return the reward of each term in the latest step, ``(n_envs, n_terms)``; 0 if a scenario lacks the term."""
        names, paid = self.reward_names, []
        for batch in self._batches:
            columns = [names.index(name) for name in batch.reward_names]
            rows = np.zeros((batch.num_envs, len(names)))
            rows[:, columns] = batch.reward_terms()
            paid.append(rows)
        return np.concatenate(paid)

    def describe(self) -> dict[str, Description]:
        """Return the meaning of observations, actions, rewards, endings and infos in each batch, by name."""
        return {name: batch.describe() for name, batch in self.parts.items()}

    def close(self) -> None:
        """Close all batches. May be called twice."""
        for batch in self._batches:
            batch.close()

    def get_images(self) -> Sequence[Bytes | None]:
        """Return a fresh picture of each world."""
        return [picture for batch in self._batches for picture in batch.get_images()]

    def get_attr(self, attr_name: str, indices: Indices = None) -> list[Any]:
        """Return an attribute of the chosen slots."""
        return self._each(indices, lambda batch, slot: batch.get_attr(attr_name, [slot])[0])

    def set_attr(self, attr_name: str, value: Any, indices: Indices = None) -> None:
        """Set an attribute of the chosen slots; ``max_steps`` only for all slots of a batch."""
        for batch, slots in self._chosen(indices):
            batch.set_attr(attr_name, value, slots)

    def env_method(
        self, method_name: str, *method_args: Any, indices: Indices = None, **method_kwargs: Any
    ) -> list[Any]:
        """Call a method of the chosen slots."""
        return self._each(
            indices, lambda batch, slot: batch.env_method(method_name, *method_args, indices=[slot], **method_kwargs)[0]
        )

    def env_is_wrapped(
        self, wrapper_class: type[gymnasium.Wrapper[Any, Any, Any, Any]], indices: Indices = None
    ) -> list[bool]:
        """Return True for ``Monitor`` only; see ``NativeVecEnv``."""
        answers = self._each(indices, lambda batch, slot: batch.env_is_wrapped(wrapper_class, [slot])[0])
        self.statistics_asked = any(batch.statistics_asked for batch in self._batches)
        return answers

    def _place(self, slot: int) -> tuple[int, int]:
        """Return the number of the batch of a slot, and the slot within it."""
        k = int(np.searchsorted(self._ends, slot, side="right"))
        return k, slot - self._starts[k]

    def _each(self, indices: Indices, ask: Callable[[NativeVecEnv, int], Any]) -> list[Any]:
        places = [self._place(slot) for slot in self._get_indices(indices)]
        return [ask(self._batches[k], slot) for k, slot in places]

    def _chosen(self, indices: Indices) -> Iterator[tuple[NativeVecEnv, list[int]]]:
        """Yield the batches with chosen slots, each with the numbers of these slots within it."""
        chosen: dict[int, list[int]] = {}
        for k, slot in map(self._place, self._get_indices(indices)):
            chosen.setdefault(k, []).append(slot)
        for k, slots in chosen.items():
            yield self._batches[k], slots


def _joined(spaces: Sequence[Any]) -> Space[Any]:
    """Return a space that contains all of the given spaces, which have the same form."""
    first: Space[Any] = spaces[0]
    if isinstance(first, Dict):
        return Dict({name: _joined([space[name] for space in spaces]) for name in first.spaces})
    if not isinstance(first, Box):
        return first
    low = np.min([space.low for space in spaces], axis=0)
    high = np.max([space.high for space in spaces], axis=0)
    return Box(low, high, dtype=first.dtype.type)


def _check_alike(parts: Mapping[str, NativeVecEnv]) -> None:
    """Raise an error if a batch differs from the first in its kind, its observations or its actions."""
    (first, one), *others = parts.items()
    for name, other in others:
        if type(other) is not type(one):
            raise IrsimGymError(f"{first} is a {type(one).__name__}, {name} a {type(other).__name__}: mix one kind")
        for what, ours, theirs in (("observes", _sizes(one), _sizes(other)), ("acts by", _action(one), _action(other))):
            if ours != theirs:
                raise IrsimGymError(
                    f"one policy needs observations and actions of one shape, but {first} {what} "
                    f"{_difference(ours, theirs)}, where {name} has {_difference(theirs, ours)}; --task NAME, or task= "
                    "for each, lets all of them observe alike"
                )


def _sizes(env: NativeVecEnv) -> dict[str, str]:
    """Return the shape of each part of an observation by its name, in order."""
    episodes = env.worlds.episodes
    sizes = {name: str(len(low)) for name, low, _ in episodes.observation_terms}
    sizes |= {name: str(part.shape[2:]) for name, part in episodes.view.images.items()}
    return {**sizes, "observation_form": episodes.task.observation_form}


def _action(env: NativeVecEnv) -> dict[str, str]:
    space = env.action_space
    return {type(space).__name__: str(getattr(space, "n", space.shape))}


def _difference(ours: Mapping[str, str], theirs: Mapping[str, str]) -> str:
    """Return in words what ``ours`` has and ``theirs`` has not."""
    differing = [f"{name} ({size})" for name, size in ours.items() if theirs.get(name) != size]
    if not differing and set(ours) == set(theirs):
        return f"the order {', '.join(ours)}"
    return ", ".join(differing) or "nothing more"
