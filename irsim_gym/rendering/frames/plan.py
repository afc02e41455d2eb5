"""The plan of frames: the items to draw, in order, as records made once from a scenario's styles."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Flags, Floats
from irsim_gym.rendering.frames.letters import Masks
from irsim_gym.rendering.frames.stamps import dot_mask, flag_mask
from irsim_gym.rendering.looks import styles, theme
from irsim_gym.rendering.looks.colours import CLEAR, Colour, colour, shade
from irsim_gym.rendering.looks.styles import GROUND, TOP, BodyStyle, ScanStyle
from irsim_gym.rendering.raster import records
from irsim_gym.rendering.scene import vocabulary
from irsim_gym.rendering.scene.primitives import Figure, Ink
from irsim_gym.rendering.scene.reader import DrawnSimulation
from irsim_gym.rendering.scene.scene import DrawnBody, Form, GoalView
from irsim_gym.simulator.world.group import Group
from irsim_gym.simulator.world.model import ACKERMANN

LINE_STYLES = {"solid": 0, "dashed": 1, "dashdot": 2, "dotted": 3}
FORMS = {"circle": records.CIRCLE, "rectangle": records.RECTANGLE, "linestring": records.CURVE}
RANKS = {name: number for number, name in enumerate(vocabulary.RANKS)}
DRAWN_BY_KIND = ("shadows", "fixed", "bodies", "headings", "fields", "ghosts")
"""Ranks of a body's shapes with kernels of their own; other shapes are drawn as the vocabulary describes them."""

Key = tuple[float, int, int, float]
Item = tuple[Key, np.void]
Rows = NDArray[np.void]


