"""Saved policies as what the evaluation drives worlds with."""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeGuard

import numpy as np
from gymnasium import Space
from gymnasium.spaces import Box, Dict, Discrete
from numpy.typing import NDArray

from irsim_gym.arraytypes import Ints
from irsim_gym.envs.sb3_critic_parts import actor_observation_space, for_actor, has_critic_parts, lone_name
from irsim_gym.envs.spaces import action_space, observation_layout, observation_space
from irsim_gym.errors import IrsimGymError, suggestion
from irsim_gym.evaluation.perception import Perception, perception_from
from irsim_gym.evaluation.policy import ObservationPolicy, Policy, by_world, percepts
from irsim_gym.evaluation.reference_policies import is_named_policy, policy_kinds, reference_policy
from irsim_gym.extras import require
from irsim_gym.tasks import Episodes
from irsim_gym.training.checkpoint_files import POLICY, newest_checkpoint
from irsim_gym.training.run import Run
from irsim_gym.training.shelf import SUFFIX, ShelfPolicy, read_policy, shelf_files
from irsim_gym.training.trained_perception import trained_perception

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm
    from stable_baselines3.common.vec_env import VecNormalize

    Source = str | Path | BaseAlgorithm | ShelfPolicy | Policy | Callable[[Any], Any]
else:
    Source = object
"""What a policy can be given as: see ``load_policy``."""

CHUNK = 64
"""Rows of one pass through the network: always as many, since sums may be rounded otherwise in another size."""


class UnfitPolicyError(IrsimGymError):
    """A policy that was trained with other observations or actions than those of the task."""


class UnknownPolicyError(IrsimGymError):
    """There is no policy of a name, and no file or folder.

    Args:
        source: The given name or path.
        problem: What is said of it, without what would be right.
    """

    def __init__(self, source: str | Path, problem: str) -> None:
        super().__init__(f"{problem}; use a .zip, a run's folder, or one of {', '.join(known_names())}")
        self.source, self.problem = source, problem


class SavedPolicy:
    """A trained policy, deterministic; the agents of a team share it.

    Args:
        model: The loaded algorithm, or a policy of the shelf. A recurrent one has a memory for each agent of each
            world, empty at first.
        normalization: Statistics of the observations it was trained with.

    Attributes:
        perception: What it was trained to observe, and how it acts; None where that is unknown: then it observes what
            the task says that is played.
    """

    perception: Perception | None = None

    def __init__(self, model: BaseAlgorithm | ShelfPolicy, normalization: VecNormalize | None = None) -> None:
        self.model, self.normalization = model, for_actor(normalization)
        self._shape = memory_shape(model)
        if isinstance(model, ShelfPolicy):
            self.perception = None if model.perception is None else perception_from(model.perception)
        self._memory = np.zeros((0, 0, 0, 0), np.float32)

    def begin(self, episodes: Episodes, worlds: Ints, levels: Ints) -> None:
        """Forget what was in these worlds.

        Raises:
            UnfitPolicyError: The policy was trained with other observations or actions than these of the task.
        """
        self.check(episodes)
        if self._shape is None:
            return
        n_arrays, n_layers, width = self._shape
        size = (n_arrays, n_layers, episodes.n_worlds * episodes.n_agents, width)
        if self._memory.shape != size:
            self._memory = np.zeros(size, np.float32)
        self._memory[:, :, _slots(episodes, worlds)] = 0.0

    def act(self, episodes: Episodes, worlds: Ints) -> NDArray[Any]:
        """Return the actions of worlds, the same whatever other worlds there are."""
        seen, slots = percepts(episodes, worlds), _slots(episodes, worlds)
        layout = observation_layout(episodes)
        parts = [slice(start, start + CHUNK) for start in range(0, len(slots), CHUNK)]
        chunks = [self._chunk(layout.formed(seen.each(partial(_padded, part=part))), slots[part]) for part in parts]
        return by_world(np.concatenate(chunks), episodes)

    def check(self, episodes: Episodes) -> None:
        """Refuse a task with other observations or actions than the policy was trained with.

        Raises:
            IrsimGymError: It has.
        """
        model = self.model
        observed, acted = observation_space(episodes), action_space(episodes)
        for what, learnt, here in (
            ("observations", actor_observation_space(model.observation_space), observed),
            ("actions", model.action_space, acted),
        ):
            if form_of(learnt) not in (form_of(here), form_of(channels_first(here))):
                raise UnfitPolicyError(
                    f"the policy was trained with {what} {form_of(learnt)}, but those of task '{episodes.task.name}' "
                    f"in '{episodes.simulation.scenario.name}' are {form_of(here)}"
                )

    def _chunk(self, seen: Any, slots: Ints) -> NDArray[Any]:
        count = len(slots)
        if self.normalization is not None:
            space = self.normalization.observation_space
            is_lone = has_critic_parts(space) and not isinstance(seen, dict)
            seen = self.normalization.normalize_obs({lone_name(space): seen} if is_lone else seen)
        if self._shape is None:
            return self.model.predict(seen, deterministic=True)[0][:count]
        memory = np.zeros((*self._memory.shape[:2], CHUNK, self._shape[2]), np.float32)
        memory[:, :, :count] = self._memory[:, :, slots]
        kept: Any
        actions, kept = self.model.predict(seen, tuple(memory), deterministic=True)
        self._memory[:, :, slots] = np.stack(kept)[:, :, :count]
        return actions[:count]


