"""circle: evenly on a circle, facing the centre, with the goal opposite; with options of ours, not quite evenly."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from irsim_gym.arraytypes import Floats, Ints, Words
from irsim_gym.geometry.frames import place_outline
from irsim_gym.jit import kernel
from irsim_gym.placements.free_space import bundles, is_goal_free, is_start_free
from irsim_gym.placements.manual import put_on_start, world_box
from irsim_gym.rng import uniform
from irsim_gym.scenario.options import kind, option
from irsim_gym.world.group import Group, Shard
from irsim_gym.world.model import WorldModel
from irsim_gym.world.rows import row_of
from irsim_gym.world.state import WorldState

MARGIN = 0.5
TRIES = 100
JITTER_CLEARANCE = 0.05
"""What shifted starts, and shifted goals, keep between the outlines [m]."""


@kind
class CirclePlacement:
    """Starts on a circle; each goal lies on the other side."""

    only_kernels: ClassVar[bool] = True
    roams: ClassVar[bool] = False
    ensures_way: ClassVar[bool] = False
    gives_goal: ClassVar[bool] = True

    center: tuple[float, float] | tuple[float, float, float] | None = option(
        None, unit="m", meaning="Centre; by default the centre of the world."
    )
    radius: float | None = option(
        None, gt=0.0, unit="m", meaning="Radius; by default half of the world's shorter side, less 0.5 m."
    )
    jitter: float = option(
        0.0,
        ge=0.0,
        unit="m",
        meaning="Each start and each goal is shifted in each level: drawn evenly from a disc of this radius.",
        consequence="Large on a full circle: levels take long to draw, or cannot be.",
    )
    turn: bool = option(False, meaning="Turn the whole circle by another angle in each level.")

    @property
    def is_random(self) -> bool:
        """True if levels differ."""
        return self.turn or self.jitter > 0.0

    @staticmethod
    def prepare(group: Group, model: WorldModel, n_slots: int) -> str | None:
        """Write the members' starts and goals; return what does not fit the world."""
        options = group.options[0]
        low, high = world_box(model, MARGIN)
        center = (low[:2] + high[:2]) / 2.0 if options.center is None else np.array(options.center[:2])
        radius = float(np.min(high[:2] - low[:2])) / 2.0 if options.radius is None else options.radius
        if radius <= 0.0:
            return f"needs a radius: half of the world's shorter side, less {MARGIN} m, is {radius:g} m"
        for k, b in enumerate(group.members):
            angle = 2.0 * np.pi * k / len(group.members)
            arm = radius * np.array([np.cos(angle), np.sin(angle)])
            model.start[:, b] = [*(center + arm), angle - np.pi]
            model.waypoints[:, b, 0] = [*(center - arm), angle - np.pi]
        group.arrays["circle"] = np.array([*center, radius, len(group.members)])
        group.arrays["everyone"] = np.arange(len(model.role))
        return _beyond_the_edge(center, radius + options.jitter, model) if options.is_random else None

    @staticmethod
    def draw(group: Group, model: WorldModel, state: WorldState, shard: Shard, failed: Ints) -> None:
        """Put the members on their starts; ``failed[w]`` becomes body + 1 where a shifted one found no place."""
        if not group.options[0].is_random:
            put_on_start(shard.worlds, group.members, model, state)
            return
        shapes, targets, scene = bundles(model, state)
        draw_shifted(
            shard.worlds, group.members, group.params, group.arrays["circle"], shapes, targets, scene,
            group.arrays["everyone"], state.random, failed,
        )  # fmt: skip


def _beyond_the_edge(center: Floats, extent: float, model: WorldModel) -> str | None:
    low, high = world_box(model, 0.0)
    if np.all(center - extent >= low[:2]) and np.all(center + extent <= high[:2]):
        return None
    room = float(np.min([center - low[:2], high[:2] - center]))
    return f"radius and jitter together are {extent:g} m, but the world's edge is {room:g} m from the centre"


