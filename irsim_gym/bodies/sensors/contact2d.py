"""contact2d: what a body feels of others, drawn as points and forces."""

from typing import Any, ClassVar

import numpy as np

from irsim_gym.simulator.world.names import Floats, Group, Ints, Model, Records, Shard, State, kernel, kind, option
from irsim_gym.simulator.world.outline import Outline


@kind
class ContactPlot:
    """Drawing options of the sensor; defaults come from the sensor's options."""

    force_scale: float | None = option(None, ge=0.0, unit="m/N", meaning="Length of the line of a force.")
    marker_size: float | None = option(None, ge=0.0, meaning="Size of the marker at a contact [point].")
    linewidth: float | None = option(None, ge=0.0, meaning="Width of the line [point].")
    alpha: float | None = option(None, ge=0.0, le=1.0, meaning="Opacity.")
    color: str | None = option(None, min_length=1, meaning="Colour.")


@kind
class Contact2D:
    """Draws the contacts of its body, with ``collision_mode: contact``; its reading is the force on it [N]."""

    reading: ClassVar[str] = "contact"

    force_scale: float = option(0.05, ge=0.0, unit="m/N", meaning="Length of the line of a force.")
    marker_size: float = option(6.0, ge=0.0, meaning="Size of the marker at a contact [point].")
    linewidth: float = option(1.5, ge=0.0, meaning="Width of the line [point].")
    alpha: float = option(0.9, ge=0.0, le=1.0, meaning="Opacity.")
    color: str = option("#D55E00", min_length=1, meaning="Colour.")
    plot: ContactPlot | None = option(None, meaning="Drawing options of the sensor.")

    def group_key(self) -> tuple[Any, ...]:
        """Return what members of one group share: nothing."""
        return ()

    def drawn(self, key: str) -> Any:
        """Return a drawing option: that in ``plot`` takes precedence."""
        own = getattr(self.plot, key, None)
        return getattr(self, key) if own is None else own

    @staticmethod
    def prepare(group: Group, outlines: list[Outline], model: Model, n_slots: int) -> None:
        """Make room for the forces [N], shape ``(n_worlds, n_members, 2)``."""
        group.arrays["contact"] = np.zeros((len(model.present), len(group.members), 2))

    @staticmethod
    def sense(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Write the forces on the members, in the world frame."""
        pushing = None if group.context is None else group.context.pushing
        if pushing is not None:
            copy_forces(shard.worlds, group.members, pushing.felt, group.arrays["contact"])


@kernel
def copy_forces(worlds: Ints, members: Ints, felt: Records, reading: Floats) -> None:
    """Write the forces on some bodies [N].

    Writes: reading.
    """
    for w in worlds:
        for k in range(members.shape[0]):
            reading[w, k, 0], reading[w, k, 1] = felt[w, members[k]].x, felt[w, members[k]].y
