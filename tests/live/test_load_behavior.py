"""Behaviours that are registered after a world was loaded."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from small_world import DIFF

import irsim_gym
from irsim_gym.base import families
from irsim_gym.errors import BehaviorError, NoEffectWarning, ScenarioError

MODULE = """
from irsim_gym.irsim import ObjectBase, register_behavior


@register_behavior("diff", "late")
def late(ego_object: ObjectBase, external_objects: list[ObjectBase], **kwargs):
    assert isinstance(ego_object, ObjectBase)
    return [[kwargs["speed"]], [0.0]]
"""

FILE = """
robot:
  - kinematics: {name: diff}
    state: [1, 1, 0]
    behavior: {name: late, speed: 0.5}
"""


@pytest.fixture(autouse=True)
def own_registries(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Forget what a test registers and imports."""
    families.load()
    for registry in (families.BEHAVIORS, families.GROUP_BEHAVIORS):
        monkeypatch.setattr(registry, "_entries", dict(registry._entries))
    monkeypatch.setattr(sys, "path", list(sys.path))
    known = set(sys.modules)
    yield
    for name in set(sys.modules) - known:
        if name.startswith("late_"):
            del sys.modules[name]


def load(behavior: Any = None, key: str = "behavior", **entry: Any) -> Any:
    return irsim_gym.load({"robot": [{**DIFF, "state": [1, 1, 0], key: behavior or {"name": "late"}, **entry}]})


def test_a_module_beside_the_worlds_file_is_found(tmp_path: Path) -> None:
    (tmp_path / "late_beside.py").write_text(MODULE)
    (tmp_path / "world.yaml").write_text(FILE)
    world = irsim_gym.load(tmp_path / "world.yaml")
    world.load_behavior("late_beside")
    world.step()
    assert world.robot.velocity.tolist() == [0.5, 0.0]
    world.reset(random=True)
    world.step()
    assert world.robot.velocity.tolist() == [0.5, 0.0]
    world.reload()
    world.step()
    assert world.robot.velocity.tolist() == [0.5, 0.0]


def test_a_module_beside_the_script_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "late_script.py").write_text(MODULE)
    monkeypatch.setattr(sys, "argv", [str(tmp_path / "run.py")])
    world = load({"name": "late", "speed": 0.25})
    world.load_behavior("late_script")
    world.step()
    assert world.robot.velocity.tolist() == [0.25, 0.0]


def test_what_happened_before_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "late_half.py").write_text(MODULE)
    monkeypatch.syspath_prepend(str(tmp_path))
    world = load({"name": "late", "speed": 0.5})
    world.step([1.0, 0.0])
    world.add("obstacle", name="wall", shape={"name": "circle"}, state=[8, 8, 0])
    world.load_behavior("late_half")
    assert (world.count, "wall" in world.names) == (1, True)
    world.step()
    assert world.robot.state.tolist() == pytest.approx([1.15, 1, 0])


def test_the_first_step_says_what_is_missing(tmp_path: Path) -> None:
    (tmp_path / "world.yaml").write_text(FILE.replace("late", "dahs"))
    world = irsim_gym.load(tmp_path / "world.yaml")
    with pytest.raises(BehaviorError) as caught:
        world.step()
    told = str(caught.value)
    assert told.startswith(f"{tmp_path / 'world.yaml'}:5: no behavior named 'dahs'")
    assert "did you mean 'dash'?" in told
    assert "world.load_behavior(" in told


def test_members_of_an_unknown_group_decide_by_themselves(tmp_path: Path) -> None:
    """As in IR-SIM, which looks for the group's behaviour at each step; here a warning tells it once."""
    (tmp_path / "world.yaml").write_text(
        "robot:\n"
        "  - number: 2\n"
        "    kinematics: {name: diff}\n"
        "    state: [[1, 1, 0], [1, 5, 0]]\n"
        "    goal: [[5, 1], [5, 5]]\n"
        "    behavior: {name: dash}\n"
        "    group_behavior: {name: orcas, weight: 2}\n"
    )
    world = irsim_gym.load(tmp_path / "world.yaml")
    with pytest.warns(NoEffectWarning, match=r"world\.yaml:7: no group behavior named 'orcas' .*'orca'"):
        world.step()
    world.step()
    assert [robot.velocity[0] for robot in world.robot_list] == [1.0, 1.0]

    @irsim_gym.group_behavior("orcas")
    def orcas(members: Any, others: Any, *, weight: float = 1.0) -> Any:
        return [[0.25 * weight, 0.0] for _ in members]

    (tmp_path / "late_nothing.py").write_text("")
    world.load_behavior("late_nothing")
    world.step()
    assert [robot.velocity[0] for robot in world.robot_list] == [0.5, 0.5]


def test_who_never_decides_needs_no_behaviour() -> None:
    world = load(static=True)
    world.step()
    assert world.robot.state.tolist() == [1, 1, 0]
    world = load()
    world.step([0.5, 0.0])
    assert world.robot.velocity.tolist() == [0.5, 0.0]


