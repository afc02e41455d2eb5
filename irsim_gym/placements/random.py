"""random: uniform in a box, clear of everything, with a goal that can be reached."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np

from irsim_gym.arraytypes import Flags, Floats, Ints, Words
from irsim_gym.geometry.buckets import bucket_of, gather_nearby, put
from irsim_gym.geometry.frames import place_outline
from irsim_gym.jit import kernel
from irsim_gym.paths.grid import Grid
from irsim_gym.paths.regions import of_slot, way_tables
from irsim_gym.placements.free_space import bundles, has_way, is_goal_free, is_spaced, is_start_free
from irsim_gym.placements.manual import world_box
from irsim_gym.rng import uniform
from irsim_gym.scenario.options import crossed_bounds, kind, option
from irsim_gym.world.group import Group, Shard
from irsim_gym.world.model import WorldModel
from irsim_gym.world.rows import row_of
from irsim_gym.world.state import WorldState

MARGIN = 0.5
WISHED_DISTANCE = 1.0
"""Distance [m] between members of an entry that asks for none, where they find room for it."""
FULLEST = 0.45
"""Share of a plane that discs put down at random cover without much searching; they never cover more than 0.547 of it
(Feder, Journal of Theoretical Biology 87, 1980).
"""
START_TRIES = 1000
GOAL_TRIES = 100
PATH_TRIES = 8
COARSE, FINE = 1.0, 0.5
"""Sides of cells, relative to the reach of the body that looks for a way."""
WAY_TABLES = ("frame", "blocked", "runs", "labels", "known")


@kind
class RandomPlacement:
    """Uniform draws without any overlap; a draw that fails too often is an error that names the body."""

    only_kernels: ClassVar[bool] = True
    is_random: ClassVar[bool] = True
    roams: ClassVar[bool] = True
    gives_goal: ClassVar[bool] = True

    range_low: tuple[float, float, float] | None = option(
        None, unit="m, m, rad", meaning="Lower bounds; by default the world drawn in by 0.5 m, and -pi."
    )
    range_high: tuple[float, float, float] | None = option(
        None, unit="m, m, rad", meaning="Upper bounds; by default the world drawn in by 0.5 m, and pi."
    )
    goal_low: tuple[float, float, float] | None = option(
        None, unit="m, m, rad", meaning="Lower bounds of the goals; by default those of the starts."
    )
    goal_high: tuple[float, float, float] | None = option(
        None, unit="m, m, rad", meaning="Upper bounds of the goals; by default those of the starts."
    )
    min_distance: float | None = option(
        None,
        ge=0.0,
        unit="m",
        meaning="Least distance between the origins (and between the goals) of one entry; by default 1 m, or 0 "
        "where so many have no room for that.",
        consequence="As clearance.",
    )
    clearance: float = option(
        0.0,
        ge=0.0,
        unit="m",
        meaning="Surface distance kept from everything else.",
        consequence="Large in a full world: levels take long to draw, or cannot be.",
    )
    min_goal_distance: float = option(
        0.0,
        ge=0.0,
        unit="m",
        meaning="Least distance from start to goal.",
        consequence="Larger than the world: an error that names the body.",
    )
    reachable: bool = option(
        False, meaning="Hand out only goals that a disc around the body can reach past the static bodies."
    )

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of what cannot be."""
        if self.range_low is not None and self.range_high is not None:
            yield from crossed_bounds(self.range_low, self.range_high)
        if self.goal_low is not None and self.goal_high is not None:
            yield from crossed_bounds(self.goal_low, self.goal_high, "goal_low", "goal_high")

    @property
    def ensures_way(self) -> bool:
        """True if no level is drawn without a way from start to goal."""
        return self.reachable

    @staticmethod
    def prepare(group: Group, model: WorldModel, n_slots: int) -> str | None:
        """Settle the bounds, and make room for the grid on which ways are looked for; return what does not fit."""
        options = group.options[0]
        low, high, goal_low, goal_high = bounds = _bounds(options, model)
        for name, lower, upper in (("range", low, high), ("goal", goal_low, goal_high)):
            if np.any(lower > upper):
                ends = [[round(float(value), 6) for value in bound] for bound in (lower, upper)]
                missing = f"the world less {MARGIN} m" if name == "range" else "that of the starts"
                return f"{name}_low {ends[0]} exceeds {name}_high {ends[1]}; what is not given is {missing}"
        corners = np.array([*(bound[:2] for bound in bounds), model.bounds[:2], model.bounds[2:]])
        area = (*corners.min(axis=0).tolist(), *corners.max(axis=0).tolist())
        group.arrays = dict(zip(("low", "high", "goal_low", "goal_high"), bounds, strict=True))
        if options.min_distance is None:
            has_room = all(_has_room(len(group.members), *ends) for ends in ((low, high), (goal_low, goal_high)))
            group.params["min_distance"] = WISHED_DISTANCE if has_room else 0.0
        group.arrays["everyone"] = np.arange(len(model.role))
        group.arrays["is_member"] = np.isin(group.arrays["everyone"], group.members)
        group.arrays["blocks"] = np.zeros((n_slots, len(model.role)), np.bool_)
        reach = float(np.min(model.reach[:, group.members]))
        whole = max(area[2] - area[0], area[3] - area[1])
        for name, share in (("coarse", COARSE), ("fine", FINE)):
            grid = Grid.over(area, share * reach if options.reachable else whole)
            tables: Any = way_tables(grid, n_slots, len(model.role))
            group.arrays |= {f"{name}_{table}": made for table, made in zip(WAY_TABLES, tables, strict=True)}
        return None

    @staticmethod
    def draw(group: Group, model: WorldModel, state: WorldState, shard: Shard, failed: Ints) -> None:
        """Draw starts and goals; ``failed[w]`` becomes body + 1 where a member found no place."""
        shapes, targets, scene = bundles(model, state)
        table, slot = group.arrays, shard.slot
        grids: Any = None  # then nothing that looks for a way is compiled
        if group.options[0].reachable:
            both = (of_slot([table[f"{name}_{part}"] for part in WAY_TABLES], slot) for name in ("coarse", "fine"))
            grids = model.rigid, table["blocks"][slot], *both
        near: Any = None
        if model.bucket_frame[0].columns:
            lists = state.bucket, state.bucket_first, state.bucket_next, state.nearby
            near = model.bucket_frame, model.bucketed, *lists
        draw_members(
            shard.worlds,
            (group.members, table["is_member"], table["everyone"]),
            group.params,
            (table["low"], table["high"], table["goal_low"], table["goal_high"]),
            shapes,
            targets,
            scene,
            near,
            grids,
            state.random,
            failed,
        )


