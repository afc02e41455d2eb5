"""The parallel environment: ends, spaces, limits, seeds and errors."""

from __future__ import annotations

import re

import numpy as np
import pettingzoo
import pytest
from contract_tools import assert_same
from gymnasium.error import ResetNeeded
from gymnasium.spaces import Box, Dict, Discrete
from gymnasium.utils.seeding import np_random
from pettingzoo.utils import wrappers
from team_scenes import ahead, crossing, four_ends, mixed, robot, towards, world

import irsim_gym
from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.envs.teams.parallel import WorldParallelEnv
from irsim_gym.errors import UnknownNameError
from irsim_gym.tasks import HitKind, Outcome


def test_a_list_of_actions_is_refused_in_words():
    env = irsim_gym.parallel_env("circle_swap", n_robots=2)
    env.reset(seed=0)
    with pytest.raises(TypeError, match="actions must be a dict with one action per agent name, got list"):
        env.step([[0, 0], [0, 0]])
    with pytest.raises(ValueError, match=r"num_envs must be a whole number >= 1, got 2\.5"):
        irsim_gym.make_vec("empty_goal", 2.5)


def test_spaces_are_those_of_each_drive_unless_asked_otherwise():
    drives = (("diff", 2), ("omni_angular", 5))
    robots = [{"kinematics": {"name": name}, "state": [2, y, 0], "goal": [8, y, 0]} for name, y in drives]
    worlds = Worlds({"robot": robots}, team=True, task={"name": "blank", "agents": "all", "observations": ["velocity"]})
    assert [space.shape for space in WorldParallelEnv(worlds).action_spaces.values()] == [(2,), (3,)]
    assert [space.shape for space in WorldParallelEnv(worlds, padded=True).action_spaces.values()] == [(3,), (3,)]


def test_each_ends_in_its_own_way():
    """The script of ``four_ends``: arrival, collision, time limit, and an arrival in the very last step."""
    env = irsim_gym.parallel_env(four_ends())
    env.reset(seed=0)
    ends = {}
    for step in range(1, 10):
        answered = list(env.agents)
        observations, rewards, terminations, truncations, infos = env.step(ahead(env))
        assert list(observations) == list(rewards) == answered
        for name in answered:
            if terminations[name] or truncations[name]:
                outcome = Outcome(infos[name]["outcome"])
                ends[name] = step, outcome, terminations[name], truncations[name]
                assert name not in env.agents
    assert ends == {
        "robot_0": (4, Outcome.SUCCESS, True, False),
        "robot_1": (6, Outcome.COLLISION, True, False),
        "robot_2": (9, Outcome.TIMEOUT, False, True),
        "robot_3": (9, Outcome.SUCCESS, True, False),
    }
    assert infos["robot_3"]["is_success"] is True
    assert env.agents == []
    assert env.step({}) == ({}, {}, {}, {}, {})


@pytest.mark.parametrize(
    ("ended", "outcome", "hit_kind"),
    [("stay", Outcome.COLLISION, HitKind.ROBOT), ("vanish", Outcome.SUCCESS, HitKind.NOTHING)],
)
def test_what_becomes_of_the_body(ended, outcome, hit_kind):
    """One robot follows another and arrives behind it: whether that stands in the way is the task's choice."""
    scene = world([robot([2, 1, 0], [3, 1, 0]), robot([1, 1, 0], [5, 1, 0])], [], ended=ended, max_steps=60)
    env = irsim_gym.parallel_env(scene)
    env.reset(seed=0)
    while env.agents:
        infos = env.step(ahead(env))[4]
    assert (infos["robot_1"]["outcome"], infos["robot_1"]["hit_kind"]) == (outcome, hit_kind)


def test_spaces_of_different_drives():
    """Each agent has the components of its own drive; padded, all have three."""
    env, padded = irsim_gym.parallel_env(mixed()), irsim_gym.parallel_env(mixed(), padded=True)
    sizes = {"robot_0": 2, "robot_1": 2, "robot_2": 3, "robot_3": 2}
    assert {name: env.action_space(name).shape[0] for name in env.possible_agents} == sizes
    assert {padded.action_space(name).shape[0] for name in sizes} == {3}
    own = {name: env.observation_space(name).shape[0] for name in sizes}
    assert own["robot_2"] == own["robot_0"] + 1  # the third component of its velocity
    assert {padded.observation_space(name).shape[0] for name in sizes} == {own["robot_2"]}
    for name in sizes:
        assert env.action_space(name) is env.action_space(name) is env.action_spaces[name]
        assert env.observation_space(name) is env.observation_spaces[name]
    assert padded.action_space("robot_0") == padded.action_space("robot_1")
    assert padded.action_space("robot_0") is not padded.action_space("robot_1")


