"""PPO with a memory: what it remembers, where it forgets, what it is worth, and how it is saved."""

from __future__ import annotations

import io
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
import torch
import yaml
from gymnasium.spaces import Box, Discrete
from rich.console import Console
from stable_baselines3.common.buffers import RolloutBuffer
from stable_baselines3.common.vec_env import DummyVecEnv

from irsim_gym import sb3
from irsim_gym.envs.sb3_learning.gru import SequenceBuffer, SequenceTable
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.protocol.protocol import evaluate
from irsim_gym.evaluation.requests.episode_setup import make_episodes
from irsim_gym.evaluation.requests.interruption import TrainingInterruptedError
from irsim_gym.evaluation.saved_policies.cards import read_card
from irsim_gym.evaluation.saved_policies.policies import SavedPolicy, load_policy
from irsim_gym.evaluation.saved_policies.shelf import ShelfPolicy, read_policy
from irsim_gym.training.export.exported_network import export_network
from irsim_gym.training.export.exporting import export
from irsim_gym.training.requests.train import train
from irsim_gym.training.runs.models import new_model
from irsim_gym.training.settings.hyperparameters import Hyperparameters, load_hyperparameters
from irsim_gym.training.settings.run import Run, Settings

QUIET = Console(file=io.StringIO())
GRU: dict[str, Any] = {
    "n_timesteps": 768, "n_envs": 8, "n_steps": 24, "batch_size": 64, "n_epochs": 2, "checkpoint_every": 384,
    "rollout_buffer_kwargs": {"sequence_length": 5}, "policy_kwargs": {"net_arch": [16], "memory_size": 8},
}  # fmt: skip
ROBOT: dict[str, Any] = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.2}}
TWO_ROBOTS: dict[str, Any] = {
    "world": {"width": 10, "height": 10},
    "robot": [{**ROBOT, "state": [2, 5, 0], "goal": [2.05, 5]}, {**ROBOT, "state": [2, 8, 0], "goal": [9, 8]}],
    "task": {"name": "blank", "observations": ["goal"], "rewards": ["arrival"], "endings": ["arrived"]},
}
"""The first robot arrives in its first step, and waits for the other one."""


@pytest.fixture
def task(tmp_path: Path) -> str:
    path = tmp_path / "short.yaml"
    path.write_text(yaml.safe_dump({"name": "navigation", "max_steps": 20}))
    return str(path)


def settings(scenario: str = "cluttered_room", task: str | None = None, **own: Any) -> Settings:
    return Settings(scenario, "gru_ppo", 3, task, Hyperparameters.from_plain({**GRU, **own}))


class Counts(gymnasium.Env[Any, Any]):
    """Pays 1 in each of its five steps; then its time is over (``cut``), or it has ended."""

    observation_space, action_space = Box(0, 1, (1,)), Box(-1, 1, (1,))
    cut = True

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        self.steps = 0
        return np.zeros(1, np.float32), {}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        self.steps += 1
        over = self.steps == 5
        return np.zeros(1, np.float32), 1.0, over and not self.cut, over and self.cut, {}


class Ends(Counts):
    """The same, but it ends by itself."""

    cut = False


class Cue(gymnasium.Env[Any, Any]):
    """Shows -1 or 1 at first and then 0; in its fourth step it pays 1 for the choice that was shown."""

    observation_space, action_space = Box(-1, 1, (1,)), Discrete(2)

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        self.steps, self.cue = 0, int(self.np_random.integers(2))
        return np.array([2 * self.cue - 1], np.float32), {}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        self.steps += 1
        last = self.steps == 4
        return np.zeros(1, np.float32), float(last and action == self.cue), last, False, {}


