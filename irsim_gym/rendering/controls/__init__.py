"""What a person commands with keys and mouse, and where these come from.

No window.
"""

from irsim_gym.rendering.controls.driver import Driver

__all__ = ["Driver"]
