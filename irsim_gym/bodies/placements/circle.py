"""circle: evenly on a circle, facing the centre, with the goal opposite; further options add random shifts."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from irsim_gym.base.arraytypes import Cells, Floats, Ints, Point
from irsim_gym.bodies.placements.free_space import is_goal_free, is_start_free
from irsim_gym.bodies.placements.manual import put_on_start, world_box
from irsim_gym.simulator.world.names import Group, Model, Shard, State, Struct, kernel, kind, option, row_of, uniform
from irsim_gym.simulator.world.outline import place_outline

MARGIN = 0.5
"""Distance of the default circle from the world's shorter sides [m]."""
TRIES = 100
"""Maximum number of draws for a start or a goal."""


@dataclass(repr=False)
class CircleTables(Struct):
    """The tables for drawing shifted starts and goals.

    Attributes:
        x: x of the centre [m].
        y: y of the centre [m].
        radius: Radius of the circle [m].
        jitter: Maximum shift of starts and goals [m].
        turn: Whether the circle is rotated at random.
        scatter: Whether each place on the circle is drawn.
        mirror: Whether goals are the starts' mirror images.
        clearance: Clearance between outlines [m]; 0 if places are even.
        angles: Direction of each member's place from the centre [rad], shape ``(n_bodies,)``.
        everyone: Numbers of all bodies.
    """

    x: float
    y: float
    radius: float
    jitter: float
    turn: bool
    scatter: bool
    mirror: bool
    clearance: float
    angles: Floats
    everyone: Ints


@kind
class CirclePlacement:
    """Starts on a circle, with each goal on the opposite side."""

    roams: ClassVar[bool] = False
    ensures_way: ClassVar[bool] = False
    gives_goal: ClassVar[bool] = True

    center: tuple[float, float] | tuple[float, float, float] | None = option(
        None, unit="m", meaning="Centre; by default the centre of the world."
    )
    radius: float | None = option(None, gt=0.0, unit="m", meaning="Radius; default: half the shorter side less 0.5 m.")
    jitter: float = option(
        0.0,
        ge=0.0,
        unit="m",
        meaning="Each start and each goal is shifted in each level: drawn evenly from a disc of this radius.",
        consequence="Large on a full circle: levels take long to draw, or cannot be.",
    )
    turn: bool = option(False, meaning="Turn the whole circle by another angle in each level.")
    scatter: bool = option(False, meaning="Each level draws the places on the circle; default: evenly spaced.")
    mirror: bool = option(
        False,
        meaning="Each goal is the mirror image of its start about the centre, and no body starts at another's goal; by "
        "default, goals are shifted independently.",
    )
    clearance: float = option(0.05, ge=0.0, unit="m", meaning="Least gap of shifted or scattered starts and goals.")

    @property
    def is_random(self) -> bool:
        """True if levels differ."""
        return self.turn or self.scatter or self.jitter > 0.0

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> str | None:
        """Write the members' starts and goals, and return what does not fit the world."""
        options = group.options[0]
        low, high = world_box(model, MARGIN)
        center = (low[:2] + high[:2]) / 2.0 if options.center is None else np.array(options.center[:2])
        radius = float(np.min(high[:2] - low[:2])) / 2.0 if options.radius is None else options.radius
        if radius <= 0.0:
            return f"needs a radius: half of the world's shorter side, less {MARGIN} m, is {radius:g} m"
        angles = np.zeros(len(model.role))
        # Those who walk together share one place.
        leaders, place = np.unique(model.leader[group.members], return_inverse=True)
        angles[group.members] = 2.0 * np.pi * place / len(leaders)
        for b in group.members:
            angle = angles[b]
            # `aside` points to the left of a body that faces the centre.
            arm, aside = radius * np.array([np.cos(angle), np.sin(angle)]), np.array([np.sin(angle), -np.cos(angle)])
            model.start[:, b] = [*(center + arm + model.abreast[b] * aside), angle - np.pi]
            model.waypoints[:, b, 0] = [*(center - arm + model.abreast[b] * aside), angle - np.pi]
        everyone = np.arange(len(model.role))
        x, y, jitter = float(center[0]), float(center[1]), float(options.jitter)
        # Even places are not tested for clearance, only for contact.
        clearance = options.clearance if options.scatter or jitter > 0.0 else 0.0
        model.kept_clearance[group.members] = clearance
        group.tables = CircleTables(
            x, y, float(radius), jitter, options.turn, options.scatter, options.mirror, clearance, angles, everyone
        )
        return _beyond_the_edge(center, radius + options.jitter, model) if options.is_random else None

    @staticmethod
    def draw(group: Group, model: Model, state: State, shard: Shard, failed: Ints) -> None:
        """Put the members on their starts; ``failed[w]`` becomes body + 1 if a shifted member finds no place."""
        if not group.options[0].is_random:
            put_on_start(shard.worlds, group.members, model, state)
            return
        draw_shifted(shard.worlds, group.members, group.tables, model, state, model.cells, failed)


