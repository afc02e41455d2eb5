"""Policies on the shelf: small files of numbers that drive without PyTorch and run no code as they are loaded.

A policy is two files: ``NAME.npz`` with arrays and a description of the network, and ``NAME.json``, its card.
"""

import hashlib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium import Space
from gymnasium.spaces import Box, Dict, Discrete
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Floats
from irsim_gym.base.errors import IrsimGymError, UnknownNameError, UnreadableFileError, suggestion
from irsim_gym.base.outside_files import json_text, npz_arrays, reading
from irsim_gym.evaluation.byte_planes import from_planes, layout_of, to_planes
from irsim_gym.evaluation.saved_policies.array_network import Options, apply_steps, check_steps, gru_cell
from irsim_gym.evaluation.saved_policies.cards import PolicyCard, card_file, read_card

PACKAGE = Path(__file__).parents[2]
SUFFIX = ".npz"
FORMAT = 3
READ = (1, 2, FORMAT)
"""Formats 1 and 2 (with memory) have each array under its own name, format 3 all of them as ``layout`` and planes."""
LONE = ""
"""Name of an observation that is no dict."""
OUTPUTS = ("clip", "squash", "argmax")
"""How an action is made of what the network returns: cut off, by the hyperbolic tangent, the greatest's number."""

Observation = NDArray[Any] | Mapping[str, NDArray[Any]]


class ShelfPolicy:
    """A trained policy in NumPy, which always takes its mean or most probable action.

    Args:
        form: The description of its network.
        arrays: Its arrays by name: weights, of the shapes of PyTorch, and bounds of spaces.
        card: What is known of it; None without a card.

    Attributes:
        observation_space: The observations that it was trained with.
        action_space: Its actions.
        perception: The observations with their options, and the action, in the words of a task; None where the file
            does not say.
        card: What is known of it; None without a card.
        parts: The steps that each part of an observation goes through first, by its name.
        part_arrays: Their arrays.
        trunk: The steps after them, from all parts side by side to the action.
        trunk_arrays: Their arrays.
        memory: The arrays of a GRU before the trunk; None for a policy without memory.
        output: How an action is made of the last numbers, one of ``OUTPUTS``.

    Raises:
        IrsimGymError: The network has a step, or makes actions in a way, that is not known here.
    """

    def __init__(
        self, form: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]], card: PolicyCard | None = None
    ) -> None:
        self.card = card
        self.perception: Mapping[str, Any] | None = form.get("perception")
        self.observation_space = _observation_space(form["observation"], arrays)
        acts = form["action"]
        self.action_space = Discrete(acts["n"]) if "n" in acts else _box("action", acts["dtype"], arrays)
        self.output: str = form["output"]
        self.parts: dict[str, Sequence[Options]] = form["parts"]
        self.trunk: Sequence[Options] = form["trunk"]
        for steps in (*self.parts.values(), self.trunk):
            check_steps(steps)
        if self.output not in OUTPUTS:
            raise IrsimGymError(f"output must be one of {', '.join(OUTPUTS)}, got '{self.output}'")
        self.part_arrays = {name: _arrays_of(f"part/{name}", steps, arrays) for name, steps in self.parts.items()}
        self.trunk_arrays = _arrays_of("trunk", self.trunk, arrays)
        self.memory = _arrays_of("memory", [form["memory"]], arrays)[0] if "memory" in form else None

    def predict(
        self,
        observation: Observation,
        state: tuple[NDArray[Any], ...] | None = None,
        episode_start: NDArray[Any] | None = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[Any], tuple[NDArray[Any], ...] | None]:
        """Return the action for one observation, or those for several, and ``state``, as Stable-Baselines3 does.

        Actions are of the shape of ``action_space``, or ``(n, ...)`` for several observations.

        Args:
            observation: As the environment gives it, or several, shape ``(n, ...)``.
            state: What the last call returned, a policy with memory needs it, shape ``(1, n, size)``; None at the
                beginning.
            episode_start: Where an episode begins, so that nothing is remembered, shape ``(n,)``; None for nowhere.
            deterministic: Only True: nothing is drawn.

        Raises:
            ValueError: ``deterministic`` is False, or the observation or the state is of another shape.
        """
        if not deterministic:
            raise ValueError("policies on the shelf do not draw their actions: pass deterministic=True")
        shown = _parts(observation, self.observation_space)
        batches = {name: _batch(shown[name], space) for name, space in spaces_of(self.observation_space).items()}
        rows = {name: rows for name, (rows, _) in batches.items()}
        parts = [apply_steps(steps, self.part_arrays[name], rows[name]) for name, steps in self.parts.items()]
        seen = np.concatenate(parts, axis=1)
        if self.memory is not None:
            memory = gru_cell(seen, self._before(len(seen), state, episode_start), self.memory)
            seen, state = np.concatenate([seen, memory], axis=1), (memory[None],)
        actions = self._actions(seen)
        return (actions if all(several for _, several in batches.values()) else actions[0]), state

    @property
    def memory_shape(self) -> tuple[int, int, int] | None:
        """Arrays of its state, layers and numbers of each; None for a policy without memory."""
        return None if self.memory is None else (1, 1, self.memory["weight_hh"].shape[1])

    def _before(
        self, n: int, state: tuple[NDArray[Any], ...] | None, episode_start: NDArray[Any] | None
    ) -> NDArray[Any]:
        """Return what was remembered before a step, ``(n, size)``.

        Raises:
            ValueError: The state is that of another number of observations, or of another policy.
        """
        assert self.memory_shape is not None
        shape = (1, n, self.memory_shape[2])
        shapes = [shape] if state is None else [np.shape(part) for part in state]
        if shapes != [shape]:
            raise ValueError(f"for {n} observations, state must hold one array of shape {shape}, got {_listed(shapes)}")
        memory = np.zeros(shape[1:]) if state is None else np.array(state[0][0], np.float64)
        if episode_start is not None:
            memory[np.broadcast_to(episode_start, (n,)).astype(bool)] = 0.0
        return memory

    def _actions(self, seen: NDArray[Any]) -> NDArray[Any]:
        outputs: NDArray[Any] = apply_steps(self.trunk, self.trunk_arrays, seen)
        space = self.action_space
        width = int(space.n if isinstance(space, Discrete) else np.prod(space.shape))
        if outputs.shape[1:] != (width,):
            raise ValueError(f"the network returns {outputs.shape[1:]} numbers for an action of {width}")
        if isinstance(space, Discrete):
            return np.asarray(outputs.argmax(axis=1))
        low, high = space.low.astype(np.float64), space.high.astype(np.float64)
        if self.output == "squash":
            outputs = low + 0.5 * (np.tanh(outputs) + 1.0) * (high - low)
        return np.asarray(np.clip(outputs, low, high), np.float32).reshape(-1, *low.shape)


