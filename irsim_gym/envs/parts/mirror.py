"""Mirrored experience: observations and actions of a world whose left and right are exchanged."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Ints
from irsim_gym.base.contract import is_foreign
from irsim_gym.base.errors import IrsimGymError
from irsim_gym.envs.parts.spaces import Observation, observed
from irsim_gym.simulator.world.kinds import KeepsSymmetry
from irsim_gym.simulator.world.model import OMNI_WORLD
from irsim_gym.tasks import Episodes
from irsim_gym.tasks.actions.discrete import DiscreteAction
from irsim_gym.tasks.plugin_checks.term_contract import checked_mirrored
from irsim_gym.tasks.terms.mirrored import HasMirrored, Mirrored, command_exchanged, signed
from irsim_gym.tasks.terms.term import IsImage, Term, needs_of

CLOSE = 1e-9
"""Largest difference of lengths [m], angles [rad] and limits that count as equal."""


@dataclass(frozen=True)
class Mirror:
    """Exchanges left and right in observations and actions of one environment.

    Attributes:
        vectors: What becomes of the columns of each array of the observation, by key; the key of a single array is
            empty.
        images: The column of pixels that each column of an image takes its pixels from, by key, shape ``(width,)``.
        choices: The mirrored choice of each choice, shape ``(n_choices,)``; empty for continuous actions.
        action: What becomes of the components of a continuous action; empty for choices.
    """

    vectors: Mapping[str, Mirrored]
    images: Mapping[str, Ints]
    choices: Ints
    action: Mirrored

    def observation(self, observed: Observation, *, channels_first: bool = False) -> Observation:
        """Return mirrored observations, of the same form and shape as the given ones.

        Args:
            observed: Observations, of shape ``(..., width)`` or ``(..., height, width, n_channels)``, or a dict of
                them.
            channels_first: Images have the shape ``(..., n_channels, height, width)``.
        """
        if isinstance(observed, dict):
            return {key: self._part(key, part, channels_first) for key, part in observed.items()}
        return self._part("", observed, channels_first)

    def actions(self, actions: NDArray[Any]) -> NDArray[Any]:
        """Return mirrored actions.

        Args:
            actions: Actions in [-1, 1], of shape ``(..., n_components)``, or choices of any shape.

        Returns:
            Mirrored actions, of the shape of ``actions``.
        """
        if self.choices.size:
            return self.choices[actions.astype(np.int64)].astype(actions.dtype)
        mirrored: NDArray[Any] = actions[..., self.action.columns] * self.action.signs
        return mirrored

    def _part(self, key: str, values: NDArray[Any], channels_first: bool) -> NDArray[Any]:
        if key in self.images:
            return values.take(self.images[key], axis=-1 if channels_first else -2)
        columns = self.vectors[key]
        mirrored: NDArray[Any] = values[..., columns.columns] * columns.signs
        return mirrored


def mirror_of(episodes: Episodes) -> Mirror:
    """Return the mirror of an environment.

    Raises:
        IrsimGymError: If left and right cannot be exchanged; the message lists every reason.
    """
    problems = [*_of_bodies(episodes), *_of_action(episodes)]
    parts: dict[str, list[Mirrored]] = {}
    images: dict[str, Ints] = {}
    for key, term in observed(episodes):
        mirrored = _mirrored(term)
        if isinstance(mirrored, Mirrored) and isinstance(term.options, IsImage):
            images[key] = mirrored.columns
        elif isinstance(mirrored, Mirrored):
            parts.setdefault(key, []).append(mirrored)
        else:
            problems.append(mirrored)
    if problems:
        raise IrsimGymError(f"left and right cannot be exchanged here: {'; '.join(problems)}")
    vectors = {key: _side_by_side(columns) for key, columns in parts.items()}
    action = episodes.terms["action"][0]
    command = command_exchanged(action)
    assert isinstance(command, Mirrored), "the reason is among the problems"
    if isinstance(action.options, DiscreteAction):
        return Mirror(vectors, images, _mirrored_choices(action, command), signed())
    return Mirror(vectors, images, np.zeros(0, np.int64), command)


def _mirrored(term: Term) -> Mirrored | str:
    """Return what becomes of an observation, or why it cannot be mirrored."""
    kind = type(term.options)
    if not isinstance(term.options, HasMirrored):
        return f"the observation '{term.name}' does not say what it becomes (it has no method 'mirrored')"
    width = term.options.image_shape[1] if isinstance(term.options, IsImage) else term.bounds[0].size
    mirrored = checked_mirrored(term, width) if is_foreign(kind) else term.options.mirrored(term)
    return f"the observation '{term.name}' {mirrored}" if isinstance(mirrored, str) else mirrored


def _side_by_side(parts: list[Mirrored]) -> Mirrored:
    starts = np.cumsum([0, *(part.columns.size for part in parts)])
    columns = [part.columns + start for part, start in zip(parts, starts, strict=False)]
    return Mirrored(np.concatenate(columns), np.concatenate([part.signs for part in parts]))


def _mirrored_choices(action: Term, command: Mirrored) -> Ints:
    """Return the mirrored choice of each choice, or an empty array if one has none among them."""
    grid = np.round(action.arrays["grid"][int(action.action_sizes.argmax())], 9) + 0.0
    number = {tuple(row): k for k, row in enumerate(grid.tolist())}
    rows = (grid[:, command.columns] * command.signs.astype(np.float64) + 0.0).tolist()
    mirrored = [number.get(tuple(row), -1) for row in rows]
    return np.array(mirrored if -1 not in mirrored else [], np.int64)


def _of_action(episodes: Episodes) -> Iterator[str]:
    """Yield why actions cannot be mirrored."""
    drives, agents = episodes.simulation.model.drive, np.array(episodes.task.agents)
    action = episodes.terms["action"][0]
    if is_foreign(type(action.options)):
        yield f"the action '{action.name}' is a plugin's, and nothing says what it becomes"
        return
    command = command_exchanged(action)
    if isinstance(command, str):
        yield f"the action '{action.name}' {command}"
        return
    if isinstance(action.options, DiscreteAction) and not _mirrored_choices(action, command).size:
        yield f"not all choices of the action '{action.name}' have their mirror image among them"
    if np.any(drives[agents] == OMNI_WORLD) and action.options.frame == "command":
        yield "actions are in the frame of the world ('frame: command')"
    for name, b in zip(episodes.agent_names, agents.tolist(), strict=True):
        if not _has_even_limits(episodes, b, command):
            yield f"the speed limits of '{name}' to the left and to the right differ"


def _has_even_limits(episodes: Episodes, body: int, command: Mirrored) -> bool:
    """Return whether a body's limits to the left and to the right are equal in all levels."""
    model, traits = episodes.simulation.model, episodes.simulation.parts.traits
    size = len(episodes.simulation.scenario.bodies[body].kinematics.command_names)
    low, high = model.velocity_min[0, body, :size].copy(), model.velocity_max[0, body, :size].copy()
    for drawn in traits[(traits["body"] == body) & (traits["n_axes"] > 1) & ~np.isnan(traits["low"])]:
        # A level draws the greatest speed of both axes, and raises lower limits to its negative.
        low[:2], high[:2] = np.maximum(drawn["least"][:2], -drawn["high"]), drawn["high"]
    columns, signs = command.columns[:size], command.signs[:size]
    exchanged = np.where(signs > 0, low[columns], -high[columns]), np.where(signs > 0, high[columns], -low[columns])
    return bool(np.allclose((low, high), exchanged, rtol=0.0, atol=CLOSE))


