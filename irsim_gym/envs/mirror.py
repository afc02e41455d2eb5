"""Mirrored experience: observations and actions of a world whose left and right are exchanged."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from irsim_gym.arraytypes import Ints, Rays
from irsim_gym.contract import is_foreign
from irsim_gym.envs.spaces import VECTOR, Observation, ObservationLayout, critic_key, observation_layout
from irsim_gym.errors import IrsimGymError
from irsim_gym.tasks import Episodes
from irsim_gym.tasks.actions import DiscreteAction
from irsim_gym.tasks.mirrored import HasMirrored, Mirrored
from irsim_gym.tasks.term import IsImage, Term
from irsim_gym.tasks.term_contract import checked_mirrored
from irsim_gym.tasks.term_watch import kind_of
from irsim_gym.tasks.transition import CRITIC
from irsim_gym.world.kinds import KeepsSymmetry
from irsim_gym.world.model import OMNI_WORLD

OF_GOAL_FORM = ("position", "heading", "goal_position")
"""Observations in the frame of the world that ``observation_form: goal`` adds."""
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
        action: The sign of each component of a continuous action, shape ``(n_components,)``; empty for choices.
    """

    vectors: Mapping[str, Mirrored]
    images: Mapping[str, Ints]
    choices: Ints
    action: Rays

    def observation(self, given: Observation, *, channels_first: bool = False) -> Observation:
        """Return mirrored observations, of the same form as the given ones.

        Args:
            given: Observations, of shape ``(..., width)`` or ``(..., height, width, n_channels)``, or a dict of them.
            channels_first: Images have the shape ``(..., n_channels, height, width)``.
        """
        if isinstance(given, dict):
            return {key: self._part(key, part, channels_first) for key, part in given.items()}
        return self._part("", given, channels_first)

    def actions(self, given: NDArray[Any]) -> NDArray[Any]:
        """Return mirrored actions.

        Args:
            given: Actions in [-1, 1], of shape ``(..., n_components)``, or choices of any shape.

        Returns:
            Mirrored actions, of the shape of ``given``.
        """
        if self.choices.size:
            return self.choices[given.astype(np.int64)].astype(given.dtype)
        mirrored: NDArray[Any] = given * self.action
        return mirrored

    def _part(self, key: str, given: NDArray[Any], channels_first: bool) -> NDArray[Any]:
        if key in self.images:
            return given.take(self.images[key], axis=-1 if channels_first else -2)
        columns = self.vectors[key]
        mirrored: NDArray[Any] = given[..., columns.columns] * columns.signs
        return mirrored


def mirror_of(episodes: Episodes) -> Mirror:
    """Return the mirror of an environment.

    Raises:
        IrsimGymError: If left and right cannot be exchanged; the message lists every reason.
    """
    problems = [*_of_bodies(episodes), *_of_action(episodes), *_of_form(episodes)]
    named = {id(term): _mirrored(term, width) for term, width in _widths(episodes)}
    own = OF_GOAL_FORM if episodes.task.observation_form == "goal" else ()
    chosen = [found for (term, _), found in zip(_widths(episodes), named.values(), strict=True) if term.name not in own]
    problems += [found for found in chosen if isinstance(found, str)]
    if problems:
        raise IrsimGymError(f"left and right cannot be exchanged here: {'; '.join(problems)}")
    parts = {place: found for place, found in named.items() if isinstance(found, Mirrored)}
    action = episodes.terms["action"][0].options
    choices = _mirrored_choices(action) if isinstance(action, DiscreteAction) else np.zeros(0, np.int64)
    signs = np.ones(0, np.float32) if choices.size else _signs(int(episodes.action_sizes.max()))
    return Mirror(_vectors(episodes, parts), _images(episodes, parts), choices, signs)


def _widths(episodes: Episodes) -> Iterator[tuple[Term, int]]:
    """Yield all observations with their numbers of columns, or of columns of pixels."""
    for family, bounds in (
        ("observations", episodes.observation_terms),
        ("critic_observations", episodes.critic_terms),
    ):
        widths = {name: len(low) for name, low, _ in bounds}
        for term in episodes.terms[family]:
            is_image = isinstance(term.options, IsImage)
            yield term, term.options.image_shape[1] if is_image else widths[term.name]


def _mirrored(term: Term, width: int) -> Mirrored | str:
    """Return what becomes of an observation, or why it cannot be mirrored."""
    kind = kind_of(term)
    if not isinstance(term.options, HasMirrored):
        return f"the observation '{term.name}' does not say what it becomes (it has no method 'mirrored')"
    found = checked_mirrored(term, kind, width) if is_foreign(kind) else term.options.mirrored(term)
    return f"the observation '{term.name}' {found}" if isinstance(found, str) else found