def test_padding_adds_zeros_alone():
    """Surplus columns are 0, surplus components are ignored, whatever they are."""
    env, padded = irsim_gym.parallel_env(mixed()), irsim_gym.parallel_env(mixed(), padded=True)
    assert set(env.reset(seed=0)[0]) == set(padded.reset(seed=0)[0])
    used = env.worlds.episodes.feature_mask
    rng = np.random.default_rng(0)
    for _ in range(10):
        actions = {name: rng.uniform(-1.0, 1.0, 3) for name in padded.agents}
        own = {name: action[: env.action_space(name).shape[0]] for name, action in actions.items()}
        for name, action in own.items():
            actions[name][len(action) :] = np.nan
        seen, answer = env.step(own), padded.step(actions)
        assert seen[1:] == answer[1:]
        for a, name in enumerate(env.possible_agents):
            np.testing.assert_array_equal(answer[0][name][used[a]], seen[0][name])
            assert not answer[0][name][~used[a]].any()


def test_other_forms():
    form = irsim_gym.parallel_env(crossing(observation_form="dict"))
    choice = irsim_gym.parallel_env(crossing(action={"name": "discrete", "linear": 2, "angular": 3}))
    assert isinstance(form.observation_space("robot_0"), Dict)
    assert choice.action_space("robot_3") == Discrete(6)
    choice.reset(seed=0)
    choice.step({"robot_0": 5, "robot_1": np.int32(0), "robot_2": np.array(3), "robot_3": np.int64(1)})
    with pytest.raises(ValueError, match="'robot_1' is not a choice from 0 to 5: 6"):
        choice.step({**dict.fromkeys(choice.agents, 0), "robot_1": 6})
    with pytest.raises(ValueError, match="'robot_0' must be a whole number"):
        choice.step({**dict.fromkeys(choice.agents, 0), "robot_0": 0.5})


def test_the_limit_may_be_set():
    """An environment whose ``max_cycles`` is set is one that was made with it, rewards included."""
    made, named, later = (
        irsim_gym.parallel_env(crossing(), **kwargs) for kwargs in ({"max_steps": 7}, {"max_cycles": 7}, {})
    )
    assert later.max_cycles == 25
    later.reset(seed=0)
    later.max_cycles = 7
    assert made.max_cycles == named.max_cycles == later.max_cycles == 7
    for env in (made, named, later):
        env.reset(seed=2)
    rng = np.random.default_rng(0)
    while made.agents:
        actions = towards(made, rng)
        expected = made.step(actions)
        for env in (named, later):
            assert_same(env.step(actions), expected)
    assert "robot_2" in expected[3]
    assert expected[4]["robot_2"]["steps"] == 7


def test_limits_that_make_no_sense():
    with pytest.raises(ValueError, match="max_steps and max_cycles are the same limit, got 3 and 4"):
        irsim_gym.parallel_env(crossing(), max_steps=3, max_cycles=4)
    env = irsim_gym.parallel_env(crossing(), max_steps=3, max_cycles=3)
    with pytest.raises(ValueError, match="must be a whole number >= 1, got 0"):
        env.max_cycles = 0
    assert env.max_cycles == 3


def test_seeds_levels_and_splits():
    env = irsim_gym.parallel_env(crossing())
    first = env.reset(seed=4)
    assert {info["level"] for info in first[1].values()} == {4}
    chain = [env.reset()[1]["robot_0"]["level"] for _ in range(3)]
    assert_same(env.reset(options={"split": "train", "level": 4}), first)
    env.reset(seed=4)
    assert [env.reset()[1]["robot_0"]["level"] for _ in range(3)] == chain
    test = env.reset(options={"split": "test", "level": 4})
    assert not np.array_equal(test[0]["robot_0"], first[0]["robot_0"])
    options = {"options": 1}  # PettingZoo's tests pass this
    env.reset(options=options)
    assert options == {"options": 1}
    assert env.reset()[1]["robot_0"]["level"] > 4
    with pytest.raises(UnknownNameError, match="no reset option named 'levle'"):
        env.reset(options={"levle": 3})


