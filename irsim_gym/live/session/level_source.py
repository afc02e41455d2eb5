"""The file of a world, and its present level."""

import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from irsim_gym.live.session.arguments import LoadArguments
from irsim_gym.live.session.session import Session
from irsim_gym.scenario import Scenario, load_scenario
from irsim_gym.scenario.reading import notes
from irsim_gym.scenario.reading.parameters import given_as_keywords
from irsim_gym.simulator.engine.given import LEVELS
from irsim_gym.simulator.engine.start_checks import find_blocked_starts

ScenarioSource = str | Path | Mapping[str, Any]


class LevelSource:
    """Reads a file, and draws its levels in the order that a seed gives.

    Args:
        source: The file; None for the YAML file with the name of the running script, in the same folder.
        seed: Number of the first level.
        strict: Whether unknown keys are errors.
        asked: Parameters of the scenario, and the step mode.
        columns: See ``Session``.

    Attributes:
        session: The compiled scenario; the same object throughout the life of the world.

    Raises:
        ScenarioError: The file cannot be used.
        TypeError: The seed is no whole number, or there is no file beside the script.
        ValueError: The seed is negative.
    """

    def __init__(
        self, source: ScenarioSource | None, seed: int | None, *, strict: bool, arguments: LoadArguments, columns: bool
    ) -> None:
        self._strict, self._asked = strict, arguments
        self._source: ScenarioSource = _beside_the_script() if source is None else source
        self._seed, self._episode = _level(0 if seed is None else seed), 0
        self.session = Session(self._read(self._source), columns=columns)
        self._warn_of_starts()

    def begin(self) -> None:
        """Draw the present level and begin it."""
        self.session.begin(self._seed, self._episode)

    def begin_next(self) -> None:
        """Draw the next level, with the bodies of the file, and begin it."""
        self._episode += 1
        self.session.compile(self.session.scenario)
        self.begin()

    def reload(self, source: ScenarioSource | None) -> None:
        """Read the file again, or another one, and begin its first level. An error leaves everything unchanged."""
        chosen = self._source if source is None else source
        self.session.compile(self._read(chosen))
        self._source, self._episode = chosen, 0
        self._warn_of_starts()
        self.begin()

    def set_seed(self, seed: int) -> None:
        """Draw levels from another stream. ``begin_next`` begins with its first level."""
        self._seed, self._episode = _level(seed), -1
        simulation = self.session.simulation
        simulation.state.random[:] = simulation.streams(self._seed)

    def _read(self, source: ScenarioSource) -> Scenario:
        with given_as_keywords():
            loaded = load_scenario(source, self._asked.parameters, strict=self._strict, may_pend=True)
        if self._asked.step_mode is None:
            return loaded
        return replace(loaded, world=replace(loaded.world, step_mode=self._asked.step_mode))

    def _warn_of_starts(self) -> None:
        scenario, simulation = self.session.scenario, self.session.simulation
        blocked = find_blocked_starts(scenario, simulation.parts, simulation.model, simulation.state)
        notes.warn_of_starts(scenario, blocked)


def _beside_the_script() -> Path:
    """Return the YAML file with the name of the running script, in the same folder."""
    script = Path(sys.argv[0] or "script.py")
    for file in (script.with_suffix(".yaml"), Path(script.stem + ".yaml")):
        if file.is_file():
            return file
    raise TypeError(f"no file was given, and there is no {script.stem}.yaml beside the script: load('my_world.yaml')")


def _level(seed: object) -> int:
    """Return the level of a seed, as in environments."""
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer):
        raise TypeError(f"a seed is a whole number, got {seed!r}")
    if seed < 0:
        raise ValueError(f"a seed is 0 or more, got {seed}")
    return int(seed) % LEVELS
