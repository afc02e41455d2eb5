"""The section ``gui``: options of keyboard and mouse in a window."""

from typing import Literal

from irsim_gym.base.options import defaults, kind, option


@kind
class KeyboardSpec:
    """The section ``gui.keyboard``."""

    backend: Literal["pynput", "mpl"] = option("pynput", meaning="No effect: key presses are those of the window.")
    global_hook: bool = option(False, meaning="No effect, with a warning: keys need the focus of the window.")
    key_lv_max: float = option(3.0, ge=0.0, unit="m/s", meaning="Speed while a key is held, up to vel_max.")
    key_ang_max: float = option(1.0, ge=0.0, unit="rad/s", meaning="Turn rate while a key is held.")
    key_lv: float = option(0.0, unit="m/s", meaning="Speed at the start.")
    key_ang: float = option(0.0, unit="rad/s", meaning="Turn rate at the start.")
    key_rot: float = option(0.0, unit="rad/s", meaning="Turn rate of an omnidirectional body at the start.")
    key_id: int = option(0, ge=0, meaning="Index of the robot that the keys drive.")


@kind
class MouseSpec:
    """The section ``gui.mouse``."""

    zoom_factor: float = option(1.1, gt=1.0, meaning="Zoom factor per step of the wheel.")


@kind
class GuiSpec:
    """The section ``gui``."""

    keyboard: KeyboardSpec = option(defaults(KeyboardSpec), meaning="Options of the keyboard.")
    mouse: MouseSpec = option(defaults(MouseSpec), meaning="Options of the mouse.")
