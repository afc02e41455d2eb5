"""Bodies with a mass and no drive: they keep their velocity, and friction slows them."""

from typing import ClassVar

import numpy as np

from irsim_gym.simulator.geometry.angles import wrap_from
from irsim_gym.simulator.pushing.matter import Matter, gyration
from irsim_gym.simulator.world.names import Group, Ints, Model, Shard, State, kernel, kind


@kind
class Coasting:
    """Moves with ``state.velocity``: along x and y [m/s], and a turn rate [rad/s]; ``group.tables`` has the masses."""

    command_names: ClassVar[tuple[str, ...]] = ("x", "y", "angular")
    state_size: ClassVar[int] = 3

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Do nothing."""

    @staticmethod
    def begin(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Write the members' twists, which are their velocities."""
        twist_coasting(shard.worlds, group.members, state)

    @staticmethod
    def move(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Slow the members down, and move them on."""
        coast(shard.worlds, group.members, group.tables, model, state)
        twist_coasting(shard.worlds, group.members, state)


@kernel
def twist_coasting(worlds: Ints, members: Ints, state: State) -> None:
    """Write velocities in the world frame.

    Reads: state (velocity).
    Writes: state (twist).
    """
    for w in worlds:
        for b in members:
            for axis in range(3):
                state.twist[w, b, axis] = state.velocity[w, b, axis]


@kernel
def coast(worlds: Ints, members: Ints, matter: Matter, model: Model, state: State) -> None:
    """Write velocities after friction, and poses; whom a collision holds stands still.

    Reads: matter (gravity, inertia, substance), model (heading_low, present, step_time), state (pose, stopped,
        velocity).
    Writes: state (pose, velocity).
    """
    dt = model.step_time[0]
    for w in worlds:
        for b in members:
            stuff, velocity, pose = matter.substance[b], state.velocity[w, b], state.pose[w, b]
            if state.stopped[w, b] or not model.present[w, b]:
                velocity[0], velocity[1], velocity[2] = 0.0, 0.0, 0.0
                continue
            loss = stuff.friction * matter.gravity * dt
            speed = np.sqrt(velocity[0] * velocity[0] + velocity[1] * velocity[1])
            if speed > 0.0:
                left = max(0.0, speed - loss) / speed
                velocity[0], velocity[1] = velocity[0] * left, velocity[1] * left
            # The radius of gyration turns the loss of speed into one of the turn rate.
            radius = gyration(matter, w, b)
            rate = max(0.0, abs(velocity[2]) - loss / radius) if radius > 0.0 else 0.0
            velocity[2] = np.copysign(rate, velocity[2])
            pose[0] += velocity[0] * dt
            pose[1] += velocity[1] * dt
            pose[2] = wrap_from(pose[2] + velocity[2] * dt, model.heading_low[b])
