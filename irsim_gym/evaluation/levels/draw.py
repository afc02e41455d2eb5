"""Draws the levels of a compiled scenario as data: everything that a restart writes."""

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from irsim_gym.base.arraytypes import Flags, Floats, Ints
from irsim_gym.evaluation.protocol.protocol import check_levels
from irsim_gym.scenario import Scenario
from irsim_gym.scenario.reading.level_checks import drawn_bodies, without_map
from irsim_gym.scenario.specs import library
from irsim_gym.scenario.specs.level_set import LevelSet
from irsim_gym.simulator.engine import Simulation
from irsim_gym.simulator.levels.level_table import given_bodies, varied_outlines
from irsim_gym.simulator.world.outline import outline_rows

LEFT_OUT = frozenset({"plot", "gui", "task", "custom", "levels", "parameters"})
"""Sections of a scenario that do not affect its levels."""


def draw_levels(
    simulation: Simulation,
    splits: Sequence[str],
    count: int,
    on_levels: Callable[[int], None] | None = None,
    look: Callable[[int], None] | None = None,
) -> LevelSet:
    """Return the first levels of some splits, as the simulation draws them.

    Args:
        simulation: The scenario, compiled for any number of worlds.
        splits: Different ones of ``train``, ``dev``, ``test``.
        count: Number of levels of each split.
        on_levels: Called with the number of levels that have just been drawn.
        look: Called with each world whose level has begun, in the order of the levels.

    Raises:
        IrsimGymError: If the levels come from a file with fewer levels.
        PlacementError: If a level cannot be drawn.
    """
    taker = _LevelCollector(simulation)
    for split in splits:
        check_levels(simulation.scenario, split, count)
        for first in range(0, count, simulation.n_worlds):
            simulation.reset(first, split)
            n_new = min(simulation.n_worlds, count - first)
            taker.take(n_new)
            if look is not None:
                for world in range(n_new):
                    look(world)
            if on_levels is not None:
                on_levels(n_new)
    levels = taker.levels()
    firsts = {split: (i * count, count) for i, split in enumerate(splits)}
    return replace(levels, splits=firsts, about=about(simulation.scenario))


def about(scenario: Scenario) -> dict[str, object]:
    """Return the description of a scenario for a file of its levels."""
    shipped = library.every_scenario().get(Path(scenario.file).stem)
    is_shipped = shipped is not None and shipped.resolve() == Path(scenario.file).resolve()
    home = Path(scenario.file).stem if is_shipped else Path(scenario.file).name
    said = {"scenario": home, "name": scenario.name, "hash": scenario_hash(scenario)}
    return {**said, "parameters": dict(scenario.parameters)}


def scenario_hash(scenario: Scenario) -> str:
    """Return the hash of the parts of a scenario that define its levels, 16 hexadecimal digits."""
    data = scenario.source.data
    sections = data if isinstance(data, Mapping) else {}
    inner = sections.get("irsim")
    sections = {**sections, **(inner if isinstance(inner, Mapping) else {})}
    rest = {key: value for key, value in sections.items() if key not in LEFT_OUT and key != "irsim"}
    text = json.dumps([scenario.name, rest], sort_keys=True)
    return hashlib.blake2b(text.encode(), digest_size=8).hexdigest()


class _LevelCollector:
    """Collects the levels that the worlds of a simulation have just begun."""

    def __init__(self, simulation: Simulation) -> None:
        scenario, self._simulation = simulation.scenario, simulation
        drawn = np.zeros(len(scenario.bodies), np.bool_)
        drawn[list(drawn_bodies(*without_map(scenario)))] = True
        self._bodies: Ints = np.flatnonzero(drawn | given_bodies(scenario))
        varied = varied_outlines(scenario)
        self._n_goals: Ints = np.maximum(simulation.model.drawn_goals[self._bodies], 1)
        self._shaped: Flags = varied[self._bodies]
        self._cells: list[Flags] | None = [] if scenario.occupied is not None and varied[-1] else None
        self._rows: dict[str, list[Any]] = {name: [] for name in ("start", "goal", "present", "random")}
        self._outlines: tuple[list[Floats], list[Floats]] = [], []
        self._counts: tuple[list[list[int]], list[list[int]]] = [], []

    def take(self, count: int) -> None:
        """Collect the levels of the first ``count`` worlds."""
        worlds = np.arange(count)
        model, chosen = self._simulation.model, np.ix_(worlds, self._bodies)
        present = model.present[chosen]
        # Where several goals are given, a level cannot change them; where one is drawn, a loop adds the way back.
        may_have = (model.waypoint_count[chosen] == self._n_goals) | (model.drawn_goals[self._bodies] > 0)
        has_goal = present & model.has_goal[self._bodies] & may_have
        rows = np.arange(self._n_goals.max(initial=1))
        has_goals = has_goal[:, :, None] & (rows < self._n_goals[:, None])
        self._rows["present"].append(present)
        self._rows["start"].append(np.where(present[..., None], model.start[chosen], 0.0))
        self._rows["goal"].append(np.where(has_goals[..., None], model.waypoints[chosen][:, :, rows], np.nan))
        self._rows["random"].append(model.level_random[worlds])
        if self._cells is not None:
            self._cells.append(model.map_squares[worlds, 0] == 0)
        for w in range(count):
            self._collect_outlines(w)

    def _collect_outlines(self, world: int) -> None:
        """Collect the outlines that vary between levels, of the bodies that are present."""
        model, state = self._simulation.model, self._simulation.state
        counts: tuple[list[int], list[int]] = [], []
        for b, shaped in zip(self._bodies.tolist(), self._shaped, strict=True):
            is_kept = bool(shaped and model.present[world, b])
            for rows, count, outline in zip(
                self._outlines, counts, outline_rows(model, state, world, b, local=True), strict=True
            ):
                count.append(len(outline) if is_kept else 0)
                if is_kept:
                    rows.append(outline.copy())
        for all_counts, count in zip(self._counts, counts, strict=True):
            all_counts.append(count)

    def levels(self) -> LevelSet:
        """Return the collected levels."""
        names = self._simulation.parts.names
        rows = {name: np.concatenate(parts) for name, parts in self._rows.items()}
        sides, rounds = self._outlines
        starts = [_offsets(np.array(counts, np.int64)) for counts in self._counts]
        return LevelSet(
            file="",
            bodies=tuple(names[b] for b in self._bodies),
            start=rows["start"],
            goal=rows["goal"],
            present=rows["present"],
            segments=np.concatenate([np.zeros((0, 4)), *sides]),
            segment_start=starts[0],
            discs=np.concatenate([np.zeros((0, 3)), *rounds]),
            disc_start=starts[1],
            cells=None if self._cells is None else np.concatenate(self._cells),
            random=rows["random"],
            splits={},
        )


def _offsets(counts: Ints) -> Ints:
    """Return the first row of each body, shape ``(n_levels, n_bodies + 1)``, from the number of rows of each."""
    ends = np.cumsum(counts.reshape(-1)).reshape(counts.shape)
    starts: Ints = np.concatenate([ends[:, :1] - counts[:, :1], ends], axis=1)
    return starts
