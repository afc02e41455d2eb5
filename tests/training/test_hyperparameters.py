import sys
from pathlib import Path

import pytest
from torch import nn
from torch.cuda import is_available as cuda

from irsim_gym.errors import IrsimGymError, ScenarioError
from irsim_gym.evaluation.saved_policies.algorithms import ALGORITHMS
from irsim_gym.training.requests.training_request import TrainingRequest
from irsim_gym.training.runs.models import resolve_device
from irsim_gym.training.settings.hyperparameters import Hyperparameters, Linear, load_hyperparameters


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


def test_a_file_and_single_changes_are_laid_over_the_shipped_file(tmp_path: Path) -> None:
    file = tmp_path / "ppo.yaml"
    file.write_text("default: {learning_rate: 1e-3}\n")
    shipped = load_hyperparameters("ppo", "irsim_gym/dense_room-v0")
    found = load_hyperparameters("ppo", "irsim_gym/dense_room-v0", file=file)
    assert found.arguments["learning_rate"] == 0.001
    assert found.to_plain() == {**shipped.to_plain(), "learning_rate": 0.001}
    changes = {"learning_rate": "lin_2e-3", "n_envs": "1e2", "policy_kwargs.net_arch": "[8, 8]", "mirror": "true"}
    found = load_hyperparameters("ppo", "irsim_gym/dense_room-v0", file=file, changes=changes)
    policy = {**shipped.arguments["policy_kwargs"], "net_arch": [8, 8]}
    own = {"learning_rate": "lin_2e-3", "n_envs": 100, "policy_kwargs": policy, "mirror": True}
    assert found.to_plain() == {**shipped.to_plain(), **own}


def test_mistakes_in_single_changes_are_told_together() -> None:
    changes = {"learning_rat": "1", "gamma": "2", "n_envs": "many", "policy_kwargs.net_arc": "[8]"}
    with pytest.raises(ScenarioError) as found:
        load_hyperparameters("ppo", "x", changes=changes)
    for said in ("--hp", "did you mean 'learning_rate'", "gamma", "n_envs", "did you mean 'net_arch'"):
        assert said in str(found.value)
    with pytest.raises(ScenarioError, match="gamma: not valid YAML"):
        load_hyperparameters("ppo", "x", changes={"gamma": "a: b: c"})


def test_a_task_in_place_of_the_scenarios_own_may_have_an_entry(tmp_path: Path) -> None:
    file = tmp_path / "ppo.yaml"
    file.write_text(
        "default: {n_timesteps: 10, n_envs: 2, gamma: 0.9}\nirsim_gym/x-v0: {gamma: 0.5, n_envs: 3}\n"
        "irsim_gym/x-v0/careful: {gamma: 0.7}\nirsim_gym/y-v0/careful: {gamma: 0.6}\n"
    )

    def found(environment_id: str, task: str | None) -> tuple[float, int]:
        chosen = load_hyperparameters("ppo", environment_id, task=task, file=file)
        return chosen.arguments["gamma"], chosen.n_envs

    assert found("irsim_gym/x-v0", None) == found("irsim_gym/x-v0", "other") == (0.5, 3)
    assert found("irsim_gym/x-v0", "careful") == (0.7, 3)
    assert found("irsim_gym/y-v0", "careful") == (0.6, 2)


COMPLETE = "default: {n_timesteps: 10, n_envs: 2, "


@pytest.mark.parametrize(
    ("algorithm", "text", "line", "said"),
    [
        ("ppo", COMPLETE + "leaning_rate: 1e-3}", 1, "leaning_rate: unknown key .did you mean 'learning_rate'"),
        ("ppo", "default:\n  n_timesteps: 10\n  n_envs: sixteen", 3, "n_envs: must be a whole number, got 'sixteen'"),
        ("ppo", COMPLETE + "n_steps: 0}", 1, "n_steps: must be >= 1, got 0"),
        ("ppo", COMPLETE + "learning_rate: linear_0.001}", 1, r"got 'linear_0.001' \(did you mean 'lin_0.001'\?\)"),
        ("ppo", COMPLETE + "learning_rate: lin_0}", 1, "must be a number > 0, or lin_<number>"),
        ("ppo", COMPLETE + "gamma: null}", 1, "gamma: must be a number, got nothing"),
        ("ppo", COMPLETE + "buffer_size: 9}", 1, "buffer_size: is a key of sac, td3, tqc, dqn, not of ppo"),
        ("ppo", COMPLETE + "ent_coef: auto}", 1, "ent_coef: must be a number, got 'auto'"),
        ("sac", COMPLETE + "ent_coef: auto_x}", 1, "ent_coef: must be a number, auto or auto_<number>, got 'auto_x'"),
        ("sac", COMPLETE + "train_freq: [1, episode]}", 1, "train_freq: counts episodes with one world only"),
        ("ppo", COMPLETE + "batch_size: 1}", 1, "batch_size: makes minibatches of one row"),
        ("ppo", COMPLETE + "seed: 1}", 1, "seed: is given by --seed"),
        ("ppo", COMPLETE + "gamma: 0.9, gamma: 0.8}", 1, "gamma: given twice"),
        ("ppo", COMPLETE + "device: gpu}", 1, r"device: must be auto, cpu, cuda, .* got 'gpu' \(did you mean 'cuda'"),
        ("ppo", COMPLETE + "normalize: {norm_rewards: true}}", 1, "of VecNormalize .did you mean 'norm_reward'"),
        ("ppo", COMPLETE + "normalize: {norm_obs: 1}}", 1, "normalize.norm_obs: must be true or false, got 1"),
        ("ppo", COMPLETE + "normalize: {clip_obs: 0}}", 1, "normalize.clip_obs: must be a number > 0, got 0"),
        ("ppo", COMPLETE + "policy_kwargs: {net_ach: [8]}}", 1, r"policy_kwargs.net_ach: .*\(did you mean 'net_arch'"),
        ("ppo", COMPLETE + "policy_kwargs: {net_arch: [8, wide]}}", 1, "must be a list of widths of layers"),
        ("ppo", COMPLETE + "policy_kwargs: {activation_fn: rellu}}", 1, "got 'rellu' .did you mean 'relu'"),
        ("ppo", COMPLETE + "policy_kwargs: {optimizer_class: Adam}}", 1, "is a class, which a file cannot hold"),
        ("ppo", COMPLETE + "gamma: 0.9", 1, "not valid YAML"),
        ("ppo", "gamma: 0.9", 1, "gamma: no entry .it belongs below 'default:'"),
        ("ppo", "defualt: {n_envs: 2}", 1, "defualt: no entry .did you mean 'default'"),
        ("ppo", COMPLETE + "}\nirsim_gym/cave-v9: {gamma: 0.9}", 2, "no entry .did you mean 'irsim_gym/cave-v0'"),
        ("ppo", COMPLETE + "}\nirsim_gym/x-v1/own: {gamma: 0.9}", 2, "no entry .did you mean 'irsim_gym/x-v0/own'"),
        ("ppo", "- 1", 1, r"must be a mapping with the entry 'default', got \[1\]"),
    ],
)
def test_mistakes_are_told_with_line_and_key(algorithm: str, text: str, line: int, said: str, tmp_path: Path) -> None:
    file = tmp_path / "own.yaml"
    file.write_text(text)
    with pytest.raises(ScenarioError, match=rf"own\.yaml:{line} .*{said}"):
        load_hyperparameters(algorithm, "irsim_gym/x-v0", file=file)


