"""The order of moves: bodies whose behaviour sees others move one after another, as in IR-SIM."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from irsim_gym.simulator.world.names import Group, Ints, State


@dataclass
class Turn:
    """Bodies that decide together and then move together.

    Attributes:
        behaviors: Bodies that decide for themselves, by behaviour.
        movers: Bodies that can move.
        kinematics: The same, by drive.
        driven: Those of them that have a drive; the others coast.
        commands: Disturbances of their commands, in the order in which they act.
        motions: Disturbances of their motion, likewise.
        asked: The state with the commands that reach the drives; None where nothing disturbs them.
        moved: The state with the velocities with which bodies move; None where nothing disturbs them.
    """

    behaviors: list[Group]
    movers: Ints
    kinematics: list[Group]
    driven: Ints
    commands: list[Group] = field(default_factory=list)
    motions: list[Group] = field(default_factory=list)
    asked: State | None = None
    moved: State | None = None


def take_turns(
    movers: Ints, behaviors: Sequence[Group], kinematics: Sequence[Group], driven: Ints, *, in_order: bool
) -> list[Turn]:
    """Return the turns of a step.

    A behaviour that reads its neighbours must see the bodies before it after their move, and those behind it before
    theirs. So a turn begins with each such body and lasts until the next one. A scenario without such bodies has one
    turn.

    Args:
        movers: Bodies that can move, ascending.
        behaviors: Groups of bodies that decide.
        kinematics: Groups of bodies that move.
        driven: Bodies with a drive, ascending.
        in_order: Whether bodies move one after another; False for a single turn.
    """
    readers = [group.members for group in behaviors if group.kind.reads_neighbors] if in_order else []
    if not readers:
        return [Turn(list(behaviors), movers, list(kinematics), driven)]
    firsts = np.sort(np.concatenate(readers))
    # Turn k begins with the k-th body that reads its neighbours; turn 0 holds the bodies before the first of them.
    turn_of_mover, turn_of_driven = (np.searchsorted(firsts, bodies, side="right") for bodies in (movers, driven))
    decided = [_split(group, firsts) for group in behaviors]
    moved = [_split(group, firsts) for group in kinematics]
    turns = []
    for turn in np.unique(turn_of_mover).tolist():
        decides, moves = ([parts[turn] for parts in split if turn in parts] for split in (decided, moved))
        turns.append(Turn(decides, movers[turn_of_mover == turn], moves, driven[turn_of_driven == turn]))
    return turns


def _split(group: Group, firsts: Ints) -> dict[int, Group]:
    """Return the members of a group by turn."""
    # The parts share the arrays of the whole group, so behaviours index their memory by body or by slot.
    turns = np.searchsorted(firsts, group.members, side="right")
    return {turn: group.select(np.flatnonzero(turns == turn)) for turn in np.unique(turns).tolist()}
