"""Which of the two renderers draws: matplotlib, or the compiled rasteriser."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, Any

from irsim_gym.arraytypes import Flags
from irsim_gym.errors import UnknownNameError, suggestion

if TYPE_CHECKING:
    from irsim_gym.render.easel import Share
    from irsim_gym.render.layout import Layout
    from irsim_gym.render.renderer import WorldRenderer
    from irsim_gym.scenario.spec import Scenario
    from irsim_gym.world.group import Group
    from irsim_gym.world.model import WorldModel
    from irsim_gym.world.state import WorldState
    from irsim_gym.world.trails import Trails

BACKENDS = ("matplotlib", "raster")


def layout_of(renderer: WorldRenderer, *, follows: bool) -> Layout:
    """Return where the world is on a frame that would be drawn now.

    Args:
        renderer: Who draws it.
        follows: The scenario's ``viewpoint`` decides what is seen, and nobody has asked for another part.
    """
    center = renderer.scene().center if follows else None
    return renderer.layout if center is None else renderer.layout.centred(*center)


def checked_backend(name: str) -> str:
    """Return the name of a renderer, or raise an ``UnknownNameError`` that lists them."""
    if name not in BACKENDS:
        raise UnknownNameError(
            f"render_backend must be {' or '.join(map(repr, BACKENDS))}, got {name!r}{suggestion(str(name), BACKENDS)}"
        )
    return name


def make_renderer(
    backend: str,
    scenario: Scenario,
    model: WorldModel,
    state: WorldState,
    sensors: Sequence[Group] = (),
    *,
    learners: Collection[int] = (),
    size: tuple[int, int] | None = None,
    trails: Trails | None = None,
    explored: Flags | None = None,
    share: Share | None = None,
) -> WorldRenderer:
    """Make the renderer of a simulation; the libraries that it needs are loaded here and not before.

    Args:
        backend: ``"matplotlib"``, or ``"raster"``, which is faster and does without matplotlib. Both lay frames out
            alike, in the same size.
        scenario: What is simulated, for names, colours and plot options.
        model: The simulation's constants.
        state: Its present state.
        sensors: Its sensor groups.
        learners: Bodies whose goals and trajectories are drawn unless the scenario says otherwise.
        size: Width and height of the frames in pixels, made even; None for what the scenario asks for.
        trails: Where bodies have been, kept by who steps the worlds; None for poses at which frames were drawn.
        explored: Which cells of the world its robots have seen (``Simulation.explored``); what is left lies in fog.
        share: Who divides the pictures of one call among threads, as ``Shards.run`` of the engine does; None for
            nobody. Matplotlib draws one after the other all the same.

    Raises:
        UnknownNameError: There is no such renderer.
    """
    options: dict[str, Any] = {"learners": learners, "size": size, "trails": trails, "explored": explored}
    if checked_backend(backend) == "raster":
        from irsim_gym.render.raster_renderer import RasterRenderer

        return RasterRenderer(scenario, model, state, sensors, share=share, **options)
    from irsim_gym.render.matplotlib_renderer import Renderer

    return Renderer(scenario, model, state, sensors, **options)