def memory_shape(model: BaseAlgorithm | ShelfPolicy) -> tuple[int, int, int] | None:
    """Return of how many arrays the state of a policy is, of how many layers each, and how wide; None for no memory."""
    if isinstance(model, ShelfPolicy):
        return model.memory_shape
    lstm = getattr(model.policy, "lstm_hidden_state_shape", None)
    found: tuple[int, int, int] | None = getattr(model.policy, "memory_shape", None)
    return found if lstm is None else (2, lstm[0], lstm[2])


def _padded(rows: NDArray[Any], part: slice) -> NDArray[Any]:
    """Return some rows, with zeros behind them up to the size of a chunk."""
    chosen = rows[part]
    padded = np.zeros((CHUNK, *rows.shape[1:]), rows.dtype)
    padded[: len(chosen)] = chosen
    return padded


def channels_first(space: Space[Any]) -> Space[Any]:
    """Return a space as Stable-Baselines3 shows it to networks for pictures: channels, height, width."""
    if isinstance(space, Dict):
        return Dict({name: channels_first(part) for name, part in space.spaces.items()})
    if not is_picture(space):
        return space
    assert isinstance(space, Box)
    return Box(np.transpose(space.low, (2, 0, 1)), np.transpose(space.high, (2, 0, 1)), dtype=np.uint8)


def is_picture(space: Space[Any]) -> bool:
    """Return whether a space holds pictures whose channels are last."""
    shape = space.shape or ()
    return isinstance(space, Box) and space.dtype == np.uint8 and len(shape) == 3 and int(np.argmin(shape)) != 0


def form_of(space: Space[Any]) -> str:
    """Return what a space has to have in common with another one, in words."""
    if isinstance(space, Dict):
        return ", ".join(f"{name} {form_of(part)}" for name, part in space.spaces.items())
    return f"from 0 to {space.n - 1}" if isinstance(space, Discrete) else f"of shape {space.shape}"


def _slots(episodes: Episodes, worlds: Ints) -> Ints:
    """Return the numbers of the agents of worlds, counted over all worlds, ``(n * n_agents,)``."""
    agents = np.arange(episodes.n_agents, dtype=np.int64)
    return (worlds[:, None] * episodes.n_agents + agents).ravel()


