"""Load the file of levels that the key ``levels`` names, and check that it fits the scenario."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.errors import Problem, ScenarioError, suggestion
from irsim_gym.scenario.checking.validation import Report
from irsim_gym.scenario.reading.level_reading import MOST_TOLD, Mistake, load_levels
from irsim_gym.scenario.specs.level_set import LevelSet
from irsim_gym.scenario.specs.spec import BodySpec, PlacementSpec, Scenario
from irsim_gym.scenario.specs.world_spec import WorldSpec
from irsim_gym.scenario.text.messages import show
from irsim_gym.scenario.text.source import Place, Source


def read_level_file(data: object, place: Place, source: Source, report: Report) -> LevelSet | None:
    """Return the levels of the file that ``levels`` names; None without a file, or after reporting problems."""
    if data is None:
        return None
    if not isinstance(data, str) or not data.strip():
        report.add(place, f"must be the name of an .npz file, got {show(data)}")
        return None
    folder = Path(source.file).parent if source.file else Path()
    levels, mistakes = load_levels(folder / data)
    tell(mistakes, place, report, data)
    return None if mistakes else levels


def tell(mistakes: Sequence[Mistake], place: Place, report: Report, file: str) -> None:
    """Report the mistakes of a file of levels, each with its array."""
    for name, text in mistakes:
        report.add((*place, name) if name else place, text if name else f"{file}: {text}")


def home_of(levels: LevelSet) -> tuple[str | Path, Mapping[str, Any]]:
    """Return the scenario that a file of levels names, and the values of its parameters.

    A shipped scenario is given by its name, any other by the name of its file in the folder of the file of levels.

    Raises:
        ScenarioError: If the file names no scenario.
    """
    name, values = levels.about.get("scenario"), levels.about.get("parameters", {})
    if not isinstance(name, str) or not name or not isinstance(values, Mapping):
        wish = f"names no scenario: load a YAML file that has levels: {Path(levels.file).name}"
        raise ScenarioError(levels.file, [Problem(0, "about", wish)])
    beside = Path(levels.file).parent / Path(name).name
    return (beside if Path(name).suffix else name), values


def with_levels(scenario: Scenario, levels: LevelSet) -> Scenario:
    """Return a scenario with levels from a file.

    Raises:
        ScenarioError: If the levels do not fit the scenario.
    """
    world_without_map, placements = without_map(scenario)
    mistakes = list(misfits(levels, world_without_map, placements, scenario.world, scenario.occupied))
    if mistakes:
        raise ScenarioError(levels.file, [Problem(0, name, text) for name, text in mistakes])
    return replace(scenario, levels=levels)


def without_map(scenario: Scenario) -> tuple[tuple[BodySpec, ...], tuple[PlacementSpec, ...]]:
    """Return the bodies and placements of a scenario without those of its obstacle map, which come last."""
    end = -1 if scenario.occupied is not None else None
    return scenario.bodies[:end], scenario.placements[:end]


def drawn_bodies(bodies: Sequence[BodySpec], placements: Sequence[PlacementSpec]) -> tuple[int, ...]:
    """Return the bodies whose start, goal, outline or presence levels draw."""
    drawn = {k for k, one in enumerate(placements) if one.kind.is_random or one.number_range is not None}
    return tuple(b for b, body in enumerate(bodies) if body.shape.is_random or body.entry in drawn)


def levels_differ(scenario: Scenario) -> bool:
    """Return whether anything is drawn for each level, or several levels come from a file; noise does not count."""
    bodies = scenario.bodies
    traits = any(body.wanders or body.speed_range is not None or body.unyielding > 0.0 for body in bodies)
    from_file = scenario.levels is not None and scenario.levels.count > 1
    return from_file or traits or bool(drawn_bodies(bodies, scenario.placements))


def n_goals_drawn(placement: PlacementSpec) -> int:
    """Return the number of goals that the distribution of an entry gives each of its bodies."""
    return int(getattr(placement.kind, "n_goals", 1)) if placement.kind.gives_goal else 0


def misfits(
    levels: LevelSet,
    bodies: Sequence[BodySpec],
    placements: Sequence[PlacementSpec],
    world: WorldSpec,
    occupied: NDArray[np.bool_] | None,
) -> Iterator[Mistake]:
    """Yield mismatches between levels and a scenario: in its bodies, without that of the map, and in its map."""
    if levels.cells is None and getattr(world.obstacle_map, "is_random", False):
        yield "cells", "the scenario draws its obstacle_map: the file must give the cells"
    if levels.cells is not None and occupied is None:
        yield "cells", "the scenario has no obstacle_map for them"
    elif levels.cells is not None and occupied is not None and levels.cells.shape[1:] != occupied.shape:
        (columns, rows), (n_columns, other) = occupied.shape, levels.cells.shape[1:]
        yield "cells", f"must be {columns} x {rows} cells, as the obstacle_map has, got {n_columns} x {other}"
    names = [body.name for body in bodies]
    for name in levels.bodies:
        if name not in names:
            yield "bodies", f"the scenario has no body named '{name[:40]}'{suggestion(name[:40], names)}"
    missing = [names[b] for b in drawn_bodies(bodies, placements) if names[b] not in levels.bodies]
    if missing:
        more = f" and {len(missing) - MOST_TOLD} more" if len(missing) > MOST_TOLD else ""
        named = ", ".join(f"'{name}'" for name in missing[:MOST_TOLD])
        yield "bodies", f"the scenario draws {named}{more}: the file must place them, or the scenario give their state"
    shaped = levels.shaped
    for k, name in enumerate(levels.bodies):
        if name in names:
            body = bodies[names.index(name)]
            yield from _misfits_of(levels, k, body, placements[body.entry], is_shaped=bool(shaped[k]))


def _misfits_of(
    levels: LevelSet, k: int, body: BodySpec, placement: PlacementSpec, *, is_shaped: bool
) -> Iterator[Mistake]:
    """Yield mismatches of one body."""
    name, present = f"'{levels.bodies[k]}'", levels.present[:, k]
    if placement.number_range is None and not present.all():
        yield "present", f"{_where(~present, name)}: must be there, since its entry has no number_range"
    count = (~np.isnan(levels.goal[:, k, :, 0])).sum(axis=1) * present
    is_mobile = not body.static
    drawn = n_goals_drawn(placement) if is_mobile else 0
    if count.any() and not drawn and not (is_mobile and len(body.goal) == 1):
        has = f"{len(body.goal)} goals" if is_mobile and body.goal else "no goal"
        yield "goal", f"{_where(count > 0, name)}: has {has} in the scenario, so the file can give it none"
    elif (count > 1).any() and not drawn:
        yield "goal", f"{_where(count > 1, name)}: has 1 goal in the scenario, so the file can give it no more"
    if (wrong := present & (count != drawn)).any() and drawn:
        what = "a goal, since its distribution would draw one" if drawn == 1 else f"{drawn} goals, as in the scenario"
        yield "goal", f"{_where(wrong, name)}: needs {what}, got {count[wrong][0] or 'none'}"
    rows = np.diff(levels.segment_start, axis=1)[:, k] + np.diff(levels.disc_start, axis=1)[:, k]
    if is_shaped and not body.shape.is_random and (is_mobile or body.sensors):
        yield "segments", f"{name}: only a random_shape or a standing obstacle takes its outline from a file"
    if (is_shaped or body.shape.is_random) and (present & (rows == 0)).any():
        yield "segments", f"{_where(present & (rows == 0), name)}: has no outline (segments or discs)"


def _where(bad: Any, name: str) -> str:
    """Return the first level with a problem, and how many more there are, as text."""
    rows = np.flatnonzero(bad)
    return f"level {rows[0]}{f' and {len(rows) - 1} more' if len(rows) > 1 else ''}, {name}"