def _beyond_the_edge(center: Floats, extent: float, model: Model) -> str | None:
    low, high = world_box(model, 0.0)
    if np.all(center - extent >= low[:2]) and np.all(center + extent <= high[:2]):
        return None
    room = float(np.min([center - low[:2], high[:2] - center]))
    return f"radius and jitter together are {extent:g} m, but the world's edge is {room:g} m from the centre"


@kernel
def draw_shifted(
    worlds: Ints, members: Ints, circle: CircleTables, model: Model, state: State, cells: Cells, failed: Ints
) -> None:
    """Rotate the circle, then draw shifts of the start and the goal of one member after another until both are free.

    Reads: circle (angles, clearance, everyone, jitter, mirror, radius, scatter, turn, x, y), model (abreast,
        disc_count, disc_start, drawn_goals, goal_renewal, has_goal, kept_clearance, leader, local_discs,
        local_segments, present, reach, segment_count, segment_start, solid, stands, waypoint_count, waypoints), state
        (discs, placed, pose, random, segments).
    Writes: model (waypoints), state (discs, placed, pose, random, segments), failed.
    """
    placed = state.placed
    for w in worlds:
        turned = uniform(state.random, w, 0.0, 2.0 * np.pi) if circle.turn else 0.0
        for b in members:
            if failed[w] > 0 or not model.present[w, b] or placed[w, b]:
                continue
            angle = turned + circle.angles[b]
            angle = shift_start(w, b, angle, circle, model, state, cells)
            placed[w, b] = not np.isnan(angle) and (
                not model.has_goal[b] or shift_goal(w, b, members, angle, circle, model, state, cells)
            )
            if not placed[w, b]:
                failed[w] = b + 1


@kernel
def shift_start(w: int, b: int, angle: float, circle: CircleTables, model: Model, state: State, cells: Cells) -> float:
    """Draw a pose near body b's place on the circle, facing the centre.

    Return the angle of the place, NaN if no free pose was found.

    Reads: circle (clearance, everyone, jitter, mirror, radius, scatter, x, y), model (abreast, disc_count, disc_start,
        drawn_goals, goal_renewal, has_goal, kept_clearance, leader, local_discs, local_segments, present, reach,
        segment_count, segment_start, solid, stands, waypoint_count, waypoints), state (discs, placed, pose, random,
        segments).
    Writes: state (discs, pose, random, segments).
    """
    pose = state.pose[w, b]
    for _ in range(TRIES):
        if circle.scatter and model.leader[b] == b:
            angle = uniform(state.random, w, 0.0, 2.0 * np.pi)
        # It walks with its leader, which is placed already.
        elif circle.scatter:
            first = state.pose[w, model.leader[b]]
            angle = np.arctan2(first[1] - circle.y, first[0] - circle.x)
        cosine, sine, aside = np.cos(angle), np.sin(angle), model.abreast[b]
        # As `arm` and `aside` in CirclePlacement.prepare.
        place = circle.radius * cosine + aside * sine, circle.radius * sine - aside * cosine
        x, y = shifted(w, place, circle.jitter, state)
        pose[0], pose[1], pose[2] = circle.x + x, circle.y + y, np.arctan2(-y, -x)
        place_outline(model, state, w, b)
        if circle.mirror and not faces_nobody(w, b, circle, model, state):
            continue
        if is_start_free(w, b, circle.everyone, circle.clearance, model, state, cells):
            return angle
    return np.nan


