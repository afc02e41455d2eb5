"""The grid of disturbances and strengths, from ``factors.json``."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from irsim_gym.base import families
from irsim_gym.base.errors import IrsimGymError, UnknownNameError, suggestion
from irsim_gym.base.families import DISTURBANCES
from irsim_gym.base.outside_files import json_object
from irsim_gym.scenario import Scenario
from irsim_gym.scenario.reading.perturbations import read_perturbations

GRID = Path(__file__).with_name("factors.json")
"""Factors by name, see ``Factor``."""


@dataclass(frozen=True)
class Factor:
    """A disturbance, or several together, of several strengths.

    Attributes:
        name: Its name.
        unit: Unit of the strengths.
        strengths: The strengths that are played, in ascending order, above 0.
        perturb: Disturbances as ``--perturb`` takes them, with ``{}`` for the strength.
        noise: Standard deviation of the noise that a strength of 1 adds to each range [m].
    """

    name: str
    unit: str
    strengths: tuple[float, ...]
    perturb: tuple[str, ...] = ()
    noise: float = 0.0

    @property
    def names(self) -> set[str]:
        """What it is chosen by: its name, and that of its kind of disturbance if it has only one."""
        kinds = {_kind(text) for text in self.perturb}
        return {self.name, *(kinds if len(kinds) == 1 else ())}

    def text(self, strength: float) -> str:
        """Return the disturbances of a strength, as the scenario's argument ``disturbances`` takes them."""
        return "; ".join(text.format(*[f"{strength:g}"] * text.count("{}")) for text in self.perturb)


def every_factor() -> list[Factor]:
    """Return the factors of the grid, each with its registered kinds; those without any are left out."""
    families.load()
    entries = {name: {"perturb": (), "noise": 0.0, **entry} for name, entry in json_object(GRID).items()}
    for entry in entries.values():
        entry["perturb"] = tuple(text for text in entry["perturb"] if _kind(text) in DISTURBANCES)
    return [Factor(name, **entry) for name, entry in entries.items() if entry["perturb"] or entry["noise"]]


def chosen_factors(names: Sequence[str] | None) -> list[Factor]:
    """Return factors in the order of the grid.

    Args:
        names: Names of factors, or of kinds of disturbance for all factors of these; None for all factors.

    Raises:
        UnknownNameError: If there is no such factor; the message lists all.
    """
    factors = every_factor()
    for name in names or ():
        if not any(name in factor.names for factor in factors):
            known = [factor.name for factor in factors]
            raise UnknownNameError(f"no factor named '{name}'{suggestion(name, known)}; factors: {', '.join(known)}")
    return [factor for factor in factors if names is None or factor.names & set(names)]


def disturbed(base: Scenario, agents: Sequence[int], disturbances: str, noise: float) -> Scenario:
    """Return a scenario whose learners have disturbances, and noise of their ranges [m] besides their own.

    Raises:
        IrsimGymError: If the disturbances cannot be read, or a learner has no sensor with noise.
    """
    bodies = list(base.bodies)
    for b in agents if noise else ():
        sensors = [_noisy(sensor, noise) if hasattr(sensor, "angle_std") else sensor for sensor in bodies[b].sensors]
        bodies[b] = replace(bodies[b], sensors=tuple(sensors))
        if bodies[b] == base.bodies[b]:
            raise IrsimGymError(f"{bodies[b].name} has no sensor with noise")
    return replace(base, bodies=tuple(bodies), disturbances=read_perturbations(disturbances))


def _noisy(sensor: Any, std: float) -> Any:
    own = sensor.noise * sensor.std
    return replace(sensor, noise=True, std=math.hypot(own, std), angle_std=sensor.noise * sensor.angle_std)


def _kind(text: str) -> str:
    return text.partition(":")[0]
