"""What a drive can execute of what it is asked."""

from __future__ import annotations

from irsim_gym.arraytypes import Ints
from irsim_gym.jit import kernel
from irsim_gym.world.group import Shard
from irsim_gym.world.model import WorldModel
from irsim_gym.world.rows import row_of
from irsim_gym.world.state import WorldState


def apply(movers: Ints, model: WorldModel, state: WorldState, shard: Shard) -> None:
    """Write ``state.velocity``: the command within velocity and acceleration limits; zero for a stopped body."""
    limit_velocity(shard.worlds, movers, model, state)


@kernel
def limit_velocity(worlds: Ints, movers: Ints, model: WorldModel, state: WorldState) -> None:
    """Clip each component to [max(v_min, v - a dt), min(v_max, v + a dt)].

    The upper end wins where the interval is empty. A body that nobody commands stands still, whatever its limits.
    """
    dt = model.step_time[0]
    for w in worlds:
        slowest, fastest = (
            model.velocity_min[row_of(model.velocity_min, w)],
            model.velocity_max[row_of(model.velocity_max, w)],
        )
        sharpest = model.acceleration_limit[row_of(model.acceleration_limit, w)]
        for b in movers:
            asked, now, low, high, change = (
                state.command[w, b],
                state.velocity[w, b],
                slowest[b],
                fastest[b],
                sharpest[b],
            )
            is_asked = asked[0] != 0.0 or asked[1] != 0.0 or asked[2] != 0.0
            is_free = model.present[w, b] and not state.stopped[w, b] and (model.driven[b] or is_asked)
            for axis in range(3):
                least = max(low[axis], now[axis] - change[axis] * dt)
                most = min(high[axis], now[axis] + change[axis] * dt)
                now[axis] = min(max(asked[axis], least), most) if is_free else 0.0