def worlds(kind: type[gymnasium.Env[Any, Any]], n: int = 16) -> DummyVecEnv:
    env = DummyVecEnv([kind] * n)
    env.seed(0)
    return env


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "wanted"),
    [
        (Counts, [2.0, 2.0, 2.0, 2.0, 2.0]),  # 1 / (1 - 0.5): the time limit is no end
        (Ends, [1.9375, 1.875, 1.75, 1.5, 1.0]),  # (1 - 0.5^k) / (1 - 0.5), k steps before the end
    ],
)
def test_values_are_those_of_episodes_that_go_on_or_end(kind: Any, wanted: list[float]) -> None:
    """All observations are alike: how far an episode is, the critic knows by its memory alone."""
    options = {"gamma": 0.5, "n_steps": 30, "batch_size": 240, "n_epochs": 8, "learning_rate": 1e-2, "seed": 0}
    short = {"rollout_buffer_kwargs": {"sequence_length": 5}, "policy_kwargs": {"memory_size": 16}}
    model = sb3.GruPPO("MlpGruPolicy", worlds(kind, 8), **options, **short)
    model.learn(8 * 30 * 25)
    memory, starts, found = model.policy.first_memory(1), torch.ones(1), []
    with torch.no_grad():
        for _ in range(5):
            _, value, _, memory = model.policy(torch.zeros(1, 1), memory, starts)
            found.append(value.item())
            starts = torch.zeros(1)
    np.testing.assert_allclose(found, wanted, atol=0.2)


@pytest.mark.slow
def test_it_remembers_what_it_has_seen_over_the_ends_of_sequences() -> None:
    """Sequences are of six steps, episodes of four: most of the latter lie in two of the former.

    With twice this learning rate, one of five seeds learnt nothing.
    """
    options = {"n_steps": 32, "batch_size": 256, "n_epochs": 6, "learning_rate": 5e-3, "gamma": 0.9, "seed": 1}
    short = {"rollout_buffer_kwargs": {"sequence_length": 6}, "policy_kwargs": {"memory_size": 16}}
    model = sb3.GruPPO("MlpGruPolicy", worlds(Cue, 16), **options, **short)
    model.learn(16 * 32 * 25)
    env = worlds(Cue, 64)
    seen, state, starts, paid = env.reset(), None, np.ones(64), 0.0
    for _ in range(4):
        actions, state = model.predict(seen, state, starts, deterministic=True)
        seen, rewards, starts, _ = env.step(actions)
        paid += rewards.sum()
    assert paid >= 62  # a policy without memory: 32


def test_minibatches_are_of_about_the_same_size_and_each_row_is_in_one() -> None:
    """Five sequences of two rows, three minibatches: the sequences end after 2, 4, 6, .. of 10 rows, cut at 10 / 3."""
    sequences = SequenceTable(np.arange(0, 10, 2), np.full(5, 2), np.arange(5.0)[:, None])
    parts = list(sequences.shuffled(4))
    assert [running.tolist() for _, running, _ in parts] == [[1, 1], [2, 2], [2, 2]]
    assert sorted(np.concatenate([rows for rows, _, _ in parts]).tolist()) == list(range(10))
    for rows, running, memories in parts:
        first, second = rows[: running[0]], rows[running[0] :]
        assert second.tolist() == (first + 1).tolist()
        assert memories[:, 0].tolist() == (first / 2).tolist()
    assert [len(rows) for rows, _, _ in sequences.shuffled(None)] == [10]


def test_a_sequence_that_ends_where_a_minibatch_is_full_belongs_to_it() -> None:
    sequences = SequenceTable(np.arange(0, 96, 16), np.full(6, 16), np.zeros((6, 1)))
    assert [len(rows) for rows, _, _ in sequences.shuffled(32)] == [32, 32, 32]


