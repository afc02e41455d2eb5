"""The meaning of keys: velocities of the selected robot, and commands to the world."""

import time
import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.base.errors import NoKeyboardWarning
from irsim_gym.rendering.controls.keys import HeldKeys, Stroke
from irsim_gym.rendering.controls.keys_window import WindowKeys

SPEED_STEP = 0.2
"""Change of a maximum speed per key press [m/s or rad/s]."""

AXES = {"ahead": ("w", "s"), "aside": ("a", "d"), "turn": ("q", "e")}
"""The keys of each direction of motion: the positive one and the negative one."""

COMMANDS = {
    "r": "reset",
    "n": "next",
    "space": "pause",
    "escape": "quit",
    "x": "switch",
    "l": "reload",
    "f5": "step",
    "v": "figure",
    "y": "display",
}
"""Keys that command the world, and their commands."""


class Keyboard:
    """Turns strokes into velocity commands of a drive and commands to the world.

    A held key means full speed, a released one 0; of two opposite keys, the one pressed last counts.

    Args:
        options: The section ``gui.keyboard``.
        source: Source of strokes.
    """

    def __init__(self, options: Any, source: WindowKeys) -> None:
        if options.global_hook:
            warnings.warn("global_hook: keys count only while the window has focus", NoKeyboardWarning, stacklevel=4)
        self.key_lv_max, self.key_ang_max = float(options.key_lv_max), float(options.key_ang_max)
        self.key_id = int(options.key_id)
        self._initial = {"ahead": options.key_lv, "aside": options.key_ang, "turn": options.key_rot}
        self._source, self._held = source, HeldKeys()

    def poll(self, *, drives: bool = True, turns: bool = False) -> list[str]:
        """Process the strokes since the last call.

        Args:
            drives: Whether keys select robots and speeds; commands to the world are processed in either case.
            turns: Whether q and e turn the robot; then they do not change its maximum speed.

        Returns:
            Commands to the world, values of ``COMMANDS``, in order.
        """
        commands = []
        now = time.perf_counter()
        for stroke in self._source.strokes():
            if not self._held.take(stroke, now):
                continue
            if stroke.key in COMMANDS and not stroke.alt:
                commands.append(COMMANDS[stroke.key])
            elif drives:
                # From the first key of an axis on, its initial speed counts no more.
                self._initial.update({way: 0.0 for way, keys in AXES.items() if stroke.key in keys})
                self._set(stroke, turns)
        self._held.settle(now)
        return commands

    def _set(self, stroke: Stroke, turns: bool) -> None:
        """Select a robot, or change a maximum speed."""
        if stroke.alt:
            if stroke.key.isdecimal() and len(stroke.key) == 1:
                self.key_id = int(stroke.key)
            return
        # q and z slow down, e and c speed up: q and e ahead, z and c turning, or ahead with shift.
        sign = {"z": -1, "q": -1, "c": 1, "e": 1}.get(stroke.key)
        if sign is None:
            return
        if stroke.key in ("z", "c") and not stroke.shift:
            self.key_ang_max = _changed_speed(self.key_ang_max, sign)
        elif stroke.key in ("z", "c") or not turns:
            self.key_lv_max = _changed_speed(self.key_lv_max, sign)

    def _axis_speed(self, name: str, full: float) -> float:
        """Return the speed along one of ``AXES``: plus or minus full, 0, or the initial one before its first key."""
        more, less = AXES[name]
        key = self._held.latest(more, less)
        return float(self._initial[name]) if key is None else full if key == more else -full

    @property
    def key_vel(self) -> Floats:
        """Speed ahead [m/s], of a and d [rad/s], and of q and e [rad/s]; shape ``(3,)``."""
        return self.command(("linear", "angular", "angular"))

    def command(self, command_names: Sequence[str]) -> Floats:
        """Return the command of a drive, shape ``(n_components,)``; the step enforces limits.

        Args:
            command_names: Names of its components. If the second one is sideways motion, a and d command it, as fast
                as motion ahead; if there is a third component, q and e command it.
        """
        sideways = self.key_lv_max if command_names[1] in ("y", "left") else self.key_ang_max
        full = {"ahead": self.key_lv_max, "aside": sideways, "turn": self.key_ang_max}
        return np.array([self._axis_speed(name, full[name]) for name in AXES][: len(command_names)])


def _changed_speed(speed: float, sign: int) -> float:
    """Return a maximum speed that is one step faster or slower, rounded because 0.2 has no exact binary form."""
    return max(round(speed + sign * SPEED_STEP, 6), 0.0)
