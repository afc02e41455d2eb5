"""Records an episode as plain data, for a page that replays it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.rendering.looks import theme
from irsim_gym.rendering.looks.packing import METRE, packed
from irsim_gym.rendering.replay import replay_tracks
from irsim_gym.rendering.replay.replay_items import Items, SharedItems
from irsim_gym.rendering.replay.replay_tracks import BodyTrack, Changes, FogTrack, ScanTrack, Seen
from irsim_gym.rendering.scene import vocabulary
from irsim_gym.rendering.scene.scene import DrawnBody, Scene
from irsim_gym.simulator.readings.marks import Overlay

if TYPE_CHECKING:
    from irsim_gym.scenario.specs.spec import Scenario

TIME = 1e-4
VALUE = 1e-6
ENDLESS = 1e6
"""Limit for values of agents; larger ones, such as the clearance in an empty world, are omitted."""


class Recording:
    """A recording of one episode: its scenes, and the values of its agents.

    ``data`` returns the content of a page, which `irsim_gym.rendering.replay.replay_page` writes. It is plain JSON.
    Tables of numbers are packed (`irsim_gym.rendering.looks.packing`), and values that change seldom are lists of
    ``[moment, value]``, one for each change:

    - ``name``: its name in the list of episodes; ``details``: further facts, text by name;
    - ``title``: heading of the picture; ``bounds``: the world's rectangle [m]; ``look``: ``axis``, ``title`` (whether
      there is a line above), ``titled`` (whether it is only a title); ``center``: the point in the middle of the
      picture, or None;
    - ``count``: number of moments; ``time`` of each [s];
    - ``status`` and ``titles`` (titles set by a script, or None): changes; ``tones``: the colour of each status;
    - ``bodies``: ``name``, ``fixed``, ``shape`` (number of the outline), and ``poses``: x, y, then heading and turn of
      the heading's mark; None while the body is absent;
    - ``scans``: ``body``, ``surrounds``, ``angles``, ``ranges``, ``places`` (x, y, then heading), ``speeds``; a range
      from above ``near`` to below ``far`` is a hit;
    - ``fog``: the cells that no robot has seen, see ``FogTrack``, or None;
    - ``items``: the drawn items, the lowest first: ``rank`` (of `irsim_gym.rendering.scene.vocabulary`), ``draw`` (a
      primitive of the page's script) and its fields: ``pen``, ``shape``, ``body`` and ``scan`` by number, ``places``
      (x, y and optionally heading), ``spans`` (first moment, end, first moment, end...) of items that are not always
      visible;
    - ``agents``: ``name``, ``outcome`` (changes), and for each moment ``values``, ``action`` and ``terms`` of the
      reward.

    Args:
        scenario: The scenario, for its drawing options.
        agents: Names of the robots whose values are recorded.
        details: Further facts, such as the policy and the level.

    Attributes:
        name: Its name in the list of episodes.
        look: ``axis``, ``title``, ``titled``, see above.
        saved_figure: Resolution, margins and background of saved figures.
    """

    def __init__(
        self, scenario: Scenario, agents: Sequence[str] = (), details: Mapping[str, str] | None = None
    ) -> None:
        plot = scenario.world.plot
        self.look = {"axis": not plot.no_axis, "title": bool(plot.show_title), "titled": plot.title is not None}
        self.saved_figure = plot.saved_figure
        self.name, self._details = "", dict(details or {})
        self._agents = tuple(agents)
        self._last: Scene | None = None
        self._fixed: Sequence[DrawnBody] | None = None
        self._times: list[float] = []
        self._centers: list[tuple[float, float]] = []
        self._bodies: dict[str, list[BodyTrack]] = {}
        self._scans: dict[tuple[str, int], ScanTrack] = {}
        self._status = Changes()
        self._goals, self._struck, self._maps, self._outcomes = Seen(), Seen(), Seen(), Seen()
        self._fog: FogTrack | None = None
        self._overlays: list[Overlay] = []
        self._values: list[tuple[Mapping[str, Any], ...]] = []

    def __len__(self) -> int:
        return len(self._times)

    @property
    def agents(self) -> tuple[str, ...]:
        """Names of the robots whose values are recorded."""
        return self._agents

    @property
    def times(self) -> Sequence[float]:
        """The times of the moments [s]."""
        return self._times

    @property
    def last(self) -> Scene:
        """The scene of the last moment.

        Raises:
            ValueError: If nothing was recorded.
        """
        if self._last is None:
            raise ValueError("nothing was recorded")
        return self._last

    def moving(self, moment: int) -> dict[str, DrawnBody]:
        """Return the movable bodies that are present at a moment, by name."""
        tracks = (track for tracks in self._bodies.values() for track in tracks if not track.fixed)
        return {view.name: view for track in tracks if (view := track.view(moment)) is not None}

    def note(self, scene: Scene, poses: Floats, values: Sequence[Mapping[str, object]] = ()) -> None:
        """Record a moment.

        Args:
            scene: The scene.
            poses: Poses of the bodies [m, m, rad], by id, shape ``(n_bodies, 3)``.
            values: For each agent, its ``outcome`` (text), numbers by any names, and optionally ``action`` (numbers)
                and ``terms`` (numbers by name).

        Raises:
            ValueError: If the numbers of values and agents differ.
        """
        if len(values) != len(self._agents):
            raise ValueError(f"values of {len(self._agents)} agents are needed, got {len(values)}")
        moment = len(self._times)
        names = {view.body: view.name for view in scene.fixed + scene.moving}
        self._note_bodies(scene, poses, moment)
        self._note_scans(scene, names, moment)
        self._status.note(moment, scene.status)
        if theme.ends_episode(scene.status):
            tone = theme.status_colour(scene.status)
            self._outcomes.note(moment, tone, tone)
        for body in scene.struck:
            self._struck.note(moment, body.name, body)
        if self._last is not None and scene.goals is self._last.goals:
            self._goals.note_again(moment)
        else:
            for goal in scene.goals:
                numbers = goal.x, goal.y, goal.heading, goal.tolerance, goal.arrived, *goal.later.flat
                self._goals.note(moment, (goal.name, id(goal.style), np.array(numbers).tobytes()), goal)
        if scene.map is not None:
            self._maps.note(moment, id(scene.map), scene.map)
        if scene.fog is not None:
            self._fog = self._fog or FogTrack(scene.fog)
            self._fog.note(scene.fog, moment)
        self._times.append(scene.time)
        self._centers.append(scene.center or (np.nan, np.nan))
        self._values.append(tuple(dict(value) for value in values))
        self._overlays.append(scene.overlay)
        self._last = scene

    def redraw(self, scene: Scene) -> None:
        """Replace the marks of the latest moment by those of a scene."""
        self._overlays[-1], self._last = scene.overlay, scene

    def data(self, shared: SharedItems | None = None) -> dict[str, Any]:
        """Return the episode as JSON.

        Args:
            shared: Receives its pens, shapes and pictures, which it refers to by number.

        Raises:
            ValueError: If nothing was recorded.
        """
        last, count, shared = self.last, len(self._times), shared or SharedItems()
        centers, bodies = np.array(self._centers), [track for tracks in self._bodies.values() for track in tracks]
        titles = Changes()
        for moment, overlay in enumerate(self._overlays):
            titles.note(moment, overlay.title)
        return {
            "name": self.name,
            "details": self._details,
            "title": last.title,
            "bounds": [round(float(value), 6) for value in last.bounds],
            "look": self.look,
            "count": count,
            "time": packed(self._times, TIME),
            "status": self._status.list,
            "tones": {status: theme.status_colour(status) for _, status in self._status.list},
            "titles": titles.list,
            "bodies": [track.data(count, shared) for track in bodies],
            "scans": [track.data(count) for track in self._scans.values()],
            "fog": None if self._fog is None else self._fog.data(),
            "center": None if np.isnan(centers).all() else packed(centers, METRE),
            "agents": [self._agent(a, name) for a, name in enumerate(self._agents)],
            "items": self._items(bodies, Items(shared)).list(),
        }

    def _items(self, bodies: Sequence[BodyTrack], items: Items) -> Items:
        """Add all items."""
        for view, spans in self._maps.things.values():
            items.add(replay_tracks.map_figure(view), spans=spans)
        for tone, spans in self._outcomes.things.values():
            for figure in vocabulary.outcome(tone, self.last.bounds):
                items.add(figure, spans=spans)
        if self._fog is not None:
            self._fog.draw(items)
        for number, track in enumerate(bodies):
            track.draw(items, number, self._struck)
        for number, scan in enumerate(self._scans.values()):
            scan.draw(items, number)
        for goal, spans in self._goals.things.values():
            for thing in vocabulary.goal(goal):
                items.add(thing, spans=spans)
        for mark, spans in replay_tracks.marks_seen(self._overlays).things.values():
            items.add(vocabulary.mark(mark), spans=spans)
        return items

    def _note_bodies(self, scene: Scene, poses: Floats, moment: int) -> None:
        still = scene.fixed is self._fixed
        self._fixed = scene.fixed
        fields = {id(view.style): (view.span, view.radius) for view in scene.fields}
        if still:
            for view in scene.fixed:
                self._bodies[view.name][-1].stay(moment)
        for views, fixed in ((() if still else scene.fixed, True), (scene.moving, False)):
            for view in views:
                self._track(view, fields.get(id(view.style)), fixed).note(view, poses[view.body], moment)

    def _track(self, view: DrawnBody, field: tuple[float, float] | None, fixed: bool) -> BodyTrack:
        """Return the track for a body's poses; a body whose outline has changed gets a new one."""
        tracks = self._bodies.setdefault(view.name, [])
        if not tracks or not tracks[-1].fits(view):
            tracks.append(BodyTrack(view, field, fixed=fixed))
        return tracks[-1]

    def _note_scans(self, scene: Scene, names: Mapping[int, str], moment: int) -> None:
        count: dict[str, int] = {}
        for view in scene.scans:
            name = names[view.body]
            key = name, count.get(name, 0)
            count[name] = key[1] + 1
            if key not in self._scans:
                self._scans[key] = ScanTrack(view, name)
            self._scans[key].note(view, moment)

    def _agent(self, a: int, name: str) -> dict[str, Any]:
        rows = [values[a] for values in self._values]
        outcome = Changes()
        for moment, row in enumerate(rows):
            outcome.note(moment, str(row.get("outcome", "")))
        plain = [key for key in _keys(rows) if key not in ("outcome", "action", "terms")]
        terms = _keys(row.get("terms", {}) for row in rows)
        action = [row.get("action") for row in rows]
        return {
            "name": name,
            "outcome": outcome.list,
            "values": {key: _series(row.get(key) for row in rows) for key in plain},
            "terms": {key: _series(row.get("terms", {}).get(key) for row in rows) for key in terms},
            "action": None if all(each is None for each in action) else packed(_filled(action), 1e-3),
        }


def _series(values: Iterable[Any]) -> dict[str, Any]:
    """Pack values of an agent, without missing or very large ones."""
    numbers = np.array([np.nan if value is None else float(value) for value in values])
    return packed(np.where(np.abs(numbers) < ENDLESS, numbers, np.nan), VALUE)


def _keys(rows: Iterable[Mapping[str, object]]) -> list[str]:
    """Return the keys of all rows, in order of appearance."""
    return list(dict.fromkeys(key for row in rows for key in row))


def _filled(actions: Sequence[Any]) -> Floats:
    """Return actions as a table, with NaN for missing ones, for example before the first step."""
    width = max(len(action) for action in actions if action is not None)
    return np.array([np.full(width, np.nan) if action is None else action for action in actions], np.float64)
