"""How it is drawn: scenes, frames, films."""

from irsim_gym.render.matplotlib_renderer import Renderer

__all__ = ["Renderer"]
