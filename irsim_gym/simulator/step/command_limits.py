"""Limits of commands: velocities that a drive can execute."""

import numpy as np

from irsim_gym.simulator.world.names import Floats, Ints, Model, State, kernel, row_of


@kernel
def limit_velocity(worlds: Ints, movers: Ints, model: Model, state: State) -> None:
    """Write ``state.velocity``: each component of the command, clipped to the limits of velocity and acceleration.

    These are [max(v_min, v - a dt), min(v_max, v + a dt)]. The upper end wins if this interval is empty. With
    ``speed_bound``, the speed is limited to the first component of v_max, too. Stopped bodies stand still, and so do
    those without a command.

    Reads: model (acceleration_limit, driven, present, speed_bound, step_time, velocity_max, velocity_min), state
        (command, stopped, velocity).
    Writes: state (velocity).
    """
    dt = model.step_time[0]
    for w in worlds:
        slowest = model.velocity_min[row_of(model.velocity_min, w)]
        fastest = model.velocity_max[row_of(model.velocity_max, w)]
        sharpest = model.acceleration_limit[row_of(model.acceleration_limit, w)]
        for b in movers:
            # ``now`` is a view of the state: the velocity of the last step, which the new one replaces axis by axis.
            command, now = state.command[w, b], state.velocity[w, b]
            low, high, change = slowest[b], fastest[b], sharpest[b]
            # A body that nobody drives stands still unless it has a command other than zeros.
            is_asked = command[0] != 0.0 or command[1] != 0.0 or command[2] != 0.0
            is_free = model.present[w, b] and not state.stopped[w, b] and (model.driven[b] or is_asked)
            for axis in range(3):
                least = max(low[axis], now[axis] - change[axis] * dt)
                most = min(high[axis], now[axis] + change[axis] * dt)
                now[axis] = min(max(command[axis], least), most) if is_free else 0.0
            if model.speed_bound[b]:
                hold_speed(now, high[0])


@kernel
def hold_speed(velocity: Floats, most: float) -> None:
    """Shorten a velocity whose first two components are faster than ``most`` [m/s].

    Writes: velocity.
    """
    speed = np.sqrt(velocity[0] * velocity[0] + velocity[1] * velocity[1])
    if speed > most:
        velocity[0], velocity[1] = velocity[0] * (most / speed), velocity[1] * (most / speed)
