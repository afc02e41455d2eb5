"""The groups and index lists that a compiled scenario consists of."""

from dataclasses import dataclass, field

import numpy as np

from irsim_gym.simulator.contact.swept import SweptMotion
from irsim_gym.simulator.levels.level_table import LevelTable
from irsim_gym.simulator.levels.path_checks import ReachabilityCheck
from irsim_gym.simulator.pushing.matter import Matter
from irsim_gym.simulator.pushing.memory import Pushing
from irsim_gym.simulator.step.disturbances import Disturbances
from irsim_gym.simulator.step.fog import FogMap
from irsim_gym.simulator.step.patience import Patience
from irsim_gym.simulator.step.turns import Turn
from irsim_gym.simulator.world.names import Group, Ints, Records


@dataclass
class Parts:
    """Groups in the order in which they act, and lists of bodies by what is done with them.

    Attributes:
        kinematics: Bodies that move, by drive.
        behaviors: Bodies that decide for themselves, by behaviour.
        group_behaviors: Groups whose members decide together, from the state at the beginning of the step.
        turns: The order in which bodies decide and move.
        visitors: Bodies whose behaviours let them appear and disappear, by behaviour.
        external: Whether only the caller moves bodies (``step_mode: external``).
        footprints: Bodies whose outline each level draws, by shape.
        maps: The body of an occupancy map that each level draws; empty without one.
        placements: Entries of the file, in the order in which they are placed.
        levels: Levels that a file gives; None where they are drawn.
        free: Entries with bodies that no file of levels places.
        promised: Bodies whose placement ensures a way, and after which bodies that stand are placed, by entry.
        sensors: Sensors, by kind and beams.
        movers: Bodies that can move.
        fixed: Bodies that cannot.
        goal_bodies: Bodies with a goal.
        everyone: All bodies.
        measured: Bodies whose radius and centroid change with their outline, if anything reads these.
        number_ranges: First body, least and greatest number of bodies of entries with ``number_range``, shape ``(n,
            3)``.
        traits: What a level draws of bodies besides outlines and places, records of type ``traits.TRAITS``.
        loop_returns: Bodies that loop between a single goal and their start.
        ways: Agents whose path to the goal is checked when a level is drawn.
        fog: What the robots have explored; None unless the file asks for it.
        sweep: Memory for contacts within a step; None where only its end is tested.
        patience: Wandering bodies that go on after a collision; None without any.
        matter: What bodies weigh; None unless they push each other or coast.
        pushing: What they feel of each other; None unless they push each other.
        names: The bodies' names.
        places: Name, file and line of each body, for messages.
        disturbances: What disturbs robots.
    """

    kinematics: list[Group]
    behaviors: list[Group]
    group_behaviors: list[Group]
    turns: list[Turn]
    visitors: list[Group]
    external: bool
    footprints: list[Group]
    maps: list[Group]
    placements: list[Group]
    levels: LevelTable | None
    free: list[Group]
    promised: list[Group]
    sensors: list[Group]
    movers: Ints
    fixed: Ints
    goal_bodies: Ints
    everyone: Ints
    measured: Ints
    number_ranges: Ints
    traits: Records
    loop_returns: Ints
    ways: ReachabilityCheck
    fog: FogMap | None
    sweep: SweptMotion | None
    patience: Patience | None
    matter: Matter | None
    pushing: Pushing | None
    names: tuple[str, ...]
    places: tuple[str, ...]
    disturbances: Disturbances = field(default_factory=Disturbances)

    @property
    def coasting(self) -> Ints:
        """Bodies that move without a drive."""
        return np.zeros(0, np.int64) if self.matter is None else self.matter.coasting

    @property
    def remembering(self) -> list[Group]:
        """Groups of kinds written as functions, whose ``arrays["memory"]`` holds an object for each world and body."""
        believed = [] if self.disturbances.belief is None else self.disturbances.belief.drives
        groups = (*self.behaviors, *self.group_behaviors, *self.sensors, *self.kinematics, *believed)
        return [group for group in groups if getattr(group.arrays.get("memory"), "dtype", None) == np.object_]
