"""Checkpoints: all that a run needs to continue as if it had never stopped.

A checkpoint is a folder named after its number of steps. It is written under a temporary name and renamed, so a folder
with the final name is always complete. Only the newest keeps the state for resuming. Older ones keep their policy,
which is scored after the training.
"""

import io
import json
import pickle
import random
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm

from irsim_gym.base.outside_files import reading, remove, writing
from irsim_gym.evaluation.protocol.tables import plain, write_bytes
from irsim_gym.evaluation.saved_policies import checkpoint_files as stored
from irsim_gym.training.runs.environment import worlds_state

EPISODE_STATE = ("_last_obs", "_last_original_obs", "_last_episode_starts", "ep_info_buffer", "ep_success_buffer")
"""Attributes of a model that belong to the current episodes, which a policy does not need."""
MEMORY = "last_memory"
"""Attribute of a model that holds the memory of its policy."""


def save_checkpoint(folder: Path, model: BaseAlgorithm, progress: stored.RunProgress) -> Path:
    """Write a checkpoint into ``folder`` and return its own folder."""
    return write_checkpoint(folder, model, progress, _state(model))


def write_checkpoint(
    folder: Path, model: BaseAlgorithm, progress: stored.RunProgress, state: Mapping[str, Any]
) -> Path:
    """Write a checkpoint into ``folder`` and return its own folder.

    Args:
        model: Model whose policy, normalisation and replay buffer are saved.
        state: Further state for resuming.
    """
    target = folder / f"{progress.steps:010d}"
    partial = folder / f"{stored.PARTIAL}-{target.name}"
    remove(partial)
    partial.mkdir(parents=True)
    try:
        with writing(target):
            _write_parts(partial, model, progress, state)
    except BaseException:
        remove(partial)
        raise
    remove(target)
    partial.rename(target)
    for older in stored.list_checkpoints(folder):
        if older != target:
            stored.remove_state(older)
    return target


def _write_parts(partial: Path, model: BaseAlgorithm, progress: stored.RunProgress, state: Mapping[str, Any]) -> None:
    """Write the files of a checkpoint.

    Raises:
        OSError: The disk is full. A model is written in memory first: PyTorch has another error for that.
    """
    content = io.BytesIO()
    model.save(content)
    (partial / stored.POLICY).write_bytes(content.getbuffer())
    normalization = model.get_vec_normalize_env()
    if normalization is not None:
        normalization.save(str(partial / stored.NORMALIZATION))
    if isinstance(model, OffPolicyAlgorithm):
        model.save_replay_buffer(partial / stored.REPLAY_BUFFER)
    (partial / stored.STATE).write_bytes(pickle.dumps(dict(state)))
    (partial / stored.PROGRESS).write_text(json.dumps(plain(vars(progress))), encoding="utf-8")


def export_policy(path: Path, model: BaseAlgorithm) -> None:
    """Write the policy without optimiser state, a third of a checkpoint's size. Clears the optimisers of ``model``."""
    parts = [model, model.policy, *(getattr(model, name, None) for name in ("actor", "critic"))]
    for part in parts:
        for name in ("optimizer", "ent_coef_optimizer"):
            optimizer = getattr(part, name, None)
            if optimizer is not None:
                optimizer.state.clear()
    content = io.BytesIO()
    model.save(content, exclude=EPISODE_STATE)
    write_bytes(path, content.getvalue())


def load_state(checkpoint: Path) -> dict[str, Any]:
    """Read the state of worlds and random generators. It is a pickle: open only files that you trust.

    Raises:
        UnreadableFileError: It is damaged, or another version has written it.
    """
    with reading(checkpoint / stored.STATE, "state that this version can resume"):
        state: dict[str, Any] = pickle.loads((checkpoint / stored.STATE).read_bytes())
        if not isinstance(state, dict):
            raise TypeError(f"got {type(state).__name__}")
    return state


def restore_random(model: BaseAlgorithm, state: dict[str, Any]) -> None:
    """Restore the state of all random generators."""
    saved = state["random"]
    random.setstate(saved["python"])
    np.random.set_state(saved["numpy"])  # noqa: NPY002  (Stable-Baselines3 shuffles with the global generator)
    torch.set_rng_state(saved["torch"])
    if saved.get("cuda") is not None and torch.cuda.device_count() == len(saved["cuda"]):
        torch.cuda.set_rng_state_all(saved["cuda"])
    model.action_space.np_random.bit_generator.state = saved["actions"]


def restore_memories(model: BaseAlgorithm, state: dict[str, Any]) -> None:
    """Restore a recurrent policy's memory of the current episodes."""
    if state.get("memories") is not None:
        setattr(model, MEMORY, _to_device(state["memories"], model.device))


def _state(model: BaseAlgorithm) -> dict[str, Any]:
    env = model.get_env()
    assert env is not None, "a model in training has an environment"
    return {
        "worlds": worlds_state(env),
        "memories": _to_device(getattr(model, MEMORY, None), torch.device("cpu")),
        "random": {
            "python": random.getstate(),
            "numpy": np.random.get_state(),  # noqa: NPY002
            "torch": torch.get_rng_state(),
            "cuda": torch.cuda.get_rng_state_all() if torch.cuda.is_available() else None,
            "actions": model.action_space.np_random.bit_generator.state,
        },
    }


def _to_device(value: object, device: torch.device) -> Any:
    """Move tensors, also those inside (named) tuples, to a device. On the CPU, any machine can read them."""
    if isinstance(value, torch.Tensor):
        return value.to(device)
    if isinstance(value, tuple):
        parts = [_to_device(part, device) for part in value]
        return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
    return value
