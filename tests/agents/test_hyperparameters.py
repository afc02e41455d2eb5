from pathlib import Path

import pytest
from torch import nn

from irsim_gym.errors import IrsimGymError
from irsim_gym.training.hyperparameters import ALGORITHMS, Hyperparameters, Linear, load_hyperparameters


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_shipped_files(algorithm: str) -> None:
    found = load_hyperparameters(algorithm, "irsim_gym/nowhere-v0")
    assert found.n_timesteps > found.n_envs > 0
    assert found.torch_threads == 1
    assert Hyperparameters.from_plain(found.to_plain()) == found


def test_entry_is_laid_over_the_default(tmp_path: Path) -> None:
    file = tmp_path / "ppo.yaml"
    file.write_text(
        "default: {n_timesteps: 10, n_envs: 2, gamma: 0.9, learning_rate: lin_3e-3,"
        " policy_kwargs: {activation_fn: relu}}\nirsim_gym/x-v0: {gamma: 0.5, normalize: true}\n"
    )
    default = load_hyperparameters("ppo", "irsim_gym/y-v0", file=file)
    assert default.arguments["gamma"] == 0.9
    assert default.normalize is None
    arguments = default.algorithm_arguments()
    assert arguments["learning_rate"] == Linear(0.003)
    assert arguments["learning_rate"](0.5) == pytest.approx(0.0015)
    assert arguments["learning_rate"](-0.1) == 0.0  # the last rollout goes beyond the end of the run
    assert arguments["policy_kwargs"] == {"activation_fn": nn.ReLU}
    special = load_hyperparameters("ppo", "irsim_gym/x-v0", file=file, overrides={"n_envs": 4})
    assert (special.arguments["gamma"], special.n_envs, special.normalize) == (0.5, 4, {})


def test_mistakes_are_named(tmp_path: Path) -> None:
    with pytest.raises(IrsimGymError, match="did you mean 'ppo'"):
        load_hyperparameters("ppoo", "x")
    with pytest.raises(IrsimGymError, match="cannot read"):
        load_hyperparameters("ppo", "x", file=tmp_path / "none.yaml")
    (tmp_path / "flat.yaml").write_text("gamma: 0.9\n")
    with pytest.raises(IrsimGymError, match="one mapping"):
        load_hyperparameters("ppo", "x", file=tmp_path / "flat.yaml")
    (tmp_path / "empty.yaml").write_text("default: {}\n")
    with pytest.raises(IrsimGymError, match="lack n_envs, n_timesteps"):
        load_hyperparameters("ppo", "x", file=tmp_path / "empty.yaml")
    with pytest.raises(IrsimGymError, match="activation"):
        Hyperparameters(1, 1, arguments={"policy_kwargs": {"activation_fn": "rellu"}}).algorithm_arguments()