def test_chains_without_a_seed_differ():
    levels = {irsim_gym.parallel_env(crossing()).reset()[1]["robot_0"]["level"] for _ in range(3)}
    assert len(levels) == 3


def test_mistakes_are_told():
    env = irsim_gym.parallel_env(four_ends(), render_mode="rgb_array")
    for call in (env.render, lambda: env.step({})):
        with pytest.raises(ResetNeeded, match="call reset"):
            call()
    env.reset(seed=0)
    before = env.state()
    good = ahead(env)
    for change, error, message in [
        ({"robot_1": None}, ValueError, "no action for robot_1: each agent"),
        ({"robot_9": good["robot_0"]}, UnknownNameError, "no agent named 'robot_9' (did you mean 'robot_"),
        ({"robot_0": np.zeros(3)}, ValueError, "'robot_0' must have shape (2,), got (3,)"),
        ({"robot_2": np.array([0.0, np.inf])}, ValueError, "'robot_2' is not finite"),
        ({"robot_2": np.array(["a", "b"])}, ValueError, "'robot_2' must be numbers"),
    ]:
        actions = {name: action for name, action in {**good, **change}.items() if action is not None}
        with pytest.raises(error, match=re.escape(message)):
            env.step(actions)
        np.testing.assert_array_equal(env.state(), before)
    for space in (env.observation_space, env.action_space):
        with pytest.raises(UnknownNameError, match="no agent named 'robot'"):
            space("robot")


@pytest.mark.parametrize("black_death", [False, True])
def test_actions_of_agents_that_have_ended_are_ignored(black_death):
    """As PettingZoo's conversions ignore them, whatever they are; whom nobody knows is still told."""
    env, twin = (irsim_gym.parallel_env(four_ends(), black_death=black_death) for _ in range(2))
    env.reset(seed=0)
    twin.reset(seed=0)
    everybody = {name: np.array([1.0, 0.0]) for name in env.possible_agents}
    gone: dict[str, object] = {}
    while env.agents:
        actions = {name: action for name, action in everybody.items() if name not in gone}
        infos = env.step({**actions, **gone})[4]
        assert_same(infos, twin.step(actions)[4])
        leftovers = (np.full(2, np.nan), "left", None, np.zeros(7))
        ended = [name for name, info in infos.items() if info["outcome"]]
        gone |= {name: leftovers[int(name[-1])] for name in ended}
        with pytest.raises(UnknownNameError, match=re.escape("no agent named 'robot_01' (did you mean 'robot_")):
            env.step({**everybody, "robot_01": np.zeros(2)})
    assert set(gone) == set(everybody)
    assert env.step(everybody) == ({}, {}, {}, {}, {})


@pytest.mark.parametrize("task", [{}, {"observation_form": "dict"}, {"team_reward": 0.2}, {"ended": "vanish"}])
def test_black_death_changes_nothing_for_those_under_way(task):
    """Those who have ended perceive zeros and are paid 0; all end in the step in which the last one does."""
    whole = irsim_gym.parallel_env(crossing(**task), black_death=True)
    leaving = irsim_gym.parallel_env(crossing(**task))
    rng, waited = np.random.default_rng(0), 0
    for seed in range(3):
        assert_same(whole.reset(seed=seed)[0], leaving.reset(seed=seed)[0])
        ends: dict[str, tuple[bool, bool]] = {}
        last: dict[str, dict[str, object]] = {}
        while leaving.agents:
            actions = towards(leaving, rng)
            observations, rewards, *flags, infos = whole.step(actions)
            theirs = leaving.step(actions)
            assert list(observations) == list(rewards) == list(infos) == whole.possible_agents
            shown = [{name: part[name] for name in theirs[0]} for part in (observations, rewards)]
            assert_same(shown, list(theirs[:2]))
            for name, info in infos.items():
                assert info.pop("idle") == (name not in theirs[4])
                if name in theirs[4]:
                    assert info == theirs[4][name]
                    continue
                waited += 1
                assert rewards[name] == sum(info[key] for key in info if key.startswith("reward/")) == 0.0
                assert {**last[name], **info} == info
                parts = observations[name].values() if "observation_form" in task else [observations[name]]
                assert not any(part.any() for part in parts)
                assert observations[name] in whole.observation_space(name)
            last = {name: {key: info[key] for key in info if "/" not in key} for name, info in infos.items()}
            ends |= {name: (theirs[2][name], theirs[3][name]) for name in theirs[2]}
            over = not leaving.agents
            wanted = ends if over else dict.fromkeys(ends, (False, False))
            assert {name: (flags[0][name], flags[1][name]) for name in ends} == wanted
            assert whole.agents == ([] if over else whole.possible_agents)
    assert waited > 50


