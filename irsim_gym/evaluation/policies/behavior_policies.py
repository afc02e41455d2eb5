"""Behaviours of the scenario language as policies: baselines that need no training.

They see the whole state of the world, as simulated bodies do, not the learners' observations. Like learners, all agents
decide at the beginning of the step, whereas bodies with such a behaviour move one after another unless the file sets
``world: {update: simultaneous}``. Their decisions become commands of the drives as in the simulation.

An agent has the options of its own behaviour if the scenario gives it one of that kind. Otherwise it has the defaults
with two exceptions, since a baseline should be at its best. First, ``vxmax`` and ``vymax`` of ``rvo`` are the maximum
speeds of the drive, as ``maxSpeed`` of ``orca`` is by default. Second, ``orca`` looks 5 s ahead (2 s at walls) and
steps aside: if it looks 20 s ahead, IR-SIM's default, robots crawl, and four of them fail in 27 % of 1,000 levels of
``circle_swap`` instead of in none.
"""

from collections.abc import Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base import families
from irsim_gym.base.arraytypes import Floats, Ints
from irsim_gym.base.errors import IrsimGymError
from irsim_gym.base.families import BEHAVIORS, GROUP_BEHAVIORS, KINEMATICS
from irsim_gym.evaluation.policies.drive_actions import decided_commands, to_actions
from irsim_gym.evaluation.policies.named_policies import kind_name, read_options
from irsim_gym.evaluation.policies.policy import without_lone_axis
from irsim_gym.scenario.entries.body_checks import SCANNER, has_range_sensor
from irsim_gym.simulator.engine import Shard
from irsim_gym.simulator.engine.own_scans import with_scans
from irsim_gym.simulator.levels.body_measures import measure
from irsim_gym.simulator.step.guide import decide, guide
from irsim_gym.simulator.world.group import Group
from irsim_gym.simulator.world.model import DIFFERENTIAL, NO_DRIVE
from irsim_gym.tasks import Episodes, Outcome

AT_THEIR_BEST = MappingProxyType({"orca": {"timeHorizon": 5.0, "timeHorizonObst": 2.0, "sidestep": True}})
"""Options that replace the defaults, tuned on ``dev`` levels of circle_swap and random_swap with 4 to 16 robots."""


class UnfitBehaviorError(IrsimGymError, ValueError):
    """A behaviour that cannot drive an agent."""


class BehaviorPolicy:
    """Drives the agents by a registered behaviour: each for itself, or all together as a group.

    In a group, agents whose episode has ended do not decide but are still seen, as is everything else that can move.
    All decide with the options of the first agent.

    Args:
        name: Name of the behaviour or group behaviour in YAML, optionally with options: ``pursuit:known=seen``.
        driven: Indices of the agents that it drives; None for all. It sees the others as moving bodies, and its
            actions for them are meaningless.
    """

    def __init__(self, name: str, driven: Sequence[int] | None = None) -> None:
        families.load()
        self.name, self.driven, self.options = name, driven, read_options(name)
        name = kind_name(name)
        self.is_group = name not in BEHAVIORS and name in GROUP_BEHAVIORS
        self.kind = (GROUP_BEHAVIORS if self.is_group else BEHAVIORS).entry(name).kind
        self._episodes: Episodes | None = None
        self._groups: list[Group] = []

    def check(self, episodes: Episodes) -> None:
        """Check that the behaviour can drive all agents.

        Raises:
            UnfitBehaviorError: If the behaviour cannot command the drive of an agent, or lacks the scan that it reads.
        """
        for body in self._bodies(episodes).tolist():
            spec = episodes.simulation.scenario.bodies[body]
            drive = type(spec.kinematics)
            if not families.commands(self.kind, drive) and not families.steers(self.kind, drive):
                name = KINEMATICS.name_of(drive)
                raise UnfitBehaviorError(f"'{self.name}' cannot drive kinematics '{name}' of '{spec.name}'")
            family = "group_behavior" if self.is_group else "behavior"
            options = _options(episodes, body, family, self)
            if getattr(options, "reads_scan", False) and not has_range_sensor(spec.sensors):
                place = episodes.simulation.parts.places[body]
                raise UnfitBehaviorError(f"'{self.name}' reads a scan, but {place} has no range sensor; {SCANNER}")

    def begin(self, episodes: Episodes, worlds: Ints, levels: Ints) -> None:
        """Prepare for the drives and sizes of the bodies.

        Raises:
            UnfitBehaviorError: If the behaviour cannot command the drive of an agent.
        """
        simulation = episodes.simulation
        if self._episodes is not episodes:
            self.check(episodes)
            bind = _one_group if self.is_group else _groups_by_drive
            self._groups = bind(self, episodes, self._bodies(episodes))
            for group in self._groups:
                group.context = simulation.context
                self.kind.prepare(group, simulation.model, simulation.shards.n_slots)
                guide(group, simulation.scenario.bodies, simulation.parts.kinematics, simulation.model)
            self._episodes = episodes
        if hasattr(self.kind, "begin"):
            shard = Shard(np.ascontiguousarray(worlds))
            for group in self._groups:
                self.kind.begin(group, shard)
        if self.kind.reads_neighbors:
            measure(worlds, simulation.parts.everyone, simulation.model)

    def _bodies(self, episodes: Episodes) -> Ints:
        """Return the driven bodies."""
        agents = episodes.simulation.agents
        return agents if self.driven is None else agents[np.array(self.driven, np.int64)]

    def act(self, episodes: Episodes, worlds: Ints) -> NDArray[np.float64] | Ints:
        """Return the actions of worlds."""
        return without_lone_axis(to_actions(episodes, worlds, self.command(episodes, worlds)))

    def command(self, episodes: Episodes, worlds: Ints) -> Floats:
        """Return the commands that the behaviour asks for [m/s, rad/s], ``(n, n_agents, n_components)``."""
        simulation, shard = episodes.simulation, Shard(np.ascontiguousarray(worlds))
        if self.is_group:
            _show_who_stands(episodes, worlds)
        for group in self._groups:
            decide(group, simulation.model, simulation.state, shard)
        return decided_commands(episodes, worlds)