@pytest.mark.parametrize("waits", [False, True])
def test_sequences_give_what_was_computed_step_by_step(waits: bool) -> None:
    """With unchanged weights values and probabilities are the same, over episodes, sequences and rows that wait."""
    if waits:
        env: Any = sb3.make_multi_agent_vec_env(TWO_ROBOTS, 6, seed=0, max_steps=15)
    else:
        env = sb3.make_vec_env("cluttered_room", 12, seed=0, max_steps=15)
    options = {"n_steps": 40, "batch_size": 96, "seed": 0, "policy_kwargs": {"memory_size": 8}}
    model = sb3.GruPPO("MlpGruPolicy", env, **options, rollout_buffer_kwargs={"sequence_length": 6})
    torch.nn.init.uniform_(model.policy.memory.weight_hh_l0, -1.0, 1.0)
    torch.nn.init.uniform_(model.policy.action_net.weight, -1.0, 1.0)
    model._setup_learn(480)
    buffer, callback = model.rollout_buffer, model._init_callback(None)
    for _ in range(2):  # the second one begins in the midst of episodes
        assert model.collect_rollouts(env, callback, buffer, 40)
    acted, starts = buffer.acted.copy(), buffer.episode_starts.copy()
    rows = 0
    for part in buffer.get(96):
        with torch.no_grad():
            values, log_prob, _ = model.policy.evaluate_actions(part.observations, part.actions)
        np.testing.assert_allclose(values[:, 0], part.old_values, atol=2e-6)
        np.testing.assert_allclose(log_prob, part.old_log_prob, atol=2e-5)
        rows += len(values)
        assert len(part.observations.running) <= 6
    assert rows == acted.sum()
    assert acted.all() == (not waits)
    assert starts[1:].any()


def test_a_cut_episode_is_worth_what_would_have_followed() -> None:
    """Its last reward is 1 and, times gamma, the value of the last observation after all that came before it."""
    model = sb3.GruPPO("MlpGruPolicy", worlds(Counts, 3), n_steps=8, batch_size=24, gamma=0.9, seed=0)
    torch.nn.init.constant_(model.policy.value_net.bias, 3.0)
    model._setup_learn(24)
    buffer = model.rollout_buffer
    assert model.collect_rollouts(model.get_env(), model._init_callback(None), buffer, 8)
    memory = model.policy.first_memory(3)
    with torch.no_grad():
        for step in range(6):
            _, values, _, memory = model.policy(torch.zeros(3, 1), memory, torch.full((3,), float(step == 0)))
    wanted = np.ones((8, 3))
    wanted[4] += 0.9 * values[:, 0].numpy()  # of the sixth observation
    np.testing.assert_allclose(buffer.rewards, wanted, atol=1e-5)
    assert buffer.episode_starts[:, 0].tolist() == [1, 0, 0, 0, 0, 1, 0, 0]


def test_minibatches_hold_each_row_once() -> None:
    """Two slots of five steps; the first begins an episode at step 2, the second waits at steps 1 and 2."""
    buffer = SequenceBuffer(5, Box(-1, 1, (1,)), Box(-1, 1, (1,)), "cpu", n_envs=2, sequence_length=2)
    begins = np.array([[1, 1], [0, 0], [1, 0], [0, 1], [0, 0]], np.float32)
    acts = np.array([[1, 1], [1, 0], [1, 0], [1, 1], [1, 1]], bool)
    for step in range(5):
        told = np.array([[step], [10 + step]], np.float32)
        row = told, told, told[:, 0], begins[step], torch.as_tensor(told[:, 0]), torch.as_tensor(told[:, 0])
        buffer.add(*row, memory=torch.as_tensor(told[None] + 0.5), acted=acts[step])
    parts = [part.observations for part in buffer.get(None)]
    assert len(parts) == 1
    # sequences: 0 1 | 2 3 | 4 (after two steps) and 10 | 13 (it has waited) | 14
    assert parts[0].running.tolist() == [6, 2]
    first = parts[0].observations[: parts[0].running[0], 0].tolist()
    assert sorted(first) == [0.0, 2.0, 4.0, 10.0, 13.0, 14.0]
    remembered = dict(zip(first, parts[0].memory[0, :, 0].tolist(), strict=True))
    assert remembered == {0.0: 0.0, 2.0: 0.0, 4.0: 4.5, 10.0: 0.0, 13.0: 0.0, 14.0: 14.5}
    later = parts[0].observations[parts[0].running[0] :, 0].tolist()
    assert [int(one) for one in first[:2]] in ([0, 2], [2, 0])
    assert later == [one + 1.0 for one in first[:2]]


