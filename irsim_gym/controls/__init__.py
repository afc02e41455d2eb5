"""What a person does with keyboard and mouse, for worlds by hand and for learners' environments."""

from irsim_gym.controls.keyboard import Keyboard
from irsim_gym.controls.mouse import Mouse

__all__ = ["Keyboard", "Mouse"]
