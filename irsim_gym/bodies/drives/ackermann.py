"""Ackermann steering: a car."""

from typing import Any, ClassVar, Literal

import numpy as np

from irsim_gym.bodies.drives import motion_noise
from irsim_gym.simulator.geometry.angles import wrap_below, wrap_from
from irsim_gym.simulator.world.names import ACKERMANN, Floats, Group, Ints, Model, Shard, State, kernel, kind, option


@kind
class Ackermann(motion_noise.RollingDrive):
    """A car with front steering; its position is the middle of the rear axle.

    Mode ``steer``: the command is speed v [m/s] and steering angle [rad]. The car turns at v tan(steering) / wheelbase
    with the angle of the step before, as in IR-SIM; the commanded angle takes effect from the next step on.

    Mode ``angular``: the command is speed v [m/s] and yaw rate w [rad/s]. The limits of the second component
    (``vel_min``, ``vel_max``, ``acce``) bind the yaw rate; the car turns at just that rate, and the steering angle is
    the one that does it, atan(w wheelbase / v), less than a right angle to either side. A car at rest (v = 0) cannot
    turn: it keeps heading and steering angle.
    """

    command_names: ClassVar[tuple[str, ...]] = ("linear", "steer")
    state_size: ClassVar[int] = 4
    drive: ClassVar[int] = ACKERMANN
    needs_wheelbase: ClassVar[bool] = True

    mode: Literal["steer", "angular"] = option("steer", meaning="Second component: steering angle, or yaw rate.")
    wheelbase: float | None = option(None, gt=0.0, unit="m", meaning="Axle distance; default: the shape's.")

    @property
    def command_words(self) -> tuple[tuple[str, str], ...]:
        """What the components of a command are, and their units."""
        second = ("steering angle", "rad") if self.mode == "steer" else ("turn rate", "rad/s")
        return ("speed ahead", "m/s"), (f"{second[0]}, positive to the left", second[1])

    @staticmethod
    def begin(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Write the members' twists at the start of an episode, from their poses and initial velocities."""
        twist_ackermann(shard.worlds, group.members, group.params, model, state)

    @staticmethod
    def move(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Advance the members' poses by one step (explicit Euler with the heading of the step's start)."""
        executed = motion_noise.executed(group, model, state, shard)
        move_ackermann(shard.worlds, group.members, group.params, model, state, executed)
        Ackermann.begin(group, model, state, shard)


@kernel
def twist_ackermann(worlds: Ints, members: Ints, params: Any, model: Model, state: State) -> None:
    """Write velocities in the world frame; the yaw rate is that of the present steering angle.

    Reads: model (wheelbase), state (pose, steering, velocity).
    Writes: state (twist).
    """
    for w in worlds:
        for k in range(members.shape[0]):
            b = members[k]
            speed = state.velocity[w, b, 0]
            state.twist[w, b, 0] = speed * np.cos(state.pose[w, b, 2])
            state.twist[w, b, 1] = speed * np.sin(state.pose[w, b, 2])
            state.twist[w, b, 2] = speed * np.tan(state.steering[w, b]) / model.wheelbase[b]
            # Mode `angular`: the yaw rate itself; the angle of a car that stands does not show it.
            if params[k].mode == 1:
                state.twist[w, b, 2] = state.velocity[w, b, 1] if speed != 0.0 else 0.0


@kernel
def move_ackermann(worlds: Ints, members: Ints, params: Any, model: Model, state: State, executed: Floats) -> None:
    """Write poses and steering angles of the members that are free to move, from what they execute.

    Reads: model (heading_low, step_time, wheelbase), state (pose, steering, stopped).
    Writes: state (pose, steering).
    """
    dt = model.step_time[0]
    for w in worlds:
        for k in range(members.shape[0]):
            b = members[k]
            if state.stopped[w, b]:
                continue
            heading, speed, second = state.pose[w, b, 2], executed[w, b, 0], executed[w, b, 1]
            state.pose[w, b, 0] += speed * np.cos(heading) * dt
            state.pose[w, b, 1] += speed * np.sin(heading) * dt
            if params[k].mode == 0:
                # Kinematic bicycle model. The wheels turn only now: this step still rolls at the angle of the step
                # before.
                rate = speed * np.tan(state.steering[w, b]) / model.wheelbase[b]
                state.steering[w, b] = second
            # Mode `angular`: the steering angle that goes with the yaw rate.
            elif speed != 0.0:
                rate = second
                state.steering[w, b] = np.arctan(second * model.wheelbase[b] / speed)
            else:
                rate = 0.0
            # Wrapped twice, as in IR-SIM: by the drive to [-pi, pi), then to the interval of the body's angle_range.
            heading = wrap_below(heading + rate * dt)
            state.pose[w, b, 2] = wrap_from(heading, model.heading_low[b])
