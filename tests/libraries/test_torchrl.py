"""TorchRL: specs, rollouts and info readers of its wrappers."""

from __future__ import annotations

import functools

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode
from needed import library
from scenes import ENDS, FORMS, LIMIT, paid_alone, team

import irsim_gym

STEPS = 20
ID = "irsim_gym/empty_goal-v0"


@pytest.fixture(scope="module")
def envs():
    return library("torchrl.envs")


def drawn(env, seed=0):
    """A rollout of random actions that goes on after ends."""
    import torch

    torch.manual_seed(seed)
    env.set_seed(seed)
    return env.rollout(STEPS, break_when_any_done=False)


@pytest.mark.parametrize("numpy_infos", [False, True])
def test_a_single_environment(envs, numpy_infos):
    env = envs.GymWrapper(irsim_gym.make("empty_goal", max_steps=6, numpy_infos=numpy_infos))
    envs.check_env_specs(env)
    rows = drawn(env)
    assert rows["next", "truncated"].flatten().nonzero().flatten().tolist() == [5, 11, 17]
    plain = irsim_gym.make("empty_goal", max_steps=6)
    plain.reset(seed=0)
    plain.reset()  # TorchRL seeds with a reset, and begins its rollout with another
    for k, action in enumerate(rows["action"][:6].numpy()):
        observation, reward = plain.step(action)[:2]
        np.testing.assert_array_equal(rows["next", "observation"][k], observation)
        assert rows["next", "reward"][k].item() == np.float32(reward)


def test_by_id(envs):
    env = envs.GymEnv(ID, max_steps=6)
    envs.check_env_specs(env)
    assert drawn(env)["next", "done"].sum() == 3


@pytest.mark.parametrize("how", ["auto_register_info_dict", "set_info_dict_reader"])
def test_infos_are_read(envs, how):
    env = envs.GymWrapper(irsim_gym.make("empty_goal", max_steps=6, numpy_infos=True))
    given = [envs.default_info_dict_reader()] if how == "set_info_dict_reader" else []
    env = getattr(env, how)(*given)
    envs.check_env_specs(env)
    then = drawn(env)["next"]
    assert then["steps"].tolist() == [k % 6 + 1 for k in range(STEPS)]
    terms = [values for key, values in then.items() if key.startswith("reward/")]
    np.testing.assert_allclose(sum(terms).numpy(), then["reward"].squeeze(-1).numpy(), rtol=1e-6)
    assert (str(then["is_success"].dtype), str(then["outcome"].dtype)) == ("torch.bool", "torch.int64")


@pytest.mark.parametrize("mode", [AutoresetMode.SAME_STEP, AutoresetMode.DISABLED])
def test_native_batches_equal_single_environments(envs, mode):
    """All infos included, and what an episode ended with."""
    native = irsim_gym.make_vec("empty_goal", 3, autoreset_mode=mode, max_steps=6)
    single = gymnasium.make_vec(ID, 3, vectorization_mode="sync", vector_kwargs={"autoreset_mode": mode}, max_steps=6)
    batches = [envs.GymWrapper(env) for env in (native, single)]
    if mode is AutoresetMode.DISABLED:
        batches = [env.auto_register_info_dict() for env in batches]
    for env in batches:
        envs.check_env_specs(env)
    rows, wanted = map(drawn, batches)
    assert rows["next", "done"].sum() == 9
    assert rows["next", "steps"].tolist()[0][:6] == [1, 2, 3, 4, 5, 6]
    assert (rows == wanted).all()


def test_the_other_mode_is_refused_by_torchrl(envs):
    """So that the page says so only as long as it is true."""
    with pytest.raises(RuntimeError, match="must be one of SAME_STEP or DISABLED"):
        envs.GymWrapper(irsim_gym.make_vec("empty_goal", 3))


def made(n_steps):
    from torchrl.envs import GymWrapper

    return GymWrapper(irsim_gym.make("empty_goal", max_steps=n_steps))


def test_processes(envs):
    env = envs.ParallelEnv(2, functools.partial(made, 6))
    try:
        assert drawn(env)["next", "done"].sum() == 6
    finally:
        env.close()


@pytest.mark.parametrize("form", FORMS)
def test_other_forms(envs, form):
    alone, together = team(agents=["robot_0"], **FORMS[form]), team(**FORMS[form])
    for env in (
        envs.GymWrapper(irsim_gym.make(alone)),
        envs.GymWrapper(irsim_gym.make_vec(alone, 2, autoreset_mode="SameStep")),
        envs.PettingZooWrapper(irsim_gym.parallel_env(together), use_mask=True, done_on_any=False),
        envs.PettingZooWrapper(irsim_gym.parallel_env(together, black_death=True)),
    ):
        envs.check_env_specs(env)
        assert drawn(env)["next", "done"].any()


def rollout_of(envs, **options):
    """Two episodes of the team and a bit, in which nobody turns."""
    kept = {key: options.pop(key) for key in ("black_death",) if key in options}
    env = envs.PettingZooWrapper(irsim_gym.parallel_env(team(), **kept), return_state=True, seed=0, **options)
    envs.check_env_specs(env)

    def still(tensordict):
        return tensordict.set(("robot", "action"), env.full_action_spec["robot", "action"].zero())

    return env.rollout(STEPS, still, break_when_any_done=False)


@pytest.mark.parametrize("options", [{"use_mask": True, "done_on_any": False}, {"black_death": True}])
def test_teams_play_to_their_end(envs, options):
    rows = rollout_of(envs, **options)
    assert rows["next", "done"].flatten().nonzero().flatten().tolist() == [LIMIT - 1, 2 * LIMIT - 1]
    paid = rows["next", "robot", "reward"][:LIMIT].sum(0).flatten()
    np.testing.assert_allclose(paid.numpy(), list(paid_alone().values()), rtol=1e-5)
    infos = rows["next", "robot", "info"]
    terms = sum(values for key, values in infos.items() if key.startswith("reward/"))
    np.testing.assert_allclose(terms.numpy(), rows["next", "robot", "reward"].squeeze(-1).numpy(), rtol=1e-5)
    left = [rows["next", "robot", "mask"][:, a] for a in range(3)] if "use_mask" in options else []
    for there, end in zip(left, ENDS.values(), strict=False):
        assert there[:LIMIT].tolist() == [True] * (end - 1) + [False] * (LIMIT - end + 1)


def test_the_first_end_is_everybodys_unless_torchrl_is_told(envs):
    """TorchRL's default for parallel environments, which is why the page says ``done_on_any=False``."""
    rows = rollout_of(envs, use_mask=True)
    assert rows["next", "done"].flatten().nonzero().flatten().tolist() == [3, 7, 11, 15, 19]
