"""Demonstrations in files: what is in them, going on with them, and learning from them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gymnasium.spaces import Box, Dict, Discrete, MultiBinary

import irsim_gym
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.comparison.demonstrations import DemonstrationError, describe_space
from irsim_gym.evaluation.comparison.recorder import RecordedStep, Recorder
from irsim_gym.tasks import Outcome

ROBOT = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.2}, "state": [1, 5, 0]}
SCENARIO: dict[str, Any] = {
    "world": {"name": "lane", "step_time": 0.5},
    "robot": [{**ROBOT, "goal": [4, 5], "goal_threshold": 0.3}],
    "task": {"max_steps": 20},
}


def test_a_policy_demonstrates(tmp_path: Path) -> None:
    """Dash drives 3 m at 0.5 m a step, until it is nearer than 0.3 m: six steps a level, full speed ahead."""
    file = tmp_path / "new" / "dash.npz"
    found = irsim_gym.record_demonstrations(SCENARIO, "dash", file, levels=3)
    assert (found.n_episodes, len(found)) == (3, 18)
    assert found.levels.tolist() == [0, 1, 2]
    assert found.outcomes.tolist() == [Outcome.SUCCESS] * 3
    assert np.flatnonzero(found.episode_starts).tolist() == [0, 6, 12]
    assert np.flatnonzero(found.terminations).tolist() == [5, 11, 17]
    assert not found.truncations.any()
    assert not found.by_hand.any()
    assert found.actions.dtype == np.float32
    assert np.allclose(found.actions, [1.0, 0.0])
    assert list(file.parent.iterdir()) == [file]


def test_the_steps_are_those_of_the_environment(tmp_path: Path) -> None:
    found = irsim_gym.record_demonstrations(SCENARIO, "dash", tmp_path / "a.npz", levels=[4], split="dev")
    env = irsim_gym.make(SCENARIO)
    seen, _ = env.reset(options={"split": "dev", "level": 4})
    for i in range(len(found)):
        assert np.array_equal(found.observations[i], seen)
        seen, reward, terminated, truncated, _ = env.step(found.actions[i])
        assert (found.rewards[i], found.terminations[i], found.truncations[i]) == (reward, terminated, truncated)
        assert np.array_equal(found.next_observations[i], seen)
    assert np.array_equal(found.final_observations, seen[None])
    env.close()


def test_a_file_is_gone_on_with(tmp_path: Path) -> None:
    file = tmp_path / "a.npz"
    first = irsim_gym.record_demonstrations(SCENARIO, "dash", file, levels=1)
    both = irsim_gym.record_demonstrations(SCENARIO, "random", file, levels=[7])
    assert both.levels.tolist() == [0, 7]
    assert np.array_equal(both.observations[: len(first)], first.observations)
    assert both.truncations[-1]  # at random it does not arrive
    other = {**SCENARIO, "world": {"name": "lane", "step_time": 0.2}}
    with pytest.raises(DemonstrationError, match=r"another environment: step_time 0.5 \(now: 0.2\)"):
        irsim_gym.record_demonstrations(other, "dash", file)
    assert irsim_gym.load_demonstrations(file).n_episodes == 2


def test_discrete_actions_and_observations_in_a_dict(tmp_path: Path) -> None:
    task = {"action": "discrete", "observation_form": "dict"}
    found = irsim_gym.record_demonstrations(SCENARIO, "dash", tmp_path / "a.npz", levels=2, task=task)
    assert found.actions.dtype == np.int64
    assert set(found.actions.tolist()) == {12}  # the last of three speeds, the middle one of five turn rates
    assert isinstance(found.observations, dict)
    assert isinstance(found.next_observations, dict)
    for name, rows in found.observations.items():
        assert np.array_equal(found.next_observations[name][0], rows[1])
        assert found.final_observations[name].shape == (2, *rows.shape[1:])
    assert found.about["action_space"] == {"kind": "Discrete", "n": 15}
    assert set(found.about["observation_space"]["spaces"]) == set(found.observations)


def test_an_episode_that_is_left_is_kept_as_cut_off_or_dropped(tmp_path: Path) -> None:
    env = irsim_gym.make(SCENARIO)
    recorder = Recorder(env, tmp_path / "a.npz")
    recorder.save()
    assert not list(tmp_path.iterdir())  # nothing yet
    action = np.array([1.0, 0.0], np.float32)
    for level in (0, 1, 2):
        seen, _ = env.reset(options={"split": "train", "level": level})
        recorder.begin(seen, level)
        for _ in range(2):
            seen, reward, terminated, truncated, info = env.step(action)
            recorder.add(
                RecordedStep(action, seen, float(reward), terminated, truncated, info["outcome"], by_hand=True)
            )
        if level == 1:
            recorder.discard()
    assert recorder.n_episodes == 2
    recorder.save()
    found = irsim_gym.load_demonstrations(tmp_path / "a.npz")
    assert found.levels.tolist() == [0, 2]
    assert found.outcomes.tolist() == [Outcome.RUNNING] * 2
    assert found.truncations.tolist() == found.ends.tolist() == [False, True, False, True]
    assert found.by_hand.all()
    env.close()


def test_an_interruption_loses_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from irsim_gym.envs.gymnasium.single import WorldEnv

    step, count = WorldEnv.step, iter(range(100))

    def interrupted(self: WorldEnv, action: Any) -> Any:
        if next(count) == 8:
            raise KeyboardInterrupt
        return step(self, action)

    monkeypatch.setattr(WorldEnv, "step", interrupted)
    with pytest.raises(KeyboardInterrupt):
        irsim_gym.record_demonstrations(SCENARIO, "dash", tmp_path / "a.npz", levels=5)
    assert len(irsim_gym.load_demonstrations(tmp_path / "a.npz")) == 8


def test_other_files_are_refused(tmp_path: Path) -> None:
    (tmp_path / "text.npz").write_text("no arrays")
    (tmp_path / "empty.npz").write_text("")
    np.savez(tmp_path / "arrays.npz", actions=np.zeros(3))
    for name in ("text.npz", "arrays.npz"):
        with pytest.raises(DemonstrationError, match="no file of demonstrations"):
            irsim_gym.load_demonstrations(tmp_path / name)
    for name, what in (("text.npz", "it is no .npz file"), ("empty.npz", "it is no .npz file")):
        with pytest.raises(DemonstrationError, match=f"{what}.*creates one that does not exist"):
            irsim_gym.load_demonstrations(tmp_path / name)
    np.savez(tmp_path / "newer.npz", about=np.array('{"format": 99}'))
    with pytest.raises(DemonstrationError, match="format 99, this version reads 1"):
        irsim_gym.load_demonstrations(tmp_path / "newer.npz")
    with pytest.raises(FileNotFoundError):
        irsim_gym.load_demonstrations(tmp_path / "none.npz")
    with pytest.raises(DemonstrationError, match=r"\.npz files, got 'a.csv'"):
        irsim_gym.record_demonstrations(SCENARIO, "dash", tmp_path / "a.csv")
    assert issubclass(DemonstrationError, IrsimGymError)


def test_broken_files_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "whole.npz"
    irsim_gym.record_demonstrations(SCENARIO, "dash", file, levels=1)
    content = file.read_bytes()
    broken = {"cut": content[: len(content) // 2], "changed": content[:400] + bytes(9) + content[409:]}
    for name, part in broken.items():
        (tmp_path / name).write_bytes(part)
    arrays = dict(np.load(file))
    np.savez(tmp_path / "short.npz", **{**arrays, "actions": arrays["actions"][:3]})
    np.savez(tmp_path / "many.npz", **{**arrays, "levels": np.zeros(2, np.int64)})
    for name in (*broken, "short.npz", "many.npz"):
        with pytest.raises(DemonstrationError, match=f"{name} is no file of demonstrations"):
            irsim_gym.load_demonstrations(tmp_path / name)


def test_spaces_as_plain_data() -> None:
    box = Box(np.array([-1.0, -np.inf]), np.array([1.0, 1.0]), dtype=np.float64)
    told = describe_space(Dict({"box": box, "n": Discrete(3), "bits": MultiBinary(2)}))
    bounds = {"low": [-1.0, "-inf"], "high": 1.0}
    assert told["spaces"]["box"] == {"kind": "Box", "shape": [2], "dtype": "float64", **bounds}
    assert told["spaces"]["n"] == {"kind": "Discrete", "n": 3}
    assert told["spaces"]["bits"] == {"kind": "MultiBinary"}


def test_a_policy_of_stable_baselines3_learns_to_imitate(tmp_path: Path) -> None:
    """Behavioural cloning: a policy that saw dash drive to random goals drives to others by itself."""
    import torch
    from stable_baselines3 import PPO

    anywhere = {"name": "random", "range_low": [1, 1, -3.14], "range_high": [9, 9, 3.14]}
    robot = {"kinematics": {"name": "diff"}, "distribution": anywhere, "goal_threshold": 0.4}
    scenario = {"world": {"step_time": 0.3}, "robot": [robot], "task": {"max_steps": 80}}
    shown = irsim_gym.record_demonstrations(scenario, "dash", tmp_path / "a.npz", levels=60).transitions()
    assert set(shown) == {"obs", "acts", "infos", "next_obs", "dones"}
    env = irsim_gym.make(scenario)
    policy = PPO("MlpPolicy", env, n_steps=8, batch_size=8, device="cpu", seed=0).policy
    seen, done = torch.as_tensor(shown["obs"]), torch.as_tensor(shown["acts"])
    optimizer, chosen = torch.optim.Adam(policy.parameters(), lr=3e-3), np.random.default_rng(0)
    for _ in range(300):
        rows = chosen.integers(len(seen), size=256)
        loss = -policy.evaluate_actions(seen[rows], done[rows])[1].mean()
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
    arrived = []
    for level in range(10):
        observation, _ = env.reset(options={"split": "test", "level": level})
        ended = False
        while not ended:
            observation, _, terminated, truncated, info = env.step(policy.predict(observation, deterministic=True)[0])
            ended = terminated or truncated
        arrived.append(info["is_success"])
    assert sum(arrived) >= 8
    env.close()