def test_a_sequence_ends_with_its_slot() -> None:
    """Two slots; the second waits in the first step and begins no episode: its rows do not go on those of the first."""
    buffer = SequenceBuffer(3, Box(-1, 1, (1,)), Box(-1, 1, (1,)), "cpu", n_envs=2, sequence_length=8)
    for step in range(3):
        told = np.array([[step], [10 + step]], np.float32)
        begins = np.array([step == 0, False], np.float32)
        row = told, told, told[:, 0], begins, torch.as_tensor(told[:, 0]), torch.as_tensor(told[:, 0])
        buffer.add(*row, memory=torch.as_tensor(told[None] + 0.5), acted=np.array([True, step > 0]))
    (part,) = [part.observations for part in buffer.get(None)]
    assert part.running.tolist() == [2, 2, 1]  # 0 1 2 and 11 12
    first = part.observations[:2, 0].tolist()
    assert dict(zip(first, part.memory[0, :, 0].tolist(), strict=True)) == {0.0: 0.0, 11.0: 11.5}


@pytest.mark.parametrize("batch_size", [None, 4])
def test_a_rollout_in_which_nobody_acted_has_no_minibatches(batch_size: int | None) -> None:
    buffer = SequenceBuffer(2, Box(-1, 1, (1,)), Box(-1, 1, (1,)), "cpu", n_envs=3)
    for _ in range(2):
        column, told = np.zeros((3, 1), np.float32), torch.zeros(3)
        nobody = np.zeros(3, np.bool_)
        buffer.add(column, column, column[:, 0], column[:, 0], told, told, memory=torch.zeros(1, 3, 4), acted=nobody)
    assert list(buffer.get(batch_size)) == []


@pytest.mark.parametrize(
    ("scenario", "own"),
    [
        ("cluttered_room", {}),
        ("cluttered_room", {"normalize": True}),
        ("random_swap", {"team": "episode", "normalize": True}),
    ],
)
def test_a_resumed_run_equals_an_uninterrupted_one(
    scenario: str, own: dict[str, Any], tmp_path: Path, interrupt: Callable[[int, int], None]
) -> None:
    asked = settings(scenario, **own)
    whole = train(asked, tmp_path / "whole", console=QUIET)
    assert torch.equal(weights(whole), weights(in_parts(asked, tmp_path / "parts", interrupt)))


def in_parts(asked: Settings, folder: Path, interrupt: Callable[[int, int], None]) -> Run:
    """Train with an interruption, after which PyTorch's generator is in another state."""
    interrupt(300, signal.SIGINT)
    with pytest.raises(TrainingInterruptedError):
        train(asked, folder, console=QUIET)
    torch.manual_seed(99)
    return train(asked, folder, resume=True, console=QUIET)


def weights(run: Run) -> torch.Tensor:
    model: Any = load_policy(run.policy).model  # type: ignore[union-attr]
    return torch.cat([value.flatten() for value in model.policy.state_dict().values()])


@pytest.mark.parametrize("own", [{}, {"normalize": True}])
def test_it_drives_from_its_run_and_from_the_shelf(own: dict[str, Any], task: str, tmp_path: Path) -> None:
    """The shelf's network remembers as PyTorch's does."""
    run = train(settings(task=task, **own), tmp_path / "run", console=QUIET)
    policy = load_policy(run.folder)
    assert isinstance(policy, SavedPolicy)
    model: Any = policy.model
    for name, part in model.policy.named_parameters():
        if "vf" in name or "value" in name:
            part.data.fill_(np.nan)
        else:
            part.data.uniform_(-0.4, 0.4)
    exported = export_network(model, policy.normalization)
    shelf = SavedPolicy(ShelfPolicy(exported.form, exported.arrays))
    assert any(line.startswith("memory: gru 8") for line in exported.layers)
    episodes = make_episodes("cluttered_room", n_worlds=6)
    levels = np.arange(6)
    episodes.begin(levels, levels, "dev")
    for one in (policy, shelf):
        one.begin(episodes, levels, levels)
    for _ in range(30):
        actions = policy.act(episodes, levels)
        np.testing.assert_allclose(shelf.act(episodes, levels), actions, atol=2e-5)
        episodes.step(actions[:, None])
    few = evaluate(policy, make_episodes("cluttered_room", n_worlds=3), 9, "dev")
    many = evaluate(policy, make_episodes("cluttered_room", n_worlds=9), 9, "dev")
    assert str(few) == str(many)  # whatever other worlds there are, and whatever they remembered