class Plan:
    """The items of one simulation.

    Attributes:
        ground: Items that never move and lie below all others.
        live: Items that are drawn anew for each picture.
        layers: Layers of the live items, ascending.
        covered: The highest layer of the ground; marks in this layer or above lie over it.
        scans: The sensors.
        groups: Their groups, in the order of their readings.
        angles: Directions of all beams [rad].
        has_speeds: Whether a sensor measures radial velocities.
        flagged: Whether each body's goal is shown.
        corners: Corners of shapes, see ``records.Prints``.
    """

    def __init__(
        self,
        drawn: DrawnSimulation,
        followed: Sequence[int],
        images: dict[int, int],
        masks: Masks,
        point: float,
        lowest: float,
    ) -> None:
        model, learners, self._bodies = drawn.model, drawn.learners, drawn.scenario.bodies
        self._model, self._masks, self._point, self._images = model, masks, point, images
        self.corners: Floats = np.zeros((0, 6))
        self._styles = [styles.body_style(body, learner=b in learners) for b, body in enumerate(self._bodies)]
        self.groups = [group for group in drawn.sensors if {"ranges", "angles"} <= group.arrays.keys()]
        self.has_speeds = any("radial_velocity" in group.arrays for group in self.groups)
        self.angles: Floats = np.zeros(0)
        self.scans: Rows = np.zeros(0, records.BEAMS)
        self.flagged: Flags = np.array([style.show_goal for style in self._styles], np.bool_)
        live = [*self._scan_items(), *self._body_items(), *self._goal_items(), *self._past_items(followed)]
        if drawn.explored is not None:
            live.append(((GROUND, RANKS["fog"], 0, 0.0), self._item(records.FOG, colours=[colour(theme.FOG, 1.0)])))
        # What never moves is painted once for all pictures if nothing that is drawn anew, and no mark, lies below it.
        floor = min([lowest, *(key[0] for key, _ in live)])
        fixed = [b for b in self._ordered() if not model.movable[b]]
        live += [row for b in fixed if self._styles[b].order > floor for row in self._fixed_items(b)]
        self.live, self.layers = _table(live), np.array(sorted(key[0] for key, _ in live))
        below = [b for b in fixed if self._styles[b].order <= floor]
        self.covered = max((self._styles[b].order for b in below), default=-np.inf)
        self.ground = _table([((0.0, *key[1:]), item) for b in below for key, item in self._fixed_items(b)])

    def _ordered(self) -> list[int]:
        return sorted(range(len(self._styles)), key=lambda body: self._styles[body].order)

    def _item(self, kind: int, body: int = -1, *, colours: Sequence[Colour] = (), **fields: Any) -> np.void:
        """Return a record; widths are given in points and stored in pixels."""
        item = np.zeros(1, records.ITEM)
        item["every"], item["box"] = 1, records.WORLD
        item["kind"], item["body"] = kind, body
        item["colours"][0, : len(colours)] = list(colours) if colours else 0.0
        for name, value in fields.items():
            item[name] = value * self._point if name in ("width", "other_width") and value is not None else value
        row: np.void = item[0]
        return row

    def _footprint(self, kind: int, body: int, style: BodyStyle, **fields: object) -> np.void:
        fill = colour(style.colour, style.alpha)
        if style.edge_colour is not None:
            edge = line = colour(style.edge_colour, style.alpha)
        else:
            edge, line = shade(style.colour, 0.68, style.alpha), fill
        fields |= {"style": LINE_STYLES[style.line_style], "filled": style.filled}
        widths = {"width": style.line_width, "other_width": style.wall_width}
        return self._item(kind, body, colours=[fill, edge, line], **widths, **fields)

    def _fixed_items(self, body: int) -> Iterator[Item]:
        """Yield the items of a body that never moves, with its shadows."""
        style = self._styles[body]
        look: dict[str, Any] = {"box": records.WALLS, "snapped": True}
        if body in self._images:
            yield (style.order, RANKS["fixed"], 3, 0.0), self._item(records.IMAGE, body, row=self._images[body], **look)
            return
        for number, (pixels, alpha) in enumerate(theme.SHADOWS if style.filled else ()):
            colours = [colour(theme.SHADOW, alpha), colour(theme.SHADOW, 0.4 * alpha)]
            shift = pixels * self._point
            item = self._item(records.SHADOW, body, colours=colours, width=1.5, x=shift, y=shift, **look)
            yield (style.order, RANKS["fixed"], number, 0.0), item
        yield (style.order, RANKS["fixed"], 2, 0.0), self._footprint(records.FOOTPRINT, body, style, **look)

    def _body_items(self) -> Iterator[Item]:
        """Yield footprints of moving bodies, and headings, impacts, fields of view and labels of all bodies."""
        model, order = self._model, self._ordered()
        for body in order:
            style, wall = self._styles[body], records.WALLS
            if model.movable[body] and body in self._images:
                item = self._item(records.IMAGE, body, row=self._images[body], box=wall)
                yield (style.order, RANKS["bodies"], 1, 0.0), item
            elif model.movable[body]:
                yield (style.order, RANKS["bodies"], 0, 0.0), self._footprint(records.FOOTPRINT, body, style, box=wall)
            if style.show_arrow:
                layer = style.order if style.arrow_order is None else style.arrow_order
                yield (layer, RANKS["headings"], 0, float(model.movable[body])), self._heading(body, style)
            red = [CLEAR, colour(theme.IMPACT, 1.0), colour(theme.IMPACT, 0.25)]
            item = self._item(records.IMPACT, body, colours=red, width=1.8, other_width=5.0, box=wall)
            yield (TOP, RANKS["impacts"], 0, float(model.movable[body])), item
            field = styles.field_of_view(self._bodies[body]) if style.show_field else None
            if field is not None:
                colours = [colour(name, style.field_alpha) for name in (style.field_colour, style.field_edge_colour)]
                item = self._item(records.FIELD, body, colours=colours, width=0.9, x=field[0], y=field[1])
                yield (style.field_order, RANKS["fields"], 0, float(body)), item
            yield from self._label(body, style)
            for primitive in vocabulary.body(_empty_view(style), None, fixed=not model.movable[body]):
                if isinstance(primitive, Figure) and primitive.rank not in DRAWN_BY_KIND:
                    key = primitive.layer, RANKS[primitive.rank], 0, float(body)
                    yield key, self._shape(body, records.AT_BODY, primitive)

    def _heading(self, body: int, style: BodyStyle) -> np.void:
        is_car = self._model.drive[body] == ACKERMANN and body not in self._images
        form = records.ARROW if style.arrow is not None else records.WINDSCREEN if is_car else records.WEDGE
        length, width = style.arrow or (0.0, 0.0)
        colours, turns = [colour(style.arrow_colour, style.arrow_alpha)], styles.is_omni(self._bodies[body])
        look = {"form": form, "x": length, "y": width, "box": records.WALLS, "turns": turns}
        return self._item(records.HEADING, body, colours=colours, **look)

    def _label(self, body: int, style: BodyStyle) -> Iterator[Item]:
        for kind, text in ((records.LABEL, style.label), (records.GOAL_LABEL, style.goal_label)):
            if not text or (kind == records.GOAL_LABEL and not style.show_goal):
                continue
            word = self._masks.word(text, style.label_size * self._point)
            offset = style.label_offset if kind == records.LABEL else None
            item = self._item(
                kind,
                body,
                colours=[colour(style.label_colour, style.label_alpha)],
                row=word.mask,
                length=len(text),
                width=style.label_size,
                half=0.5 * word.width,
                foot=word.foot,
                in_metres=offset is not None,
                x=0.0 if offset is None else offset[0],
                y=0.0 if offset is None else offset[1],
                box=records.WHOLE,
            )
            yield (style.label_order, RANKS["labels"], kind, float(self._model.movable[body])), item

    def _goal_items(self) -> Iterator[Item]:
        shown = [body for body, style in enumerate(self._styles) if style.show_goal]
        if not shown:
            return
        dot, flag = dot_mask(self._masks, vocabulary.WAYPOINT.dot * self._point), flag_mask(self._masks, self._point)
        for body in shown:
            near, far, reached = (_goal(self._styles[body], *how) for how in ((1.0, False), (2.0, False), (1.0, True)))
            inks: dict[str, Colour] = {}
            for number, primitive in enumerate(near):
                key = primitive.layer, RANKS[primitive.rank], 0, float(body)
                if primitive.shape.discs is not None:
                    look = {"width": primitive.pen.width, "filled_radius": primitive.pen.filled_radius * self._point}
                    colours = [ink_of(primitive.pen.fill), ink_of(primitive.pen.edge), ink_of(reached[number].pen.fill)]
                    yield key, self._item(records.GOAL_CIRCLE, body, colours=colours, box=records.PLOT, **look)
                elif primitive.rank in ("waypoints", "flags"):
                    inks[primitive.rank] = ink_of(primitive.pen.fill)
                else:
                    yield key, self._shape(body, records.AT_GOAL, primitive, far[number].shape.chains)
            look = {"row": flag, "every": dot, "box": records.PLOT}
            item = self._item(records.GOAL_MARKS, body, colours=[CLEAR, inks["flags"], inks["waypoints"]], **look)
            yield (near[0].layer, RANKS["flags"], 0, float(body)), item

    def _shape(self, body: int, where: int, figure: Figure, farther: tuple[Floats, ...] | None = None) -> np.void:
        """Return the item of a shape at a body or at its goal.

        Args:
            body: The body.
            where: ``records.AT_BODY`` or ``AT_GOAL``.
            figure: The shape; at a goal, that for a tolerance of 1 m.
            farther: The shape's chains for a tolerance of 2 m.
        """
        shape, pen = figure.shape, figure.pen
        count = len((shape.chains or shape.offsets)[0])
        corners = np.zeros((count, 6))
        if shape.chains:
            # A goal's shape is linear in its tolerance: what a metre adds follows from the shapes for 1 m and 2 m, and
            # the shape for a tolerance of 0 from both.
            per_metre = (farther or shape.chains)[0] - shape.chains[0]
            corners[:, :2], corners[:, 2:4] = shape.chains[0] - per_metre, per_metre
        if shape.offsets:
            corners[:, 4:] = self._point * shape.offsets[0]
        self.corners = np.vstack([self.corners, corners])
        return self._item(
            records.SHAPE,
            body,
            form=where,
            row=len(self.corners) - count,
            length=count,
            turns=figure.turned or (figure.places is not None and figure.places.shape[1] > 2),
            filled=pen.fill is not None,
            colours=[ink_of(pen.fill), ink_of(pen.edge)],
            width=pen.width if pen.edge is not None else 0.0,
            style=LINE_STYLES[pen.line],
            x=shape.least * self._point,
            box=records.PLOT if vocabulary.RANKS[figure.rank].reach is None else records.WORLD,
        )

    def _past_items(self, followed: Sequence[int]) -> Iterator[Item]:
        for row, body in enumerate(followed):
            style, ghost = self._styles[body], self._styles[body].ghost
            if style.show_trajectory:
                metres = style.trajectory_width
                item = self._item(
                    records.PATH,
                    body,
                    colours=[CLEAR, colour(style.trajectory_colour, style.trajectory_alpha)],
                    row=row,
                    length=style.trajectory_length,
                    style=LINE_STYLES[style.trajectory_style],
                    width=theme.PATH_WIDTH if metres is None else metres / self._point,
                    in_metres=metres is not None,
                )
                yield (style.trajectory_order, RANKS["paths"], 0, float(row)), item
            if ghost is not None:
                fields: dict[str, Any] = {"row": row, "every": style.ghost_every, "length": style.ghost_length}
                fields["form"] = FORMS.get(style.ghost_shape or "", records.OWN)
                yield (
                    (ghost.order, RANKS["ghosts"], 0, float(row)),
                    self._footprint(records.GHOSTS, body, ghost, **fields),
                )

    def _scan_items(self) -> Iterator[Item]:
        beams, angles = list[Rows](), list[Floats]()
        first, dot = 0, dot_mask(self._masks, 1.3 * self._point)
        for group in self.groups:
            for k, body in enumerate(group.members.tolist()):
                style = styles.scan_style(group.options[k])
                beam = self._beams(group, k, style, first)
                angles.append(np.asarray(group.arrays["angles"], np.float64))
                first += len(angles[-1])
                if self._styles[body].show_sensor:
                    yield (GROUND, RANKS["scans"], 0, float(len(beams))), self._scan(body, len(beams), style)
                    look = [colour(style.colour, min(3.0 * style.alpha, 1.0))]
                    item = self._item(records.HITS, body, colours=look, row=len(beams), every=dot, box=records.MARKS)
                    yield (TOP, RANKS["hits"], 0, float(len(beams))), item
                beams.append(beam)
        if beams:
            self.scans, self.angles = np.concatenate(beams), np.concatenate(angles)

    def _scan(self, body: int, row: int, style: ScanStyle) -> np.void:
        speed = style.velocity
        if speed is None or not speed.coloured:
            look = [colour(style.colour, min(share * style.alpha, 1.0)) for share in (0.22, 0.9)]
            return self._item(records.SCAN, body, row=row, colours=look, width=0.45)
        look = [colour(speed.free_colour, speed.free_alpha), colour(speed.rest_colour, style.alpha)]
        return self._item(records.SCAN, body, row=row, colours=look, width=speed.width, other_width=speed.free_width)

    def _beams(self, group: Group, k: int, style: ScanStyle, first: int) -> Rows:
        options, angles, speed = group.options[k], group.arrays["angles"], style.velocity
        beam = np.zeros(1, records.BEAMS)
        x, y, heading = getattr(options, "offset", None) or (0.0, 0.0, 0.0)
        span, count = float(angles[-1] - angles[0]), len(angles)
        values = {
            "body": group.members[k],
            "first": first,
            "count": count,
            "x": x,
            "y": y,
            "heading": heading,
            "range_min": getattr(options, "range_min", 0.0),
            "range_max": options.range_max,
            # Beams over a full turn may leave out the last one, which looks like the first: half a beam's spacing of
            # tolerance.
            "surrounds": span > 2.0 * np.pi * (1.0 - 1.5 / max(count, 2)),
        }
        if speed is not None:
            values |= {
                "coloured": speed.coloured,
                "full_speed": speed.full_speed,
                # Sizes of marks are areas in square points, as in matplotlib; half of the side is the radius.
                "mark": 0.5 * np.sqrt(speed.mark_size) * self._point,
                "mark_edge": speed.mark_edge_width * self._point,
                "rest": colour(speed.rest_colour, 1.0),
                "away": colour(speed.away_colour, 1.0),
                "nearer": colour(speed.nearer_colour, 1.0),
                "rim": colour(speed.mark_edge_colour, 1.0),
            }
        for name, value in values.items():
            beam[name] = value
        return beam


def ink_of(ink: Ink | None) -> Colour:
    """Return a colour of the vocabulary; None gives a transparent one."""
    return CLEAR if ink is None else shade(ink.colour, ink.brightness, ink.opacity)


def _goal(style: BodyStyle, tolerance: float, arrived: bool) -> list[Figure]:
    """Return the shapes of a goal at the origin with a tolerance [m] and a later goal."""
    view = GoalView(0.0, 0.0, 0.0, tolerance, np.zeros((1, 2)), arrived, "", style)
    return [primitive for primitive in vocabulary.goal(view) if isinstance(primitive, Figure)]


def _empty_view(style: BodyStyle) -> DrawnBody:
    """Return a body without an outline at the origin."""
    nothing, discs = np.zeros((0, 2)), np.zeros((0, 3))
    form, pose = Form((), discs, solid=True, mark=nothing), (0.0, 0.0, 0.0)
    return DrawnBody(-1, "", (), discs, True, nothing, (0.0, 0.0), style, form, pose)


def _table(rows: Sequence[Item]) -> Rows:
    """Return the records sorted by their keys."""
    table = np.zeros(len(rows), records.ITEM)
    for number, (_, item) in enumerate(sorted(rows, key=lambda row: row[0])):
        table[number] = item
    return table
