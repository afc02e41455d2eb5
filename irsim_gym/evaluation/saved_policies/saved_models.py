"""Loading of Stable-Baselines3 models from files, without running code from them; see ``trusted``."""

import pickle
from pathlib import Path
from typing import Any

from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.vec_env import VecNormalize

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.base.outside_files import reading
from irsim_gym.envs.sb3_learning.memory import GruPolicy
from irsim_gym.evaluation.saved_policies.algorithms import find_algorithm
from irsim_gym.evaluation.saved_policies.checkpoint_files import NORMALIZATION, OFF_POLICY
from irsim_gym.evaluation.saved_policies.trusted import SERIALIZED, harmless_objects, load_pickle, read_data


class NoOptimizer:
    """Stands in for the optimizer of a policy that only acts: making one takes PyTorch more than a second."""

    def __init__(self, *args: Any, **options: Any) -> None:
        pass

    def load_state_dict(self, *args: Any, **options: Any) -> None:
        """Ignore the state of the training."""


def load_model(path: Path) -> tuple[BaseAlgorithm, VecNormalize | None]:
    """Load the model of a file, without its optimizer, and the normalisation from the same folder, if any.

    Raises:
        UnreadableFileError: If a file is damaged, or the first is not a policy of Stable-Baselines3.
    """
    with reading(path, "policy of Stable-Baselines3"):
        objects = harmless_objects(path)
        options = objects.get("policy_kwargs", read_data(path).get("policy_kwargs", {}))
        if SERIALIZED not in options:  # else they are not harmless, and Stable-Baselines3 reads them
            objects["policy_kwargs"] = {**options, "optimizer_class": NoOptimizer}
        model = _algorithm(path, objects.get("policy_class")).load(path, device="cpu", custom_objects=objects)
    statistics = path.parent / NORMALIZATION
    with reading(statistics, "file of statistics of VecNormalize"):
        return model, _normalization(statistics)


def _algorithm(path: Path, policy: object) -> type[BaseAlgorithm]:
    """Return the class of the algorithm that wrote a file.

    Args:
        path: The file.
        policy: The class of its policy; None for a class that is not known to be harmless.
    """
    data = read_data(path)
    module = str(data["policy_class"].get("__module__", ""))
    if policy is GruPolicy:
        return find_algorithm("gru_ppo").load()
    if "recurrent" in module:
        raise IrsimGymError(f"{path}: policies of sb3-contrib's recurrent PPO are not read; take gru_ppo")
    off_policy = next((name for name in OFF_POLICY if f".{name}." in module), None)
    return find_algorithm(off_policy or ("ppo" if "clip_range" in data else "a2c")).load()


def _normalization(path: Path) -> VecNormalize | None:
    if not path.is_file():
        return None
    loaded = load_pickle(path)
    if not isinstance(loaded, VecNormalize):
        raise TypeError(f"got {type(loaded).__name__}")
    loaded.training = False
    return loaded


def frozen(normalization: VecNormalize | None) -> VecNormalize | None:
    """Return a copy of a model's normalisation without its environment, whose statistics no longer change."""
    if normalization is None:
        return None
    copied: VecNormalize = pickle.loads(pickle.dumps(normalization))
    copied.training = False
    return copied
