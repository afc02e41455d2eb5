"""Public names of version 0.1 can still be imported, and say where they are now."""

from __future__ import annotations

import importlib
import subprocess
import sys
from copy import copy

import gymnasium
import pytest

import irsim_gym
from irsim_gym.base.faces import FORMER, _homes

NAMES = [(module, name, place) for module, text in FORMER.items() for name, place in _homes(text)]


@pytest.mark.parametrize(("module", "name", "place"), NAMES, ids=[f"{module}.{name}" for module, name, _ in NAMES])
def test_a_former_name_warns_and_is_the_same(module: str, name: str, place: str) -> None:
    home, _, last = f"irsim_gym.{place}".rpartition(".")
    with pytest.warns(DeprecationWarning, match=rf"irsim_gym\.{module}\.{name} is now irsim_gym\.{place}"):
        found = getattr(importlib.import_module(f"irsim_gym.{module}"), name)
    assert found is getattr(importlib.import_module(home), last)


def test_no_former_module_hides_one_of_today() -> None:
    names = "[name for name in faces.FORMER if faces.find_spec('irsim_gym.' + name).loader]"
    script = f"import irsim_gym.base.faces as faces; print({names})"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
    with pytest.raises(ImportError, match="Wrold"):
        from irsim_gym.envs.single import Wrold  # noqa: F401


def test_a_saved_spec_of_version_0_1_can_be_made() -> None:
    spec = copy(gymnasium.spec("irsim_gym/corridor-v0"))
    spec.entry_point = "irsim_gym.envs.single:WorldEnv"
    with pytest.warns(DeprecationWarning, match="WorldEnv"):
        env = gymnasium.make(spec)
    assert isinstance(env.unwrapped, irsim_gym.WorldEnv)
    env.close()