@kernel
def faces_nobody(w: int, b: int, circle: CircleTables, model: Model, state: State) -> bool:
    """Return whether the mirror image of body b's start keeps the clearance from all placed bodies.

    Reads: circle (clearance, everyone, x, y), model (present, reach, stands), state (placed, pose).
    """
    x, y = 2.0 * circle.x - state.pose[w, b, 0], 2.0 * circle.y - state.pose[w, b, 1]
    reaches = model.reach[row_of(model.reach, w)]
    for q in circle.everyone:
        if q == b or not state.placed[w, q] or not model.present[w, q] or model.stands[q]:
            continue
        dx, dy, room = state.pose[w, q, 0] - x, state.pose[w, q, 1] - y, reaches[b] + reaches[q] + circle.clearance
        if dx * dx + dy * dy < room * room:
            return False
    return True


@kernel
def shift_goal(
    w: int, b: int, members: Ints, angle: float, circle: CircleTables, model: Model, state: State, cells: Cells
) -> bool:
    """Draw a goal opposite body b's place, heading away from the centre; return whether a free one was found.

    Reads: circle (clearance, jitter, mirror, radius, x, y), model (abreast, disc_count, disc_start, drawn_goals,
        goal_renewal, has_goal, kept_clearance, present, reach, segment_count, segment_start, solid, stands,
        waypoint_count, waypoints), state (discs, placed, pose, random, segments).
    Writes: model (waypoints), state (random).
    """
    clearance, goal = circle.clearance, model.waypoints[w, b, 0]
    for _ in range(TRIES):
        cosine, sine, aside = np.cos(angle), np.sin(angle), model.abreast[b]
        # Opposite, on the same side of its leader.
        place = aside * sine - circle.radius * cosine, -circle.radius * sine - aside * cosine
        # The mirror image of the start about the centre, from the centre.
        x, y = circle.x - state.pose[w, b, 0], circle.y - state.pose[w, b, 1]
        if not circle.mirror:
            x, y = shifted(w, place, circle.jitter, state)
        goal[0], goal[1], goal[2] = circle.x + x, circle.y + y, np.arctan2(y, x)
        if are_goals_apart(w, b, members, clearance, model, state) and is_goal_free(
            w, b, 0, clearance, model, state, cells
        ):
            return True
    return False


@kernel
def shifted(w: int, place: Point, jitter: float, state: State) -> Point:
    """Draw a point uniformly from a disc of radius ``jitter`` [m] around another point.

    Reads: state (random).
    Writes: state (random).
    """
    # The root makes equal areas equally likely.
    along = jitter * np.sqrt(uniform(state.random, w, 0.0, 1.0))
    direction = uniform(state.random, w, 0.0, 2.0 * np.pi)
    return place[0] + along * np.cos(direction), place[1] + along * np.sin(direction)


@kernel
def are_goals_apart(w: int, b: int, members: Ints, clearance: float, model: Model, state: State) -> bool:
    """Return whether body b at its goal keeps clear of the other placed members at theirs.

    Reads: model (present, reach, waypoints), state (placed).
    """
    reaches, goals = model.reach[row_of(model.reach, w)], model.waypoints[w]
    for q in members:
        dx, dy = goals[q, 0, 0] - goals[b, 0, 0], goals[q, 0, 1] - goals[b, 0, 1]
        room = reaches[b] + reaches[q] + clearance
        if q != b and state.placed[w, q] and model.present[w, q] and dx * dx + dy * dy < room * room:
            return False
    return True
