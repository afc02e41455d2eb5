"""What is left of contacts that push: poses, velocities, forces, bounces and times."""

import numpy as np

from irsim_gym.simulator.geometry.angles import wrap_from
from irsim_gym.simulator.pushing.matter import Matter
from irsim_gym.simulator.pushing.memory import BOUNCES, PAIRS, Pushing
from irsim_gym.simulator.pushing.pieces import pushed_origin
from irsim_gym.simulator.world.model import ACKERMANN, DIFFERENTIAL, NO_DRIVE, OMNI_ANGULAR, OMNI_WORLD
from irsim_gym.simulator.world.names import Floats, Model, State, kernel
from irsim_gym.simulator.world.outline import place_outline


@kernel
def write_motions(w: int, slot: int, push: Pushing, matter: Matter, model: Model, state: State) -> None:
    """Write poses, outlines and velocities of the bodies that were pushed or turned.

    Reads: push (counts, motions, pairs), matter (substance), model (disc_count, disc_start, drive, local_discs,
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
            change(velocity, motion.dx / dt, motion.dy / dt, matter.substance[b].passive, model.drive[b], pose[2])
            rate_axis = 2 if matter.substance[b].passive else turn_axis(model.drive[b])
            if rate_axis >= 0:
                velocity[rate_axis] += motion.turn / dt
                state.twist[w, b, 2] = velocity[rate_axis]
            vx, vy = ground_velocity(velocity, matter.substance[b].passive, model.drive[b], pose[2])
            if matter.substance[b].passive or model.drive[b] != NO_DRIVE:
                state.twist[w, b, 0], state.twist[w, b, 1] = vx, vy
            motion.dx, motion.dy, motion.turn = 0.0, 0.0, 0.0


@kernel
def turn_axis(drive: int) -> int:
    """Return which number of a drive's velocity is its turn rate, -1 for none."""
    return 1 if drive == DIFFERENTIAL else 2 if drive == OMNI_ANGULAR else -1


@kernel
def change(velocity: Floats, dx: float, dy: float, is_passive: bool, drive: int, heading: float) -> None:
    """Add a velocity over ground [m/s] to that of a body; a drive on wheels takes what is along its heading."""
    if is_passive or drive == OMNI_WORLD:
        velocity[0] += dx
        velocity[1] += dy
        return
    cosine, sine = np.cos(heading), np.sin(heading)
    if drive != NO_DRIVE:
        velocity[0] += cosine * dx + sine * dy
    if drive not in (NO_DRIVE, DIFFERENTIAL, ACKERMANN):
        velocity[1] += cosine * dy - sine * dx


@kernel
def ground_velocity(velocity: Floats, is_passive: bool, drive: int, heading: float) -> tuple[float, float]:
    """Return the velocity over ground [m/s] that belongs to that of a body."""
    ahead, left = velocity[0], velocity[1]
    if is_passive or drive == OMNI_WORLD:
        return ahead, left
    cosine, sine = np.cos(heading), np.sin(heading)
    if drive in (DIFFERENTIAL, ACKERMANN):
        left = 0.0
    return cosine * ahead - sine * left, sine * ahead + cosine * left


@kernel
def note_forces(w: int, slot: int, push: Pushing, matter: Matter, model: Model, state: State) -> None:
    """Write the forces of contacts, and let bodies bounce.

    Reads: push (bounces, counts, drive, pairs, reports), matter (substance), model (drive, step_time), state (pose,
        velocity).
    Writes: push (reports), state (twist, velocity).
    """
    dt = model.step_time[0]
    for k in range(push.counts[slot, PAIRS]):
        pair = push.pairs[slot, k]
        if pair.impulse > 0.0:
            told = push.reports[w, pair.report]
            force = pair.impulse / (dt * dt)
            for b, sign in ((pair.a, -1.0), (pair.b, 1.0)):
                stuff, drive = matter.substance[b], push.drive[w, b]
                vx, vy = ground_velocity(drive, stuff.passive, model.drive[b], state.pose[w, b, 2])
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
        ax, ay = ground_velocity(
            state.velocity[w, bounce.a], one.passive, model.drive[bounce.a], state.pose[w, bounce.a, 2]
        )
        bx, by = ground_velocity(
            state.velocity[w, bounce.b], other.passive, model.drive[bounce.b], state.pose[w, bounce.b, 2]
        )
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

    Reads: push (air_time, changed, contact_time, force, in_contact, n_reports, reports), model (step_time).
    Writes: push (air_time, changed, contact_time, force, in_contact).
    """
    force, now, changed, dt = push.force[w], push.in_contact[w], push.changed[w], model.step_time[0]
    for b in range(now.shape[0]):
        changed[b], now[b], force[b, 0], force[b, 1] = now[b], False, 0.0, 0.0
    for k in range(push.n_reports[w]):
        told = push.reports[w, k]
        now[told.a], now[told.b] = True, True
        for axis, part in ((0, told.nx), (1, told.ny)):
            force[told.a, axis] += told.force * part
            force[told.b, axis] -= told.force * part
    for b in range(now.shape[0]):
        changed[b] = changed[b] != now[b]
        push.contact_time[w, b] = push.contact_time[w, b] + dt if now[b] else 0.0
        push.air_time[w, b] = 0.0 if now[b] else push.air_time[w, b] + dt
