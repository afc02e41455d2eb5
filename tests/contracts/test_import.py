"""What ``import irsim_gym`` loads, and how long it takes."""

from __future__ import annotations

import json
import subprocess
import sys

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
        "import sys; from irsim_gym import cli;"
        "cli.app(['check', 'empty_goal'], standalone_mode=False);"
        "print('torch' in sys.modules, 'stable_baselines3' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.split()[-2:] == ["False", "False"]


def test_public_names():
    for name in irsim_gym.__all__:
        assert getattr(irsim_gym, name) is not None
        assert name in dir(irsim_gym)
