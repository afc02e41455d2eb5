"""Every public name of the installed ir-sim is here, or an error says what to use."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import irsim
import irsim.lib.path_planners
import irsim.msg
import irsim.world.map
import irsim.world.sensors
import pytest
from irsim.env import EnvBase
from irsim.world import World

import irsim_gym.irsim as ours
from irsim_gym.bodies.behaviors.python.views import BodyView, tell_missing

FILE = """
world: {height: 8, width: 8, step_time: 0.1, collision_mode: contact}
robot:
  - kinematics: {name: diff}
    state: [1, 1, 0]
    goal: [7, 6, 0]
    sensors: [{name: lidar2d, number: 12}, {name: fmcw_lidar2d, number: 4}, {name: contact2d}]
obstacle:
  - shape: {name: rectangle, length: 2, width: 0.6}
    state: [4, 3, 0.5]
  - shape: {name: rectangle, length: 0.6, width: 0.6}
    state: [1.49, 1, 0]
    mass: 2
"""
INNER = {"bind_env", "debug_step"}


def modules() -> list[str]:
    return [found.name for found in pkgutil.walk_packages(irsim.__path__, "irsim.")]


def importable() -> Iterator[str]:
    """Yield the public classes and functions of all modules, and whatever else packages list in ``__all__``."""
    for name in ["irsim", *modules()]:
        module = importlib.import_module(name)
        yield from (one for one in getattr(module, "__all__", ()) if not inspect.ismodule(getattr(module, one)))
        for one, value in vars(module).items():
            is_own = str(getattr(value, "__module__", "")).startswith("irsim")
            if not one.startswith("_") and is_own and (inspect.isclass(value) or inspect.isfunction(value)):
                yield one


def public(thing: object) -> list[str]:
    return [name for name in dir(thing) if not name.startswith("_")]


def untold(thing: object, names: Iterable[str]) -> list[str]:
    """Return what is said of names that are neither there nor told what to use."""
    found = []
    for name in sorted(set(names)):
        try:
            getattr(thing, name)
        except (AttributeError, ImportError) as error:
            if isinstance(thing, BodyView):
                tell_missing(error)  # type: ignore[arg-type]
            if ": " not in str(error) or "did you mean" in str(error):
                found.append(f"{name}: {error}")
    return found


def test_names_to_import() -> None:
    names = set(importable())
    assert len(names) > 150
    assert not (missing := untold(ours, names)), "\n".join(missing)
    with pytest.raises(ImportError, match=r"has no 'TreeNode': planning\(start, goal\) is all that planners do"):
        from irsim_gym.irsim import TreeNode  # noqa: F401
    with pytest.raises(ImportError, match=r"KinematicsFactory.*@register_kinematics"):
        from irsim_gym.irsim.lib import KinematicsFactory  # noqa: F401


def test_modules_to_import() -> None:
    """Each of IR-SIM's modules is another name of ours."""
    assert [name for name in modules() if importlib.import_module(f"irsim_gym.{name}") is not ours] == []
    from irsim_gym.irsim.lib.behavior.behavior_methods import DiffDash
    from irsim_gym.irsim.util.util import WrapToPi

    assert (DiffDash, WrapToPi) == (ours.DiffDash, ours.WrapToPi)
    assert ours.util.util.WrapToPi is ours.lib.behavior.WrapToPi is WrapToPi
    with pytest.raises(ModuleNotFoundError):
        importlib.import_module("irsim_gym.irsim.utils")


@pytest.fixture(scope="module")
def both(tmp_path_factory: pytest.TempPathFactory) -> tuple[Any, Any]:
    file: Path = tmp_path_factory.mktemp("names") / "yard.yaml"
    file.write_text(FILE, encoding="utf-8")
    theirs = irsim.make(str(file), headless=True, log_level="CRITICAL")
    here = ours.make(file)
    for env in (theirs, here):
        env.step([0.5, 0.1])
    return theirs, here


def test_names_of_a_world(both: tuple[Any, Any]) -> None:
    theirs, here = both
    assert isinstance(theirs, EnvBase)
    assert not untold(here, public(theirs))
    assert not untold(here, ["_world", "_objects", "_env_plot", "_env_param"])
    assert not untold(here._world, {*public(theirs._world), *public(World)})
    assert not untold(here.world_param, public(theirs.world_param))
    assert not untold(here.logger, public(theirs.logger))
    assert not untold(here.get_map(), public(theirs.get_map()))


def test_names_of_bodies_and_sensors(both: tuple[Any, Any]) -> None:
    theirs, here = both
    for one, another in zip(theirs.objects, here.objects, strict=True):
        assert not untold(another, {*public(one), "_state", "_goal", "_velocity", "_world_param"})
        assert not untold(another.info, public(one.info))
        assert not untold(another.obstacle_info, public(one.get_obstacle_info()))
    for sensor, own in zip(theirs.robot.sensors, here.robot.sensors, strict=True):
        assert not untold(own, public(sensor))
    group = here.simulation.parts.kinematics[0]
    view = BodyView(group, here.simulation.model, here.simulation.state, 0, 0)
    assert not untold(view, public(theirs.robot))


def test_names_of_contacts_and_messages(both: tuple[Any, Any]) -> None:
    theirs, here = both
    assert (len(theirs.contacts), len(here.contacts)) == (1, 1)
    assert not untold(here.contacts[0], public(theirs.contacts[0]))
    for one, own in zip(theirs.objects, here.objects, strict=True):
        assert not untold(own.contact, public(one.contact))
        for report, other in zip(one.contact.reports, own.contact.reports, strict=True):
            assert not untold(other, public(report))
    assert here.robot.sensors[2].force.tolist() == here.robot.contact.force.tolist() != [[0.0], [0.0]]
    for name in irsim.msg.__all__:
        kind = getattr(irsim.msg, name)
        fields = set(getattr(kind, "__slots__", ()))
        assert not untold(getattr(ours, name), set(public(kind)) - fields), name
        assert not untold(getattr(ours, name)(), fields), name
    with pytest.raises(AttributeError, match=r"WorldState has no 'from_env': world.get_msg\(\) makes"):
        ours.WorldState.from_env(here)


def test_names_of_planners(both: tuple[Any, Any]) -> None:
    theirs, here = both
    for name in ("AStarPlanner", "JPSPlanner"):
        planner = getattr(irsim.lib.path_planners, name)(theirs.get_map())
        assert not untold(getattr(ours, name)(here.get_map()), public(planner))
    for name in ("RRT", "RRTStar", "InformedRRTStar"):
        planner = getattr(irsim.lib.path_planners, name)(theirs.get_map(), robot=theirs.robot)
        assert not untold(getattr(ours, name)(here.get_map(), robot=here.robot), public(planner))
    planner = irsim.lib.path_planners.PRMPlanner(theirs.get_map(), 0.2)
    assert not untold(ours.PRMPlanner(here.get_map(), 0.2), public(planner))