def _has_room(count: int, low: Floats, high: Floats) -> bool:
    """Return whether so many points find places in a box that are ``WISHED_DISTANCE`` apart."""
    width, height = high[:2] - low[:2] + WISHED_DISTANCE
    return bool(count * np.pi * (WISHED_DISTANCE / 2.0) ** 2 <= FULLEST * width * height)


def _bounds(options: RandomPlacement, model: WorldModel) -> tuple[Floats, Floats, Floats, Floats]:
    """Return the lower and upper bounds of the starts and of the goals."""
    low, high = world_box(model, MARGIN)
    low = low if options.range_low is None else np.array(options.range_low, np.float64)
    high = high if options.range_high is None else np.array(options.range_high, np.float64)
    goal_low = low if options.goal_low is None else np.array(options.goal_low, np.float64)
    goal_high = high if options.goal_high is None else np.array(options.goal_high, np.float64)
    return low, high, goal_low, goal_high


@kernel
def draw_members(
    worlds: Ints,
    lists: Any,
    params: Any,
    bounds: Any,
    shapes: Any,
    targets: Any,
    scene: Any,
    near: Any,
    grids: Any,
    random: Words,
    failed: Ints,
) -> None:
    """Place one member after the other in each world, those that have no place yet, until one finds none.

    ``lists`` are the numbers of the members, which bodies those are, and the numbers of all bodies; ``near`` are the
    world's buckets (``geometry/buckets.py``), which hold whoever is placed, or None without.
    """
    present, has_goal, placed, options, members = shapes[0], targets[0], scene[3], params[0], lists[0]
    low, high, goal_low, goal_high = bounds
    for w in worlds:
        if near is not None:
            sort_placed(w, present, placed, scene[0], near)
        for b in members:
            if failed[w] > 0 or not present[w, b] or placed[w, b]:
                continue
            for _ in range(PATH_TRIES if has_goal[b] else 1):
                placed[w, b] = draw_start(w, b, lists, options, low, high, shapes, targets, scene, near, random) and (
                    not has_goal[b]
                    or draw_goal(w, b, lists, options, goal_low, goal_high, shapes, targets, scene, random)
                )
                if grids is not None:
                    placed[w, b] = placed[w, b] and (not has_goal[b] or has_way(w, b, shapes, targets, scene, grids))
                if placed[w, b]:
                    break
            if not placed[w, b]:
                failed[w] = b + 1
            elif near is not None:
                put_placed(w, b, scene[0], near)


