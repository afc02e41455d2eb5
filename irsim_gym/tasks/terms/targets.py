"""Bodies that are to be pushed to a target: their goals, or an area."""

from dataclasses import dataclass
from typing import ClassVar, Protocol, runtime_checkable

import numpy as np

from irsim_gym.base.arraytypes import Flags, Floats, Ints, Point
from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.simulator.step.arrival import goal_gap
from irsim_gym.simulator.world.model import STATE
from irsim_gym.tasks.terms import Model, Simulation, State, Struct, kernel, kind, option, row_of

Area = tuple[float, float, float, float]
NO_AREA = (np.nan, np.nan, np.nan, np.nan)
NO_CONTACTS = "bodies push each other with collision_mode contact alone"


def without_contacts(scenario: Scenario) -> str | None:
    """Return what a scenario lacks in which bodies do not push each other, as text."""
    return None if scenario.world.collision_mode == "contact" else NO_CONTACTS


def pushable(scenario: Scenario) -> list[int]:
    """Return the bodies that can be pushed and do not drive."""
    return [b for b, body in enumerate(scenario.bodies) if body.coasts and not body.unobstructed]


@runtime_checkable
class FitsScenario(Protocol):
    """A kind of a task that needs something of the scenario."""

    def misfit(self, scenario: Scenario) -> str | None:
        """Return what the scenario lacks, as text; None if it fits."""


@dataclass
class Targets(Struct):
    """Bodies with their targets, and what is remembered of them.

    Attributes:
        bodies: The bodies, shape ``(n,)``.
        area: Where they belong: x0, y0, x1, y1 [m], shape ``(4,)``; NaN where it is the goal of each.
        goal: Their goals one step ago [m], shape ``(n_worlds, n, 2)``.
        distance: Their distances from their targets then [m], shape ``(n_worlds, n)``.
        counted: Bodies whose arrival an agent has been paid for, or that lay in their target when its episode began;
            shape ``(n_worlds, n_agents, n)``.
    """

    bodies: Ints
    area: Floats
    goal: Floats
    distance: Floats
    counted: Flags


@kind
class OfBodies:
    """What kinds about bodies that can be pushed have in common."""

    needs_goal: ClassVar[bool] = False
    needs_target: ClassVar[bool] = False

    bodies: tuple[str, ...] = option((), meaning="Names of bodies or groups; default: all that can be pushed.")
    area: Area | None = option(
        None, unit="m", meaning="Where their origins belong: x0, y0, x1, y1; default: the goal of each."
    )

    def chosen(self, scenario: Scenario) -> list[int]:
        """Return the bodies that it is about."""
        names, bodies, is_any = set(self.bodies), scenario.bodies, self.area is not None or not self.needs_target
        aimed = [b for b in pushable(scenario) if is_any or has_goal(scenario, b)]
        return [b for b in aimed if not names or names & {bodies[b].name, bodies[b].group_name}]

    def misfit(self, scenario: Scenario) -> str | None:
        """Return what the scenario lacks, as text."""
        chosen, area = self.chosen(scenario), self.area
        found = {name for b in chosen for name in (scenario.bodies[b].name, scenario.bodies[b].group_name)}
        unknown = [name for name in self.bodies if name not in found]
        if lacks := without_contacts(scenario):
            return lacks
        if area is not None and not (area[0] < area[2] and area[1] < area[3]):
            return f"'area' must be x0, y0, x1, y1 with x0 < x1 and y0 < y1, got {list(area)}"
        if unknown or not chosen:
            what = f"{unknown[0]!r} is" if unknown else "there is"
            aim = ", with a 'goal' unless there is an 'area'" if self.needs_target else ""
            return f"{what} no body that can be pushed: an obstacle with a finite 'mass', and without a drive, can{aim}"
        return None

    def targets(self, simulation: Simulation, n_agents: int) -> Targets:
        """Return the bodies with their targets."""
        bodies, n_worlds = np.array(self.chosen(simulation.scenario), np.int64), simulation.n_worlds
        shape = (n_worlds, len(bodies))
        area = np.array(NO_AREA if self.area is None else self.area, np.float64)
        counted = np.zeros((n_worlds, n_agents, len(bodies)), np.bool_)
        return Targets(bodies=bodies, area=area, goal=np.zeros((*shape, 2)), distance=np.zeros(shape), counted=counted)


@kind
class ToTargets(OfBodies):
    """What kinds about bodies that are pushed to a target have in common."""

    needs_target: ClassVar[bool] = True


def has_goal(scenario: Scenario, b: int) -> bool:
    """Return whether a body has a goal, or levels draw one."""
    body = scenario.bodies[b]
    return bool(body.goal) or bool(scenario.placements[body.entry].kind.gives_goal) or body.wanders


@kernel
def way_to_target(pose: Floats, area: Floats, goal: Floats) -> Point:
    """Return the way from a pose to a goal, or into the area if there is one [m]."""
    if np.isnan(area[0]):
        return goal[0] - pose[0], goal[1] - pose[1]
    return min(max(pose[0], area[0]), area[2]) - pose[0], min(max(pose[1], area[1]), area[3]) - pose[1]


@kernel
def lies_there(w: int, b: int, area: Floats, model: Model, state: State) -> bool:
    """Return whether a body lies in the area, or else nearer to its last goal than its threshold.

    Reads: model (arrive_mode, goal_threshold), state (goal, pose, waypoint, waypoint_end).
    """
    if not np.isnan(area[0]):
        dx, dy = way_to_target(state.pose[w, b], area, state.goal[w, b])
        return dx == 0.0 and dy == 0.0
    gap = goal_gap(state.pose[w, b], state.goal[w, b], model.arrive_mode[b] == STATE)
    is_last = state.waypoint[w, b] + 1 >= state.waypoint_end[w, b]
    return bool(is_last and gap < model.goal_threshold[row_of(model.goal_threshold, w), b])
