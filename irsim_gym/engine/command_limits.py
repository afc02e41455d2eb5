"""What a drive can execute of what it is asked."""

from __future__ import annotations

from irsim_gym.arraytypes import Flags, Floats, Ints
from irsim_gym.jit import kernel
from irsim_gym.world.group import Shard
from irsim_gym.world.model import WorldModel
from irsim_gym.world.state import WorldState


def apply(movers: Ints, model: WorldModel, state: WorldState, shard: Shard) -> None:
    """Write ``state.velocity``: the command within velocity and acceleration limits; zero for a stopped body."""
    limit_velocity(
        shard.worlds,
        movers,
        model.step_time,
        model.driven,
        model.velocity_min,
        model.velocity_max,
        model.acceleration_limit,
        model.present,
        state.stopped,
        state.command,
        state.velocity,
    )


@kernel
def limit_velocity(
    worlds: Ints,
    movers: Ints,
    step_time: Floats,
    driven: Flags,
    velocity_min: Floats,
    velocity_max: Floats,
    acceleration_limit: Floats,
    present: Flags,
    stopped: Flags,
    command: Floats,
    velocity: Floats,
) -> None:
    """Clip each component to [max(v_min, v - a dt), min(v_max, v + a dt)].

    The upper end wins where the interval is empty. A body that nobody commands stands still, whatever its limits.
    """
    dt = step_time[0]
    for i in range(worlds.shape[0]):
        w = worlds[i]
        slowest, fastest = (
            velocity_min[min(w, velocity_min.shape[0] - 1)],
            velocity_max[min(w, velocity_max.shape[0] - 1)],
        )
        sharpest = acceleration_limit[min(w, acceleration_limit.shape[0] - 1)]
        for k in range(movers.shape[0]):
            b = movers[k]
            asked, now, low, high, change = command[w, b], velocity[w, b], slowest[b], fastest[b], sharpest[b]
            is_asked = asked[0] != 0.0 or asked[1] != 0.0 or asked[2] != 0.0
            is_free = present[w, b] and not stopped[w, b] and (driven[b] or is_asked)
            for axis in range(3):
                least = max(low[axis], now[axis] - change[axis] * dt)
                most = min(high[axis], now[axis] + change[axis] * dt)
                now[axis] = min(max(asked[axis], least), most) if is_free else 0.0
