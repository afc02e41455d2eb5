"""Turns the arguments of ``World.step`` into one action per body."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.base.errors import UnknownNameError
from irsim_gym.live.session.roster import Reference, Roster

Action = Sequence[float] | Floats
Actions = Action | Sequence[Action | None] | Mapping[str, Action | None]


def pair_actions(
    actions: Actions, references: Reference | Sequence[Reference] | None, roster: Roster
) -> dict[int, Floats]:
    """Return the action for each body that gets one.

    Args:
        actions: One action (a flat list, tuple or array of numbers), a list of actions, or a mapping from names.
        references: Bodies that the actions are for: a number or name, or a list of them. By default, one action is for
            the first body, and a list of actions for the bodies from the first on. One action may be for a list of
            bodies. A list of actions is for a list of as many bodies, or for the bodies from a named one on.
        roster: The bodies.

    Raises:
        ValueError: There is no such body, or there are more actions than bodies.
        TypeError: The actions are none of these.
    """

    def find(reference: Reference) -> int:
        try:
            return roster.index(reference)
        except UnknownNameError as error:
            raise ValueError(str(error)) from None

    if isinstance(actions, Mapping):
        if references is not None:
            raise ValueError("a mapping names the bodies already: leave action_id out")
        return _numbers((find(name), action) for name, action in actions.items())
    if not isinstance(actions, list | tuple | np.ndarray):
        raise TypeError(f"an action is a list, a tuple, an array or a mapping, got {type(actions).__name__}")
    if isinstance(references, str | int | np.integer | None):
        first = 0 if references is None else find(references)
        if is_single(actions):
            return _numbers([(first, actions)])
        targets = list(range(first, len(roster)))[: len(actions)]
    else:
        targets = [find(reference) for reference in references]
        if is_single(actions):
            return _numbers((target, actions) for target in targets)
    if len(targets) != len(actions):
        raise ValueError(f"{len(actions)} actions for {len(targets)} bodies")
    return _numbers(zip(targets, actions, strict=True))


def is_single(actions: Sequence[object] | Floats) -> bool:
    """Return whether this is one action: a flat row of numbers, or a column as in IR-SIM."""
    if isinstance(actions, np.ndarray):
        return actions.ndim < 2 or max(actions.shape) == actions.size
    return len(actions) > 0 and all(np.isscalar(value) for value in actions)


def _numbers(pairs: Iterable[tuple[int, Action | None]]) -> dict[int, Floats]:
    """Return the actions as rows of numbers, without those that are None."""
    rows = {}
    for body, action in pairs:
        if action is not None:
            rows[body] = np.asarray(action, np.float64).reshape(-1)
            if not np.isfinite(rows[body]).all():
                raise ValueError(f"an action must be finite, got {rows[body].tolist()}")
    return rows
