"""From fragments to the batches that RLlib's learners take, without a copy for each row."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from ray.rllib.algorithms.appo.torch.appo_torch_learner import APPOTorchLearner
from ray.rllib.algorithms.ppo.torch.ppo_torch_learner import PPOTorchLearner
from ray.rllib.core import DEFAULT_MODULE_ID
from ray.rllib.core.columns import Columns
from ray.rllib.core.learner.training_data import TrainingData
from ray.rllib.evaluation.postprocessing import Postprocessing
from ray.rllib.policy.sample_batch import MultiAgentBatch, SampleBatch

from irsim_gym.envs.parts.observations import on_each
from irsim_gym.envs.parts.spaces import Observation
from irsim_gym.envs.rllib.fragments import Fragment, advantages, joined


class ArrayPPOLearner(PPOTorchLearner):  # type: ignore[misc]
    """RLlib's PPO learner, for fragments in place of episodes."""

    def configure_optimizers_for_module(self, module_id: str, config: Any = None) -> None:
        """Make Adam with the arguments under ``optimizer`` in ``learner_config_dict``.

        Args:
            module_id: Name of the module.
            config: Ignored; RLlib passes it.
        """
        _make_adam(self, module_id)

    def update(self, training_data: TrainingData, **kwargs: Any) -> Any:
        """Compute advantages of fragments and update the networks.

        Args:
            training_data: Fragments, in place of episodes, or a batch.
            **kwargs: Passed on to RLlib's learner.

        Returns:
            What RLlib's learner returns.
        """
        training_data.solve_refs()
        if training_data.episodes is not None:
            module = self.module[DEFAULT_MODULE_ID].unwrapped()
            batch = advantage_batch(module, training_data.episodes, self.config.gamma, self.config.lambda_)
            training_data = TrainingData(batch=batch)
        return super().update(training_data=training_data, **kwargs)


class ArrayAPPOLearner(APPOTorchLearner):  # type: ignore[misc]
    """RLlib's APPO learner, for fragments in place of episodes."""

    def configure_optimizers_for_module(self, module_id: str, config: Any = None) -> None:
        """Make Adam with the arguments under ``optimizer`` in ``learner_config_dict``.

        Args:
            module_id: Name of the module.
            config: Ignored; RLlib passes it.
        """
        _make_adam(self, module_id)

    def update(self, training_data: TrainingData, **kwargs: Any) -> Any:
        """Pass fragments to the thread that updates the networks.

        Args:
            training_data: Fragments, in place of episodes, or a batch.
            **kwargs: Passed on to RLlib's learner.

        Returns:
            What RLlib's learner returns.
        """
        training_data.solve_refs()
        if training_data.episodes is not None:
            module = self.module[DEFAULT_MODULE_ID].unwrapped()
            training_data = TrainingData(batch=sequence_batch(module, training_data.episodes, self.config.gamma))
        return super().update(training_data=training_data, **kwargs)


def _make_adam(learner: Any, module_id: str) -> None:
    params = learner.get_parameters(learner.module[module_id])
    optimizer = torch.optim.Adam(params, **learner.config.learner_config_dict.get("optimizer", {}))
    learner.register_optimizer(
        module_id=module_id, optimizer=optimizer, params=params, lr_or_lr_schedule=learner.config.lr
    )


def advantage_batch(module: Any, fragments: Sequence[Fragment], gamma: float, lambda_: float) -> MultiAgentBatch:
    """Return what PPO learns from: rows, their advantages over the deviation of all, and the targets of their values.

    Args:
        module: Whose ``compute_values`` knows what a state is worth.
        lambda_: See ``fragments.advantages``.
    """
    fragment, device = joined(fragments), _device(module)
    seen = _tensors(fragment.observation, device)
    with torch.no_grad():
        values = _values(module, seen)
        after = _values(module, _tensors(fragment.following, device))
    found = advantages(fragment, values, after, gamma=gamma, lambda_=lambda_)
    scaled = (found - found.mean()) / max(1e-4, found.std())
    columns = {
        Columns.ACTIONS: fragment.action,
        Columns.ACTION_LOGP: fragment.log_probability,
        Columns.ACTION_DIST_INPUTS: fragment.distribution,
        Postprocessing.ADVANTAGES: scaled.astype(np.float32),
        Postprocessing.VALUE_TARGETS: (found + values).astype(np.float32),
    }
    return _batch(seen, columns, len(fragment), device)


def sequence_batch(module: Any, fragments: Sequence[Fragment], gamma: float) -> MultiAgentBatch:
    """Return what APPO learns from: rows in their order; after a cut nothing follows but what its reward already holds.

    The value of what follows a cut is added to the reward there, because the V-trace of RLlib takes it away again from
    rows that are appended for it.

    Args:
        module: Whose ``compute_values`` knows what a state is worth.
    """
    fragment, device = joined(fragments), _device(module)
    reward = fragment.reward.copy()
    with torch.no_grad():
        reward[fragment.cut] += np.float32(gamma) * _values(module, _tensors(fragment.following, device))
    columns = {
        Columns.ACTIONS: fragment.action,
        Columns.ACTION_LOGP: fragment.log_probability,
        Columns.ACTION_DIST_INPUTS: fragment.distribution,
        Columns.REWARDS: reward,
        Columns.TERMINATEDS: fragment.terminated | fragment.cut,
        Columns.LOSS_MASK: np.ones(len(fragment), np.bool_),
    }
    return _batch(_tensors(fragment.observation, device), columns, len(fragment), device)


def _batch(seen: Any, columns: dict[str, NDArray[Any]], n_steps: int, device: torch.device) -> MultiAgentBatch:
    tensors = {name: _tensor(array, device) for name, array in columns.items()}
    return MultiAgentBatch({DEFAULT_MODULE_ID: SampleBatch({Columns.OBS: seen, **tensors})}, env_steps=n_steps)


def _device(module: Any) -> torch.device:
    found: torch.device = next(module.parameters()).device
    return found


def _tensors(observation: Observation, device: torch.device) -> Any:
    return on_each(observation, lambda array: _tensor(array, device))


def _tensor(array: NDArray[Any], device: torch.device) -> torch.Tensor:
    """Return an array as a tensor; one that Ray has sent is read-only, which PyTorch does not take."""
    return torch.from_numpy(array if array.flags.writeable else array.copy()).to(device)


def _values(module: Any, seen: Any) -> NDArray[Any]:
    values: NDArray[Any] = module.compute_values({Columns.OBS: seen}).cpu().numpy()
    return values
