"""Reads the key ``obstacle_map``, and makes the cells of the map."""

import importlib.util
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.errors import OptionError, suggestion
from irsim_gym.base.families import MAPS
from irsim_gym.scenario.checking.validation import BAD, Report, build_named
from irsim_gym.scenario.reading.ros_map import SUFFIXES
from irsim_gym.scenario.specs import library
from irsim_gym.scenario.specs.world_spec import WorldSpec
from irsim_gym.scenario.text.messages import show
from irsim_gym.scenario.text.source import Place, Source

MOST_CELLS = 4_000_000
IRSIM_MAPS = frozenset({"cave.png", *(f"hm3d_{k}.png" for k in range(1, 10))})
_IRSIM_FOLDER = Path("irsim", "world", "map")


def read_map(data: object, place: Place, report: Report) -> Any:
    """Return the kind of map that ``obstacle_map`` describes by a file name, a table of cells, or a mapping.

    Return BAD after reporting problems.
    """
    if isinstance(data, str):
        data = {"name": "ros" if Path(data).suffix in SUFFIXES else "image", "path": data}
    elif isinstance(data, list | tuple):
        data = {"name": "array", "cells": data}
    elif not isinstance(data, Mapping):
        report.add(place, "must be the name of an image, a mapping such as {name: perlin, resolution: 0.1}, or cells")
        return BAD
    map_options = build_named(MAPS, data, place, report)
    return BAD if map_options is None else map_options


def map_extent(map_options: Any, source: Source) -> dict[str, Any]:
    """Return width, height and offset of the world [m] that a map states; nothing for others, or if it is broken."""
    try:
        return dict(map_options.extent(_finder(source))) if hasattr(map_options, "extent") else {}
    except OptionError:
        return {}  # read_cells reports it


def _finder(source: Source) -> Callable[[str], Path]:
    folders = (Path(source.file).parent,) if source.file else ()
    return lambda name: find_map(name, folders)


def read_cells(world: WorldSpec, place: Place, source: Source, report: Report) -> NDArray[np.bool_] | None:
    """Return the occupied cells of the world's map, shape ``(columns, rows)``; None without a map.

    Args:
        world: The section ``world``.
        place: Path of ``obstacle_map``.
    """
    if world.obstacle_map is None:
        return None
    for key, stated in map_extent(world.obstacle_map, source).items():
        if not np.allclose(getattr(world, key), stated, rtol=0.0, atol=1e-6):
            report.add((*place[:-1], key), f"must be {show(stated)}, as the map says: leave it out")
    try:
        cells = world.obstacle_map.occupied(world.width, world.height, world.name, _finder(source))
    except OptionError as error:
        is_mapping = source.line((*place, error.key)) > 0 or not source.file
        report.add((*place, error.key) if is_mapping else place, str(error))
        return None
    step = world.mdownsample
    cells = np.ascontiguousarray(cells[::step, ::step])
    if cells.size == 0 or cells.size > MOST_CELLS:
        size = f"{cells.shape[0]} x {cells.shape[1]}"
        report.add(place, f"must have 1 to {MOST_CELLS} cells, got {size}; mdownsample keeps every n-th")
        return None
    radius = getattr(world.obstacle_map, "disc_radius", None)
    side = min(world.width / cells.shape[0], world.height / cells.shape[1])
    if radius is not None and radius > 0.5 * side * (1.0 + 1e-9):
        message = f"must be at most half a cell, {0.5 * side:g} m, got {radius:g}: cells are {side:g} m wide"
        report.add((*place, "disc_radius"), message)
        return None
    return cells


def find_map(name: str, folders: tuple[Path, ...]) -> Path:
    """Return the file of a map: as given, in one of the folders, shipped (suffix optional), or of an installed ir-sim.

    Raises:
        OptionError: If the file is not found; the message lists the shipped maps.
    """
    path = Path(name)
    for file in (path, *(folder / path for folder in folders)):
        if _is_file(file):
            return file
    shipped = library.assets("maps")
    if name in shipped:
        return shipped[name]
    by_stem = {file.stem: file for file in shipped.values()}
    if name in by_stem:
        return by_stem[name]
    theirs = _irsim_map(path)
    if theirs is not None:
        return theirs
    offer = f"shipped: {', '.join(shipped)}"
    if path.name in IRSIM_MAPS:
        way = f"install ir-sim, copy the file beside the scenario, or give its path ({_IRSIM_FOLDER}/.../{path.name})"
        raise OptionError("path", f"'{name[:60]}' belongs to IR-SIM and is not shipped here: {way}; {offer}")
    near = suggestion(path.name, shipped) or suggestion(path.stem, by_stem)
    raise OptionError("path", f"no map '{name[:60]}': no such file as given or beside the scenario{near}; {offer}")


def _is_file(file: Path) -> bool:
    try:
        return file.is_file()
    except (OSError, ValueError):
        return False


def _irsim_map(path: Path) -> Path | None:
    """Return a file in the map folder of an installed ir-sim, without importing it; None if there is none."""
    if path.is_absolute() or ".." in path.parts:
        return None
    package = importlib.util.find_spec("irsim")
    for home in (package.submodule_search_locations if package is not None else None) or ():
        folder = Path(home).parent / _IRSIM_FOLDER
        below = sorted(folder.glob(f"*/{path.name}")) if path.name in IRSIM_MAPS else []
        for file in (folder / path, *below):
            if _is_file(file):
                return file
    return None
