"""Whoever draws is chosen by name, and nothing that it does not need is loaded."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from hand_made import standard_world

from irsim_gym.errors import UnknownNameError
from irsim_gym.render import BACKENDS, Renderer, make_renderer


def test_names_are_checked() -> None:
    world = standard_world()
    with pytest.raises(UnknownNameError, match=r"'matplotlib' or 'raster', got 'rasta' \(did you mean 'raster'\?\)"):
        make_renderer("rasta", world.scenario, world.model, world.state)
    assert BACKENDS == ("matplotlib", "raster")


def test_several_frames_are_the_single_ones() -> None:
    world = standard_world()
    renderer = make_renderer("matplotlib", world.scenario, world.model, world.state, size=(120, 80))
    assert isinstance(renderer, Renderer)
    frames = renderer.frames([0, 0], ["running", "success"])
    assert (frames.shape, frames.dtype) == ((2, 80, 120, 3), np.uint8)
    assert np.array_equal(frames[1], renderer.frame(0, "success"))
    assert not np.array_equal(frames[0], frames[1])
    assert renderer.frames([], []).shape == (0, 80, 120, 3)


ALONE = """
import sys
import irsim_gym
envs = irsim_gym.make_vec("empty_goal", 2, render_mode="rgb_array_list", render_backend="raster")
envs.reset(seed=0)
(first,), (second,) = envs.render()
assert first.any() and envs.tiled(2, room=(400, 400)).shape[1] == 400
print("matplotlib" in sys.modules)
"""


@pytest.mark.parametrize(
    "script", ["import sys, irsim_gym.render as r; r.make_renderer; print('matplotlib' in sys.modules)", ALONE]
)
def test_matplotlib_is_loaded_for_nobody_else(script: str) -> None:
    result = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "False"
