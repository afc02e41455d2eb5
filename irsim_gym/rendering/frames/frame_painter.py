"""Draws frames from a plan, with cached words and backdrops, and memory for each thread."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from irsim_gym.base.arraytypes import Bytes, Floats, Ints
from irsim_gym.rendering.frames.card import Card, Head, plot_box, world_box
from irsim_gym.rendering.frames.letters import Masks
from irsim_gym.rendering.frames.mark_painter import MarkPainter, marks_by_layer
from irsim_gym.rendering.frames.plan import Plan
from irsim_gym.rendering.frames.reduced_images import Images
from irsim_gym.rendering.looks import theme
from irsim_gym.rendering.looks.colours import CLEAR, colour
from irsim_gym.rendering.raster import records
from irsim_gym.rendering.raster.areas import MOST_CORNERS
from irsim_gym.rendering.raster.masks import paint_cells
from irsim_gym.rendering.raster.play import draw_frames, draw_heads, draw_items
from irsim_gym.rendering.raster.sheets import new_sheet
from irsim_gym.rendering.scene.frame_layout import Layout
from irsim_gym.rendering.scene.reader import DrawnSimulation, SceneReader
from irsim_gym.simulator.readings.marks import Overlay
from irsim_gym.simulator.readings.trails import LONGEST
from irsim_gym.simulator.world.group import Shard

POINT = 100.0 / 72.0
HALF_A_WALL = 1.1
BACKDROP_BYTES = 64 << 20
REMEMBERED_LOOKS = 64
Share = Callable[[Callable[[Shard], None], Ints], None]
"""Runs a function on parts of an array of indices, possibly on several threads, such as ``Shards.run``."""


class FramePainter:
    """Draws pictures of worlds; it is created for the first picture.

    Args:
        drawn: The simulation.
        reader: Reads the map and the trails.
        share: Divides the work among threads, or None.
        layout: Layout of a frame.
        lowest: The lowest layer of marks over the worlds.

    Attributes:
        plan: The items to draw.
        point: Pixels per typographic point.
        marks: Paints marks over the worlds.
    """

    def __init__(
        self, drawn: DrawnSimulation, reader: SceneReader, share: Share | None, layout: Layout, lowest: float
    ) -> None:
        scenario, model, explored, plot = drawn.scenario, drawn.model, drawn.explored, drawn.scenario.world.plot
        self._scenario, self._model, self._state, self._reader = scenario, model, drawn.state, reader
        self._share, self._layout = share, layout
        self._title = scenario.name if plot.title is None else plot.title
        self._clipped = plot.viewpoint is None or reader.center(0) is None
        self._explored = np.zeros((1, 1, 1), np.bool_) if explored is None else explored
        self._masks, self.point = Masks(), POINT * layout.enlargement
        self._images = Images(scenario, layout.scale)
        self._room = max(BACKDROP_BYTES // layout.width // layout.height // 3, 1)
        followed = [int(body) for body in reader.trails.bodies]
        self.plan = Plan(drawn, followed, self._images.number, self._masks, self.point, lowest)
        self._image_scale = layout.scale
        self._card = Card(self._masks, self.point, not plot.no_axis)
        self._head = Head(self._masks, self.point, layout, titled=plot.title is not None) if plot.show_title else None
        self._scratch: dict[int, records.Scratch] = {}
        self._cards: dict[Layout, Bytes] = {}
        self._looks: dict[Layout, tuple[Floats, Ints]] = {}
        self._backdrops: dict[tuple[Layout, bytes], Bytes] = {}
        self._fixed = np.unique(self.plan.ground["body"]) if len(self.plan.ground) else np.zeros(0, np.int64)
        self._segment_rows = _rows_of(
            model.segment_start, model.segment_count, self._fixed, model.local_segments.shape[1]
        )
        self._disc_rows = _rows_of(model.disc_start, model.disc_count, self._fixed, model.local_discs.shape[1])
        self.marks = MarkPainter(self.point, layout, shows_title=self._head is not None)

    def draw(
        self, worlds: Ints, statuses: Sequence[str], layouts: Sequence[Layout], overlays: Sequence[Overlay]
    ) -> Bytes:
        """Draw worlds.

        Args:
            worlds: Indices of the worlds, shape ``(n,)``.
            statuses: Status of each episode.
            layouts: Layout of each picture.
            overlays: Marks over each world.

        Returns:
            Pictures, uint8, shape ``(n, height, width, 3)``.
        """
        pictures = np.empty((len(worlds), self._layout.height, self._layout.width, 3), np.uint8)
        if not len(worlds):
            return pictures
        if layouts[0].scale != self._image_scale:
            self._image_scale = layouts[0].scale
            self._images = Images(self._scenario, self._image_scale)
        job = _Job(self, pictures, worlds, statuses, layouts, overlays)
        frames = np.arange(len(worlds))
        if self._share is None or len(worlds) == 1:
            job.draw(Shard(frames))
        else:
            self._share(job.draw, frames)
        self._keep(job)
        return pictures

    @property
    def is_rigid(self) -> bool:
        """Whether all levels have the same map, which ``card`` includes."""
        return bool(self._model.rigid[0])

    def scratch(self, slot: int) -> records.Scratch:
        """Return the memory of a thread."""
        scratch = self._scratch.get(slot)
        if scratch is None:
            layout, model = self._layout, self._model
            # The longest list of points; behind it is room for a copy of a part and for its dashes (``ways.add_way``).
            n_points = max(MOST_CORNERS, LONGEST, 2 * len(self.plan.angles), model.local_segments.shape[1]) + 16
            scratch = self._scratch[slot] = records.Scratch(
                sheet=new_sheet(layout.height, layout.width),
                points=np.zeros((3 * n_points, 2)),
                place=np.zeros(7),
                colour=np.zeros(4),
                cells=np.zeros(self._explored.shape[1:], np.float32),
                struck=np.zeros(len(model.role), np.bool_),
            )
        return scratch

    def backdrop_key(self, world: int, layout: Layout) -> tuple[Layout, bytes]:
        """Return the key of a world's backdrop."""
        state, model = self._state, self._model
        tables = state.segments[world, self._segment_rows], state.discs[world, self._disc_rows]
        parts = state.pose[world, self._fixed], *tables  # poses too: images turn even if outlines do not
        present = model.present[world, self._fixed]
        squares = model.map_squares[world % len(model.map_squares), 0]
        drawn = b"" if self.is_rigid else np.packbits(squares == 0).tobytes()
        counts = (table[world % len(table), self._fixed] for table in (model.segment_count, model.disc_count))
        return layout, b"|".join([present.tobytes(), drawn, *(part.tobytes() for part in (*counts, *parts))])

    def known_backdrop(self, key: tuple[Layout, bytes]) -> Bytes | None:
        """Return a cached backdrop; None without one."""
        return self._backdrops.get(key)

    def _keep(self, job: _Job) -> None:
        """Cache new backdrops, replacing old ones if there are too many."""
        for key, backdrop in list(job.new_backdrops.items())[: self._room]:
            while len(self._backdrops) >= self._room:
                self._backdrops.pop(next(iter(self._backdrops)))
            self._backdrops[key] = backdrop

    def look(self, layouts: Sequence[Layout]) -> records.Look:
        """Return the views of the worlds for the kernels."""
        looks = self._looks
        if len(looks) > REMEMBERED_LOOKS:
            looks.clear()
        for layout in dict.fromkeys(layouts):
            if layout not in looks:
                looks[layout] = look_from(layout), self._boxes(layout)
        places = [looks[layout] for layout in layouts]
        views, boxes = (np.array([place[k] for place in places]) for k in (0, 1))
        bounds, flag = self._model.bounds, np.array(theme.FLAG) * self.point
        return records.Look(views=views, boxes=boxes, bounds=bounds, flag=flag, flagged=self.plan.flagged)

    def _boxes(self, layout: Layout) -> Ints:
        plot = plot_box(layout)
        wall = HALF_A_WALL * self.point
        # In the order of ``records.WORLD`` to ``records.MARKS``.
        inner = [world_box(layout, 0.0), world_box(layout, wall)] if self._clipped else [plot, plot]
        whole, rim = np.array([0, 0, layout.width, layout.height]), np.array([0, 0, 1, 1])
        return np.array([*inner, plot, whole, np.minimum(inner[0] + rim, whole[[2, 3, 2, 3]])], np.int64)

    def source(self, worlds: Ints) -> records.RasterSource:
        """Return the arrays of the simulation that kernels read."""
        model, state, groups = self._model, self._state, self.plan.groups
        rows = [group.arrays["ranges"][worlds].reshape(len(worlds), -1) for group in groups]
        ranges = np.concatenate([np.zeros((len(worlds), 0), np.float32), *rows], axis=1, dtype=np.float32)
        speeds = np.zeros((len(worlds), ranges.shape[1] if self.plan.has_speeds else 0))
        first = 0
        for group, row in zip(groups, rows, strict=True):
            if "radial_velocity" in group.arrays:
                radial = group.arrays["radial_velocity"][worlds].reshape(row.shape)
                speeds[:, first : first + row.shape[1]] = radial
            first += row.shape[1]
        read = records.Readings(self.plan.angles, ranges, speeds, self._explored)
        masks, images = self._masks, self._images
        prints = records.Prints(masks.levels, masks.rows, images.pixels, images.rows, self.plan.corners)
        past = records.Past(*self._reader.trails.tables())
        return records.RasterSource(self.plan.scans, model, state, read, past, prints)

    def words(self, worlds: Ints, statuses: Sequence[str], overlays: Sequence[Overlay]) -> tuple[Ints, Ints, Floats]:
        """Return the words of the heads: their places, the end of each picture's words, and their colours."""
        if self._head is None:
            return np.zeros((0, 4), np.int64), np.zeros(len(worlds), np.int64), np.zeros((1, 4))
        placed, ends, inks = list[tuple[int, int, int, int]](), list[int](), [colour(theme.INK, 1.0)]
        for status, time, overlay in zip(statuses, self._state.time[worlds].tolist(), overlays, strict=True):
            is_named = overlay.title is None
            plain, coloured = self._head.place(self._title, status, time) if is_named else ([], [])
            placed += [(*word, 0) for word in plain]
            placed += [(*word, len(inks)) for word in coloured]
            ends.append(len(placed))
            inks.append(colour(theme.status_colour(status), 1.0))
        return np.array(placed, np.int64).reshape(-1, 4), np.array(ends, np.int64), np.array(inks)

    def card(self, layout: Layout, scratch: records.Scratch) -> Bytes:
        """Return the picture of an empty world, including its map if all levels share it."""
        card = self._cards.get(layout)
        if card is None:
            card = np.empty((layout.height, layout.width, 3), np.uint8)
            self._card.draw(card, scratch.sheet, layout)
            if self.is_rigid:
                self.paint_map(card, 0, layout)
            self._cards.clear()
            self._cards[layout] = card
        return card

    def paint_map(self, picture: Bytes, world: int, layout: Layout) -> None:
        """Paint a world's map over a picture."""
        view = self._reader.map_view(world)
        if view is not None:
            x_min, y_min, x_max, y_max = view.extent
            columns, rows = view.occupied.shape
            frame = np.array([x_min, y_min, (x_max - x_min) / columns, (y_max - y_min) / rows])
            ink = np.array(colour(view.colour, view.alpha))
            paint_cells(picture, plot_box(layout), view.occupied, frame, look_from(layout), ink)