def test_the_shelf_forgets_where_an_episode_begins() -> None:
    model = new_model(settings())
    exported = export_network(model, None)
    shelf = ShelfPolicy(exported.form, exported.arrays)
    seen = np.random.default_rng(0).uniform(-1, 1, (2, 88)).astype(np.float32)
    first, state = shelf.predict(seen)
    again, kept = shelf.predict(seen, state, np.array([True, False]))
    assert state is not None
    assert kept is not None
    np.testing.assert_array_equal(again[0], first[0])
    np.testing.assert_array_equal(kept[0][0, 0], state[0][0, 0])
    assert (kept[0][0, 1] != state[0][0, 1]).any()


def test_shipped_hyperparameters_and_what_they_may_say(tmp_path: Path) -> None:
    shipped = load_hyperparameters("gru_ppo", "irsim_gym/cluttered_room-v0")
    assert shipped.arguments["policy_kwargs"]["memory_size"] == 64
    for wrong, told in (("memory_sise: 3", "did you mean 'memory_size'"), ("memory_size: 0", ">= 1")):
        file = tmp_path / "gru.yaml"
        file.write_text(f"default: {{n_timesteps: 100, n_envs: 2, policy_kwargs: {{{wrong}}}}}")
        with pytest.raises(IrsimGymError, match=told):
            load_hyperparameters("gru_ppo", "irsim_gym/cluttered_room-v0", file=file)


class OwnBuffer(SequenceBuffer):
    """A buffer of somebody else."""


@pytest.mark.parametrize(
    ("asked", "used"), [(None, SequenceBuffer), (OwnBuffer, OwnBuffer), (RolloutBuffer, SequenceBuffer)]
)
def test_a_buffer_of_sequences_may_be_replaced_by_one_derived_from_it(asked: Any, used: Any) -> None:
    model = sb3.GruPPO("MlpGruPolicy", worlds(Cue, 2), n_steps=4, batch_size=8, rollout_buffer_class=asked)
    assert type(model.rollout_buffer) is used


@pytest.mark.parametrize("length", [0, 2.5])
def test_a_sequence_has_a_whole_number_of_steps(length: float) -> None:
    with pytest.raises(IrsimGymError, match=f"sequence_length must be an integer >= 1, got {length}"):
        new_model(settings(rollout_buffer_kwargs={"sequence_length": length}))


def test_actor_and_critic_may_share_the_extractor() -> None:
    for shared in (True, False):
        kwargs = {**GRU["policy_kwargs"], "share_features_extractor": shared}
        assert new_model(settings(policy_kwargs=kwargs)).policy.share_features_extractor is shared


def test_a_run_becomes_a_file_of_the_shelf(task: str, tmp_path: Path) -> None:
    """What is read back from the file drives as the run does; the card says what it remembers with."""
    run = train(settings(task=task), tmp_path / "run", console=QUIET)
    file = export(run.folder, "remembers", tmp_path / "shelf", levels=4)
    shelf, card = read_policy(file), read_card(file)
    assert shelf.memory_shape == (1, 1, 8)
    assert card is not None
    assert "memory: gru 8" in card.network.layers
    assert card.network.weights == 8 * 3 * (88 + 8 + 2) + 17 * 2 + (96 + 1) * 16
    rows = [
        evaluate(policy, make_episodes("cluttered_room", n_worlds=4), 4, "dev")
        for policy in (load_policy(run.folder), load_policy(file))
    ]
    assert [one.outcome for one in rows[0]] == [one.outcome for one in rows[1]]
