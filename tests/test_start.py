"""A scenario to start from, and a look at what is installed."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import gymnasium
import pytest
from typer.testing import CliRunner

import irsim_gym
from irsim_gym.base import extras
from irsim_gym.cli.app import app
from irsim_gym.cli.work import doctor
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


def test_doctor_names_versions_and_what_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    code, said = run("doctor")
    assert code == 0
    for word in (irsim_gym.__version__, "numba", "cache of kernels", "processors", "display", "films"):
        assert word in said
    monkeypatch.setattr(doctor, "OPTIONAL", {"wings": "fly"})
    monkeypatch.setattr(extras, "EXTRAS", {"wings": ("no_such_module",)})
    last = doctor.examine()[-1]
    assert (last.topic, last.found, last.advice) == (
        "wings: fly",
        "no_such_module not found",
        'pip install "irsim_gym[wings]"',
    )


def test_doctor_fails_where_a_package_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "PACKAGES", ("numpy", "no-such-package"))
    assert run("doctor")[0] == 1
    assert [one.topic for one in doctor.examine() if one.is_wrong] == ["no-such-package"]


def test_doctor_looks_for_a_display_and_its_toolkit(monkeypatch: pytest.MonkeyPatch) -> None:
    def shown(system: str, **variables: str) -> doctor.Finding:
        monkeypatch.setattr(sys, "platform", system)
        for name in ("DISPLAY", "WAYLAND_DISPLAY"):
            monkeypatch.delenv(name, raising=False)
        for name, value in variables.items():
            monkeypatch.setenv(name, value)
        return doctor._display()

    monkeypatch.setattr(doctor, "TOOLKITS", ("no_such_toolkit", "json"))
    assert "DISPLAY and WAYLAND_DISPLAY are not set" in shown("linux").found
    assert shown("linux", DISPLAY=":7").found == ":7, with json"
    assert shown("win32").found == "there is one, with json"
    monkeypatch.setattr(doctor, "TOOLKITS", ("no_such_toolkit",))
    assert shown("linux", WAYLAND_DISPLAY="wayland-0").found == "wayland-0, but no toolkit for windows"
    assert "pip install pyside6" in shown("linux", DISPLAY=":7").advice
    assert shown("darwin").found == "there is one, with macosx"


def test_doctor_says_what_films_lack(monkeypatch: pytest.MonkeyPatch) -> None:
    import imageio_ffmpeg

    def gone() -> str:
        raise RuntimeError("No ffmpeg exe could be found.\nMore lines.")

    monkeypatch.setattr(imageio_ffmpeg, "get_ffmpeg_version", gone)
    films = doctor._films()
    assert films.found == "no ffmpeg: No ffmpeg exe could be found."
    assert "film.gif" in films.advice


def test_the_number_of_threads_that_doctor_names_is_one_that_environments_take() -> None:
    said = doctor._threads().found
    number = re.search(r"num_threads=(\d+)", said)
    irsim_gym.make_vec("corridor", num_envs=2, num_threads=int(number[1]) if number else 1).close()


def test_doctor_says_how_kernels_run(monkeypatch: pytest.MonkeyPatch) -> None:
    def said() -> str:
        return next(one.found for one in doctor.examine() if one.topic == "compiled kernels")

    monkeypatch.delenv("NUMBA_DISABLE_JIT", raising=False)
    monkeypatch.delenv("IRSIM_GYM_PLAIN_NUMBA", raising=False)
    assert said() == "on"
    monkeypatch.setenv("IRSIM_GYM_PLAIN_NUMBA", "1")
    assert said() == "Numba's plain way: IRSIM_GYM_PLAIN_NUMBA is set"
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    assert said() == "off: NUMBA_DISABLE_JIT is set"


@pytest.mark.parametrize(
    ("words", "offered"),
    [
        ("train corridor_", ["corridor_two_way"]),
        ("run multi_robot_", ["multi_robot_rvo"]),
        ("check my", ["my_world.yaml"]),
        ("draw worlds/", ["worlds/one.yaml"]),
        ("train corridor --algorithm t", ["td3", "tqc"]),
        ("rollout corridor --split d", ["dev"]),
        ("evaluate corridor --task image", ["image_navigation"]),
        ("evaluate corridor runs", ["runs/corridor-ppo-0"]),
        ("arena corridor da", ["dash"]),
        ("polic", ["policies"]),
        ("draw nothing_like_that", []),
    ],
)
def test_the_shell_completes_names(
    words: str, offered: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for file in ("my_world.yaml", "worlds/one.yaml", "runs/corridor-ppo-0/policy.zip", "runs/begun/config.json"):
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / file).touch()
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
