"""drive_lag: a drive that follows its commands slowly."""

from typing import Annotated, ClassVar

import numpy as np

from irsim_gym.base.options import Bounds, Drawn
from irsim_gym.simulator.world.disturbed import Disturbed
from irsim_gym.simulator.world.names import Floats, Group, Ints, Model, Shard, State, kernel, kind, option
from irsim_gym.simulator.world.response import Response


@kind
class DriveLag:
    """Each velocity follows its command as a first-order lag: 63 % of a change after ``tau``, 95 % after 3 ``tau``.

    Limits of acceleration apply after it. Commands below ``dead_band`` do not move the wheels.
    """

    acts_on: ClassVar[str] = "command"

    tau: Annotated[Drawn, Bounds(0.0, 100.0)] = option(0.0, unit="s", meaning="Time constant; 0: no lag.")
    dead_band: Annotated[Drawn, Bounds(0.0, 100.0)] = option(
        0.0, unit="m/s or rad/s", meaning="Each number of a command that is smaller than this counts as 0."
    )

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Make room for the share of the way to the command that each step makes."""
        group.arrays["share"] = np.zeros(group.tables.count.shape)

    @staticmethod
    def disturb(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Replace the commands by velocities on the way to them."""
        lag_behind(shard.worlds, group.tables, group.arrays["share"], model, state)

    @staticmethod
    def foresee(group: Group, model: Model, response: Response, shard: Shard) -> None:
        """Write how slowly velocities follow."""
        note_lag(shard.worlds, group.tables, model, response)


@kernel
def lag_behind(worlds: Ints, disturbed: Disturbed, share: Floats, model: Model, state: State) -> None:
    """Move each command towards the velocity of the last step.

    Reads: disturbed (count, members, values), model (step_time), state (command, velocity).
    Writes: disturbed (count), share, state (command).
    """
    for w in worlds:
        for k in range(disturbed.members.shape[0]):
            b, tau, least = disturbed.members[k], disturbed.values[w, k, 0], disturbed.values[w, k, 1]
            if disturbed.count[w, k] == 0:
                share[w, k] = share_of(tau, model)
            for axis in range(3):
                command, now = state.command[w, b, axis], state.velocity[w, b, axis]
                command = command if np.abs(command) >= least else 0.0
                state.command[w, b, axis] = now + (command - now) * share[w, k]
            disturbed.count[w, k] += 1


@kernel
def share_of(tau: float, model: Model) -> float:
    """Return the share of the way to its command that a velocity makes in a step.

    Reads: model (step_time).
    """
    return 1.0 - np.exp(-model.step_time[0] / tau) if tau > 0.0 else 1.0


@kernel
def note_lag(worlds: Ints, disturbed: Disturbed, model: Model, response: Response) -> None:
    """Write the share of the way that a step makes, and the dead band; several lags make smaller shares.

    Reads: disturbed (members, values), model (step_time), response (dead_band, place, share).
    Writes: response (dead_band, share).
    """
    for w in worlds:
        for k in range(disturbed.members.shape[0]):
            place = response.place[disturbed.members[k]]
            tau, least = disturbed.values[w, k, 0], disturbed.values[w, k, 1]
            if place >= 0:
                response.share[w, place] *= share_of(tau, model)
                response.dead_band[w, place] = max(response.dead_band[w, place], least)
