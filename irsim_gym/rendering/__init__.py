"""How a world is drawn. It reads and never writes.

No task and no environment; it is loaded when a picture is asked for.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from irsim_gym.rendering.films.renderer import Renderer

__all__ = ["Renderer"]


def __getattr__(name: str) -> Any:
    """Import the renderer on first use."""
    if name == "Renderer":
        from irsim_gym.rendering.films.renderer import Renderer

        return Renderer
    raise AttributeError(f"module 'irsim_gym.rendering' has no attribute {name!r}")
