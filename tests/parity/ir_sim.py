"""ir-sim 2.12.0, silent and without a window, with its whole state at hand."""

from __future__ import annotations

import contextlib
import io
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import yaml


@contextlib.contextmanager
def silent() -> Iterator[None]:
    """Hold back ir-sim's warnings and whatever it prints."""
    with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
        warnings.simplefilter("ignore")
        yield


@cache
def package() -> Any:
    """Return the package; importing it sets matplotlib's backend and prints."""
    with silent():
        import irsim
    return irsim


@contextlib.contextmanager
def rounded_centres() -> Iterator[None]:
    """Take the rounding errors out of the centroids of ir-sim's polygons of 64 corners."""
    kind = package().world.ObjectBase
    exact: Any = kind.centroid.fget
    with mock.patch.object(kind, "centroid", property(lambda one: np.round(exact(one), 12))):
        yield


@dataclass
class Snapshot:
    """Everything of ir-sim's state that a step reads, one item per object.

    Attributes:
        states: x, y, heading and for a car the steering angle, one row each.
        velocities: In the object's own coordinates.
        goals: The queue of goals.
        flags: arrived, collided, stopped.
        touched: The objects it collides with.
        planned: Velocities that ORCA's simulators remember, one row per member.
        clock: Steps.
        random: State of the random generator.
    """

    states: list[Any]
    velocities: list[Any]
    goals: list[Any]
    flags: list[tuple[bool, bool, bool]]
    touched: list[Any]
    planned: list[list[tuple[float, float]]]
    clock: int
    random: Any


class IrSim:
    """One environment of ir-sim."""

    def __init__(self, scenario: Mapping[str, Any], folder: Path, seed: int = 0) -> None:
        file = folder / "scenario.yaml"
        file.write_text(yaml.safe_dump(dict(scenario), sort_keys=False))
        irsim = package()
        with silent():
            self.env = irsim.make(str(file), headless=True, log_level="CRITICAL", seed=seed)
        self.objects: list[Any] = list(self.env.objects)

    def step(self, actions: Mapping[int, Any] | None = None) -> None:
        """Advance by one step; ``actions`` are those of some objects."""
        given = actions or {}
        with silent():
            if given:
                self.env.step([np.array(action, float) for action in given.values()], list(given))
            else:
                self.env.step()

    def snapshot(self) -> Snapshot:
        """Return a copy of the state."""
        return Snapshot(
            [np.array(one._state, float) for one in self.objects],
            [np.array(one._velocity, float) for one in self.objects],
            [None if one._goal is None else one._goal.copy() for one in self.objects],
            [(bool(one.arrive_flag), bool(one.collision_flag), bool(one.stop_flag)) for one in self.objects],
            [list(one.collision_obj) for one in self.objects],
            [[sim.get_agent_velocity(k).to_tuple() for k in range(sim.get_num_agents())] for sim in self.planners],
            self.env._world.count,
            self.env._env_param.rng.bit_generator.state,
        )

    def restore(self, at: Snapshot) -> None:
        """Go back to a state."""
        for k, one in enumerate(self.objects):
            one._velocity, one._drive_velocity = at.velocities[k].copy(), at.velocities[k].copy()
            one._goal = None if at.goals[k] is None else at.goals[k].copy()
            one.arrive_flag, one.collision_flag, one.stop_flag = at.flags[k]
            one.collision_obj = list(at.touched[k])
            if not one.static:
                one._state = at.states[k].copy()
                one._geometry = one.gf.step(one.state)
            one._invalidate_reactive_cache()
        self.env.build_tree()
        for sim, velocities in zip(self.planners, at.planned, strict=True):
            for k, velocity in enumerate(velocities):
                sim.set_agent_velocity(k, list(velocity))
        self.env._world.count = at.clock
        self.env._env_param.rng.bit_generator.state = at.random

    @property
    def planners(self) -> list[Any]:
        """ORCA's simulators, one for each group that has one."""
        handlers = [group.group_behavior._invoke_func for group in self.env._object_groups]
        return [handler._sim for handler in handlers if hasattr(handler, "_sim")]

    @property
    def groups_of_planners(self) -> list[list[int]]:
        """The members of each of those groups."""
        number = {id(one): k for k, one in enumerate(self.objects)}
        return [
            [number[id(member)] for member in group.members]
            for group in self.env._object_groups
            if hasattr(group.group_behavior._invoke_func, "_sim")
        ]
