"""Checks what a caller passes to a simulation: levels, agents and commands."""

from collections.abc import Sequence

import numpy as np

from irsim_gym.base import rng
from irsim_gym.base.arraytypes import Floats, Ints
from irsim_gym.scenario.specs.spec import Scenario

LEVELS = int(rng.LATER)
"""Number of seeds; larger ones wrap around. Levels that follow the first one of a seed have larger numbers."""
MOST = 2**63
NOBODY = (
    "commands are given, but nobody takes them: compile(scenario, agents=[0]) says which bodies are commanded at each "
    "step, step(commands, bodies=[0]) commands some in one step alone"
)


def check_scenario(scenario: object) -> None:
    """Raise unless the argument is a loaded scenario.

    Raises:
        TypeError: It is a name or anything else.
    """
    if not isinstance(scenario, Scenario):
        shown = repr(scenario) if isinstance(scenario, str) else "..."
        raise TypeError(f"compile() takes a scenario, got {type(scenario).__name__}: compile(load_scenario({shown}))")


def check_agents(agents: Sequence[int], scenario: Scenario) -> tuple[int, ...]:
    """Return the bodies that are commanded from outside; raise a ValueError if one does not exist."""
    return tuple(_bodies(agents, scenario, "agents=").tolist())


def check_level(level: object, n_worlds: int) -> int:
    """Return the level of the first of several worlds.

    Raises:
        TypeError: It is no whole number.
        ValueError: It is negative, or larger than 64 bits can hold.
    """
    if isinstance(level, bool) or not isinstance(level, int | np.integer):
        raise TypeError(f"a seed is a whole number, got {level!r}")
    if not 0 <= level <= MOST - n_worlds:
        raise ValueError(f"a seed is a whole number from 0 to {MOST - n_worlds}, got {level}")
    return int(level)


def check_bodies(bodies: object, scenario: Scenario) -> Ints:
    """Return bodies as an array ``(n_bodies,)``; raise a ValueError if one does not exist."""
    return _bodies(bodies, scenario, "bodies=")


def check_commands(commands: object, bodies: Ints, scenario: Scenario, n_worlds: int) -> Floats:
    """Return commands that can be broadcast to ``(n_worlds, n_bodies, n)``, n as many as the largest drive takes, or 3.

    Raises:
        ValueError: They cannot, or there is nobody to command.
    """
    if not len(bodies):
        raise ValueError(NOBODY)
    drives = [scenario.bodies[int(b)].kinematics for b in bodies]
    names = max((drive.command_names for drive in drives if drive is not None), key=len, default=())
    if not names:
        raise ValueError(f"'{scenario.bodies[int(bodies[0])].name}' takes no commands: it has no kinematics")
    numbers = np.asarray(commands, np.float64)
    shape = (n_worlds, len(bodies), len(names))
    outer = zip(reversed(numbers.shape[:-1]), reversed(shape[:-1]), strict=False)
    fits = 0 < numbers.ndim <= 3 and numbers.shape[-1] in (len(names), 3) and all(n in (1, m) for n, m in outer)
    if not fits:
        raise ValueError(
            f"commands are {len(names)} numbers ({', '.join(names)}), or an array (n_worlds, n_bodies, {len(names)}) = "
            f"{shape} of them, or anything that is broadcast to that; got shape {numbers.shape}"
        )
    return numbers


def _bodies(given: object, scenario: Scenario, what: str) -> Ints:
    array = np.asarray(given)
    n_bodies = len(scenario.bodies)
    is_listed = array.ndim == 1 and (array.dtype.kind in "iu" or not array.size)
    if not (is_listed and all(0 <= b < n_bodies for b in array.tolist())):
        known = ", ".join(f"{b} '{body.name}'" for b, body in enumerate(scenario.bodies[:4]))
        more = ", ..." if n_bodies > 4 else ""
        raise ValueError(f"{what} takes indices of bodies, e.g. [0]; there are {known or 'none'}{more}; got {given!r}")
    return array.astype(np.int64)


def check_worlds(n_worlds: int, name: str = "n_worlds") -> None:
    """Raise if the number of worlds is not valid.

    Args:
        n_worlds: The number.
        name: What the caller calls it.

    Raises:
        ValueError: It is not an integer of at least 1.
    """
    if isinstance(n_worlds, bool) or not isinstance(n_worlds, int | np.integer) or n_worlds < 1:
        raise ValueError(f"{name} must be a whole number >= 1, got {n_worlds!r}")
