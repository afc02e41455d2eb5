"""What pictures show over a world: where robots believe to be, where their scanners are blind, what they feel."""

from collections.abc import Iterator, Sequence

import numpy as np

from irsim_gym.simulator.pushing.memory import Pushing
from irsim_gym.simulator.readings.marks import LineMark, Mark, PointsMark
from irsim_gym.simulator.step.disturbances import Disturbances
from irsim_gym.simulator.world.names import Group, Model, State
from irsim_gym.simulator.world.outline import corner_points, outline_rows, placed

BELIEVED, BLIND = "#7C3AED", "#64748B"
"""Colours of believed outlines and of blind sectors."""
CONTACTS = 5.0
"""Layer of contacts."""


def marks_of(found: Disturbances, model: Model, state: State, w: int) -> tuple[LineMark, ...]:
    """Return marks over a world: dashed outlines at believed poses, shaded sectors where scanners are blind."""
    return (*_blind_sectors(found, model, state, w), *_believed(found, model, w))


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
