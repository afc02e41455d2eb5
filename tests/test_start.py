"""A scenario to start from, and a look at what is installed."""

from __future__ import annotations

import re
from pathlib import Path

import gymnasium
import pytest
from typer.testing import CliRunner

import irsim_gym
from irsim_gym.cli.app import app
from irsim_gym.errors import IrsimGymError


def run(*words: str) -> tuple[int, str]:
    found = CliRunner().invoke(app, list(words))
    if isinstance(found.exception, IrsimGymError):
        return 2, str(found.exception)
    return found.exit_code, found.output


def test_a_new_scenario_is_an_environment_as_it_stands(tmp_path: Path) -> None:
    file = tmp_path / "my_world.yaml"
    code, said = run("new", str(file))
    assert (code, f"irsim-gym train {file}" in said) == (0, True)
    text = file.read_text()
    assert f"irsim-gym check {file} " in text
    assert "--out my_world.gif" in text
    env = irsim_gym.make(file)
    assert env.reset(seed=0)[0] in env.observation_space
    assert len(env.unwrapped.bodies) == 9  # the robot, the walls, six discs and a walker


def test_a_new_scenario_replaces_nothing(tmp_path: Path) -> None:
    mine = tmp_path / "mine.yaml"
    mine.write_text("mine")
    assert run("new", str(mine)) == (2, f"{mine} exists; choose another name")
    assert mine.read_text() == "mine"
    assert "a scenario is a .yaml file" in run("new", str(tmp_path / "world.txt"))[1]
    assert "there is no folder" in run("new", str(tmp_path / "nowhere" / "world.yaml"))[1]


@pytest.mark.parametrize(("words", "offered"), [("polic", ["policies"]), ("draw nothing_like_that", [])])
def test_the_shell_completes_commands(
    words: str, offered: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    line = f"irsim-gym {words}"
    asked = {"_IRSIM_GYM_COMPLETE": "complete_bash", "COMP_WORDS": line, "COMP_CWORD": str(len(line.split()) - 1)}
    said = CliRunner().invoke(app, prog_name="irsim-gym", env=asked).output
    assert said.split() == offered


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish", "powershell"])
def test_each_shell_has_a_script(shell: str) -> None:
    said = CliRunner().invoke(app, prog_name="irsim-gym", env={"_IRSIM_GYM_COMPLETE": f"source_{shell}"}).output
    assert "_IRSIM_GYM_COMPLETE" in said
    assert "irsim-gym" in said


def test_gymnasium_prints_all_ids_in_one_group(capsys: pytest.CaptureFixture[str]) -> None:
    gymnasium.pprint_registry(num_cols=1)
    groups = dict(re.findall(r"^===== (\S+) =====\n((?:(?!=====).*\n?)*)", capsys.readouterr().out, re.MULTILINE))
    ours = [one for one in gymnasium.registry if one.startswith("irsim_gym/")]
    assert groups["irsim_gym"].split() == sorted(ours)
    assert not [name for name, ids in groups.items() if "irsim_gym/" in ids and name != "irsim_gym"]