def load_policy(source: Source) -> Policy:
    """Return what drives.

    Of a file the weights are read, and objects of known, harmless classes; for others it warns, because loading them
    runs code from the file. A policy of a run or of the shelf perceives as in its training.

    Args:
        source: ``"random"``, the name of a behaviour or group behaviour (``"dwa"``, ``"pursuit:known=seen"``), that of
            a policy on the shelf (``"cluttered_room"``), a file ``policy.zip`` or one that ``irsim-gym policies
            export`` has written, a run's folder (its newest checkpoint if it is not finished), a model of
            Stable-Baselines3, a function of observations as ``ObservationPolicy`` takes it, or a ``Policy``.

    Raises:
        IrsimGymError: There is no such policy.
    """
    if isinstance(source, Policy):
        return source
    if isinstance(source, ShelfPolicy):
        return SavedPolicy(source)
    if is_model(source):
        from irsim_gym.training.saved_models import frozen

        return SavedPolicy(source, frozen(source.get_vec_normalize_env()))
    if callable(source):
        return ObservationPolicy(source)
    if not isinstance(source, str | Path):
        raise TypeError(f"a policy is a function, a model, a file or a name, got {type(source).__name__}")
    if is_named_policy(source):
        _check_one_meaning(source, "a behavior: give that another name")
        return reference_policy(str(source))
    path = policy_file(source)
    if path.suffix == SUFFIX:
        return SavedPolicy(read_policy(path))
    require("train", f"{path}: a policy.zip")
    from irsim_gym.training.saved_models import load_model

    loaded = SavedPolicy(*load_model(path))
    loaded.perception = trained_perception(path)
    return loaded


def is_model(source: object) -> TypeGuard[BaseAlgorithm]:
    """Return whether something is a model of Stable-Baselines3; that is not imported for it."""
    module = sys.modules.get("stable_baselines3.common.base_class")
    return module is not None and isinstance(source, module.BaseAlgorithm)


def load_policies(sources: Sequence[Source]) -> list[Policy]:
    """Return what drives, for each source, see ``load_policy``.

    Raises:
        UnknownPolicyError: There is no such policy; the message names all that are missing.
    """
    loaded: list[Policy] = []
    missing: list[UnknownPolicyError] = []
    for source in sources:
        try:
            loaded.append(load_policy(source))
        except UnknownPolicyError as error:
            missing.append(error)
    if missing:
        raise UnknownPolicyError(missing[0].source, "\n".join(error.problem for error in missing))
    return loaded


def policy_file(source: str | Path) -> Path:
    """Return the file of a policy.

    Args:
        source: The file itself, a name on the shelf, or a run's folder: its policy, or the newest checkpoint's if it is
            not finished. A ``Path`` is no name.

    Raises:
        UnknownPolicyError: There is none.
        IrsimGymError: A name on the shelf is also that of a file or folder here.
    """
    path = Path(source)
    if is_on_shelf(source):
        if path.exists():
            _check_one_meaning(source, f"a file or folder here: write .{os.sep}{source} for that")
        return shelf_files()[str(source)]
    if path.is_dir():
        newest = newest_checkpoint(Run(path).checkpoints)
        path = path / POLICY if (path / POLICY).is_file() or newest is None else newest / POLICY
    if not path.is_file():
        near = suggestion(str(source), known_names())
        raise UnknownPolicyError(source, f"no policy at {source}{near}")
    return path


def is_on_shelf(source: object) -> bool:
    """Return whether a source is the name of a policy on the shelf; a ``Path`` is none."""
    return isinstance(source, str) and source in shelf_files()


def known_names() -> tuple[str, ...]:
    """Return the names of behaviours and of policies on the shelf."""
    return (*policy_kinds(), *shelf_files())


def _check_one_meaning(source: str | Path, other: str) -> None:
    """Refuse a name on the shelf that is also that of something else.

    Raises:
        IrsimGymError: It is.
    """
    if is_on_shelf(source):
        raise IrsimGymError(
            f"'{source}' is a policy on the shelf, and {other}, or {shelf_files()[str(source)]} for the policy"
        )


def policy_digest(source: str | Path) -> str | None:
    """Return SHA-256 of a policy's file; None for a name, which has none."""
    return None if is_named_policy(source) else hashlib.sha256(policy_file(source).read_bytes()).hexdigest()


def policy_names(sources: Sequence[Source]) -> list[str]:
    """Return short names, all different: the run's for its folder or ``policy.zip``, else that of file or function."""
    names = [_short_name(Path(one)) if isinstance(one, str | Path) else _called(one) for one in sources]
    return [name if names.count(name) == 1 else f"{name}-{names[:i].count(name) + 1}" for i, name in enumerate(names)]


def _short_name(path: Path) -> str:
    if path.name == POLICY and path.parent.name:
        path = path.parent
    return path.stem if path.suffix in (".zip", SUFFIX) else path.name


def _called(source: object) -> str:
    """Return the name of a function, or of the class of a model or policy, without capitals."""
    return str(getattr(source, "__name__", type(source).__name__.lower()))
