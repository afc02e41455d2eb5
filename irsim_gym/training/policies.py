"""Saved policies as what the evaluation drives worlds with."""

from __future__ import annotations

import json
import pickle
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.vec_env import VecNormalize

from irsim_gym.arraytypes import Ints
from irsim_gym.envs.spaces import observation_layout
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.policy import Policy
from irsim_gym.evaluation.reference_policies import REFERENCES, reference_policy
from irsim_gym.tasks import Episodes
from irsim_gym.training.checkpoint import NORMALIZATION, POLICY, newest_checkpoint
from irsim_gym.training.run import Run

CHUNK = 64
"""Rows of one pass through the network: always as many, since sums may be rounded otherwise in another size."""


class SavedPolicy:
    """A trained policy, deterministic.

    Args:
        model: The loaded algorithm.
        normalization: Statistics of the observations it was trained with.
    """

    def __init__(self, model: BaseAlgorithm, normalization: VecNormalize | None = None) -> None:
        self.model, self.normalization = model, normalization

    def begin(self, episodes: Episodes, worlds: Ints, levels: Ints) -> None:
        """Do nothing: the policy has no memory."""

    def act(self, episodes: Episodes, worlds: Ints) -> NDArray[Any]:
        """Return the actions of worlds, the same whatever other worlds there are."""
        observation = episodes.view.observation[worlds, 0]
        chunks = [self._chunk(episodes, observation[i : i + CHUNK]) for i in range(0, len(observation), CHUNK)]
        return np.concatenate(chunks)

    def _chunk(self, episodes: Episodes, observation: NDArray[np.float32]) -> NDArray[Any]:
        padded = np.zeros((CHUNK, observation.shape[1]), np.float32)
        padded[: len(observation)] = observation
        seen: Any = observation_layout(episodes).fresh(padded)
        if self.normalization is not None:
            seen = self.normalization.normalize_obs(seen)
        return self.model.predict(seen, deterministic=True)[0][: len(observation)]


def load_policy(source: str | Path) -> Policy:
    """Load what drives: a reference policy by name, a file ``policy.zip``, or a run's folder.

    A run that is not finished gives its newest checkpoint.

    Raises:
        IrsimGymError: There is no such policy.
    """
    if str(source) in REFERENCES:
        return reference_policy(str(source))
    path = Path(source)
    if path.is_dir():
        newest = newest_checkpoint(Run(path).checkpoints)
        path = path / POLICY if (path / POLICY).is_file() or newest is None else newest / POLICY
    if not path.is_file():
        raise IrsimGymError(f"no policy at {source}; give a .zip, a run's folder, or one of {', '.join(REFERENCES)}")
    model = _algorithm(path).load(path, device="cpu")
    return SavedPolicy(model, _normalization(path.parent / NORMALIZATION))


def policy_names(sources: Sequence[str | Path]) -> list[str]:
    """Return short names, all different: the run's for its folder or ``policy.zip``, else the file's."""
    names = [_short_name(Path(source)) for source in sources]
    return [name if names.count(name) == 1 else f"{name}-{names[:i].count(name) + 1}" for i, name in enumerate(names)]


def _short_name(path: Path) -> str:
    if path.name == POLICY and path.parent.name:
        path = path.parent
    return path.stem if path.suffix == ".zip" else path.name


def _algorithm(path: Path) -> type[BaseAlgorithm]:
    """Find out from the file which algorithm wrote it."""
    try:
        with zipfile.ZipFile(path) as archive:
            data = json.loads(archive.read("data"))
    except (OSError, KeyError, ValueError, zipfile.BadZipFile) as error:
        raise IrsimGymError(f"{path} is no policy of Stable-Baselines3: {error}") from error
    return SAC if "sac" in str(data["policy_class"].get("__module__", "")) else PPO


def _normalization(path: Path) -> VecNormalize | None:
    if not path.is_file():
        return None
    loaded: VecNormalize = pickle.loads(path.read_bytes())
    loaded.training = False
    return loaded
