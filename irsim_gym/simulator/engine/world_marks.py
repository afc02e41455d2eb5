"""What pictures show over a world: where robots believe to be, are blind, see others move, and what they feel."""

from collections.abc import Iterator, Sequence

import numpy as np

from irsim_gym.simulator.pushing.memory import Pushing
from irsim_gym.simulator.readings.marks import LineMark, Mark, PointsMark, TextMark
from irsim_gym.simulator.step.disturbances import Disturbances
from irsim_gym.simulator.tracks.tracker import Tracker, is_mover
from irsim_gym.simulator.world.names import Group, Model, State
from irsim_gym.simulator.world.outline import corner_points, outline_rows, placed

BELIEVED, BLIND, TRACKED = "#7C3AED", "#64748B", "#DB2777"
"""Colours of believed outlines, of blind sectors and of tracks."""
RIM = np.exp(2j * np.pi * np.arange(24) / 24.0)
CONTACTS = 5.0
"""Layer of contacts."""


def marks_of(found: Disturbances, model: Model, state: State, w: int) -> tuple[LineMark, ...]:
    """Return marks over a world: dashed outlines at believed poses, shaded sectors where scanners are blind."""
    return (*_blind_sectors(found, model, state, w), *_believed(found, model, w))


def track_marks(trackers: Sequence[Tracker], model: Model, state: State, w: int) -> Iterator[Mark]:
    """Yield a circle for each track that moves, dotted while it is not seen, an arrow to where it is in 1 s, and a key.

    Only tracks are shown that somebody has followed in this step or the one before.
    """
    for tracker in trackers:
        for a in np.flatnonzero((tracker.noted[w] >= 0) & (state.step[w] - tracker.noted[w] < 2)).tolist():
            for track in filter(is_mover, tracker.tracks[w, a]):
                place, move = track.x + 1j * track.y, track.vx + 1j * track.vy
                head = place + move * np.array([0.0, 1.0, 0.8 + 0.1j, 1.0, 0.8 - 0.1j])
                for line, closed in ((place + track.radius * RIM, True), (head, False)):
                    points, style = np.column_stack([line.real, line.imag]), "solid" if track.lost == 0.0 else "dotted"
                    yield LineMark(points, TRACKED, 1.0, 1.5, style, closed, "", CONTACTS)
    if trackers:
        x, y = (model.bounds[:2] + 0.02 * (model.bounds[2:] - model.bounds[:2])).tolist()
        yield TextMark(x, y, "seen to move, and where to in 1 s", TRACKED, 1.0, 7.0, "left", CONTACTS)


def contact_marks(sensors: Sequence[Group], pushing: Pushing | None, w: int) -> Iterator[Mark]:
    """Yield a point for each contact that a body's ``contact2d`` feels, and a line as long as its force."""
    felt = () if pushing is None else pushing.reports[w, : pushing.n_reports[w]]
    for group in (group for group in sensors if group.kind.reading == "contact"):
        for b, options in zip(group.members.tolist(), group.options, strict=True):
            color, alpha, width = (options.drawn(key) for key in ("color", "alpha", "linewidth"))
            for told in (told for told in felt if b in (told["a"], told["b"])):
                point, length = np.array([told["x"], told["y"]]), told["force"] * options.drawn("force_scale")
                end = point + length * np.array([told["nx"], told["ny"]]) * (1.0 if told["a"] == b else -1.0)
                yield PointsMark(point[None], color, alpha, options.drawn("marker_size"), (), 0.0, CONTACTS)
                yield LineMark(np.vstack([point, end]), color, alpha, width, "solid", False, "", CONTACTS)


def _believed(found: Disturbances, model: Model, w: int) -> Iterator[LineMark]:
    if found.belief is None:
        return
    told = found.belief.state
    for b in np.concatenate([group.members for group in found.belief.drives]).tolist():
        if model.present[w, b]:
            x, y, heading = told.pose[w, b].tolist()
            outline = placed(*outline_rows(model, told, w, b, local=True), (x, y, heading))
            yield LineMark(corner_points(*outline, heading, rounds=True), BELIEVED, 0.9, 1.2, "dashed", True, "", 4.0)


def _blind_sectors(found: Disturbances, model: Model, state: State, w: int) -> Iterator[LineMark]:
    for group in found.scans:
        for k, b in enumerate(group.members.tolist() if "blind" in group.arrays else ()):
            blind, s = group.arrays["blind"][w, k], group.scan.sensors[k]
            if model.present[w, b] and blind.any():
                # From a beam that sees on, the blind ones follow each other.
                order = np.roll(np.arange(len(blind)), -int(blind.argmin()))
                x, y, heading = state.pose[w, b].tolist()
                cosine, sine, (ahead, aside) = np.cos(heading), np.sin(heading), group.scan.offset[s, :2]
                angles = heading + group.scan.angles[s, order[blind[order]]]
                rim = group.scan.range_max[s] * np.column_stack([np.cos(angles), np.sin(angles)])
                eye = np.array([x + cosine * ahead - sine * aside, y + sine * ahead + cosine * aside])
                yield LineMark(eye + np.vstack([np.zeros(2), rim]), BLIND, 0.25, 0.0, "solid", True, BLIND, 2.0)
