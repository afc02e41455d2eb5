"""Policies stored on disk, as policies for the evaluation."""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeGuard

import numpy as np
from gymnasium import Space
from gymnasium.spaces import Box, Dict, Discrete
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Ints
from irsim_gym.base.errors import IrsimGymError, UnknownPerceptionWarning, warn_caller
from irsim_gym.base.extras import require
from irsim_gym.envs.parts.spaces import action_space, observation_layout, observation_space
from irsim_gym.evaluation.policies.perception import Perception, perception_from
from irsim_gym.evaluation.policies.policy import ObservationPolicy, Policy, by_world, percepts
from irsim_gym.evaluation.policies.reference_policies import is_named_policy, reference_policy
from irsim_gym.evaluation.saved_policies.checkpoint_files import POLICY, newest_checkpoint
from irsim_gym.evaluation.saved_policies.policy_places import UnknownPolicyError, all_unknown, missing_policy, read_each
from irsim_gym.evaluation.saved_policies.run_folder import RunFolder, folder_of
from irsim_gym.evaluation.saved_policies.shelf import SUFFIX, ShelfPolicy, read_policy, shelf_files
from irsim_gym.tasks import Episodes

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm
    from stable_baselines3.common.vec_env import VecNormalize

    Source = str | Path | BaseAlgorithm | ShelfPolicy | Policy | Callable[[Any], Any]
else:
    Source = object
"""Types that ``load_policy`` accepts."""

MOST_WEIGHTS = 1_000_000
"""Largest number of weights of a network that runs on one thread of PyTorch."""
CHUNK = 64
"""Number of rows of each forward pass. It is constant, because rounding depends on the size of a batch."""


class UnfitPolicyError(IrsimGymError):
    """Raised if a policy was trained with other observations or actions than those of the task."""


class SavedPolicy:
    """A trained policy with deterministic actions. The agents of a team share it.

    Args:
        model: A model of Stable-Baselines3, or an exported policy. A recurrent one gets a memory for each agent of each
            world, which is zero at first.
        normalization: Statistics of the observations in the training; None for none.

    Attributes:
        perception: Observations and action of the training. If unknown, it is None, and the policy uses those of the
            current task.
    """

    perception: Perception | None = None

    def __init__(self, model: BaseAlgorithm | ShelfPolicy, normalization: VecNormalize | None = None) -> None:
        self.model, self.normalization = model, normalization
        self._shape = memory_shape(model)
        if isinstance(model, ShelfPolicy):
            self.perception = None if model.perception is None else perception_from(model.perception)
        self._memory = np.zeros((0, 0, 0, 0), np.float32)

    def begin(self, episodes: Episodes, worlds: Ints, levels: Ints) -> None:
        """Reset the memory of these worlds.

        Raises:
            UnfitPolicyError: If the policy was trained with other observations or actions than those of the task.
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
        """Return the actions of worlds, which do not depend on other worlds."""
        seen, slots = percepts(episodes, worlds), _slots(episodes, worlds)
        layout = observation_layout(episodes)
        parts = [slice(start, start + CHUNK) for start in range(0, len(slots), CHUNK)]
        chunks = [self._chunk(layout.formed(seen.each(partial(_padded, part=part))), slots[part]) for part in parts]
        return by_world(np.concatenate(chunks), episodes)

    def check(self, episodes: Episodes) -> None:
        """Check that a task has the observations and the action that the policy was trained with.

        Raises:
            UnfitPolicyError: If it has others.
        """
        model = self.model
        observed, acted = observation_space(episodes), action_space(episodes)
        for what, learnt, space in (
            ("observations", model.observation_space, observed),
            ("actions", model.action_space, acted),
        ):
            if form_of(learnt) not in (form_of(space), form_of(channels_first(space))):
                raise UnfitPolicyError(
                    f"the policy was trained with {what} {form_of(learnt)}, but those of task '{episodes.task.name}' "
                    f"in '{episodes.simulation.scenario.name}' are {form_of(space)}"
                )

    def _chunk(self, seen: Any, slots: Ints) -> NDArray[Any]:
        """Return the actions for one batch of observations, padded to ``CHUNK`` rows, and update the memory."""
        count = len(slots)
        if self.normalization is not None:
            seen = self.normalization.normalize_obs(seen)
        if self._shape is None:
            with torch_threads(self.model):
                return self.model.predict(seen, deterministic=True)[0][:count]
        memory = np.zeros((*self._memory.shape[:2], CHUNK, self._shape[2]), np.float32)
        memory[:, :, :count] = self._memory[:, :, slots]
        kept: Any
        with torch_threads(self.model):
            actions, kept = self.model.predict(seen, tuple(memory), deterministic=True)
        self._memory[:, :, slots] = np.stack(kept)[:, :, :count]
        return actions[:count]


@contextmanager
def torch_threads(model: BaseAlgorithm | ShelfPolicy) -> Iterator[None]:
    """Let PyTorch use one thread for a small network: several wait for each other longer than they work."""
    torch = sys.modules.get("torch")
    if torch is None or not is_model(model) or sum(item.numel() for item in model.policy.parameters()) > MOST_WEIGHTS:
        yield
        return
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before)


def memory_shape(model: BaseAlgorithm | ShelfPolicy) -> tuple[int, int, int] | None:
    """Return the shape of a policy's memory, ``(n_arrays, n_layers, width)``; None for a policy without memory."""
    if isinstance(model, ShelfPolicy):
        return model.memory_shape
    if hasattr(model.policy, "lstm_hidden_state_shape"):
        raise UnfitPolicyError("a model of sb3-contrib's recurrent PPO is not driven here: take sb3.GruPPO")
    shape: tuple[int, int, int] | None = getattr(model.policy, "memory_shape", None)
    return shape


