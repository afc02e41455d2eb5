"""The ``VecEnv`` of teams: slots, ends, waiting, beginning again, and what Stable-Baselines3 asks of an environment."""

from __future__ import annotations

import pickle
from copy import deepcopy

import gymnasium
import numpy as np
import pytest
from contract_tools import arrays_in, assert_same
from gymnasium.error import ResetNeeded
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import EvalCallback
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import VecFrameStack
from team_tools import ARRIVES, COLLIDES, KNOWN, LIMIT, MEET

from irsim_gym import compile, load_scenario, sb3
from irsim_gym.errors import UnknownNameError
from irsim_gym.tasks import Episodes, Outcome, load_task

pytestmark = pytest.mark.filterwarnings("ignore::irsim_gym.errors.WaitingRobotsWarning")
MODES = pytest.mark.parametrize("respawn", [False, True])


def team(scenario=MEET, n_worlds=3, **kwargs):
    return sb3.make_multi_agent_vec_env(scenario, n_worlds, **{"seed": 5, "render_mode": None, **kwargs})


def drawn(rng, env):
    return rng.uniform(-1, 1, (env.num_envs, 2)).astype(np.float32)


class Alone:
    """One world in ``Episodes``, its agents looked after one by one: what a slot of the batch has to equal."""

    def __init__(self, seed, max_steps):
        scenario = load_scenario(MEET)
        task = load_task(scenario, None, max_steps, team=True)
        self.episodes = Episodes(compile(scenario, 1, agents=task.agents), task)
        self.episodes.begin(np.array([0]), np.array([seed]))
        self.done = [False] * 3
        self.last = [self.now(a) for a in range(3)]
        self.sums = [0.0] * 3

    def now(self, a):
        return self.episodes.view.observation[0, a].copy()

    def step(self, actions):
        waited = list(self.done)
        self.episodes.step(actions[None])
        view, rows = self.episodes.view, []
        for a in range(3):
            if waited[a]:
                rows.append([self.last[a], 0.0, False, {"idle": True}])
                continue
            self.last[a], reward = self.now(a), view.reward[0, a]
            self.sums[a] += reward
            self.done[a] = bool(view.terminated[0, a] or view.truncated[0, a])
            rows.append([self.last[a], reward, self.done[a], self.end(a) if self.done[a] else {}])
        if all(self.done):
            for a in range(3):
                if waited[a]:
                    rows[a][2] = True
                    rows[a][3] = {"idle": True, "terminal_observation": self.last[a], "TimeLimit.truncated": False}
            self.episodes.begin_next(np.array([0]))
            self.done, self.sums = [False] * 3, [0.0] * 3
            for a in range(3):
                self.last[a] = rows[a][0] = self.now(a)
        return rows

    def end(self, a):
        view = self.episodes.view
        info = {name: values[0, a].item() for name, values in view.infos.items()}
        terms = zip(self.episodes.reward_names, view.reward_terms[0, a], strict=True)
        return {
            **info,
            **{f"reward/{name}": paid.item() for name, paid in terms},
            "terminal_observation": self.last[a],
            "TimeLimit.truncated": bool(view.truncated[0, a]),
            "episode": {"r": round(float(self.sums[a]), 6), "l": int(view.infos["steps"][0, a])},
        }


def test_slots_equal_agents_looked_after_one_by_one():
    env = team(max_steps=25)
    alone = [Alone(5 + w, 25) for w in range(3)]
    np.testing.assert_array_equal(env.reset(), [one.last[a] for one in alone for a in range(3)])
    assert [info["level"] for info in env.reset_infos] == [5, 5, 5, 6, 6, 6, 7, 7, 7]
    rng, ends, idle = np.random.default_rng(0), 0, 0
    for _ in range(150):
        actions = drawn(rng, env)
        observations, rewards, dones, infos = env.step(actions)
        rows = [row for w, one in enumerate(alone) for row in one.step(actions[3 * w : 3 * w + 3])]
        for slot, (observation, reward, done, info) in enumerate(rows):
            np.testing.assert_array_equal(observations[slot], observation)
            assert (rewards[slot], dones[slot]) == (np.float32(reward), done)
            infos[slot].get("episode", {}).pop("t", None)
            assert_same(infos[slot], info)
            assert env.acted[slot] != infos[slot].get("idle", False)
            ends += "episode" in info
            idle += "idle" in info
    assert ends > 40
    assert idle > 40
    assert env.idle_share == idle / (150 * 9)


