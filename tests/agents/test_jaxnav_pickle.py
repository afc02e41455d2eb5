"""agents/studies/jaxnav_pickle.py: numbers are taken out of pickles, whose code does not run."""

from __future__ import annotations

import pickle
import sys
import types
from pathlib import Path
from typing import Any

import numpy as np
import pytest

STUDIES = Path(__file__).parents[2] / "agents" / "studies"
NAV = {
    "cells": np.zeros((2, 3, 4), np.uint8), "start_xy": np.full((2, 1, 2), 1.5, np.float32),
    "start_heading": np.array([[0.5], [3.5]], np.float32),
    "goal_xy": np.array([[[2.5, 0.5]], [[3.5, 1.5]]], np.float32),
}  # fmt: skip
NAV["cells"][0, 2, 3] = 1  # y = 2.5, x = 3.5


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(STUDIES))
    import jaxnav_pickle

    return jaxnav_pickle


def as_jax_saves(value: Any) -> Any:
    """Return a stand-in for an array of JAX: it is pickled as JAX does it, by a function of a module of JAX."""
    made = object.__new__(sys.modules["jax._src.array"].ArrayImpl)
    made.value = value
    return made


@pytest.fixture
def foreign(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Modules of JAX and JaxMARL as far as pickles need them; they are gone when the pickle is read."""

    def _reconstruct_array(function: Any, arguments: Any, state: Any, aval: Any) -> None:
        raise AssertionError("called by the reader")

    class ArrayImpl:
        def __reduce__(self) -> Any:
            function, arguments, state = self.value.__reduce__()
            return _reconstruct_array, (function, arguments, state, {"weak_type": False})

    class EnvInstance:
        def __init__(self, **values: Any) -> None:
            self.__dict__.update(values)

        def __setstate__(self, state: Any) -> None:
            raise AssertionError("called by the reader")

    home = {"jax._src.array": [_reconstruct_array, ArrayImpl], "jaxmarl.environments.jaxnav.jaxnav_env": [EnvInstance]}
    for place, members in home.items():
        parts = place.split(".")
        for k in range(len(parts)):
            monkeypatch.setitem(sys.modules, ".".join(parts[: k + 1]), types.ModuleType(".".join(parts[: k + 1])))
        for member in members:
            member.__module__, member.__qualname__ = place, member.__name__
            setattr(sys.modules[place], member.__name__, member)
    return EnvInstance


@pytest.mark.parametrize("protocol", [2, 4, 5])
def test_pickles_are_read_without_their_classes(
    tmp_path: Path, script: Any, foreign: Any, protocol: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    words = {"agent_pos": "start_xy", "agent_theta": "start_heading", "goal_pos": "goal_xy", "map_data": "cells"}
    state = foreign(**{word: as_jax_saves(NAV[name]) for word, name in words.items()}, rew_lambda=np.float32(0.5))
    (tmp_path / "levels.pkl").write_bytes(pickle.dumps([state, state], protocol=protocol))
    for name in [one for one in sys.modules if one.split(".")[0] in ("jax", "jaxmarl")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(sys, "argv", ["", str(tmp_path / "levels.pkl"), str(tmp_path / "levels.npz")])
    script.main()
    twice = {name: np.concatenate([array, array]) for name, array in NAV.items()}
    with np.load(tmp_path / "levels.npz") as found:
        for name, array in script.levels_of(twice, "levels.pkl").items():
            np.testing.assert_array_equal(found[name], array)


class Mischief:
    def __init__(self, call: Any) -> None:
        self.call = call

    def __reduce__(self) -> Any:
        return self.call


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (lambda file: Mischief((Path.touch, (file,))), "it needs pathlib.Path"),
        (lambda file: Mischief((eval, (f"open({str(file)!r}, 'w')",))), "it needs builtins.eval, which is not read"),
        (lambda _: np.array([{}], object), "an array of objects"),
        (lambda _: [1, 2], "holds no state of JaxNav"),
    ],
)
def test_other_pickles_are_refused_and_do_nothing(tmp_path: Path, script: Any, content: Any, told: str) -> None:
    (tmp_path / "bad.pkl").write_bytes(pickle.dumps(content(tmp_path / "touched")))
    with pytest.raises((pickle.UnpicklingError, SystemExit), match=told):
        script.arrays_of(tmp_path / "bad.pkl")
    assert not (tmp_path / "touched").exists()
