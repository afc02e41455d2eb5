"""Binds the kinds of a task to a simulation, as terms."""

from collections.abc import Sequence

import numpy as np

from irsim_gym.base.arraytypes import Flags, Ints, Rays
from irsim_gym.base.contract import is_foreign
from irsim_gym.base.registry import Registry
from irsim_gym.simulator.engine import Simulation
from irsim_gym.simulator.world.arrays import aligned
from irsim_gym.simulator.world.group import Group
from irsim_gym.simulator.world.kinds import NamesCommand
from irsim_gym.simulator.world.model import OMNI_WORLD, ROBOT
from irsim_gym.tasks.definition.task import Task
from irsim_gym.tasks.plugin_checks.term_contract import check_bound, checked_bounds
from irsim_gym.tasks.terms.outcome import HitKind
from irsim_gym.tasks.terms.term import AHEAD_AND_LEFT, HasArrays, HasUnused, IsImage, Joins, Term, Words

Parts = tuple[tuple[str, Rays, Rays], ...]


def action_sizes(simulation: Simulation, agents: Ints) -> Ints:
    """Return the number of components of each agent's commands, shape ``(n_agents,)``."""
    bodies = simulation.scenario.bodies
    return np.array([len(bodies[int(b)].kinematics.command_names) for b in agents], np.int64)


def bind(family: Registry, options: Sequence[object], simulation: Simulation, task: Task) -> list[Term]:
    """Return the terms of kinds, with their own arrays; a term's column is its position in the list."""
    agents = np.array(task.agents, np.int64)
    sizes = action_sizes(simulation, agents)
    words = tuple(_action_words(simulation, task, int(b)) for b in agents)
    parts, context = simulation.parts, simulation.context
    terms: list[Term] = []
    for column, item in enumerate(options):
        term = Term(family.name_of(type(item)), item, agents, task.max_steps, int(sizes.max()), sizes, column)
        term.components = words
        term.bodies = Group(type(item), [item] * len(agents), agents, np.zeros(0), names=parts.names, context=context)
        if isinstance(item, HasArrays):
            term.arrays = item.arrays(simulation, agents)
        if isinstance(item, Joins):
            item.join(term, terms)
        if is_foreign(type(item)):
            check_bound(family.family, term)
        if isinstance(item, IsImage):
            term.image = aligned((simulation.n_worlds, len(agents), *item.image_shape), np.uint8)
        terms.append(term)
    return terms


def _action_words(simulation: Simulation, task: Task, body: int) -> Words:
    """Return the names of the components of an agent's action, with their units."""
    drive = simulation.scenario.bodies[body].kinematics
    if simulation.model.drive[body] == OMNI_WORLD and getattr(task.action, "frame", "command") == "body":
        return AHEAD_AND_LEFT
    return drive.command_words if isinstance(drive, NamesCommand) else tuple((name, "") for name in drive.command_names)


def place_observations(terms: Sequence[Term], simulation: Simulation) -> tuple[Parts, Flags]:
    """Assign columns to the parts of the observation; images have none.

    Returns:
        Name, lower and upper bounds of each part; and a mask of the columns that each agent has, shape ``(n_agents,
        n_features)``.
    """
    parts, column = [], 0
    used = [np.ones((len(simulation.agents), 0), np.bool_)]
    for term in terms:
        if isinstance(term.options, IsImage):
            continue
        term.column = column
        bounds = checked_bounds if is_foreign(type(term.options)) else term.options.bounds
        low, high = term.bounds = bounds(term, simulation.model)
        parts.append((term.name, low, high))
        column += len(low)
        everything = np.ones((len(term.agents), len(low)), np.bool_)
        used.append(term.options.used(term) if isinstance(term.options, HasUnused) else everything)
    return tuple(parts), np.concatenate(used, axis=1)


def hit_kinds(simulation: Simulation) -> Ints:
    """Return the HitKind of each body for a robot that touches it, shape ``(n_bodies,)``."""
    model = simulation.model
    kinds = np.where(model.stands, int(HitKind.OBSTACLE), int(HitKind.MOVING_OBSTACLE))
    kinds[model.role == ROBOT] = int(HitKind.ROBOT)
    if (cells := model.cells) is not None:
        kinds[cells.body] = int(HitKind.MAP)
    return kinds.astype(np.int64)
