"""Draws single levels in the picture of an evaluation: obstacles, paths and outcomes."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PatchCollection, PolyCollection
from matplotlib.colors import ListedColormap, to_rgba
from matplotlib.patches import Circle

from irsim_gym.rendering.figures import ways_marks
from irsim_gym.rendering.looks import theme
from irsim_gym.rendering.scene.scene import DrawnBody, MapView

STANDING, MOVING = "#5B6774", "#9DA9B5"


@dataclass(frozen=True)
class DrawnLevel:
    """A level in the picture.

    Attributes:
        number: Number of the level.
        time: Duration [s].
        ways: Paths of the agents.
        fixed: Standing bodies.
        moving: Other bodies, including agents, at the end of the level.
        agents: Ids of the agents, one for each path.
        map: Its occupancy map, or None.
    """

    number: int
    time: float
    ways: Sequence[ways_marks.DrawnWay]
    fixed: Sequence[DrawnBody]
    moving: Sequence[DrawnBody]
    agents: Sequence[int]
    map: MapView | None = None

    @property
    def outcome(self) -> str:
        """Outcome of the level: success if all agents arrived, else that of its agents' which is last in ``ORDER``."""
        return max((way.outcome for way in self.ways), key=ways_marks.rank_of)

    def __str__(self) -> str:
        """Return the outcome as text: ``collision, 3.2 s``; for several agents, the number that arrived."""
        arrived = sum(way.outcome == "success" for way in self.ways)
        words = ways_marks.words_of(self.outcome) if len(self.ways) == 1 else f"{arrived} of {len(self.ways)} arrive"
        return f"{words}, {self.time:.1f} s"


def worth_showing(levels: Sequence[DrawnLevel], count: int) -> list[DrawnLevel]:
    """Select levels to show: failed ones with as many different outcomes as possible, then successful ones.

    Args:
        levels: All levels.
        count: Number of levels to select.

    Returns:
        Levels grouped by outcome and sorted by number; the rarest failure first, successes last.
    """
    by_number = sorted(levels, key=lambda level: level.number)
    often = Counter(level.outcome for level in by_number)
    failures = sorted((outcome for outcome in often if outcome != "success"), key=lambda name: (often[name], name))
    room: Counter[str] = Counter()
    # One level more of each outcome in turn, the rarest first, until the room is used.
    while room.total() < count and any(room[outcome] < often[outcome] for outcome in failures):
        for outcome in failures:
            if room[outcome] < often[outcome] and room.total() < count:
                room[outcome] += 1
    room["success"] = min(count - room.total(), often["success"])
    chosen = list[DrawnLevel]()
    for outcome in (*failures, "success"):
        chosen += [level for level in by_number if level.outcome == outcome][: room[outcome]]
    return chosen


def draw_level(axes: Axes, level: DrawnLevel, bounds: Sequence[float]) -> None:
    """Draw a level, with its number and outcome above."""
    ways_marks.show_world(axes, bounds)
    if level.map is not None:
        draw_map(axes, level.map, STANDING)
    outcomes = dict(zip(level.agents, (way.outcome for way in level.ways), strict=True))
    _draw_bodies(axes, level.fixed, STANDING, 1.0)
    _draw_bodies(axes, [view for view in level.moving if view.body not in outcomes], MOVING, 1.0)
    for view in level.moving:
        if view.body in outcomes:
            _draw_bodies(axes, [view], ways_marks.colour_of(outcomes[view.body]), 0.35)
    ways_marks.draw_lines(axes, level.ways, 1.0, 1.2)
    ways_marks.draw_starts_and_goals(axes, level.ways, 22.0)
    ways_marks.draw_ends(axes, level.ways, 22.0)
    look: dict[str, Any] = {"xycoords": "axes fraction", "textcoords": "offset points", "va": "bottom"}
    look |= {"family": theme.FONT, "fontsize": 7.5}
    axes.annotate(f"level {level.number}", (0.0, 1.0), (0.0, 12.0), color=theme.INK, **look)
    axes.annotate(str(level), (0.0, 1.0), (0.0, 1.0), color=ways_marks.colour_of(level.outcome), **look)


def draw_map(axes: Axes, view: MapView, tone: str, zorder: float = 0.0, **look: Any) -> None:
    """Draw the occupied cells of a map."""
    x_min, y_min, x_max, y_max = view.extent
    axes.imshow(
        view.occupied.T, cmap=ListedColormap([theme.CARD, tone]), origin="lower", zorder=zorder,
        extent=(x_min, x_max, y_min, y_max), interpolation="nearest", vmin=0, vmax=1, **look,
    )  # fmt: skip


def _draw_bodies(axes: Axes, bodies: Sequence[DrawnBody], colour: str, opacity: float) -> None:
    areas = [line for view in bodies if view.solid for line in view.lines]
    walls = [line for view in bodies if not view.solid for line in view.lines]
    discs = [Circle((x, y), radius) for view in bodies for x, y, radius in view.discs.tolist()]
    shade = to_rgba(colour, opacity)
    look: dict[str, Any] = {"facecolors": [shade], "edgecolors": "none", "zorder": 1}
    axes.add_collection(PolyCollection(areas, **look), autolim=False)
    axes.add_collection(PatchCollection(discs, **look), autolim=False)
    axes.add_collection(LineCollection(walls, colors=[shade], linewidths=1.4, zorder=1), autolim=False)