def _of_bodies(episodes: Episodes) -> Iterator[str]:
    """Yield what is not symmetrical about the learners' bodies and range sensors."""
    is_read = "scan" in needs_of(term.options for term in episodes.terms["observations"])
    for name, b in zip(episodes.agent_names, episodes.task.agents, strict=True):
        shape = episodes.simulation.scenario.bodies[b].shape
        outline = shape.outline()
        if shape.is_random and not isinstance(shape, KeepsSymmetry):
            yield f"the shape of '{name}' is drawn, and not symmetrical about its x axis"
        elif not _is_symmetrical(outline.segments, outline.discs):
            yield f"the shape of '{name}' is not symmetrical about its x axis"
        if is_read:
            yield from _of_sensor(episodes, name, b)


def _of_sensor(episodes: Episodes, name: str, body: int) -> Iterator[str]:
    """Yield why a body's range sensor has no mirror."""
    sensor = episodes.simulation.scan(body)
    if sensor is None:
        return
    group, member = sensor
    if is_foreign(group.kind):
        yield f"the range sensor of '{name}' is a plugin's, and nothing says what its beams become"
        return
    _, aside, turn = group.options[member].offset
    angles = group.arrays["angles"]
    is_level = abs(aside) <= CLOSE and abs(np.sin(turn)) <= CLOSE
    if not (is_level and np.allclose(angles, -angles[::-1], rtol=0.0, atol=CLOSE)):
        yield f"the range sensor of '{name}' is not symmetrical about the robot's x axis"


def _is_symmetrical(segments: NDArray[Any], discs: NDArray[Any]) -> bool:
    """Return whether an outline equals its image in the x axis."""
    flipped_segments, flipped_discs = segments * [1.0, -1.0, 1.0, -1.0], discs * [1.0, -1.0, 1.0]
    return _parts(segments, discs) == _parts(flipped_segments, flipped_discs)


def _parts(segments: NDArray[Any], discs: NDArray[Any]) -> tuple[set[Any], set[Any]]:
    """Return segments without direction, and discs, rounded to nanometres."""
    ends = np.round(segments, 9) + 0.0
    lines = {frozenset([tuple(end[:2]), tuple(end[2:])]) for end in ends.tolist()}
    return lines, {tuple(disc) for disc in (np.round(discs, 9) + 0.0).tolist()}
