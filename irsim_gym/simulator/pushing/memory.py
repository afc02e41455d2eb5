"""Memory of contacts that push: what bodies feel, and what a step needs while it takes bodies apart."""

from dataclasses import dataclass

import numpy as np

from irsim_gym.base.errors import ScenarioError
from irsim_gym.base.kernels.structs import record_type
from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.simulator.pushing.matter import COASTS, Matter
from irsim_gym.simulator.world.model import ACKERMANN, DIFFERENTIAL, NO_DRIVE
from irsim_gym.simulator.world.names import Flags, Floats, Ints, Model, Records, State, Struct, kernel, row_of

FELT = record_type("x y contact_time air_time", touches=np.bool_, changed=np.bool_)
"""Force on a body in the world frame [N]; for how long it has been in contact, or not [s]; whether it is now, and
whether that has changed in this step.
"""
REPORT = record_type("nx ny depth x y force", a=np.int64, b=np.int64)
"""A contact of a step: bodies a and b, the unit vector from b to a, depth [m], point [m] and force [N]."""
PAIR = record_type(
    "nx ny depth x y impulse tx ty", a=np.int64, b=np.int64, rank=np.int64, report=np.int64, moves=np.int64,
    touches=np.bool_,
)  # fmt: skip
"""Two bodies that may touch: their deepest contact as in REPORT, how often both were moved when it was found (-1: it
was not), the sum of its impulses [kg m], and whether both are bodies to push that touch at the beginning of a sweep,
with the unit vector from b to a then; ``report`` is the number of the report, -1 before there is one, and ``rank``
tells how many bodies stand between both and one that nobody pushes.
"""
MOTION = record_type(
    "x y heading cosine sine cx cy dx dy turn", level=np.int64, blocker=np.int64, mark=np.int64, moves=np.int64
)
"""A body while it is taken apart from others: pose and centre of mass as the step began [m, m, rad], cosine and sine of
its heading now, how far it has been pushed [m] and turned [rad] since; how many bodies are between it and one that
nobody pushes, its last blocker, the search that has seen it last, and how often it has been moved.
"""
BLOCKER = record_type("nx ny friction", next=np.int64)
"""What a body cannot move into in a sweep: unit vector from the body, friction, and the blocker before, -1 for none."""
BOUNCE = record_type("nx ny speed", a=np.int64, b=np.int64, frees_a=np.bool_, frees_b=np.bool_)
"""A bounce of bodies a and b: unit vector from b to a, wanted speed apart [m/s], and who of both was free to move."""
SWEPT = "contact takes bodies apart where the step ends: leave collision_check out"


@dataclass(repr=False)
class Pushing(Struct):
    """What contacts do to bodies, and scratch memory for each slot.

    Attributes:
        drive: Velocity of each drive, which contacts do not change [m/s or rad/s], shape ``(n_worlds, n_bodies, 3)``.
        felt: What each body feels, shape ``(n_worlds, n_bodies)``.
        n_reports: Number of reports, shape ``(n_worlds,)``.
        reports: Contacts of the last step, in the order in which they were found, shape ``(n_worlds, n_pairs)``.
        boxes: Boxes of bodies: x0, y0, x1, y1 [m], shape ``(n_slots, n_bodies, 4)``.
        margin: How far bodies may come in the step [m], shape ``(n_slots,)``.
        items: Scratch for the order of bodies: boxes of nodes, first body and number, ``(n_slots, 2, n_bodies, 6)``.
        order: Scratch for orders of bodies, in the last row by left ends of boxes, shape ``(n_slots, 5, n_bodies)``.
        pairs: Pairs of bodies, shape ``(n_slots, n_pairs)``.
        sequence: Pairs in the order in which they are treated, shape ``(n_slots, n_pairs)``.
        motions: Motions of bodies, shape ``(n_slots, n_bodies)``.
        blockers: Blockers of bodies, shape ``(n_slots, 2 n_pairs)``.
        bounces: Bounces, shape ``(n_slots, n_pairs)``.
        counts: Numbers of pairs, blockers, bounces and searches, shape ``(n_slots, 4)``.
        spans: Boxes around pieces now, and around an edge of the map: x0, y0, x1, y1 [m], ``(n_slots, n, 4)``.
        corners: Corners of all pieces in the world frame [m], and two of an edge of the map, ``(n_slots, n, 2)``.
    """

    drive: Floats
    felt: Records
    n_reports: Ints
    reports: Records
    boxes: Floats
    margin: Floats
    items: Floats
    order: Ints
    pairs: Records
    sequence: Ints
    motions: Records
    blockers: Records
    bounces: Records
    counts: Ints
    spans: Floats
    corners: Floats


PAIRS, BLOCKERS, BOUNCES, SEARCHES = range(4)
"""Columns of ``Pushing.counts``."""


