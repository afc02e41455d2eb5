"""What is compiled: nothing that allocates in a step, nothing twice, and nothing that leaves its arrays."""

from __future__ import annotations

import importlib
import json
import os
import pkgutil
import subprocess
import sys
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import irsim_gym
from irsim_gym.base.kernels import Kernel, config

# Kernels that may allocate, for they run once per level and not in a step.
ALLOCATE = {"measure_bodies"}
# Compiled for more than one kind of argument: with and without grids for ways; arrays of several types; numbers that
# are known beforehand; columns of a wider array; addresses from an array and from memory.
SEVERAL = {"draw_members", "overwrite", "is_spaced", "root", "join", "goal_gap", "cast_seen", "call_all"}

FACES = """
import gc, json, sys
import numpy as np
import irsim_gym
from irsim_gym.base.kernels import Kernel

name = "cluttered_room"
single = irsim_gym.make(name)
many = irsim_gym.make_vec(name, 3)
threads = irsim_gym.make_vec(name, 8, num_threads=2)
for env in (single, many, threads):
    env.reset(seed=0)
    for _ in range(3):
        env.step(env.action_space.sample())
learners = irsim_gym.sb3.make_vec_env(name, 4)
learners.reset()
learners.step(np.zeros((4, 2), np.float32))
batch = irsim_gym.make_batch(name, 2)
batch.reset(seed=0)
batch.step(np.zeros((2, 1, 2), np.float32))

found = {}
for kernel in [one for one in gc.get_objects() if type(one) is Kernel]:
    for form in ("compiled", "packed", "inner"):
        if form in vars(kernel):
            made = vars(kernel)[form]
            found[f"{kernel.__module__}.{kernel.__name__} {form}"] = len(getattr(made, "overloads", made))
from irsim_gym.base.compiled.watch import compilation
print(json.dumps([found, compilation().compiled]))
"""

CHECKED = """
import numpy as np
import irsim_gym
robot = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.15}}
env = irsim_gym.make_vec({
    "world": {"width": 16, "height": 16, "obstacle_map": "cavern.png"},
    "robot": [
        {**robot, "state": [14.1, 3.9, 1.2], "goal": [2.5, 7.9], "sensors": [{"name": "lidar2d", "number": 37}]},
        {**robot, "state": [10.3, 6.6, 0.2], "goal": [0.7, 6.0], "behavior": {"name": "rvo"}},
        {**robot, "state": [10.3, 5.5, -0.7], "goal": [8.7, 1.0], "behavior": {"name": "dash"}},
    ],
    "obstacle": [{"shape": {"name": "rectangle", "length": 0.4, "width": 0.3}, "state": [13.8, 4.6, 0.3]}],
    "task": "navigation",
}, 2)
env.reset(seed=1)
for _ in range(60):
    env.step(np.ones(env.action_space.shape, np.float32))
"""

COMMANDS = """
import sys
from pathlib import Path
from irsim_gym.base.compiled.watch import compilation
from irsim_gym.evaluation.comparison.evaluate import evaluate_policies
from irsim_gym.cli.work.inspection import draw_level
from irsim_gym.cli.work.trial import ReadOptions, run_briefly
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.cli.work.warmup import warm_up

name, folder = "empty_goal", Path(FOLDER)
warm_up([ScenarioRequest(name)])
ready = compilation().compiled
run_briefly(name, ReadOptions({}))
draw_level(name, 0, "dev", None, folder / "level.png", None, True)
evaluate_policies(ScenarioRequest(name), ["dash"], levels=1, references=False)
print(ready, compilation().compiled - ready)
"""


def run(code: str, **environment: str) -> str:
    command = [sys.executable, "-W", "error", "-c", code]
    done = subprocess.run(command, env={**os.environ, **environment}, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def kernels() -> dict[str, Kernel]:
    found = {}
    for module in pkgutil.walk_packages(irsim_gym.__path__, "irsim_gym."):
        if module.name.split(".")[1] not in {"training", "render", "live", "envs", "evaluation", "rllib", "robot"}:
            values = vars(importlib.import_module(module.name)).values()
            found |= {value.__name__: value for value in values if isinstance(value, Kernel)}
    return found


@pytest.mark.skipif(config.DISABLE_JIT, reason="nothing is compiled")
def test_no_kernel_of_a_step_allocates() -> None:
    found = kernels()
    assert len(found) > 200
    assert {name for name, kernel in found.items() if kernel._options["_nrt"]} == ALLOCATE


def test_all_faces_share_what_is_compiled() -> None:
    # A process that compiles types a kernel anew for each caller: what is shared shows where all has been compiled.
    found: dict[str, int] = {}
    for _ in range(2):
        found, compiled = json.loads(run(FACES).splitlines()[-1])
        if compiled == 0:
            break
    assert sum(found.values()) > 40
    several = {name.split()[0].split(".")[-1] for name, n in found.items() if n > 1}
    assert several <= SEVERAL
    both = [name for name, n in found.items() if n and name.endswith("packed") and found.get(f"{name[:-6]}compiled")]
    assert len(both) <= 3, both


@pytest.mark.slow
def test_no_kernel_leaves_its_arrays() -> None:
    """All kernels are compiled for this; ``tests/bounds`` plays such scenarios in plain Python."""
    assert run(CHECKED, NUMBA_BOUNDSCHECK="1") == ""


def test_numbas_checks_find_an_index_beyond_an_array() -> None:
    """It is an error here, where it is otherwise a wrong number or a crash."""
    with pytest.raises(AssertionError, match="IndexError"):
        run("import numpy, irsim_gym.base.rng as rng; rng.next_bits(numpy.zeros(1, 'u8'), 1)", NUMBA_BOUNDSCHECK="1")


@pytest.mark.slow
def test_commands_share_what_warmup_compiles(tmp_path: Path) -> None:
    """``check``, ``draw`` and ``evaluate`` compile nothing any more."""
    done = run(COMMANDS.replace("FOLDER", repr(str(tmp_path))), NUMBA_CACHE_DIR=str(tmp_path), MPLBACKEND="Agg")
    before, after = map(int, done.splitlines()[-1].split())
    assert before > 50
    assert after == 0


@pytest.mark.skipif(config.DISABLE_JIT, reason="kernels are plain functions")
def test_kernels_call_each_other_in_one_direction() -> None:
    """Processes that compile wait for each other along these calls (``base.compiled.lock``)."""
    found = kernels()
    calls = {
        name: {
            called.__name__
            for word in kernel._function.__code__.co_names
            if isinstance(called := kernel._function.__globals__.get(word), Kernel)
        }
        for name, kernel in found.items()
    }
    assert sum(map(len, calls.values())) > 200
    TopologicalSorter(calls).prepare()
