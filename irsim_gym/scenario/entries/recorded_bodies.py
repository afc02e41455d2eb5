"""Sets up bodies that replay a recording: the file, person and start of each."""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.errors import suggestion
from irsim_gym.scenario.checking.validation import Report
from irsim_gym.scenario.entries.entries import BodyEntry
from irsim_gym.scenario.specs import library
from irsim_gym.scenario.specs.recordings import BadRecordingError, read_recording, sampled
from irsim_gym.scenario.specs.spec import BodySpec
from irsim_gym.scenario.text.messages import show
from irsim_gym.scenario.text.source import Place


def give_recordings(bodies: list[BodySpec], entry: BodyEntry, step_time: float, report: Report) -> list[BodySpec]:
    """Return the bodies of an entry, with file, person and start set for those that replay a recording.

    Without ``person``, they get one person each, in the order of the file.

    Args:
        bodies: The entry's bodies.
        step_time: Duration of a step [s].
    """
    given = []
    for i, body in enumerate(bodies):
        place = entry.of("behavior", i)[0]
        if not getattr(body.behavior, "replays", False):
            given.append(body)
        elif (made := _with_recording(body, i, len(bodies), step_time, place, report)) is not None:
            given.append(made)
        else:
            return []
    return given


def _with_recording(
    body: BodySpec, i: int, count: int, step_time: float, place: Place, report: Report
) -> BodySpec | None:
    """Return a body with its file, person and start; None after reporting problems."""
    options = body.behavior
    file, shipped = library.asset("recordings", options.file, report.source.file), library.assets("recordings")
    if not file.is_file():
        near = suggestion(options.file[:40], shipped)
        offer = near or f"; shipped: {', '.join(shipped)}; or name a file beside the scenario"
        report.add((*place, "file"), f"no recording {show(options.file)}{offer}")
        return None
    try:
        recording = read_recording(file)
    except BadRecordingError as error:
        report.add((*place, "file"), f"{file}: {error}")
        return None
    if options.person is not None and options.person not in recording.persons:
        known = ", ".join(map(str, recording.persons[:12]))
        report.add((*place, "person"), f"{file.name} has no person {options.person}; it has {known}")
        return None
    if i >= len(recording.persons) or (options.person is not None and count > 1):
        most = 1 if options.person is not None else len(recording.persons)
        report.add(place, f"the entry has {count} bodies, but there are {most} persons for them: number: {most}")
        return None
    person = recording.persons[i] if options.person is None else options.person
    known_options = replace(options, file=str(file), person=person)
    points = sampled(known_options, step_time)
    return _with_start(replace(body, behavior=known_options), points, step_time, place, report)


def _with_start(
    body: BodySpec, points: NDArray[np.float64], step_time: float, place: Place, report: Report
) -> BodySpec | None:
    """Return the body at its start; None after reporting that it is too slow for its person."""
    fastest = float(np.nanmax(np.abs(np.diff(points, axis=0)), initial=0.0)) / step_time if len(points) > 1 else 0.0
    most = min(*body.vel_max[:2], *(-speed for speed in body.vel_min[:2]))
    if fastest > most * (1.0 + 1e-9):
        needed = math.ceil(fastest * 100.0) / 100.0
        report.add(
            place,
            f"person {body.behavior.person} walks at up to {fastest:.3g} m/s, but vel_max and vel_min allow {most:g}: "
            f"give vel_min: [-{needed:g}, -{needed:g}] and vel_max: [{needed:g}, {needed:g}]",
        )
        return None
    seen = points[np.isfinite(points[:, 0])]
    x, y = (float(seen[0, 0]), float(seen[0, 1])) if len(seen) else (0.0, 0.0)
    return replace(body, state=(x, y, 0.0))