def _groups_by_drive(policy: BehaviorPolicy, episodes: Episodes, driven: Ints) -> list[Group]:
    """Return the driven bodies in groups that share a drive, as behaviours need them."""
    simulation = episodes.simulation
    drives, groups = simulation.model.drive[driven], []
    for drive in np.unique(drives):
        members = driven[drives == drive]
        options = [_options(episodes, body, "behavior", policy) for body in members.tolist()]
        group = Group(policy.kind, options, members, names=simulation.parts.names)
        groups += with_scans(group, simulation.scenario.bodies, simulation.sensors)
    return groups


def _one_group(policy: BehaviorPolicy, episodes: Episodes, driven: Ints) -> list[Group]:
    """Return one group of everything that can move, in which the driven bodies decide."""
    simulation = episodes.simulation
    options = _options(episodes, int(driven[0]), "group_behavior", policy)
    members = np.flatnonzero(simulation.model.movable)
    group = Group(policy.kind, [options] * len(members), members, names=simulation.parts.names)
    group, *others = with_scans(group, simulation.scenario.bodies, simulation.sensors)
    if others:
        place = simulation.parts.places[int(others[0].members[0])]
        raise UnfitBehaviorError(f"'{policy.name}' reads scans with the same beams, but {place} has another sensor")
    group.arrays["decides"] = np.isin(members, driven)
    return [group]


def _options(episodes: Episodes, body: int, family: str, policy: BehaviorPolicy) -> object:
    """Return a body's options: given ones over its own, or over the best defaults with the speeds of its drive."""
    behavior, kind = getattr(episodes.simulation.scenario.bodies[body], family), policy.kind
    if isinstance(behavior, kind):
        return replace(behavior, **policy.options) if policy.options else behavior
    options = kind(**{**AT_THEIR_BEST.get(kind_name(policy.name), {}), **policy.options})
    model = episodes.simulation.model
    if not hasattr(options, "vxmax"):
        return options
    fastest = model.velocity_max[:, body].max(axis=0)
    sideways = fastest[0] if model.drive[body] in (DIFFERENTIAL, NO_DRIVE) else fastest[1]
    return replace(options, **{"vxmax": float(fastest[0]), "vymax": float(sideways), **policy.options})


def _show_who_stands(episodes: Episodes, worlds: Ints) -> None:
    """Show agents whose episode has ended with their actual velocities, not with their last planned ones."""
    simulation = episodes.simulation
    row, agent = np.nonzero(episodes.view.infos["outcome"][worlds] != Outcome.RUNNING)
    places = worlds[row], simulation.agents[agent]
    simulation.state.plan[places] = simulation.state.twist[places][:, :2]