def _padded(rows: NDArray[Any], part: slice) -> NDArray[Any]:
    """Return the rows of a slice, padded with zeros to ``CHUNK`` rows."""
    chosen = rows[part]
    padded = np.zeros((CHUNK, *rows.shape[1:]), rows.dtype)
    padded[: len(chosen)] = chosen
    return padded


def channels_first(space: Space[Any]) -> Space[Any]:
    """Return a space with images as Stable-Baselines3 gives them to networks: channels, height, width."""
    if isinstance(space, Dict):
        return Dict({name: channels_first(part) for name, part in space.spaces.items()})
    if not is_picture(space):
        return space
    assert isinstance(space, Box)
    return Box(np.transpose(space.low, (2, 0, 1)), np.transpose(space.high, (2, 0, 1)), dtype=np.uint8)


def is_picture(space: Space[Any]) -> bool:
    """Return whether a space holds images whose last axis is the channels."""
    shape = space.shape or ()
    return isinstance(space, Box) and space.dtype == np.uint8 and len(shape) == 3 and int(np.argmin(shape)) != 0


def form_of(space: Space[Any]) -> str:
    """Return a description of the properties in which two compatible spaces agree."""
    if isinstance(space, Dict):
        return ", ".join(f"{name} {form_of(part)}" for name, part in space.spaces.items())
    return f"from 0 to {space.n - 1}" if isinstance(space, Discrete) else f"of shape {space.shape}"


def _slots(episodes: Episodes, worlds: Ints) -> Ints:
    """Return the indices of the agents of worlds, counted over all worlds, ``(n * n_agents,)``."""
    agents = np.arange(episodes.n_agents, dtype=np.int64)
    return (worlds[:, None] * episodes.n_agents + agents).ravel()


def load_policy(source: Source) -> Policy:
    """Load a policy.

    From a file, this reads weights, and objects of known harmless classes. It warns of objects of other classes,
    because loading them runs code from the file. A policy of a run and a shipped policy observe and act as in their
    training.

    Args:
        source: One of:

            - ``"random"``, or a behaviour or group behaviour such as ``"dwa"`` or ``"pursuit:known=seen"``;
            - the name of a shipped policy, such as ``"cluttered_room"``;
            - the path of a ``policy.zip``, or of a file that ``irsim-gym policies export`` wrote;
            - a run's folder: its policy, or that of its newest checkpoint if it is not finished;
            - a model of Stable-Baselines3;
            - a function of observations, as ``ObservationPolicy`` takes it;
            - a ``Policy``, which is returned unchanged.

    Raises:
        IrsimGymError: If there is no such policy, or it cannot be loaded.
        TypeError: If the source is of another type.
    """
    if isinstance(source, Policy):
        return source
    if isinstance(source, ShelfPolicy):
        return SavedPolicy(source)
    if is_model(source):
        from irsim_gym.evaluation.saved_policies.saved_models import frozen

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
    from irsim_gym.evaluation.saved_policies.saved_models import load_model

    loaded = SavedPolicy(*load_model(path))
    loaded.perception = _trained_perception(path)
    return loaded