def shelf_folder() -> Path:
    """Return the folder of the shipped policies: inside an installed package, else ``agents/shelf`` of a checkout."""
    inside = PACKAGE / "shelf"
    return inside if inside.is_dir() else PACKAGE.parent / "agents" / "shelf"


def shelf_files() -> dict[str, Path]:
    """Return the files of the shipped policies by name, in alphabetical order."""
    return {file.stem: file for file in sorted(shelf_folder().glob(f"*{SUFFIX}"))}


def shelf_file(name: str) -> Path:
    """Return the file of a shipped policy.

    Raises:
        UnknownNameError: There is none of that name.
    """
    files = shelf_files()
    if name not in files:
        near = suggestion(name, files)
        raise UnknownNameError(f"no policy named '{name}' on the shelf{near}; there are {', '.join(files) or 'none'}")
    return files[name]


def card_of(source: str | Path) -> PolicyCard | None:
    """Return the card of a name on the shelf or of an exported file; None for everything else.

    Raises:
        IrsimGymError: The card cannot be read.
    """
    file = shelf_files().get(source, Path(source)) if isinstance(source, str) else source
    return read_card(file) if file.suffix == SUFFIX and file.is_file() else None


def read_policy(file: Path) -> ShelfPolicy:
    """Return the policy in a file. No code of the file runs: it is numbers, and text that is read as JSON.

    Raises:
        IrsimGymError: It is no policy of the shelf, or its card belongs to another file.
    """
    with reading(file, "policy of the shelf"):
        arrays = npz_arrays(file)
        card = _checked_card(file)
        form = json_text(arrays.pop("form").item())
        if form["format"] not in READ:
            raise ValueError(f"its format is {form['format']}, and this version of irsim_gym reads 1 to {FORMAT}")
        if "layout" in form:
            arrays = from_planes(form["layout"], arrays["planes"])
        policy = ShelfPolicy(form, arrays, card)
        _check_action(policy)
    return policy