@MODES
def test_each_end_has_its_own_moment_flags_and_statistics(respawn):
    env = team(KNOWN, 2, respawn=respawn)
    env.reset()
    outcomes = (Outcome.SUCCESS, Outcome.COLLISION, Outcome.TIMEOUT)
    lengths = (ARRIVES, COLLIDES, LIMIT)
    for step in range(1, 4 * LIMIT):
        observations, rewards, dones, infos = env.step(np.zeros((6, 2), np.float32))
        restarts = step % LIMIT == 0
        for slot in range(6):
            length, outcome = lengths[slot % 3], outcomes[slot % 3]
            own = step % length == 0 if respawn else step % LIMIT == length % LIMIT
            idle = not respawn and ((step - 1) % LIMIT >= length)
            assert dones[slot] == (own or (restarts and not respawn))
            assert rewards[slot] == (0.0 if idle else -1.0)
            assert infos[slot].get("idle", False) == idle
            assert ("episode" in infos[slot]) == own
            assert ("terminal_observation" in infos[slot]) == dones[slot]
            if own:
                info = infos[slot]
                assert (info["outcome"], info["is_success"]) == (outcome, outcome == Outcome.SUCCESS)
                assert info["TimeLimit.truncated"] == (outcome == Outcome.TIMEOUT)
                assert (info["episode"]["r"], info["episode"]["l"]) == (-float(length), length)
                assert info["reward/time"] == -1.0
            if idle and dones[slot]:
                assert (infos[slot]["TimeLimit.truncated"], "is_success" in infos[slot]) == (False, False)
        assert env.observation_space.contains(observations[0])
    assert (env.idle_share == 0.0) == (respawn)


def test_a_respawned_robot_observes_its_new_start_and_its_end_is_kept():
    env = team(KNOWN, 1, respawn=True, world_steps=1000)
    first = env.reset()
    for _ in range(ARRIVES):
        observations, _, dones, infos = env.step(np.zeros((3, 2), np.float32))
    assert dones.tolist() == [True, False, False]
    np.testing.assert_array_equal(observations[0], first[0])
    assert (infos[0]["terminal_observation"] != first[0]).any()
    assert infos[0]["goal_distance"] == pytest.approx(0.2)
    assert 0.0 <= infos[0]["episode"]["t"] < 3600.0
    assert env.reset_infos[0]["goal_distance"] == pytest.approx(1.0)
    assert env.env_method("info", indices=[0, 1])[0]["steps"] == 0
    assert env.env_method("info", indices=[0, 1])[1]["steps"] == ARRIVES


def test_respawning_worlds_begin_the_next_level_now_and_then():
    env = team(respawn=True, max_steps=20, world_steps=30)
    env.reset()
    rng = np.random.default_rng(0)
    levels = set()
    for step in range(1, 121):
        _, _, dones, infos = env.step(drawn(rng, env))
        assert env.acted.all()
        levels |= {env.get_attr("worlds", 0)[0].info_of(0)["level"]}
        if step % 30:
            continue
        assert dones.all()
        cut = [info for info in infos if info["outcome"] == Outcome.RUNNING]
        assert cut
        assert all("episode" not in info and "is_success" not in info for info in cut)
        assert all(info["TimeLimit.truncated"] and "terminal_observation" in info for info in cut)
    assert len(levels) == 5
    assert env.idle_share == 0.0


@MODES
def test_types_and_fresh_arrays(respawn):
    env = team(respawn=respawn, max_steps=4)
    results = [env.reset()]
    rng = np.random.default_rng(0)
    for _ in range(12):
        observations, rewards, dones, infos = env.step(drawn(rng, env))
        assert (observations.dtype, rewards.dtype, dones.dtype) == (np.float32, np.float32, np.bool_)
        assert all(env.observation_space.contains(row) for row in observations)
        for done, info in zip(dones, infos, strict=True):
            if done:
                assert env.observation_space.contains(info["terminal_observation"])
                assert type(info["TimeLimit.truncated"]) is bool
        results.append((observations, rewards, dones, infos))
    arrays = [list(arrays_in(result)) for result in results]
    live = [*arrays_in(vars(env.worlds.episodes.view)), *arrays_in(vars(env.batch.last_seen)), env.acted, env.acting]
    for k, mine in enumerate(arrays):
        others = [array for result in arrays[k + 1 :] for array in result] + live
        assert not any(np.shares_memory(one, other) for one in mine for other in others)


