"""What is left of contacts that push: poses, velocities, forces, bounces and times."""

import numpy as np

from irsim_gym.simulator.geometry.angles import wrap_from
from irsim_gym.simulator.pushing.matter import COASTS, Matter
from irsim_gym.simulator.pushing.memory import BOUNCES, PAIRS, Pushing
from irsim_gym.simulator.pushing.pieces import pushed_origin
from irsim_gym.simulator.world.model import ACKERMANN, DIFFERENTIAL, NO_DRIVE, OMNI_ANGULAR, OMNI_WORLD
from irsim_gym.simulator.world.names import Floats, Model, State, Vector, kernel, place_outline
from irsim_gym.simulator.world.twist import Twist


@kernel
def write_motions(w: int, slot: int, push: Pushing, matter: Matter, model: Model, state: State) -> None:
    """Write poses, outlines and velocities of the bodies that were pushed or turned.

    Reads: push (counts, motions, pairs), matter (substance), model (disc_count, disc_start, local_discs,
        local_segments, segment_count, segment_start, solid, step_time), state (discs, pose, segments, velocity).
    Writes: push (motions), state (discs, pose, segments, twist, velocity).
    """
    dt, pairs = model.step_time[0], push.pairs[slot]
    for k in range(push.counts[slot, PAIRS]):
        for b in (pairs[k].a, pairs[k].b):
            motion = push.motions[slot, b]
            if motion.dx == 0.0 and motion.dy == 0.0 and motion.turn == 0.0:
                continue
            pose, velocity = state.pose[w, b], state.velocity[w, b]
            pose[0], pose[1] = pushed_origin(slot, b, push)
            pose[2] = wrap_from(motion.heading + motion.turn, -np.pi)
            place_outline(model, state, w, b)
            drive = matter.substance[b].drive
            if drive != NO_DRIVE:
                change(velocity, (motion.dx / dt, motion.dy / dt, motion.turn / dt), drive, pose[2])
                state.twist[w, b, 0], state.twist[w, b, 1] = ground_velocity(velocity, drive, pose[2])
                if drive in (DIFFERENTIAL, OMNI_ANGULAR, COASTS):
                    state.twist[w, b, 2] = velocity[1 if drive == DIFFERENTIAL else 2]
            motion.dx, motion.dy, motion.turn = 0.0, 0.0, 0.0


@kernel
def change(velocity: Floats, by: Twist, drive: int, heading: float) -> None:
    """Add a velocity over ground and a turn rate to that of a drive; wheels take what is along the heading."""
    is_turned = drive not in (OMNI_WORLD, COASTS)
    cosine, sine = (np.cos(heading), np.sin(heading)) if is_turned else (1.0, 0.0)
    velocity[0] += cosine * by[0] + sine * by[1]
    if drive == DIFFERENTIAL:
        velocity[1] += by[2]
    elif drive != ACKERMANN:
        velocity[1] += cosine * by[1] - sine * by[0]
    if drive in (OMNI_ANGULAR, COASTS):
        velocity[2] += by[2]


@kernel
def ground_velocity(velocity: Floats, drive: int, heading: float) -> Vector:
    """Return the velocity over ground [m/s] that belongs to that of a drive."""
    ahead, left = velocity[0], 0.0 if drive in (DIFFERENTIAL, ACKERMANN) else velocity[1]
    if drive in (OMNI_WORLD, COASTS):
        return ahead, left
    cosine, sine = np.cos(heading), np.sin(heading)
    return cosine * ahead - sine * left, sine * ahead + cosine * left


@kernel
def note_forces(w: int, slot: int, push: Pushing, matter: Matter, model: Model, state: State) -> None:
    """Write the forces of contacts, and let bodies bounce.

    Reads: push (bounces, counts, drive, pairs, reports), matter (substance), model (step_time), state (pose, velocity).
    Writes: push (reports), state (twist, velocity).
    """
    dt = model.step_time[0]
    for k in range(push.counts[slot, PAIRS]):
        pair = push.pairs[slot, k]
        if pair.impulse > 0.0:
            told = push.reports[w, pair.report]
            force = pair.impulse / (dt * dt)
            for b, sign in ((pair.a, -1.0), (pair.b, 1.0)):
                stuff = matter.substance[b]
                vx, vy = ground_velocity(push.drive[w, b], stuff.drive, state.pose[w, b, 2])
                # A drive presses no harder than it grips the ground.
                if not stuff.passive and stuff.inverse > 0.0 and sign * (vx * told.nx + vy * told.ny) > 0.0:
                    force = min(force, stuff.grip)
            told.force = force
    for k in range(push.counts[slot, BOUNCES]):
        bounce = push.bounces[slot, k]
        one, other = matter.substance[bounce.a], matter.substance[bounce.b]
        give_a = one.inverse if one.passive and bounce.frees_a else 0.0
        give_b = other.inverse if other.passive and bounce.frees_b else 0.0
        if give_a + give_b <= 0.0:
            continue
        ax, ay = ground_velocity(state.velocity[w, bounce.a], one.drive, state.pose[w, bounce.a, 2])
        bx, by = ground_velocity(state.velocity[w, bounce.b], other.drive, state.pose[w, bounce.b, 2])
        missing = bounce.speed - ((ax - bx) * bounce.nx + (ay - by) * bounce.ny)
        if missing > 0.0:
            for b, share in ((bounce.a, give_a), (bounce.b, -give_b)):
                speed = missing * share / (give_a + give_b)
                if speed != 0.0:
                    for axis, part in ((0, bounce.nx), (1, bounce.ny)):
                        state.velocity[w, b, axis] += speed * part
                        state.twist[w, b, axis] = state.velocity[w, b, axis]


@kernel
def note_times(w: int, push: Pushing, model: Model) -> None:
    """Write the forces on bodies, and for how long they have been in contact, or not.

    Reads: push (felt, n_reports, reports), model (step_time).
    Writes: push (felt).
    """
    felt, dt = push.felt[w], model.step_time[0]
    for b in range(felt.shape[0]):
        felt[b].changed, felt[b].touches, felt[b].x, felt[b].y = felt[b].touches, False, 0.0, 0.0
    for k in range(push.n_reports[w]):
        told = push.reports[w, k]
        for b, force in ((told.a, told.force), (told.b, -told.force)):
            felt[b].touches = True
            felt[b].x += force * told.nx
            felt[b].y += force * told.ny
    for b in range(felt.shape[0]):
        touches = felt[b].touches
        felt[b].changed = felt[b].changed != touches
        felt[b].contact_time = felt[b].contact_time + dt if touches else 0.0
        felt[b].air_time = 0.0 if touches else felt[b].air_time + dt