def is_model(source: object) -> TypeGuard[BaseAlgorithm]:
    """Return whether an object is a model of Stable-Baselines3, without importing the library."""
    module = sys.modules.get("stable_baselines3.common.base_class")
    return module is not None and isinstance(source, module.BaseAlgorithm)


def load_policies(sources: Sequence[Source]) -> list[Policy]:
    """Load several policies, see ``load_policy``.

    Raises:
        UnknownPolicyError: If policies do not exist. The message names all of these.
    """
    loaded, missing = read_each(load_policy, sources)
    if missing:
        raise all_unknown(missing)
    for source in sources:
        _report_unfinished(source)
    return loaded


def _report_unfinished(source: Source) -> None:
    """Say on standard error if a source is the folder of a run that is not finished, and what plays."""
    if not isinstance(source, str | Path) or is_named_policy(source) or is_on_shelf(source):
        return
    run = RunFolder(Path(source))
    if run.exists() and not run.finished():
        steps, total = int(policy_file(source).parent.name), run.trained().steps
        print(f"{source} is not finished: its checkpoint after {steps:,} of {total:,} steps plays", file=sys.stderr)


def policy_file(source: str | Path) -> Path:
    """Return the file of a policy.

    Args:
        source: Path of the file, name of a shipped policy, or a run's folder: its policy, or that of its newest
            checkpoint if it is not finished. A ``Path`` is never taken as a name.

    Raises:
        UnknownPolicyError: If there is no such policy.
        IrsimGymError: If a shipped policy and a file or folder here have the same name.
    """
    path = Path(source)
    if is_on_shelf(source):
        if path.exists():
            _check_one_meaning(source, f"a file or folder here: write .{os.sep}{source} for that")
        return shelf_files()[str(source)]
    if path.is_dir():
        newest = newest_checkpoint(RunFolder(path).checkpoints)
        path = path / POLICY if (path / POLICY).is_file() or newest is None else newest / POLICY
    if not path.is_file():
        raise UnknownPolicyError(source, missing_policy(source))
    return path


def is_on_shelf(source: object) -> bool:
    """Return whether a source is the name of a shipped policy. A ``Path`` is never taken as a name."""
    return isinstance(source, str) and source in shelf_files()


def _check_one_meaning(source: str | Path, other: str) -> None:
    """Check that a name is not ambiguous.

    Args:
        source: Name or path.
        other: Description of the other meaning of the name.

    Raises:
        IrsimGymError: If it is also the name of a shipped policy.
    """
    if is_on_shelf(source):
        raise IrsimGymError(
            f"'{source}' is a policy on the shelf, and {other}, or {shelf_files()[str(source)]} for the policy"
        )


def policy_digest(source: str | Path) -> str | None:
    """Return the SHA-256 hash of a policy's file; None for a behaviour, which has no file."""
    return None if is_named_policy(source) else hashlib.sha256(policy_file(source).read_bytes()).hexdigest()


def policy_names(sources: Sequence[Source]) -> list[str]:
    """Return short, unique names: of the run for its folder or ``policy.zip``, else of the file or the function."""
    names = [_short_name(Path(item)) if isinstance(item, str | Path) else _called(item) for item in sources]
    return [name if names.count(name) == 1 else f"{name}-{names[:i].count(name) + 1}" for i, name in enumerate(names)]


def _short_name(path: Path) -> str:
    if path.name == POLICY and path.parent.name:
        path = path.parent
    return path.stem if path.suffix in (".zip", SUFFIX) else path.name


def _called(source: object) -> str:
    """Return the name of a function, or of the class of a model or policy in lower case."""
    return str(getattr(source, "__name__", type(source).__name__.lower()))


def _trained_perception(policy: str | Path) -> Perception | None:
    """Return the perception of a policy's training; None for a file outside a run's folder.

    It is read from the run's copy of its scenario and task. If this fails, an ``UnknownPerceptionWarning`` gives the
    reason, and the result is None.

    Args:
        policy: A run's folder, or the file of a policy in it.
    """
    run = RunFolder(folder_of(policy))
    if not run.exists():
        return None
    try:
        return run.perception()
    except IrsimGymError as error:
        text = f"{run.folder}: the observations of its training cannot be read, so its policy uses those of the task"
        warn_caller(f"{text}: {error}", UnknownPerceptionWarning)
        return None