def test_all_mistakes_are_told_at_once_those_of_other_entries_too(tmp_path: Path) -> None:
    file = tmp_path / "own.yaml"
    file.write_text("default:\n  n_timesteps: 9\n  n_envs: x\n  gama: 1\nirsim_gym/y-v0:\n  batch_size: 0.5\n")
    with pytest.raises(ScenarioError) as found:
        load_hyperparameters("ppo", "irsim_gym/x-v0", file=file)
    assert [problem.line for problem in found.value.problems] == [3, 4, 6]


def test_numbers_that_yaml_takes_for_text(tmp_path: Path) -> None:
    file = tmp_path / "own.yaml"
    file.write_text(
        "default: {n_timesteps: 1e6, n_envs: 2.0, learning_rate: 1e-3, policy_kwargs: {optimizer_kwargs: {eps: 1e-5}}}"
    )
    found = load_hyperparameters("ppo", "irsim_gym/x-v0", file=file)
    assert (found.n_timesteps, found.n_envs, found.arguments["learning_rate"]) == (1_000_000, 2, 0.001)
    assert isinstance(found.n_timesteps, int)
    assert found.arguments["policy_kwargs"]["optimizer_kwargs"]["eps"] == 1e-5


def test_what_there_is_not() -> None:
    with pytest.raises(IrsimGymError, match="did you mean 'ppo'"):
        load_hyperparameters("ppoo", "x")
    with pytest.raises(ScenarioError, match="no such file"):
        load_hyperparameters("ppo", "x", file=Path("none.yaml"))
    with pytest.raises(IrsimGymError, match=r"must be 'episode' or 'respawn', got 'epsode' \(did you mean 'episode'\?"):
        load_hyperparameters("ppo", "x", overrides={"team": "epsode"})
    with pytest.raises(IrsimGymError, match="activation"):
        Hyperparameters(
            n_timesteps=1, n_envs=1, arguments={"policy_kwargs": {"activation_fn": "rellu"}}
        ).algorithm_arguments()
    if not cuda():
        with pytest.raises(IrsimGymError, match=r"device cuda: PyTorch \S+ finds none here"):
            resolve_device("cuda")
    assert resolve_device("cpu") == "cpu"
    assert resolve_device("auto") == ("cuda" if cuda() else "cpu")


def test_networks_for_pictures_look_for_a_graphics_card() -> None:
    assert load_hyperparameters("ppo", "x").device == "cpu"
    assert load_hyperparameters("ppo", "x", images=True).device == "auto"
    assert load_hyperparameters("ppo", "x", images=True, overrides={"device": "cpu"}).device == "cpu"


@pytest.mark.parametrize(
    ("algorithm", "task", "said"),
    [
        ("dqn", None, r"action 'velocity' is continuous: .*--task discrete_navigation.*\(ppo, sac, td3, tqc, a2c"),
        ("sac", "discrete_navigation", r"action 'discrete' is discrete: .*another algorithm \(ppo, dqn, a2c"),
    ],
)
def test_an_algorithm_that_does_not_fit_the_action(algorithm: str, task: str | None, said: str) -> None:
    with pytest.raises(IrsimGymError, match=said):
        TrainingRequest("empty_goal", algorithm, 0, None, task, None).settings()


def test_an_algorithm_that_is_not_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "sb3_contrib", None)
    said = r"the algorithm tqc needs the extra 'contrib' \(sb3_contrib not found\): pip install"
    with pytest.raises(IrsimGymError, match=said):
        load_hyperparameters("tqc", "x")