def test_the_generator_is_known():
    """As in ``gymnasium.Env``: what a seed makes, drawn where there is none, and it may be set."""
    env = irsim_gym.parallel_env(four_ends())
    env.reset(seed=5)
    assert env.np_random_seed == 5
    assert env.np_random.bit_generator.state == np_random(5)[0].bit_generator.state
    fresh, twin = (irsim_gym.parallel_env(four_ends()) for _ in range(2))
    twin.np_random = np_random(fresh.np_random_seed)[0]
    assert twin.np_random_seed == -1
    assert_same(fresh.reset(), twin.reset())


def test_the_state_keeps_its_shape():
    env = irsim_gym.parallel_env(four_ends())
    env.reset(seed=0)
    assert isinstance(env.state_space, Box)
    states = [env.state()]
    while env.agents:
        env.step(ahead(env))
        states.append(env.state())
    assert all(state in env.state_space and state.dtype == np.float32 for state in states)
    assert len({state.tobytes() for state in states}) == len(states)


def test_only_those_who_learn_are_agents():
    env = irsim_gym.parallel_env(crossing(agents=["robot_2", "robot_0"]))
    assert env.possible_agents == ["robot_2", "robot_0"]
    env.reset(seed=0)
    assert env.step(ahead(env))[1].keys() == {"robot_2", "robot_0"}


def test_parameters_of_the_scenario():
    """A team of any size from one file, also by its id."""
    made = (
        irsim_gym.parallel_env("circle_swap", n_robots=3),
        pettingzoo.make("parallel", "irsim_gym/circle_swap-v0", n_robots=3),
    )
    for env in made:
        assert env.possible_agents == ["robot_0", "robot_1", "robot_2"]
        assert len(env.reset(seed=0)[0]) == 3
    with pytest.raises(UnknownNameError, match="n_robots"):
        irsim_gym.parallel_env("circle_swap", n_robot=3)


@pytest.mark.skipif(not hasattr(wrappers, "RecordVideoParallel"), reason="PettingZoo has it from 1.27 on")
def test_films(tmp_path):
    """PettingZoo's recorder: a frame at the reset, and one for each step."""
    env = irsim_gym.parallel_env(four_ends(), render_mode="rgb_array")
    env = wrappers.RecordVideoParallel(env, str(tmp_path / "films"))
    env.reset(seed=0)
    while env.agents:
        env.step(ahead(env))
    assert len(env.recorded_frames) == 1 + 9
    env.close()
    assert [file.name for file in (tmp_path / "films").iterdir()] == ["rl-video-episode-0.mp4"]


def test_codes_in_the_infos_have_names():
    env = irsim_gym.parallel_env("orca_circle", max_cycles=2)
    _, infos = env.reset(seed=0)
    codes = {(Outcome(info["outcome"]).name, HitKind(info["hit_kind"]).name) for info in infos.values()}
    assert codes == {("RUNNING", "NOTHING")}
    for kind in (Outcome, HitKind):
        assert all(f"{code.value} " in type(env).__doc__ for code in kind)


def test_names_are_those_of_the_file():
    env = irsim_gym.parallel_env("four_drives")
    assert env.possible_agents[:2] == ["wheels", "slider"]
    assert str(env) == "four_drives_v0"
    assert repr(env) == "<WorldParallelEnv four_drives: 4 agents>"


def test_pictures_and_closing():
    env = irsim_gym.parallel_env(four_ends(), render_mode="rgb_array")
    env.reset(seed=0)
    one, two = env.render(), env.render()
    assert one.dtype == np.uint8
    assert one.shape[2] == 3
    assert not np.shares_memory(one, two)
    assert env.metadata["render_modes"] == ["human", "rgb_array", "rgb_array_list"]
    assert env.metadata["render_fps"] == pytest.approx(10.0)
    assert env.metadata["is_parallelizable"] is True
    assert env.unwrapped is env
    env.close()
    env.close()
    silent = irsim_gym.parallel_env(four_ends())
    silent.reset(seed=0)
    with pytest.warns(UserWarning, match="no render_mode"):
        assert silent.render() is None
    with pytest.raises(ValueError, match="render_mode"):
        irsim_gym.parallel_env(four_ends(), render_mode="nothing")