def test_seeds_options_and_going_on():
    env = team(seed=None)
    assert env.seed(5) == [5, 5, 5, 6, 6, 6, 7, 7, 7]
    first = env.reset()
    assert (env.reset() != first).any()
    env.seed(5)
    np.testing.assert_array_equal(env.reset(), first)
    env.set_options({"split": "dev", "level": 9})
    same = env.reset()
    np.testing.assert_array_equal(same[:3], same[3:6])
    assert {info["level"] for info in env.reset_infos} == {9}
    env.set_options([{"level": 1}, {"level": 2}, {"level": 3}])
    env.reset()
    assert [info["level"] for info in env.reset_infos] == [1, 1, 1, 2, 2, 2, 3, 3, 3]
    env.set_options([{"level": slot // 3} for slot in range(9)])
    env.reset()
    assert [info["level"] for info in env.reset_infos[::3]] == [0, 1, 2]
    env.set_options([{}, {}])
    with pytest.raises(ValueError, match="options"):
        env.reset()


def test_attributes_pictures_and_errors():
    env = team(n_worlds=2, render_mode="rgb_array")
    with pytest.raises(ResetNeeded):
        env.step(np.zeros((6, 2), np.float32))
    env.reset()
    with pytest.raises(ValueError, match="shape"):
        env.step(np.zeros((3, 2), np.float32))
    with pytest.raises(ValueError, match="finite"):
        env.step(np.full((6, 2), np.nan, np.float32))
    assert env.get_attr("agent") == [0, 1, 2] * 2
    env.set_attr("colour", "red", indices=[4])
    assert env.get_attr("colour", indices=4) == ["red"]
    assert env.env_is_wrapped(Monitor) == [True] * 6
    assert env.env_is_wrapped(gymnasium.wrappers.TimeLimit, indices=0) == [False]
    assert len(env.get_images()) == 2
    assert env.render().size == 2 * env.get_images()[0].size
    env.close()
    env.close()
    with pytest.raises(UnknownNameError, match="no parameter 'mode'"):
        team(mode="lifelong")
    with pytest.raises(ValueError, match="world_steps"):
        team(world_steps=5)


@MODES
def test_copies_go_on_alike(respawn):
    env = team(respawn=respawn, max_steps=15)
    env.reset()
    rng = np.random.default_rng(0)
    for _ in range(8):
        env.step(drawn(rng, env))
    for twin in (pickle.loads(pickle.dumps(env)), deepcopy(env)):
        again = deepcopy(env)
        for _ in range(30):
            actions = drawn(rng, env)
            here, there = again.step(actions), twin.step(actions)
            for info in (*here[3], *there[3]):
                info.get("episode", {}).pop("t", None)
            assert_same(here, there)
            np.testing.assert_array_equal(again.acted, twin.acted)


@MODES
def test_worlds_do_not_depend_on_their_number_or_on_threads(respawn):
    env, more = (
        team(n_worlds=2, respawn=respawn, max_steps=15),
        team(n_worlds=5, respawn=respawn, max_steps=15, num_threads=2),
    )
    np.testing.assert_array_equal(env.reset(), more.reset()[:6])
    rng = np.random.default_rng(0)
    for _ in range(50):
        actions = drawn(rng, more)
        here, there = env.step(actions[:6]), more.step(actions)
        for one, other in zip(here[:3], there[:3], strict=True):
            np.testing.assert_array_equal(one, other[:6])


@MODES
def test_models_are_saved_loaded_and_evaluated(respawn, tmp_path):
    env = team(respawn=respawn, max_steps=15)
    model = sb3.MaskedPPO("MlpPolicy", env, n_steps=16, batch_size=36, seed=0, device="cpu")
    watch = EvalCallback(team(max_steps=15), n_eval_episodes=18, eval_freq=16, verbose=0, best_model_save_path=tmp_path)
    model.learn(16 * env.num_envs, callback=watch)
    assert (tmp_path / "best_model.zip").is_file()
    assert watch.last_mean_reward > -np.inf
    assert len(watch._is_success_buffer) == 18
    rewards, lengths = evaluate_policy(model, team(max_steps=15), n_eval_episodes=9, return_episode_rewards=True)
    assert len(rewards) == 9
    assert max(lengths) <= 15
    model.save(tmp_path / "policy")
    again = sb3.MaskedPPO.load(tmp_path / "policy", env=team(respawn=respawn, max_steps=15), device="cpu")
    assert type(again.rollout_buffer) is sb3.MaskedRolloutBuffer
    again.learn(16 * env.num_envs, reset_num_timesteps=False)
    observation = env.reset()
    alone = PPO.load(tmp_path / "policy", device="cpu")
    np.testing.assert_array_equal(alone.predict(observation, deterministic=True)[0].shape, (9, 2))


def test_paths_of_respawned_robots_begin_where_they_begin():
    shown = {**KNOWN, "robot": [{**robot, "plot": {"show_trajectory": True}} for robot in KNOWN["robot"]]}
    env = team(shown, 1, respawn=True, render_mode="rgb_array")
    env.reset()
    for _ in range(ARRIVES + 2):
        env.step(np.zeros((3, 2), np.float32))
    trails = env.worlds.pictures.trails
    assert [len(trails.poses(0, k)) for k in range(3)] == [3, 2, ARRIVES + 3]  # robot 1 began anew one step later
    np.testing.assert_allclose(trails.poses(0, 0)[:, 0], [1.0, 1.1, 1.2])


def test_robots_that_vanish_wait_with_their_last_observation():
    env = team({**MEET, "task": {**MEET["task"], "ended": "vanish"}}, 4, max_steps=25)
    last = env.reset()
    rng, waited = np.random.default_rng(0), 0
    for _ in range(100):
        before = env.acting.copy()
        observations, _, dones, infos = env.step(drawn(rng, env))
        assert np.isfinite(observations).all()
        for slot in np.flatnonzero(~env.acted).tolist():
            assert not before[slot]
            seen = infos[slot]["terminal_observation"] if dones[slot] else observations[slot]
            np.testing.assert_array_equal(seen, last[slot])
            waited += 1
        last = observations
        for slot in np.flatnonzero(dones & ~env.acting).tolist():
            np.testing.assert_array_equal(observations[slot], infos[slot]["terminal_observation"])
    assert waited > 50


@MODES
def test_robots_of_different_drives_share_one_policy(respawn):
    drives = [
        {"kinematics": {"name": "diff"}},
        {"kinematics": {"name": "omni"}, "vel_min": [-1, -1], "vel_max": [1, 1]},
        {"kinematics": {"name": "acker", "wheelbase": 0.3}, "shape": {"name": "rectangle", "length": 0.5, "width": 0.3,
                                                                      "wheelbase": 0.3}},
    ]  # fmt: skip
    shared = {name: MEET["robot"][0][name] for name in ("shape", "distribution", "goal_threshold", "sensors")}
    env = team({**MEET, "robot": [{**shared, **drive} for drive in drives]}, 3, respawn=respawn, max_steps=10)
    model = sb3.MaskedPPO("MlpPolicy", env, n_steps=16, batch_size=48, seed=0, device="cpu")
    model.learn(16 * 9 * 2)
    assert env.observation_space.contains(env.reset()[0])


def test_wrappers_of_sb3_pass_the_masks_on():
    env = VecFrameStack(team(max_steps=15), 2)
    model = sb3.MaskedPPO("MlpPolicy", env, n_steps=16, batch_size=36, seed=0, device="cpu")
    model.learn(16 * 9 * 2)
    rows = model.rollout_buffer
    assert 0 < len(rows.values) == rows.acted.sum() < rows.acted.size


def test_choices_are_learnt_too():
    env = team(task={**MEET["task"], "action": {"name": "discrete", "linear": 2, "angular": 3}}, max_steps=15)
    sb3.MaskedPPO("MlpPolicy", env, n_steps=16, batch_size=36, device="cpu").learn(16 * 9)
