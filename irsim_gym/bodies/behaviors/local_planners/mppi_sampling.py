"""Sampled command sequences and their average: model predictive path integral control."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from irsim_gym.base.rng import normal
from irsim_gym.bodies.behaviors.local_planners.rollouts import LANES, find_nearest, gap_at, twist_of
from irsim_gym.bodies.behaviors.local_planners.task import (
    LocalTables,
    LocalTask,
    is_under_way,
    obstacle_cost,
    see_hits,
    task_of,
)
from irsim_gym.bodies.behaviors.local_planners.way import off_way
from irsim_gym.bodies.behaviors.pursuit.motion import Moving, executed, moving_of
from irsim_gym.bodies.behaviors.shared.steering import clear_command
from irsim_gym.simulator.world.names import ACKERMANN, Floats, Ints, Model, State, Struct, kernel
from irsim_gym.simulator.world.own_scan import OwnScan


@dataclass(repr=False)
class Samples(Struct):
    """The planned commands of a group's members, and scratch memory of one shard for samples.

    Attributes:
        nominal: Planned commands of each member for the coming steps, shape ``(n_worlds, n_members, n_steps, 2)``.
        asked: Scratch: sampled commands, shape ``(n_samples, n_steps, 2)``.
        cost: Scratch: cost of each sample, shape ``(n_samples,)``.
    """

    nominal: Floats
    asked: Floats
    cost: Floats


@kernel
def forget_plans(worlds: Ints, samples: Samples) -> None:
    """Reset the plans of members in some worlds to standing still.

    Writes: samples (nominal).
    """
    for w in worlds:
        samples.nominal[w, :, :, :] = 0.0


@kernel
def decide_mppi(
    worlds: Ints,
    members: Ints,
    params: Any,
    scan: OwnScan,
    model: Model,
    state: State,
    tables: LocalTables,
    samples: Samples,
) -> None:
    """Write the commands of bodies that average sampled command sequences by what they cost.

    Reads: scan (beams_x, beams_y, offset, range_max, range_min, ranges, sensors), model (acceleration_limit,
        disc_count, disc_start, drive, goal_threshold, has_goal, local_discs, local_segments, present, reach,
        segment_count, segment_start, solid, step_time, velocity_max, velocity_min, wheelbase), state (goal, pose,
        random, steering, twist, velocity), tables (by_rate, hits, poses, way, ways), samples (asked, cost, nominal).
    Writes: state (command, random), tables (hits, poses, way), samples (asked, cost, nominal).
    """
    for w in worlds:
        for k in range(members.shape[0]):
            # A member keeps its row of plans, whoever else decides in the same call.
            b, options, nominal = members[k], params[k], samples.nominal[w, tables.ways.row[members[k]]]
            clear_command(state, w, b)
            if not is_under_way(model, state, w, b):
                nominal[:, :] = 0.0
                continue
            task = task_of(w, b, see_hits(scan, w, k, options, tables.hits), options, model, state, tables)
            moving = moving_of(model, state, w, b, tables.by_rate[b])
            draw_samples(w, state, options, moving, nominal, samples)
            for i in range(options.samples):
                samples.cost[i] += rollout_cost(task, options, moving, samples.asked[i], tables)
            best = average(options.temperature, options.samples, samples, nominal)
            # The average of ways that pass something on either side leads into it: then the best sample is taken.
            # A way that touches something costs at least `collision_cost`, see rollout_cost.
            if rollout_cost(task, options, moving, nominal, tables) >= options.collision_cost:
                copy_plan(samples.asked[best], nominal)
            state.command[w, b, 0], state.command[w, b, 1] = nominal[0, 0], nominal[0, 1]
            shift(nominal)


@kernel
def draw_samples(w: int, state: State, options: Any, moving: Moving, nominal: Floats, samples: Samples) -> None:
    """Write sequences about the nominal one, itself and a stop among them, and what their noise costs.

    With u the nominal commands, e the noise and s its standard deviation, that is gamma times the sum of u e / s^2
    (Williams et al. 2017: the control cost u^T Sigma^-1 e, from importance sampling).

    Reads: state (random).
    Writes: state (random), samples (asked, cost).
    """
    asked = samples.asked
    for i in range(options.samples):
        total = 0.0
        for t in range(nominal.shape[0]):
            for axis in range(2):
                deviation = 0.5 * options.noise * (moving.high[axis] - moving.low[axis])
                # Sample 0 is the nominal sequence, sample 1 a stop.
                drawn = normal(state.random, w, 0.0, deviation) if i > 1 else 0.0
                wanted = 0.0 if i == 1 else nominal[t, axis] + drawn
                wanted = min(max(wanted, moving.low[axis]), moving.high[axis])
                asked[i, t, axis] = wanted
                if deviation > 0.0:
                    # The noise after clamping; 0 for an axis that cannot vary.
                    total += nominal[t, axis] * (wanted - nominal[t, axis]) / (deviation * deviation)
        samples.cost[i] = options.gamma * total


@kernel
def rollout_cost(task: LocalTask, options: Any, moving: Moving, asked: Floats, tables: LocalTables) -> float:
    """Return what driving by a sequence of commands costs, integrated over time.

    Once it has arrived nothing costs any more. A way that touches something costs ``collision_cost``, and from there on
    as if it stood.

    Reads: tables (hits, poses, way).
    Writes: tables (poses).
    """
    poses, limit = tables.poses[0], options.footprint_padding + options.inflation_radius
    x, y, cosine, sine, heading, steering = 0.0, 0.0, 1.0, 0.0, 0.0, moving.steering
    one, two, total, n_steps = moving.velocity[0], moving.velocity[1], 0.0, asked.shape[0]
    driven, last_x, last_y = 0.0, 0.0, 0.0
    # The wheels of a car with a steering angle follow one step later: a step rolls at the angle before it.
    steers = task.wheels.drive == ACKERMANN and not task.wheels.by_rate
    for t in range(n_steps):
        k = t % LANES
        if k == 0:
            # The next LANES poses, which find_nearest compares with the hits; beyond the horizon the last is repeated.
            for j in range(LANES):
                if t + j < n_steps:
                    one = executed(moving, 0, asked[t + j, 0], one)
                    two = executed(moving, 1, asked[t + j, 1], two)
                    ahead, left, rate = twist_of(task.wheels, one, steering if steers else two)
                    # Euler's step with the heading before it, as the drives themselves move.
                    x += (cosine * ahead - sine * left) * moving.step
                    y += (sine * ahead + cosine * left) * moving.step
                    heading, steering = heading + rate * moving.step, two
                    cosine, sine = np.cos(heading), np.sin(heading)
                poses.x[j], poses.y[j], poses.cosine[j], poses.sine[j] = x, y, cosine, sine
            find_nearest(tables.hits, task.n_hits, poses)
        here_x, here_y = poses.x[k], poses.y[k]
        gap = gap_at(task.outline, task.reach, limit, tables.hits, task.n_hits, poses, k)
        dx, dy = task.goal_x - here_x, task.goal_y - here_y
        if gap >= task.bearable and dx * dx + dy * dy < task.goal_radius * task.goal_radius:
            break
        front = here_x + task.forward * poses.cosine[k], here_y + task.forward * poses.sine[k]
        driven += np.sqrt((here_x - last_x) * (here_x - last_x) + (here_y - last_y) * (here_y - last_y))
        last_x, last_y = here_x, here_y
        # Only as much of the path counts as the body has driven, so that the projection does not skip to a later part.
        path, reached = off_way(tables.way, task.n_way, front, driven + task.forward)
        away = options.path_weight * path + options.goal_weight * (task.length - reached)
        if gap < task.bearable:
            # Early contacts cost more, up to twice as much; the rest of the horizon costs as if the body stood there.
            return float(total + options.collision_cost * (2.0 - t / n_steps) + away * (n_steps - t) * moving.step)
        total += (away + options.obstacle_weight * obstacle_cost(options, gap)) * moving.step
    return float(total)


@kernel
def average(temperature: float, count: int, samples: Samples, nominal: Floats) -> int:
    """Write the average of the sampled sequences, weighted by exp(-cost / temperature); return the cheapest sample.

    Reads: samples (asked, cost).
    Writes: nominal.
    """
    best = 0
    for i in range(1, count):
        if samples.cost[i] < samples.cost[best]:
            best = i
    # Costs count from the least one (as in Williams et al. 2017): the best weight is 1, and the sum cannot vanish.
    least, whole = samples.cost[best], 0.0
    nominal[:, :] = 0.0
    for i in range(count):
        weight = np.exp(-(samples.cost[i] - least) / temperature)
        whole += weight
        if weight > 0.0:
            for t in range(nominal.shape[0]):
                nominal[t, 0] += weight * samples.asked[i, t, 0]
                nominal[t, 1] += weight * samples.asked[i, t, 1]
    for t in range(nominal.shape[0]):
        nominal[t, 0] /= whole
        nominal[t, 1] /= whole
    return best


@kernel
def copy_plan(asked: Floats, nominal: Floats) -> None:
    """Write a sequence that was tried as the planned one.

    Writes: nominal.
    """
    for t in range(nominal.shape[0]):
        nominal[t, 0], nominal[t, 1] = asked[t, 0], asked[t, 1]


@kernel
def shift(nominal: Floats) -> None:
    """Move a sequence on by a step; its end is repeated.

    Writes: nominal.
    """
    for t in range(nominal.shape[0] - 1):
        nominal[t, 0], nominal[t, 1] = nominal[t + 1, 0], nominal[t + 1, 1]
