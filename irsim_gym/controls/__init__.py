"""Keyboard and mouse control, for worlds by hand and for learners' environments."""

from irsim_gym.controls.driver import Driver

__all__ = ["Driver"]