def lay_pushing(scenario: Scenario, matter: Matter | None, model: Model, n_slots: int) -> Pushing | None:
    """Return memory for contacts that push; None where there are none.

    Raises:
        ScenarioError: Contacts are looked for within steps, too.
    """
    world = scenario.world
    if matter is None or world.collision_mode != "contact" or world.step_mode == "external":
        return None
    if world.collision_check == "swept":
        problem = scenario.problem(("world", "collision_check"), SWEPT)
        raise ScenarioError(scenario.file or scenario.name, [problem])
    n_worlds, n_bodies = model.present.shape
    n, n_corners = len(matter.pushable), matter.corners.shape[1]
    # Each body to push with each other body.
    n_pairs = n * (n - 1) // 2 + n * (n_bodies - n)
    return Pushing(
        drive=np.zeros((n_worlds, n_bodies, 3)),
        felt=np.zeros((n_worlds, n_bodies), FELT),
        n_reports=np.zeros(n_worlds, np.int64),
        reports=np.zeros((n_worlds, n_pairs), REPORT),
        boxes=np.zeros((n_slots, n_bodies, 4)),
        margin=np.zeros(n_slots),
        items=np.zeros((n_slots, 2, n_bodies, 6)),
        order=np.tile(np.arange(n_bodies), (n_slots, 5, 1)),
        pairs=np.zeros((n_slots, n_pairs), PAIR),
        sequence=np.zeros((n_slots, n_pairs), np.int64),
        motions=np.zeros((n_slots, n_bodies), MOTION),
        blockers=np.zeros((n_slots, 2 * n_pairs), BLOCKER),
        bounces=np.zeros((n_slots, n_pairs), BOUNCE),
        counts=np.zeros((n_slots, 4), np.int64),
        spans=np.zeros((n_slots, matter.n_corners.shape[1] + 1, 4)),
        corners=np.zeros((n_slots, n_corners + 2, 2)),
    )


@kernel
def begin_pushing(worlds: Ints, push: Pushing, state: State) -> None:
    """Begin an episode: nobody feels anything, and drives have the velocities of their bodies.

    Reads: state (velocity).
    Writes: push (drive, felt, n_reports).
    """
    for w in worlds:
        push.n_reports[w] = 0
        for b in range(push.felt.shape[1]):
            forget_body(w, b, push, state)


@kernel
def forget_contacts(worlds: Ints, bodies: Ints, chosen: Flags, push: Pushing, state: State) -> None:
    """Let some bodies begin anew where ``chosen``, shape ``(n_worlds, n_bodies)``.

    Reads: state (velocity).
    Writes: push (drive, felt).
    """
    for w in worlds:
        for k in range(bodies.shape[0]):
            if chosen[w, k]:
                forget_body(w, bodies[k], push, state)


@kernel
def forget_body(w: int, b: int, push: Pushing, state: State) -> None:
    """Forget what a body has felt.

    Reads: state (velocity).
    Writes: push (drive, felt).
    """
    felt = push.felt[w, b]
    felt.x, felt.y, felt.contact_time, felt.air_time, felt.touches, felt.changed = 0.0, 0.0, 0.0, 0.0, False, False
    for axis in range(3):
        push.drive[w, b, axis] = state.velocity[w, b, axis]


@kernel
def follow(worlds: Ints, bodies: Ints, push: Pushing, matter: Matter, model: Model, state: State) -> None:
    """Let drives follow their commands, which are in ``state.velocity``: with their lag, and no faster than they grip.

    Reads: push (drive), matter (gravity, substance), model (movable, step_time), state (velocity).
    Writes: push (drive), state (velocity).
    """
    dt = model.step_time[0]
    for w in worlds:
        for b in bodies:
            stuff = matter.substance[b]
            if stuff.passive or not model.movable[b]:
                continue
            now, asked = push.drive[w, b], state.velocity[w, b]
            share = min(1.0, dt / stuff.tau) if stuff.tau > 0.0 else 1.0
            drive = stuff.drive
            n_speeds = 0 if drive == NO_DRIVE else 1 if drive in (DIFFERENTIAL, ACKERMANN) else 2
            change2 = 0.0
            for axis in range(3):
                if stuff.tau > 0.0:
                    asked[axis] = now[axis] + share * (asked[axis] - now[axis])
                if axis < n_speeds:
                    change2 += (asked[axis] - now[axis]) * (asked[axis] - now[axis])
            change, most = np.sqrt(change2), stuff.friction * matter.gravity * dt
            for axis in range(3):
                if axis < n_speeds and change > most:
                    asked[axis] = now[axis] + (asked[axis] - now[axis]) * most / change
                now[axis] = asked[axis]


@kernel
def greatest_travel(w: int, matter: Matter, model: Model, state: State) -> float:
    """Return the speed [m/s] of the fastest body, or of the one that may be.

    Reads: matter (substance), model (movable, present, velocity_max), state (twist).
    """
    fastest = 0.0
    limits = model.velocity_max[row_of(model.velocity_max, w)]
    for b in range(model.movable.shape[0]):
        if not model.movable[b] or not model.present[w, b]:
            continue
        speed, drive = 0.0, matter.substance[b].drive
        if drive != COASTS:
            aside = 0.0 if drive in (DIFFERENTIAL, ACKERMANN) else limits[b, 1]
            speed = np.sqrt(limits[b, 0] * limits[b, 0] + aside * aside)
        vx, vy = state.twist[w, b, 0], state.twist[w, b, 1]
        fastest = max(fastest, speed, np.sqrt(vx * vx + vy * vy))
    return float(fastest)