class _Job:
    """The data of one call of ``FramePainter.draw``."""

    def __init__(
        self,
        painter: FramePainter,
        pictures: Bytes,
        worlds: Ints,
        statuses: Sequence[str],
        layouts: Sequence[Layout],
        overlays: Sequence[Overlay],
    ) -> None:
        self._painter, self._pictures, self._worlds, self._layouts = painter, pictures, worlds, layouts
        self._overlays = overlays
        self.new_backdrops: dict[tuple[Layout, bytes], Bytes] = {}
        scratch = painter.scratch(0)
        self._cards = {layout: painter.card(layout, scratch) for layout in dict.fromkeys(layouts)}
        self._look = painter.look(layouts)
        self._words = painter.words(worlds, statuses, overlays)
        painter.marks.prepare(overlays)
        self._source = painter.source(worlds)  # after new words have been added to the masks
        outcomes = [theme.status_colour(status) if theme.ends_episode(status) else None for status in statuses]
        self._tints = np.array([CLEAR if name is None else colour(name, 0.07) for name in outcomes])
        self._edges = np.array([CLEAR if name is None else colour(name, 0.9) for name in outcomes])

    def draw(self, shard: Shard) -> None:
        """Draw the pictures of a shard."""
        painter, frames, pictures = self._painter, shard.worlds, self._pictures
        scratch = painter.scratch(shard.slot)
        self._draw_ground(frames, scratch)
        draw_frames(pictures, frames, self._tints, 0.0, self._look, scratch)
        self._draw_live(frames, scratch)
        draw_frames(pictures, frames, self._edges, 2.2 * painter.point, self._look, scratch)
        draw_heads(pictures, frames, *self._words, self._source.prints, self._look.boxes)
        for f in frames.tolist():
            if (title := self._overlays[f].title) is not None:
                painter.marks.write_title(pictures[f], title)

    def _draw_live(self, frames: Ints, scratch: records.Scratch) -> None:
        """Draw the items that change between pictures, with marks between their layers."""
        painter = self._painter
        items, layers = painter.plan.live, painter.plan.layers
        is_plain = np.array([not self._overlays[f].marks for f in frames.tolist()])
        if is_plain.any():
            self._draw_items(items, frames[is_plain], scratch)
        for f in frames[~is_plain]:
            first, frame, layout = 0, np.array([f]), self._layouts[f]
            for layer, marks in marks_by_layer(self._overlays[f]):
                end = int(np.searchsorted(layers, layer, "right"))
                self._draw_items(items[first:end], frame, scratch)
                painter.marks.paint(self._pictures[f], scratch.sheet, self._look.boxes[f, records.WORLD], layout, marks)
                first = end
            self._draw_items(items[first:], frame, scratch)

    def _draw_items(self, items: object, frames: Ints, scratch: records.Scratch) -> None:
        """Draw items of the plan on some pictures."""
        draw_items(self._pictures, frames, self._worlds, items, self._source, self._look, scratch)

    def _draw_ground(self, frames: Ints, scratch: records.Scratch) -> None:
        """Draw what never moves, or copy it from a cached picture."""
        painter, missing = self._painter, {}
        for f in frames.tolist():
            layout = self._layouts[f]
            key = painter.backdrop_key(int(self._worlds[f]), layout)
            backdrop = painter.known_backdrop(key)
            if backdrop is None:
                missing[f], backdrop = key, self._cards[layout]
            np.copyto(self._pictures[f], backdrop)
        if missing:
            for f in missing if not painter.is_rigid else ():
                painter.paint_map(self._pictures[f], int(self._worlds[f]), self._layouts[f])
            chosen = np.array(list(missing), np.int64)
            self._draw_items(painter.plan.ground, chosen, scratch)
            self.new_backdrops |= {key: self._pictures[f].copy() for f, key in missing.items()}


def look_from(layout: Layout) -> Floats:
    """Return column and row of the world's origin [pixel], and pixels per metre, shape ``(3,)``."""
    return np.array([*layout.column_row(0.0, 0.0), layout.scale])


def _rows_of(start: Any, size: Any, bodies: Any, n_rows: int) -> Any:
    """Return the rows of some bodies in a table of outlines, for the largest outlines of all worlds."""
    ends = [int(start[b]) + int(size[:, b].max(initial=0)) for b in bodies]
    rows = [np.arange(start[b], min(end, n_rows)) for b, end in zip(bodies, ends, strict=True)]
    return np.concatenate([np.zeros(0, np.int64), *rows])
