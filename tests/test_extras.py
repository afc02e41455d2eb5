"""The package without PyTorch and Stable-Baselines3: what works, and what the rest says."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from command_line import run as command
from packaging.requirements import Requirement

from irsim_gym.base import extras
from irsim_gym.errors import IrsimGymError, MissingExtraError

ROOT = Path(__file__).parents[1]
HIDDEN = (
    "torch",
    "stable_baselines3",
    "sb3_contrib",
    "tensorboard",
    "optuna",
    "ray",
    "onnx",
    "onnxruntime",
    "rosbags",
    "ompl",
)
HIDE = f"import sys\nsys.modules.update(dict.fromkeys({HIDDEN}))\n"
WORKS = """
import numpy as np
import irsim_gym
env = irsim_gym.make("cluttered_room", render_mode="rgb_array")
env.reset(seed=0)
assert env.render().shape[2] == 3
envs = irsim_gym.make_vec("cluttered_room", num_envs=2)
seen, _ = envs.reset(seed=0)
team = irsim_gym.parallel_env("circle_swap", n_robots=3)
team.reset(seed=0)
world = irsim_gym.load("corridor")
world.step()
action, _ = irsim_gym.load_policy("cluttered_room").predict(seen)
envs.step(action)
found = irsim_gym.evaluate("cluttered_room", ["cluttered_room", "dash"], levels=2, references=False)
assert len(found.summaries) == 2
from irsim_gym.cli import main
for words in (
    ["evaluate", "cluttered_room", "cluttered_room", "--levels", "2", "--out", "table"],
    ["record", "cluttered_room", "cluttered_room", "--out", "film.mp4"],
    ["record", "cluttered_room", "cluttered_room", "--out", "page.html"],
    ["policies", "list"],
):
    sys.argv = ["irsim-gym", *words]
    try:
        main()
    except SystemExit as end:
        assert end.code in (0, None), words
assert not any(sys.modules.get(name) for name in %r)
""" % (HIDDEN,)  # noqa: UP031


def test_environments_films_pages_and_policies_on_the_shelf_need_no_extra(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", HIDE + WORKS], cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert (tmp_path / "film.mp4").stat().st_size > 1000
    assert (tmp_path / "page.html").stat().st_size > 1000


@pytest.mark.parametrize(
    ("words", "extra"),
    [
        (["train", "cluttered_room"], "train"),
        (["demo"], "train"),
        (["tune", "cluttered_room"], "tune"),
        (["policies", "export", "policy.zip", "mine"], "train"),
        (["evaluate", "cluttered_room", "policy.zip"], "train"),
    ],
)
def test_a_command_names_the_extra_that_it_lacks(
    words: list[str], extra: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("policy.zip").touch()
    for name in HIDDEN:
        monkeypatch.setitem(sys.modules, name, None)
    assert command(monkeypatch, *words) == 1
    said = capsys.readouterr().err
    assert f"the extra '{extra}'" in said
    assert said.rstrip().endswith(f'pip install "irsim_gym[{extra}]"')
    assert not Path("runs").exists()


def test_a_module_names_the_extra_that_it_lacks() -> None:
    for module, extra in (("sb3", "train"), ("rllib", "rllib")):
        script = f"{HIDE}import irsim_gym.{module}"
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60, check=False)
        assert f"MissingExtraError: irsim_gym.{module} needs the extra '{extra}'" in done.stderr


def test_the_error_is_one_of_a_missing_module_too() -> None:
    assert issubclass(MissingExtraError, IrsimGymError)
    assert issubclass(MissingExtraError, ModuleNotFoundError)


def test_extras_are_those_of_the_project_file() -> None:
    """Each module comes with a package that the extra asks for, or one that it includes."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    packages = {"stable_baselines3": "stable-baselines3", "sb3_contrib": "sb3-contrib"}

    def brought(extra: str) -> set[str]:
        found: set[str] = set()
        for one in map(Requirement, project[extra]):
            found |= (
                {name for other in one.extras for name in brought(other)} if one.name == "irsim_gym" else {one.name}
            )
        return found

    assert {extra: {packages.get(name, name) for name in names} for extra, names in extras.EXTRAS.items()} == {
        extra: brought(extra) for extra in extras.EXTRAS
    }
