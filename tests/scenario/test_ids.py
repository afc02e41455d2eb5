"""One reading of ids: whatever takes a scenario's name knows the same ids, files and mistakes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import gymnasium
import pytest
from command_line import run

import irsim_gym
from irsim_gym import sb3
from irsim_gym.errors import IrsimGymError, MissingScenarioError, UnknownNameError
from irsim_gym.evaluation.requests.folders import labelled
from irsim_gym.scenario.specs.ids import IDS, scenario_name

WORLD = """
world: {name: mine, width: 6, height: 6}
robot:
  - {kinematics: {name: diff}, state: [1, 1, 0], goal: [5, 5, 0]}
"""
FACES: tuple[Callable[[Any], Any], ...] = (
    irsim_gym.make,
    irsim_gym.make_vec,
    irsim_gym.parallel_env,
    irsim_gym.make_batch,
    irsim_gym.load,
    irsim_gym.load_scenario,
    sb3.make_vec_env,
    sb3.make_multi_agent_vec_env,
    lambda name: irsim_gym.evaluate(name, "dash", levels=1),
    lambda name: irsim_gym.record_demonstrations(name, "dash", "demo.npz", levels=1),
)
COMMANDS = (
    *(("check",), ("draw",), ("run",), ("train",), ("evaluate",), ("play",), ("warmup",)),
    ("demo", "--scenario"),
)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder ``irsim_gym`` with files, where we are, and a registry that is left as it was."""
    before = dict(gymnasium.registry)
    (tmp_path / "irsim_gym").mkdir()
    for name in ("mine.yaml", "cluttered_room-v9.yaml", "bare-v1"):
        (tmp_path / "irsim_gym" / name).write_text(WORLD)
    monkeypatch.chdir(tmp_path)
    yield tmp_path
    gymnasium.registry.clear()
    gymnasium.registry.update(before)


@pytest.mark.parametrize("face", FACES)
@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("irsim_gym/cluttered_room-v9", "room-v9': there is 'irsim_gym/cluttered_room-v0'"),
        ("irsim_gym:irsim_gym/cluttered_room", "room': there is 'irsim_gym/cluttered_room-v0'"),
        ("irsim_gym/clutered_room-v0", r"did you mean 'irsim_gym/cluttered_room-v0'\?"),
        ("irsim_gym/qqq-v0", "`irsim-gym list` shows"),
        ("lab/mine-v0", r"nothing is registered as 'lab/\.\.\.' in this process.* each worker process"),
        ("no_such_module:lab/mine-v0", "cannot import module 'no_such_module'"),
    ],
)
def test_an_id_that_is_none_is_the_same_error_everywhere(face: Callable[[Any], Any], name: str, said: str) -> None:
    with pytest.raises(UnknownNameError) as told:
        face(name)
    assert str(told.value).startswith(f"no environment '{name}'")
    told.match(said)


@pytest.mark.parametrize("words", COMMANDS, ids=lambda words: words[0])
def test_and_in_every_command(
    words: tuple[str, ...], folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, *words, "irsim_gym/cluttered_room-v9") == 1
    assert "no environment 'irsim_gym/cluttered_room-v9': there is 'irsim_gym/cluttered_room-v0'" in (
        capsys.readouterr().err
    )
    assert sorted(file.name for file in folder.iterdir() if file.name != "runs") == ["irsim_gym"]


def test_what_ids_and_paths_stand_for(folder: Path) -> None:
    """Files in a folder that is named as the package is; ids of one's own, of the package, and behind its name."""
    assert irsim_gym.register_scenarios("irsim_gym", namespace="lab") == ("lab/cluttered_room-v9-v0", "lab/mine-v0")
    mine = str(folder / "irsim_gym" / "mine.yaml")
    for name in ("irsim_gym/mine.yaml", Path("irsim_gym/mine.yaml"), "lab/mine-v0", "irsim_gym:lab/mine-v0", mine):
        assert irsim_gym.load_scenario(name).name == "mine"
        assert irsim_gym.load(name).scenario.name == "mine"
        assert irsim_gym.make(name).unwrapped.worlds.scenario.name == "mine"  # type: ignore[attr-defined]
        assert labelled(str(name)) == "mine"
    assert scenario_name("irsim_gym:lab/mine-v0") == mine
    assert irsim_gym.load_scenario("irsim_gym/cluttered_room-v9.yaml").name == "mine"
    assert irsim_gym.load_scenario("irsim_gym/bare-v1").name == "mine"  # no id, so a file
    for name in ("cluttered_room", "irsim_gym/cluttered_room-v0", "irsim_gym:irsim_gym/cluttered_room-v0"):
        assert irsim_gym.load_scenario(name).name == "cluttered_room"
        assert scenario_name(name) == "cluttered_room"
    with pytest.raises(UnknownNameError, match=r"'lab/mime-v0' \(did you mean 'lab/mine-v0'\?\)"):
        irsim_gym.load_scenario("lab/mime-v0")


@pytest.mark.usefixtures("folder")
def test_commands_take_ids(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    names = ("irsim_gym/empty_goal-v0", "irsim_gym:irsim_gym/empty_goal-v0", "irsim_gym/mine.yaml")
    assert run(monkeypatch, "check", *names) == 0
    said = capsys.readouterr().out
    assert all(f"{name}: fine" in said for name in names)
    assert run(monkeypatch, "draw", "irsim_gym/empty_goal-v0") == 0
    assert capsys.readouterr().out.split() == ["empty_goal.png"]
    assert Path("empty_goal.png").is_file()


@pytest.mark.usefixtures("folder")
def test_ids_that_stand_for_more_or_for_less_than_a_scenario() -> None:
    made = {"entry_point": "irsim_gym.envs.gymnasium.single:WorldEnv"}
    gymnasium.register("lab/short-v0", **made, kwargs={"scenario": "empty_goal", "max_steps": 7})
    gymnasium.register("lab/plain-v0", **made, kwargs={"scenario": {"robot": {}}})
    assert irsim_gym.make("lab/short-v0").unwrapped.worlds.task.max_steps == 7  # type: ignore[attr-defined]
    with pytest.raises(IrsimGymError, match=r"'lab/short-v0' was registered with max_steps as well"):
        irsim_gym.make_batch("lab/short-v0")
    assert IDS.scenario("lab/plain-v0") == {"robot": {}}
    with pytest.raises(IrsimGymError, match="is plain data: save it to a file"):
        scenario_name("lab/plain-v0")
    with pytest.raises(UnknownNameError, match="'CartPole-v1' is registered, but is not a scenario of irsim_gym"):
        irsim_gym.load("CartPole-v1")


@pytest.mark.parametrize(
    "make",
    [
        lambda: gymnasium.make("irsim_gym/World-v0"),
        lambda: gymnasium.make_vec("irsim_gym/World-v0", num_envs=2),
        irsim_gym.parallel_env,
        lambda: irsim_gym.make_batch("irsim_gym/World-v0"),
        lambda: irsim_gym.load("irsim_gym:irsim_gym/World-v0"),
    ],
)
def test_a_world_of_no_scenario_says_what_to_give(make: Callable[[], Any]) -> None:
    with pytest.raises(MissingScenarioError, match=r"a shipped name such as 'corridor', a file such as"):
        make()
