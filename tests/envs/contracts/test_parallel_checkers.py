"""Every shipped scenario with several robots against PettingZoo's own tests."""

from __future__ import annotations

import re
import warnings
from types import SimpleNamespace

import pytest
from pettingzoo.utils.conversions import aec_to_parallel, parallel_to_aec
from team_scenes import TEAMS, crossing, mixed

import irsim_gym
from irsim_gym.envs.teams.parallel import WorldParallelEnv
from irsim_gym.scenario import load_scenario

with warnings.catch_warnings():  # with pytest at hand, PettingZoo's tests import a game in a deprecated way
    warnings.filterwarnings("ignore", ".*connect_four.*", DeprecationWarning)
    from pettingzoo.test import api_test, max_cycles_test, parallel_api_test, parallel_seed_test, seed_test, state_test

CYCLES = 12
every = pytest.mark.parametrize("name", TEAMS)


def warned_of(name):
    """What ``api_test`` would rather see: agents called ``word_number``, and one space for all."""
    scenario = load_scenario(name)
    robots = [scenario.bodies[b] for b in scenario.robots]
    if not all(re.match("[a-z]+_[0-9]+", robot.name) for robot in robots):
        yield "ignore:We recommend agents to be named in the format:UserWarning"
    if len({type(robot.kinematics) for robot in robots}) > 1:
        yield "ignore:Agents have different (observation|action) space sizes:UserWarning"
        yield "ignore:Observations are different shapes:UserWarning"


def made(name, **kwargs):
    return irsim_gym.parallel_env(name, **kwargs)


def in_turns(name, **kwargs):
    """The environment in which agents act one after another."""
    return parallel_to_aec(made(name, **kwargs))


@every
def test_parallel_api(name):
    parallel_api_test(made(name), CYCLES)


@every
def test_parallel_seed(name):
    parallel_seed_test(lambda: made(name), CYCLES)


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.filterwarnings(one) for one in warned_of(name)]) for name in TEAMS]
)
def test_api_in_turns(name):
    api_test(in_turns(name), CYCLES)


@every
def test_seed_in_turns(name):
    seed_test(lambda: in_turns(name), CYCLES)


@every
def test_max_cycles(name):
    max_cycles_test(
        SimpleNamespace(
            parallel_env=lambda max_cycles: made(name, max_cycles=max_cycles),
            env=lambda max_cycles: in_turns(name, max_cycles=max_cycles),
        )
    )


@every
def test_state(name):
    state_test(in_turns(name), made(name), CYCLES)


@pytest.mark.filterwarnings("ignore:Observation(s)? (space for each agent probably|is not a NumPy):UserWarning")
@pytest.mark.parametrize("task", [{"observation_form": "dict"}, {"action": {"name": "discrete"}}])
def test_other_spaces(task):
    scene = crossing(**task)
    parallel_api_test(made(scene), CYCLES)
    parallel_seed_test(lambda: made(scene), CYCLES)
    api_test(in_turns(scene), CYCLES)
    seed_test(lambda: in_turns(scene), CYCLES)


@pytest.mark.parametrize("scene", ["circle_swap", crossing()], ids=["shipped", "crossing"])
def test_black_death(scene):
    """Long enough for agents to end one after another: nobody is terminated and stays."""
    parallel_api_test(made(scene, black_death=True, max_steps=30), 40)
    parallel_seed_test(lambda: made(scene, black_death=True), CYCLES)
    api_test(in_turns(scene, black_death=True, max_steps=10), 40)
    seed_test(lambda: in_turns(scene, black_death=True), CYCLES)
    state_test(in_turns(scene, black_death=True), made(scene, black_death=True), CYCLES)
    max_cycles_test(
        SimpleNamespace(
            parallel_env=lambda max_cycles: made(scene, max_cycles=max_cycles, black_death=True),
            env=lambda max_cycles: in_turns(scene, max_cycles=max_cycles, black_death=True),
        )
    )


def test_padded_spaces_are_equal():
    """Nothing to be warned of: all agents have one shape."""
    scene = mixed()
    parallel_api_test(made(scene, padded=True), CYCLES)
    api_test(in_turns(scene, padded=True), CYCLES)
    state_test(in_turns(scene, padded=True), made(scene, padded=True), CYCLES)


def test_conversion_there_and_back():
    env = made(crossing())
    assert aec_to_parallel(parallel_to_aec(env)) is env
    assert isinstance(parallel_to_aec(env).unwrapped, WorldParallelEnv)
