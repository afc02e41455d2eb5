"""What frames show, and in which order: the styles of a scenario as records, made once."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from irsim_gym.arraytypes import Flags, Floats
from irsim_gym.raster import records
from irsim_gym.raster.areas import paint_disc, paint_line, paint_polygon
from irsim_gym.render import theme
from irsim_gym.render.colours import CLEAR, Colour, colour, shade
from irsim_gym.render.letters import Masks
from irsim_gym.render.styles import GROUND, TOP, BodyStyle, ScanStyle, body_style, field_of_view, is_omni, scan_style
from irsim_gym.world.group import Group
from irsim_gym.world.model import ACKERMANN, WorldModel

if TYPE_CHECKING:
    from irsim_gym.scenario.spec import Scenario

LINE_STYLES = {"solid": 0, "dashed": 1, "dashdot": 2, "dotted": 3}
FORMS = {"circle": records.CIRCLE, "rectangle": records.RECTANGLE, "linestring": records.CURVE}
WHITE = np.array([255.0, 1.0])
RAISED, FOGS, GHOSTS, SCANS, FIELDS, GOALS, PATHS, MOVING, HEADINGS, HITS, IMPACTS, LABELS = range(12)
"""What covers what within a layer."""

Key = tuple[float, int, int, float]


class Plan:
    """The records of one simulation.

    Attributes:
        ground: What never moves and has nothing below it.
        live: What is drawn anew for each picture.
        layers: The layers of these, ascending.
        covered: The highest layer of what is on the ground; marks from there on lie over it.
        scans: The sensors.
        groups: Their groups, in the order of their readings.
        angles: Directions of all beams [rad].
        has_speeds: Some sensor measures radial velocities.
        flagged: Which bodies' goals are shown.
    """

    def __init__(
        self,
        scenario: Scenario,
        model: WorldModel,
        sensors: Sequence[Group],
        learners: Collection[int],
        followed: Sequence[int],
        images: dict[int, int],
        masks: Masks,
        point: float,
        *,
        fog: bool,
        lowest: float = TOP,
    ) -> None:
        self._model, self._masks, self._point, self._images = model, masks, point, images
        self._bodies = scenario.bodies
        self._styles = [body_style(body, learner=b in learners) for b, body in enumerate(scenario.bodies)]
        self.groups = [group for group in sensors if {"ranges", "angles"} <= group.arrays.keys()]
        self.has_speeds = any("radial_velocity" in group.arrays for group in self.groups)
        self.angles: Floats = np.zeros(0)
        self.scans: Any = np.zeros(0, records.BEAMS)
        self.flagged: Flags = np.array([style.show_goal for style in self._styles], np.bool_)
        live = [*self._scan_items(), *self._body_items(), *self._goal_items(), *self._past_items(followed)]
        if fog:
            live.append(((GROUND, FOGS, 0, 0.0), self._item(records.FOG, colours=[colour(theme.FOG, 1.0)])))
        floor = min([lowest, *(key[0] for key, _ in live)])
        fixed = [b for b in self._ordered() if not model.movable[b]]
        live += [row for b in fixed if self._styles[b].order > floor for row in self._fixed_items(b)]
        self.live, self.layers = _table(live), np.array(sorted(key[0] for key, _ in live))
        self.covered = max((self._styles[b].order for b in fixed if self._styles[b].order <= floor), default=-np.inf)
        self.ground = _table(
            [
                ((0.0, *key[1:]), item)
                for b in fixed
                if self._styles[b].order <= floor
                for key, item in self._fixed_items(b)
            ]
        )

    def _ordered(self) -> list[int]:
        return sorted(range(len(self._styles)), key=lambda body: self._styles[body].order)

    def _item(self, kind: int, body: int = -1, *, colours: Sequence[Colour] = (), **fields: Any) -> Any:
        """Return a record; widths are points here and pixels there."""
        item = np.zeros(1, records.ITEM)
        item["every"], item["box"] = 1, records.WORLD
        item["kind"], item["body"] = kind, body
        item["colours"][0, : len(colours)] = list(colours) if colours else 0.0
        for name, value in fields.items():
            item[name] = value * self._point if name in ("width", "other_width") and value is not None else value
        return item[0]

    def _footprint(self, kind: int, body: int, style: BodyStyle, **fields: Any) -> Any:
        fill = colour(style.colour, style.alpha)
        if style.edge_colour is not None:
            edge = line = colour(style.edge_colour, style.alpha)
        else:
            edge, line = shade(style.colour, 0.68, style.alpha), fill
        return self._item(
            kind,
            body,
            colours=[fill, edge, line],
            width=style.line_width,
            other_width=style.wall_width,
            style=LINE_STYLES[style.line_style],
            filled=style.filled,
            **fields,
        )

    def _fixed_items(self, body: int) -> Iterator[tuple[Key, Any]]:
        """Yield what a body that never moves looks like, with its shadow."""
        style = self._styles[body]
        look: dict[str, Any] = {"box": records.WALLS, "snapped": True}
        if body in self._images:
            yield (style.order, RAISED, 3, 0.0), self._item(records.IMAGE, body, row=self._images[body], **look)
            return
        for number, (pixels, alpha) in enumerate(theme.SHADOWS if style.filled else ()):
            colours = [colour(theme.SHADOW, alpha), colour(theme.SHADOW, 0.4 * alpha)]
            shift = pixels * self._point
            item = self._item(records.SHADOW, body, colours=colours, width=1.5, x=shift, y=shift, **look)
            yield (style.order, RAISED, number, 0.0), item
        yield (style.order, RAISED, 2, 0.0), self._footprint(records.FOOTPRINT, body, style, **look)

    def _body_items(self) -> Iterator[tuple[Key, Any]]:
        """Yield footprints of what moves, and of all bodies headings, impacts, fields of view and labels."""
        model, order = self._model, self._ordered()
        for body in order:
            style, wall = self._styles[body], records.WALLS
            if model.movable[body] and body in self._images:
                item = self._item(records.IMAGE, body, row=self._images[body], box=wall)
                yield (style.order, MOVING, 1, 0.0), item
            elif model.movable[body]:
                yield (style.order, MOVING, 0, 0.0), self._footprint(records.FOOTPRINT, body, style, box=wall)
            if style.show_arrow:
                layer = style.order if style.arrow_order is None else style.arrow_order
                yield (layer, HEADINGS, 0, float(model.movable[body])), self._heading(body, style)
            red = [CLEAR, colour(theme.IMPACT, 1.0), colour(theme.IMPACT, 0.25)]
            item = self._item(records.IMPACT, body, colours=red, width=1.8, other_width=5.0, box=wall)
            yield (TOP, IMPACTS, 0, float(model.movable[body])), item
            field = field_of_view(self._bodies[body]) if style.show_field else None
            if field is not None:
                colours = [colour(name, style.field_alpha) for name in (style.field_colour, style.field_edge_colour)]
                item = self._item(records.FIELD, body, colours=colours, width=0.9, x=field[0], y=field[1])
                yield (style.field_order, FIELDS, 0, float(body)), item
            yield from self._label(body, style)

    def _heading(self, body: int, style: BodyStyle) -> Any:
        is_car = self._model.drive[body] == ACKERMANN and body not in self._images
        form = records.ARROW if style.arrow is not None else records.WINDSCREEN if is_car else records.WEDGE
        length, width = style.arrow or (0.0, 0.0)
        return self._item(
            records.HEADING,
            body,
            colours=[colour(style.arrow_colour, style.arrow_alpha)],
            form=form,
            x=length,
            y=width,
            box=records.WALLS,
            turns=is_omni(self._bodies[body]),
        )

    def _label(self, body: int, style: BodyStyle) -> Iterator[tuple[Key, Any]]:
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
            yield (style.label_order, LABELS, kind, float(self._model.movable[body])), item

    def _goal_items(self) -> Iterator[tuple[Key, Any]]:
        shown = [body for body, style in enumerate(self._styles) if style.show_goal]
        if not shown:
            return
        point = self._point
        dot = _dot(self._masks, 2.25 * point)
        flag = _flag(self._masks, point)
        for body in shown:
            style = self._styles[body]
            shares = theme.GOAL_FILL, 0.9, theme.REACHED_FILL
            look = [colour(style.goal_colour, share * style.goal_alpha) for share in shares]
            arrow = dict(
                zip(
                    ("x", "other_width", "half", "foot"),
                    theme.GOAL_ARROW * np.array([point, 1.0, point, point]),
                    strict=True,
                )
            )
            look_of_circle = {"width": 1.1, "box": records.PLOT, "filled_radius": theme.FILLED_RADIUS * point}
            item = self._item(records.GOAL_CIRCLE, body, colours=look, **look_of_circle, **arrow)
            yield (style.goal_order, GOALS, 0, float(body)), item
            look = [CLEAR, *(colour(style.goal_colour, share * style.goal_alpha) for share in (1.0, 0.45))]
            item = self._item(records.GOAL_MARKS, body, colours=look, row=flag, every=dot, box=records.PLOT)
            yield (style.goal_order, GOALS, 1, float(body)), item

    def _past_items(self, followed: Sequence[int]) -> Iterator[tuple[Key, Any]]:
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
                yield (style.trajectory_order, PATHS, 0, float(row)), item
            if ghost is not None:
                fields: dict[str, Any] = {"row": row, "every": style.ghost_every, "length": style.ghost_length}
                fields["form"] = FORMS.get(style.ghost_shape or "", records.OWN)
                yield (ghost.order, GHOSTS, 0, float(row)), self._footprint(records.GHOSTS, body, ghost, **fields)

    def _scan_items(self) -> Iterator[tuple[Key, Any]]:
        beams, angles = list[Any](), list[Floats]()
        first, dot = 0, _dot(self._masks, 1.3 * self._point)
        for group in self.groups:
            for k, body in enumerate(group.members.tolist()):
                style = scan_style(group.options[k])
                beam = self._beams(group, k, style, first)
                angles.append(np.asarray(group.arrays["angles"], np.float64))
                first += len(angles[-1])
                if self._styles[body].show_sensor:
                    yield (GROUND, SCANS, 0, float(len(beams))), self._scan(body, len(beams), style)
                    look = [colour(style.colour, min(3.0 * style.alpha, 1.0))]
                    item = self._item(records.HITS, body, colours=look, row=len(beams), every=dot, box=records.MARKS)
                    yield (TOP, HITS, 0, float(len(beams))), item
                beams.append(beam)
        if beams:
            self.scans, self.angles = np.concatenate(beams), np.concatenate(angles)

    def _scan(self, body: int, row: int, style: ScanStyle) -> Any:
        speed = style.velocity
        if speed is None or not speed.coloured:
            look = [colour(style.colour, min(share * style.alpha, 1.0)) for share in (0.22, 0.9)]
            return self._item(records.SCAN, body, row=row, colours=look, width=0.45)
        look = [colour(speed.free_colour, speed.free_alpha), colour(speed.rest_colour, style.alpha)]
        return self._item(records.SCAN, body, row=row, colours=look, width=speed.width, other_width=speed.free_width)

    def _beams(self, group: Group, k: int, style: ScanStyle, first: int) -> Any:
        options, angles, speed = group.options[k], group.arrays["angles"], style.velocity
        beam = np.zeros(1, records.BEAMS)
        x, y, heading = getattr(options, "offset", None) or (0.0, 0.0, 0.0)
        span, count = float(angles[-1] - angles[0]), len(angles)
        known = {
            "body": group.members[k],
            "first": first,
            "count": count,
            "x": x,
            "y": y,
            "heading": heading,
            "range_min": getattr(options, "range_min", 0.0),
            "range_max": options.range_max,
            "surrounds": span > 2.0 * np.pi * (1.0 - 1.5 / max(count, 2)),
        }
        if speed is not None:
            known |= {
                "coloured": speed.coloured,
                "full_speed": speed.full_speed,
                "mark": 0.5 * np.sqrt(speed.mark_size) * self._point,
                "mark_edge": speed.mark_edge_width * self._point,
                "rest": colour(speed.rest_colour, 1.0),
                "away": colour(speed.away_colour, 1.0),
                "nearer": colour(speed.nearer_colour, 1.0),
                "rim": colour(speed.mark_edge_colour, 1.0),
            }
        for name, value in known.items():
            beam[name] = value
        return beam


def _table(rows: Sequence[tuple[Key, Any]]) -> Any:
    """Return records in the order of their keys."""
    table = np.zeros(len(rows), records.ITEM)
    for number, (_, item) in enumerate(sorted(rows, key=lambda row: row[0])):
        table[number] = item
    return table


def _dot(masks: Masks, radius: float) -> int:
    """Return the mask of a dot in the middle of a pixel."""
    return masks.drawn(
        radius + 0.5,
        lambda picture, sheet, box, corner: paint_disc(picture, sheet, box, corner + 0.5, corner + 0.5, radius, WHITE),
    )


def _flag(masks: Masks, point: float) -> int:
    """Return the mask of a flag's pole; that of its pennant comes next."""
    pole, pennant = (np.array(part) * [point, -point] for part in (theme.FLAG_POLE, theme.FLAG_PENNANT))
    number = masks.drawn(
        10.0 * point,
        lambda picture, sheet, box, middle: paint_line(
            picture, sheet, box, pole + middle, 0, 2, 1.3 * point, False, False, WHITE
        ),
    )
    masks.drawn(
        10.0 * point,
        lambda picture, sheet, box, middle: paint_polygon(picture, sheet, box, pennant + middle, 0, 3, False, WHITE),
    )
    return number
