"""Rendering: scenes, frames, figures, films."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from irsim_gym.render.renderer import Renderer

__all__ = ["Renderer"]


def __getattr__(name: str) -> Any:
    """Import the renderer on first use."""
    if name == "Renderer":
        from irsim_gym.render.renderer import Renderer

        return Renderer
    raise AttributeError(f"module 'irsim_gym.render' has no attribute {name!r}")
