"""What pictures show of disturbances: where robots believe to be, and where their scanners are blind."""

from collections.abc import Iterator

import numpy as np

from irsim_gym.simulator.readings.marks import LineMark
from irsim_gym.simulator.step.disturbances import Disturbances
from irsim_gym.simulator.world.model import Model
from irsim_gym.simulator.world.outline import corner_points, outline_rows, placed
from irsim_gym.simulator.world.state import State

BELIEVED, BLIND = "#7C3AED", "#64748B"
"""Colours of believed outlines and of blind sectors."""


def marks_of(found: Disturbances, model: Model, state: State, w: int) -> tuple[LineMark, ...]:
    """Return marks over a world: dashed outlines at believed poses, shaded sectors where scanners are blind."""
    return (*_blind_sectors(found, model, state, w), *_believed(found, model, w))


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