@kernel
def sort_placed(w: int, present: Flags, placed: Flags, pose: Floats, near: Any) -> None:
    """Let the buckets of world w hold the placed bodies and nobody else."""
    _, _, bucket, first, following, _ = near
    bucket[w, :], first[w, :], following[w, :] = -1, -1, -1
    for b in range(placed.shape[1]):
        if placed[w, b] and present[w, b]:
            put_placed(w, b, pose, near)


@kernel
def put_placed(w: int, b: int, pose: Floats, near: Any) -> None:
    """Put body b of world w into its bucket."""
    frame, bucketed, bucket, first, following, _ = near
    put(b, bucket_of(pose[w, b, 0], pose[w, b, 1], bucketed[b], frame[0]), bucket[w], first[w], following[w])


@kernel
def draw_start(
    w: int,
    b: int,
    lists: Any,
    options: Any,
    low: Floats,
    high: Floats,
    shapes: Any,
    targets: Any,
    scene: Any,
    near: Any,
    random: Words,
) -> bool:
    """Draw a pose for body b that is clear of everything placed so far; return whether there is one."""
    reach, segment_start, segment_count, local_segments, disc_start, disc_count, local_discs = shapes[2:]
    pose, segments, discs, placed, _ = scene
    members, is_member, everyone = lists
    for _ in range(START_TRIES):
        for axis in range(3):
            pose[w, b, axis] = uniform(random, w, low[axis], high[axis])
        if near is None:
            peers, n_peers, others, n_others = members, members.shape[0], everyone, everyone.shape[0]
        else:
            frames, _, _, first, following, found = near
            frame = frames[0]
            radius = max(options.min_distance, reach[row_of(reach, w), b] + options.clearance + frame.reach)
            n_others = gather_nearby(pose[w, b, 0], pose[w, b, 1], radius, frame, first[w], following[w], found[w])
            peers, n_peers, others = found[w], n_others, found[w]
        if not is_spaced(pose[w], peers, n_peers, is_member, b, options.min_distance, shapes[0][w], placed[w]):
            continue
        place_outline(
            local_segments[row_of(local_segments, w)],
            local_discs[row_of(local_discs, w)],
            segment_start[b],
            segment_count[row_of(segment_count, w), b],
            disc_start[b],
            disc_count[row_of(disc_count, w), b],
            pose[w, b, 0],
            pose[w, b, 1],
            pose[w, b, 2],
            segments[w],
            discs[w],
        )
        if is_start_free(w, b, options.clearance, shapes, targets, scene, others, n_others):
            return True
    return False


@kernel
def draw_goal(
    w: int,
    b: int,
    lists: Any,
    options: Any,
    low: Floats,
    high: Floats,
    shapes: Any,
    targets: Any,
    scene: Any,
    random: Words,
) -> bool:
    """Draw a goal for body b that its footprint can stand on; return whether there is one."""
    waypoints, pose, members = targets[3], scene[0], lists[0]
    goal = waypoints[w, b, 0]
    for _ in range(GOAL_TRIES):
        for axis in range(3):
            goal[axis] = uniform(random, w, low[axis], high[axis])
        dx, dy = goal[0] - pose[w, b, 0], goal[1] - pose[w, b, 1]
        if dx * dx + dy * dy < options.min_goal_distance * options.min_goal_distance:
            continue
        if not is_spaced(
            waypoints[w, :, 0],
            members,
            members.shape[0],
            lists[1],
            b,
            options.min_distance,
            shapes[0][w],
            scene[3][w],
        ):
            continue
        if is_goal_free(w, b, options.clearance, shapes, targets, scene):
            return True
    return False
