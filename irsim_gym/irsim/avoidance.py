"""IR-SIM's ``rvo`` as functions and as a class, for behaviours of one's own. It chooses as ``rvo`` does here."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NoReturn, final

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.bodies.behaviors.rvo.rvo import Rvo, free_velocity
from irsim_gym.bodies.behaviors.shared.surroundings import DISC, Ego
from irsim_gym.irsim.rotations import vel_world2diff

Rows = Sequence[Sequence[float]]


@final
class reciprocal_vel_obs:  # noqa: N801
    """Chooses the velocity of one body that leads to no collision.

    Args:
        state: ``rvo_state`` of the body: x, y, vx, vy, radius, wanted vx and vy, and perhaps more [m, m/s].
        obs_state_list: ``rvo_neighbor_state`` of others: x, y, vx, vy, radius [m, m/s], or x, y, radius.
        vxmax: Greatest velocity along x [m/s].
        vymax: Greatest velocity along y [m/s].
        acce: Greatest change of each component [m/s].
        factor: Weight, without unit, of the time to a collision where each velocity leads to one.
        line_obs_list: Walls: x, y, x, y [m].
    """

    def __init__(
        self,
        state: Sequence[float],
        obs_state_list: Rows | None = None,
        vxmax: float = 1.5,
        vymax: float = 1.5,
        acce: float = 0.5,
        factor: float = 1.0,
        line_obs_list: Rows | None = None,
    ) -> None:
        self._options: dict[str, Any] = {"vxmax": vxmax, "vymax": vymax, "acce": acce, "factor": factor}
        self.update(state, obs_state_list, line_obs_list)

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> NoReturn:
            raise AttributeError(f"reciprocal_vel_obs has no '{name}': cal_vel(mode) does it all", name=name, obj=self)

    def update(self, state: Sequence[float], obs_state_list: Rows | None, line_obs_list: Rows | None = None) -> None:
        """Replace the body (``state``), the others (``obs_state_list``) and the walls (``line_obs_list``)."""
        self.state, self.obs_state_list, self.line_obs_list = state, obs_state_list or [], line_obs_list or []

    def cal_vel(self, mode: str = "rvo") -> list[float]:
        """Return the velocity vx, vy [m/s].

        Args:
            mode: How the cone of forbidden velocities is placed: ``rvo``, ``hrvo`` or ``vo``.

        Raises:
            ValueError: The mode is unknown.
        """
        if mode not in ("rvo", "hrvo", "vo"):
            raise ValueError(f"mode must be 'rvo', 'hrvo' or 'vo', got {mode!r}")
        numbers, options = list(map(float, self.state[:7])), Rvo(**{**self._options, "mode": mode})
        rounds = np.zeros(len(self.obs_state_list), DISC)
        for disc, row in zip(rounds, self.obs_state_list, strict=True):
            seen = [*row[:2], 0.0, 0.0, row[2]] if len(row) == 3 else row
            disc["x"], disc["y"], disc["vx"], disc["vy"], disc["radius"] = map(float, seen[:5])
        sides = np.asarray(self.line_obs_list, np.float64).reshape(-1, 4)
        return list(map(float, free_velocity(options, Ego(*numbers[:5]), (numbers[5], numbers[6]), rounds, sides)))


def OmniRVO(  # noqa: N802
    state_tuple: Sequence[float],
    neighbor_list: Rows | None = None,
    vxmax: float = 1.5,
    vymax: float = 1.5,
    acce: float = 1.0,
    factor: float = 1.0,
    mode: str = "rvo",
    neighbor_threshold: float = 3.0,
    line_segments: Rows | None = None,
) -> Floats:
    """Return the velocity vx, vy in the world frame that ``rvo`` chooses [m/s], shape ``(2, 1)``.

    Args:
        state_tuple: ``rvo_state`` of the body [m, m/s, rad].
        neighbor_list: ``rvo_neighbor_state`` of others [m, m/s].
        vxmax: Greatest velocity along x [m/s].
        vymax: Greatest velocity along y [m/s].
        acce: Greatest change of each component [m/s].
        factor: Weight, without unit, of the time to a collision where each velocity leads to one.
        mode: ``rvo``, ``hrvo`` or ``vo``.
        neighbor_threshold: Others whose centres are farther away are not seen [m].
        line_segments: Walls: x, y, x, y [m].
    """
    near = _near(state_tuple, neighbor_list, neighbor_threshold)
    chooser = reciprocal_vel_obs(state_tuple, near, vxmax, vymax, acce, factor, line_segments)
    return np.array(chooser.cal_vel(mode)).reshape(2, 1)


def DiffRVO(  # noqa: N802
    state_tuple: Sequence[float],
    neighbor_list: Rows | None = None,
    vxmax: float = 1.5,
    vymax: float = 1.5,
    acce: float = 1.0,
    factor: float = 1.0,
    mode: str = "rvo",
    neighbor_threshold: float = 3.0,
    line_segments: Rows | None = None,
) -> Floats:
    """Return the command (linear, angular) of a differential drive that follows ``OmniRVO``, shape ``(2, 1)``.

    With nobody in sight and the goal behind it, the robot turns on the spot. ``neighbor_list``, ``vxmax``, ``vymax``,
    ``acce``, ``factor``, ``mode``, ``neighbor_threshold`` and ``line_segments`` are those of ``OmniRVO``.

    Args:
        state_tuple: ``rvo_state`` of the body [m, m/s, rad], with the heading at its end.
    """
    others = neighbor_list, vxmax, vymax, acce, factor, mode, neighbor_threshold, line_segments
    command = vel_world2diff(state_tuple[-1], OmniRVO(state_tuple, *others))
    if not command.any() and not line_segments and not _near(state_tuple, neighbor_list, neighbor_threshold):
        command = vel_world2diff(state_tuple[-1], [state_tuple[5], state_tuple[6]])
        command[0] = 0.0
    return command


def _near(state: Sequence[float], others: Rows | None, sight: float) -> list[Sequence[float]]:
    return [row for row in others or () if np.hypot(row[0] - state[0], row[1] - state[1]) < sight]