@kernel
def draw_shifted(
    worlds: Ints,
    members: Ints,
    params: Any,
    circle: Floats,
    shapes: Any,
    targets: Any,
    scene: Any,
    everyone: Ints,
    random: Words,
    failed: Ints,
) -> None:
    """Turn the circle, then shift the start and the goal of one member after the other until they are free."""
    present, has_goal, placed, options = shapes[0], targets[0], scene[3], params[0]
    for w in worlds:
        turned = uniform(random, w, 0.0, 2.0 * np.pi) if options.turn else 0.0
        for k in range(members.shape[0]):
            b = members[k]
            if failed[w] > 0 or not present[w, b] or placed[w, b]:
                continue
            angle = turned + 2.0 * np.pi * params[k].index / circle[3]
            placed[w, b] = shift_start(
                w, b, angle, options.jitter, circle, shapes, targets, scene, everyone, random
            ) and (
                not has_goal[b]
                or shift_goal(w, k, members, angle, options.jitter, circle, shapes, targets, scene, random)
            )
            if not placed[w, b]:
                failed[w] = b + 1


@kernel
def shift_start(
    w: int,
    b: int,
    angle: float,
    jitter: float,
    circle: Floats,
    shapes: Any,
    targets: Any,
    scene: Any,
    everyone: Ints,
    random: Words,
) -> bool:
    """Draw a pose near body b's place on the circle, facing the centre; return whether one is free."""
    _, _, _, segment_start, segment_count, local_segments, disc_start, disc_count, local_discs = shapes
    pose, segments, discs, _, _ = scene
    clearance = JITTER_CLEARANCE if jitter > 0.0 else 0.0
    for _ in range(TRIES):
        along = jitter * np.sqrt(uniform(random, w, 0.0, 1.0))
        direction = uniform(random, w, 0.0, 2.0 * np.pi)
        x = circle[2] * np.cos(angle) + along * np.cos(direction)
        y = circle[2] * np.sin(angle) + along * np.sin(direction)
        pose[w, b, 0], pose[w, b, 1], pose[w, b, 2] = circle[0] + x, circle[1] + y, np.arctan2(-y, -x)
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
        if is_start_free(w, b, clearance, shapes, targets, scene, everyone, everyone.shape[0]):
            return True
    return False


@kernel
def shift_goal(
    w: int,
    k: int,
    members: Ints,
    angle: float,
    jitter: float,
    circle: Floats,
    shapes: Any,
    targets: Any,
    scene: Any,
    random: Words,
) -> bool:
    """Draw a goal near the place opposite of member k's, headed away from the centre; return whether one is free."""
    b, waypoints = members[k], targets[3]
    clearance = JITTER_CLEARANCE if jitter > 0.0 else 0.0
    for _ in range(TRIES):
        along = jitter * np.sqrt(uniform(random, w, 0.0, 1.0))
        direction = uniform(random, w, 0.0, 2.0 * np.pi)
        x = -circle[2] * np.cos(angle) + along * np.cos(direction)
        y = -circle[2] * np.sin(angle) + along * np.sin(direction)
        goal = waypoints[w, b, 0]
        goal[0], goal[1], goal[2] = circle[0] + x, circle[1] + y, np.arctan2(y, x)
        if are_goals_apart(w, b, members, clearance, shapes[0], shapes[2], scene[3], waypoints) and is_goal_free(
            w, b, clearance, shapes, targets, scene
        ):
            return True
    return False


@kernel
def are_goals_apart(
    w: int, b: int, members: Ints, clearance: float, present: Any, reach: Floats, placed: Any, waypoints: Floats
) -> bool:
    """Return whether body b has room at its goal beside the other members that are placed, at theirs."""
    reaches = reach[row_of(reach, w)]
    for q in members:
        dx, dy = waypoints[w, q, 0, 0] - waypoints[w, b, 0, 0], waypoints[w, q, 0, 1] - waypoints[w, b, 0, 1]
        room = reaches[b] + reaches[q] + clearance
        if q != b and placed[w, q] and present[w, q] and dx * dx + dy * dy < room * room:
            return False
    return True
