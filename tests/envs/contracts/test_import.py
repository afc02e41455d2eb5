"""What ``import irsim_gym`` loads, and how long it takes."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib.metadata import version

import pytest

import irsim_gym

FORBIDDEN = ("numba", "matplotlib", "pettingzoo", "torch", "stable_baselines3", "shapely", "pygame")
SCRIPT = """
import json, sys, time
begin = time.process_time()
import irsim_gym
elapsed = time.process_time() - begin
import gymnasium
ids = [one for one in gymnasium.registry if one.startswith("irsim_gym/")]
print(json.dumps([elapsed, sorted(sys.modules), ids]))
"""


def test_import_is_light():
    runs = [
        json.loads(subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=True).stdout)
        for _ in range(3)
    ]
    assert min(run[0] for run in runs) < 0.6
    loaded, ids = runs[0][1:]
    assert not {name.split(".")[0] for name in loaded} & set(FORBIDDEN)
    assert "irsim_gym/cluttered_room-v0" in ids


def test_making_with_a_render_mode_loads_no_renderer():
    script = (
        "import gymnasium, sys, irsim_gym;"
        "env = gymnasium.make('irsim_gym/sparse_circles-v0', render_mode='rgb_array');"
        "env.reset(seed=0); env.step(env.action_space.sample());"
        "print('matplotlib' in sys.modules, 'torch' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "False"]


def test_checking_a_file_waits_for_no_learning_library():
    script = (
        "import sys; from irsim_gym.cli import app as cli; from irsim_gym.cli.work import trial;"
        "trial._in_a_process = lambda files, reading: "
        "({file: trial.Played() for file in files}, '');"  # it has tests of its own
        "cli.app(['check', 'empty_goal'], standalone_mode=False);"
        "print('torch' in sys.modules, 'stable_baselines3' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.split()[-2:] == ["False", "False"]


def test_public_names():
    assert dir(irsim_gym) == sorted(irsim_gym.__all__)
    for name in irsim_gym.__all__:
        assert getattr(irsim_gym, name) is not None


def test_modules_that_are_loaded_late_can_be_imported():
    script = (
        "import irsim_gym.sb3; from irsim_gym.sb3 import make_vec_env; import irsim_gym.irsim as irsim;"
        "from irsim_gym.irsim import make;"
        "print(irsim_gym.sb3.make_vec_env is make_vec_env, irsim.make is make, irsim_gym.irsim is irsim)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["True"] * 3
    assert all(hasattr(irsim_gym.sb3, name) for name in irsim_gym.sb3.__all__)


def test_the_version_is_that_of_the_package():
    """A constant, so that a checkout that is not installed has it too; the build takes it from there."""
    assert irsim_gym.__version__ == version("irsim_gym")


def test_a_name_that_is_elsewhere_is_told():
    with pytest.raises(AttributeError, match=r"'WrapToPi': use irsim_gym\.irsim\.WrapToPi"):
        irsim_gym.WrapToPi  # noqa: B018
    with pytest.raises(AttributeError, match=r"'make_vek' \(did you mean 'make_vec'\?\)"):
        irsim_gym.make_vek  # noqa: B018
