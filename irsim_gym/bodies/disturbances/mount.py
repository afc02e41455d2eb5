"""mount: sensors that stand elsewhere than their entry says."""

from typing import Annotated, ClassVar

from irsim_gym.base.options import Bounds, Drawn
from irsim_gym.simulator.world.disturbed import Disturbed
from irsim_gym.simulator.world.names import Floats, Group, Ints, Model, OwnScan, Shard, State, kernel, kind, option


@kind
class Mount:
    """Each range sensor of the robot is mounted elsewhere than its ``offset`` says, by the same in the body frame."""

    acts_on: ClassVar[str] = "mount"

    x: Annotated[Drawn, Bounds(-100.0, 100.0)] = option(0.0, unit="m", meaning="How far it is ahead of that place.")
    y: Annotated[Drawn, Bounds(-100.0, 100.0)] = option(0.0, unit="m", meaning="How far it is to the left of it.")
    turn: Annotated[Drawn, Bounds(-10.0, 10.0)] = option(0.0, unit="rad", meaning="How far it is turned to the left.")

    @staticmethod
    def disturb(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Move the sensors."""
        move_mounts(shard.worlds, group.tables, group.scan, group.arrays["mounts"])


@kernel
def move_mounts(worlds: Ints, disturbed: Disturbed, scan: OwnScan, mounts: Floats) -> None:
    """Write true mount poses, shape ``(n_worlds, n_sensors, 3)``.

    Reads: disturbed (values), scan (offset, sensors).
    Writes: mounts.
    """
    for w in worlds:
        for k in range(scan.sensors.shape[0]):
            for axis in range(3):
                mounts[w, scan.sensors[k], axis] = scan.offset[scan.sensors[k], axis] + disturbed.values[w, k, axis]