def test_a_pending_body_wanders_where_it_shall() -> None:
    world = load({"name": "late", "wander": True, "range_low": [6, 6, 0], "range_high": [7, 7, 0]})
    x, y = world.robot.goal[:2]
    assert 6 <= x <= 7
    assert 6 <= y <= 7
    with pytest.raises(ScenarioError, match="wander: must be true or false, got 'much'"):
        load({"name": "late", "wander": "much"})


def test_options_are_checked_when_a_behaviour_is_known() -> None:
    world = load({"name": "late", "gian": 1.0})

    @irsim_gym.behavior("late", kinematics=("omni",))
    def late(ego: Any, others: Any, *, gain: float = 0.0) -> Any:
        return [gain, 0.0]

    with pytest.raises(BehaviorError, match=r"'late' is registered now; call world\.load_behavior"):
        world.step()
    with pytest.raises(ScenarioError, match=r"gian: unknown key \(did you mean 'gain'\?\)"):
        world.load_behavior("math")


def test_a_drive_that_a_behaviour_cannot_command_is_told() -> None:
    world = load()
    irsim_gym.behavior("late", kinematics=("omni",))(lambda ego, others: [0.0, 0.0])
    with pytest.raises(ScenarioError, match="'late' cannot drive kinematics 'diff'; it drives 'omni'"):
        world.load_behavior("math")


def test_modules_that_are_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", [str(tmp_path / "run.py")])
    with pytest.raises(ModuleNotFoundError, match=f"no module named 'late_nowhere'.*{tmp_path}"):
        load().load_behavior("late_nowhere")
    (tmp_path / "late_foreign.py").write_text("import irsim.no_such_part\n")
    monkeypatch.setitem(sys.modules, "irsim", None)
    with pytest.raises(ModuleNotFoundError) as caught:
        load().load_behavior("late_foreign")
    assert caught.value.__notes__ == ["in 'late_foreign': what it imports from IR-SIM is in irsim_gym.irsim"]


def test_environments_and_scenarios_refuse_unknown_behaviours() -> None:
    data = {"robot": [{**DIFF, "goal": [5, 5], "behavior": {"name": "late"}}]}
    with pytest.raises(ScenarioError, match="no behavior named 'late'"):
        irsim_gym.load_scenario(data)
    with pytest.raises(ScenarioError, match="no behavior named 'late'"):
        irsim_gym.make(data)


BESIDE = """
import numpy as np

from {home} import register_behavior
from {class_home} import register_behavior_class


@register_behavior("omni", "late_round")
def late_round(ego_object, external_objects=None, **kwargs):
    away = ego_object.state[:2] - external_objects[0].state[:2]
    return kwargs.get("pace", 1.0) * np.array([[-away[1, 0]], [away[0, 0]]]) / np.linalg.norm(away)


@register_behavior_class("diff", "late_smooth")
class Smooth:
    def __init__(self, object_info, smoothing=0.3, **kwargs):
        self.before, self.smoothing, self.name = np.zeros((2, 1)), smoothing, object_info.name

    def __call__(self, ego_object, external_objects, **kwargs):
        least, greatest = ego_object.get_vel_range()
        ahead = ego_object.get_desired_omni_vel(normalized=True)
        turn = np.arctan2(ahead[1, 0], ahead[0, 0]) - ego_object.state[2, 0]
        wanted = np.array([[greatest[0, 0] * np.cos(turn)], [greatest[1, 0] * np.sign(turn)]])
        self.before = self.smoothing * self.before + (1 - self.smoothing) * wanted
        return np.clip(self.before, least, greatest)
"""

BESIDE_FILE = """
world: {height: 10, width: 10, step_time: 0.1}
robot:
  - {kinematics: {name: diff}, shape: {name: circle, radius: 0.2}, state: [1, 2, 0.2], goal: [8, 7], acce: [1, 3],
     behavior: {name: late_smooth, smoothing: 0.6}}
  - {kinematics: {name: omni}, shape: {name: circle, radius: 0.2}, state: [5, 8, 0], goal: [9, 9], vel_max: [2, 2],
     vel_min: [-2, -2], behavior: {name: late_round, pace: 0.7}}
"""


def test_a_module_written_for_irsim_moves_bodies_as_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    irsim = pytest.importorskip("irsim")
    monkeypatch.syspath_prepend(str(tmp_path))
    registry = "irsim.lib.behavior.behavior_registry"
    (tmp_path / "late_theirs.py").write_text(BESIDE.format(home="irsim.lib", class_home=registry))
    (tmp_path / "late_ours.py").write_text(BESIDE.format(home="irsim_gym.irsim", class_home="irsim_gym.irsim"))
    (tmp_path / "late_world.yaml").write_text(BESIDE_FILE)
    theirs = irsim.make(str(tmp_path / "late_world.yaml"), display=False, disable_all_plot=True)
    theirs.load_behavior("late_theirs")
    ours = irsim_gym.load(tmp_path / "late_world.yaml")
    ours.load_behavior("late_ours")
    for _ in range(30):
        theirs.step()
        ours.step()
        for there, here in zip(theirs.robot_list, ours.robots, strict=True):
            assert here.state.tolist() == pytest.approx(there.state[:, 0].tolist(), abs=1e-12)
    theirs.end(0)
    assert abs(ours.robots[0].state[0] - 1) > 0.5