def _checked_card(file: Path) -> PolicyCard | None:
    """Return the card of a policy; None without one.

    Raises:
        IrsimGymError: It cannot be read, or it is the card of another file.
    """
    card = read_card(file)
    if card is not None and card.sha256 and card.sha256 != hashlib.sha256(file.read_bytes()).hexdigest():
        reason = "its sha256 is that of another file; export the policy again, or remove the card"
        raise UnreadableFileError(str(card_file(file)), f"card of {file}", reason)
    return card


def _check_action(policy: ShelfPolicy) -> None:
    """Check that a policy acts upon zeros, which needs each array in its shape.

    Raises:
        Exception: An array is missing or of another shape; of any class, as NumPy raises it.
    """
    zeros = {name: np.zeros(part.shape or (), part.dtype) for name, part in spaces_of(policy.observation_space).items()}
    policy.predict(zeros if isinstance(policy.observation_space, Dict) else zeros[LONE])


def policy_arrays(form: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Return what the file of a policy holds, by name; see ``ShelfPolicy`` for the arguments."""
    described = {**form, "format": FORMAT, "layout": layout_of(arrays)}
    return {"planes": to_planes(arrays), "form": np.array(json.dumps(described).encode())}


def _arrays_of(place: str, steps: Sequence[Options], arrays: Mapping[str, NDArray[Any]]) -> list[dict[str, Floats]]:
    """Return the arrays of each step: their names begin with the place of the step."""
    layers: list[dict[str, Floats]] = []
    for i in range(len(steps)):
        head = f"{place}/{i}/"
        layer = {name.removeprefix(head): array for name, array in arrays.items() if name.startswith(head)}
        layers.append({name: array.astype(np.float64) for name, array in layer.items()})
    return layers


def _observation_space(form: Mapping[str, str], arrays: Mapping[str, NDArray[Any]]) -> Space[Any]:
    spaces: dict[str, Space[Any]] = {name: _box(f"observation/{name}", dtype, arrays) for name, dtype in form.items()}
    return spaces[LONE] if list(spaces) == [LONE] else Dict(spaces)


def _box(place: str, dtype: str, arrays: Mapping[str, NDArray[Any]]) -> Box:
    kind: Any = np.dtype(dtype).type
    return Box(arrays[f"{place}/low"], arrays[f"{place}/high"], dtype=kind)


def spaces_of(space: Space[Any]) -> Mapping[str, Any]:
    """Return the spaces of the parts of an observation by name."""
    return space.spaces if isinstance(space, Dict) else {LONE: space}


def _parts(observation: Observation, space: Space[Any]) -> Mapping[str, NDArray[Any]]:
    """Return the parts of an observation by name.

    Raises:
        ValueError: It is a dict where the policy needs an array, or the other way round, or a part is missing.
    """
    if isinstance(observation, Mapping) != isinstance(space, Dict):
        kind = "a dict" if isinstance(observation, Mapping) else "an array"
        raise ValueError(f"the policy was trained with observations of {_shapes(space)}, got {kind}")
    parts = observation if isinstance(observation, Mapping) else {LONE: observation}
    missing = [name for name in spaces_of(space) if name not in parts]
    if missing:
        raise ValueError(f"the observation has no {', '.join(missing)}; the policy was trained with {_shapes(space)}")
    return parts


def _shapes(space: Space[Any]) -> str:
    """Return the shape of an observation, or those of the parts of a dict, as text."""
    return ", ".join(f"{name} shape {part.shape}".lstrip() for name, part in spaces_of(space).items())


def _listed(shapes: Sequence[tuple[int, ...]]) -> str:
    return ", ".join(map(str, shapes)) or "none"


def _batch(observation: NDArray[Any], space: Space[Any]) -> tuple[NDArray[Any], bool]:
    """Return observations as rows, pictures with their channels first, and whether there were several.

    Raises:
        ValueError: They are of another shape.
    """
    rows, shape = np.asarray(observation), space.shape
    assert shape is not None
    for several in (False, True):
        batch = rows if several else rows[None]
        if batch.shape[1:] == shape:
            return batch, several
        if len(shape) == 3 and batch.ndim == 4 and batch.transpose(0, 3, 1, 2).shape[1:] == shape:
            return batch.transpose(0, 3, 1, 2), several
    raise ValueError(f"the policy was trained with observations of shape {shape}, got {rows.shape}")