def _vectors(episodes: Episodes, parts: Mapping[int, Mirrored]) -> dict[str, Mirrored]:
    """Return what becomes of the columns of each array, by key."""
    layout = observation_layout(episodes)
    found: dict[str, Mirrored] = {}
    numbers = [term for term in episodes.terms["observations"] if not isinstance(term.options, IsImage)]
    if numbers:
        flat = _side_by_side([parts[id(term)] for term in numbers])
        found |= {key: _chosen(flat, columns) for key, columns in _arrays(layout, flat.columns.size).items()}
    seen_by_critic = [term for term in episodes.terms["critic_observations"] if not isinstance(term.options, IsImage)]
    if seen_by_critic:
        found[CRITIC] = _side_by_side([parts[id(term)] for term in seen_by_critic])
    return found


def _arrays(layout: ObservationLayout, width: int) -> dict[str, Ints]:
    """Return the columns of the flat observation in each array that the layout makes of it, by key."""
    every = np.arange(width)
    if not layout.flat:
        return {key: every[columns] for key, columns in layout.columns.items()}
    is_alone = not layout.images and not layout.critic
    return {"" if is_alone else VECTOR: every if layout.picked is None else layout.picked}


def _images(episodes: Episodes, parts: Mapping[int, Mirrored]) -> dict[str, Ints]:
    """Return the columns of pixels of each image, by key."""
    own = [term for term in episodes.terms["observations"] if isinstance(term.options, IsImage)]
    others = [term for term in episodes.terms["critic_observations"] if isinstance(term.options, IsImage)]
    is_alone = observation_layout(episodes).flat and len(own) == 1
    is_alone &= not episodes.observation_terms and not episodes.view.critic
    keys = [("" if is_alone else term.name, term) for term in own]
    keys += [(critic_key(term.name, term.options), term) for term in others]
    return {key: parts[id(term)].columns for key, term in keys}


def _side_by_side(parts: list[Mirrored]) -> Mirrored:
    starts = np.cumsum([0, *(part.columns.size for part in parts)])
    columns = [part.columns + start for part, start in zip(parts, starts, strict=False)]
    return Mirrored(np.concatenate(columns), np.concatenate([part.signs for part in parts]))


def _chosen(flat: Mirrored, columns: Ints) -> Mirrored:
    """Return what becomes of some columns, which are exchanged among themselves."""
    places = np.full(flat.columns.size, -1)
    places[columns] = np.arange(columns.size)
    return Mirrored(places[flat.columns[columns]], flat.signs[columns])


def _signs(n_components: int) -> Rays:
    """Return the signs of a command's components: all but the speed ahead point or turn to one side."""
    return np.array([1.0, *[-1.0] * (n_components - 1)], np.float32)


def _mirrored_choices(action: DiscreteAction) -> Ints:
    """Return the mirrored choice of each choice."""
    grid = np.arange(action.n_choices).reshape(action.linear, action.lateral, action.angular)
    return grid[:, ::-1, ::-1].reshape(-1).copy()


def _of_form(episodes: Episodes) -> Iterator[str]:
    """Yield why the form of observations has no mirror."""
    if episodes.task.observation_form == "goal":
        yield "'observation_form: goal' gives positions in the frame of the world"


def _of_action(episodes: Episodes) -> Iterator[str]:
    """Yield why actions cannot be mirrored."""
    drives, agents = episodes.simulation.model.drive, np.array(episodes.task.agents)
    action = episodes.terms["action"][0]
    if is_foreign(kind_of(action)):
        yield f"the action '{action.name}' is a plugin's, and nothing says what it becomes"
    elif np.any(drives[agents] == OMNI_WORLD) and action.options.frame == "command":
        yield "actions are in the frame of the world ('frame: command')"
    for name, b in zip(episodes.agent_names, agents.tolist(), strict=True):
        if is_foreign(type(episodes.simulation.scenario.bodies[b].kinematics)):
            yield f"the drive of '{name}' is a plugin's, and nothing says what its commands become"
        elif not _has_even_limits(episodes, b):
            yield f"the speed limits of '{name}' to the left and to the right differ"


def _has_even_limits(episodes: Episodes, body: int) -> bool:
    """Return whether a body's limits to the left and to the right are equal in all levels."""
    model, traits = episodes.simulation.model, episodes.simulation.parts.traits
    size = len(episodes.simulation.scenario.bodies[body].kinematics.command_names)
    low, high = model.velocity_min[0, body, 1:size].copy(), model.velocity_max[0, body, 1:size].copy()
    for drawn in traits[(traits["body"] == body) & (traits["n_axes"] > 1) & ~np.isnan(traits["low"])]:
        # A level draws the greatest speed of both axes, and raises lower limits to its negative.
        low[0], high[0] = max(drawn["least"][1], -drawn["high"]), drawn["high"]
    return bool(np.allclose(low, -high, rtol=0.0, atol=CLOSE))


def _of_bodies(episodes: Episodes) -> Iterator[str]:
    """Yield what is not symmetrical about the learners' bodies and range sensors."""
    terms = [*episodes.terms["observations"], *episodes.terms["critic_observations"]]
    is_read = any(term.options.needs_scan for term in terms)
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
    found = episodes.simulation.scan(body)
    if found is None:
        return
    group, member = found
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
    lines = {frozenset([tuple(one[:2]), tuple(one[2:])]) for one in ends.tolist()}
    return lines, {tuple(one) for one in (np.round(discs, 9) + 0.0).tolist()}
