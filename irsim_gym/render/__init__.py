"""How it is drawn: scenes, frames, films."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from irsim_gym.render.backends import BACKENDS, checked_backend, make_renderer

if TYPE_CHECKING:
    from irsim_gym.render.matplotlib_renderer import Renderer
    from irsim_gym.render.renderer import WorldRenderer

__all__ = ["BACKENDS", "Renderer", "WorldRenderer", "checked_backend", "make_renderer"]


def __getattr__(name: str) -> Any:
    """Load matplotlib only for who draws with it."""
    if name == "Renderer":
        from irsim_gym.render.matplotlib_renderer import Renderer

        return Renderer
    if name == "WorldRenderer":
        from irsim_gym.render.renderer import WorldRenderer

        return WorldRenderer
    raise AttributeError(f"module 'irsim_gym.render' has no attribute {name!r}")
