"""Demonstrations for imitation learning: the observations and actions of a driver, in one file.

The file is an ``.npz`` archive of NumPy with the arrays of ``Demonstrations``. Dict observations are stored as
``observations/NAME``. ``about`` is a JSON text that describes the environment.
"""

import io
import json
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium import Space
from gymnasium.spaces import Box, Dict, Discrete
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Flags, Floats, Ints
from irsim_gym.base.errors import IrsimGymError, UnreadableFileError
from irsim_gym.base.outside_files import json_text, npz_arrays, reading
from irsim_gym.evaluation.protocol.tables import plain, write_bytes
from irsim_gym.tasks.terms.outcome import Outcome

FORMAT = 1
OBSERVED = ("observations", "final_observations")

Array = NDArray[Any]
Observations = Array | dict[str, Array]


class DemonstrationError(IrsimGymError, ValueError):
    """Raised for files of demonstrations that cannot be used."""


@dataclass(frozen=True)
class Demonstrations:
    """The steps of whole episodes, one after the other, in the order of recording.

    Attributes:
        observations: Observation before each step, ``(n_steps, ...)``, or a dict of such arrays.
        actions: Action of each step, as the environment takes it: ``(n_steps, action_dim)`` in [-1, 1], or
            ``(n_steps,)`` choices.
        rewards: Reward of each step, ``(n_steps,)``.
        terminations: Whether the step terminated its episode, ``(n_steps,)``.
        truncations: Whether the step truncated its episode, by the time limit or because the driver stopped,
            ``(n_steps,)``.
        episode_starts: Whether the step is the first of an episode, ``(n_steps,)``.
        by_hand: Whether a person drove, ``(n_steps,)``; False for a behaviour.
        final_observations: Observation after the last step of each episode, ``(n_episodes, ...)``, or a dict of such
            arrays.
        levels: Level of each episode, ``(n_episodes,)``.
        outcomes: Outcome of each episode, ``(n_episodes,)``: numbers of ``irsim_gym.tasks.Outcome``, 0 if the driver
            stopped.
        about: Scenario, parameters, task, robot, split, step time [s] and spaces, as plain data.
    """

    observations: Observations
    actions: Array
    rewards: Floats
    terminations: Flags
    truncations: Flags
    episode_starts: Flags
    by_hand: Flags
    final_observations: Observations
    levels: Ints
    outcomes: Ints
    about: Mapping[str, object]

    def __len__(self) -> int:
        return len(self.actions)

    @property
    def n_episodes(self) -> int:
        """Number of episodes."""
        return len(self.levels)

    @property
    def ends(self) -> Flags:
        """Whether each step is the last of an episode, ``(n_steps,)``."""
        return np.asarray(self.terminations | self.truncations)

    @property
    def next_observations(self) -> Observations:
        """Observation after each step, in the same form and shape as ``observations``."""
        if isinstance(self.observations, dict):
            assert isinstance(self.final_observations, dict)
            return {key: self._shifted(rows, self.final_observations[key]) for key, rows in self.observations.items()}
        assert not isinstance(self.final_observations, dict)
        return self._shifted(self.observations, self.final_observations)

    def _shifted(self, rows: Array, final: Array) -> Array:
        following = np.roll(rows, -1, axis=0)
        following[np.flatnonzero(self.ends)] = final
        return following

    def transitions(self) -> dict[str, Any]:
        """Return the fields of ``imitation.data.types.Transitions``: obs, acts, infos, next_obs, dones."""
        return {
            "obs": self.observations,
            "acts": self.actions,
            "infos": np.array([{} for _ in range(len(self))], dtype=object),
            "next_obs": self.next_observations,
            "dones": self.ends,
        }


KINDS = {
    **dict.fromkeys(("terminations", "truncations", "episode_starts", "by_hand"), "b"),
    **dict.fromkeys(("levels", "outcomes"), "iu"),
}
"""Kinds of types of arrays that hold no numbers of any type."""
WORDS = {"b": "true or false", "iu": "whole numbers", "biuf": "numbers"}
CLOSE = 1e-5
"""Tolerance for rounding of actions."""
ARRAYS = tuple(field.name for field in fields(Demonstrations) if field.name not in (*OBSERVED, "about"))


def load_demonstrations(path: str | Path) -> Demonstrations:
    """Read demonstrations from a file that ``irsim-gym play --record`` or ``record_demonstrations`` wrote.

    Raises:
        FileNotFoundError: If the file does not exist.
        DemonstrationError: If the file is broken or of another kind.
        ValueError: The same error, which is one of both classes.
    """
    file = Path(path)
    file.stat()
    try:
        with reading(file, "file of demonstrations"):
            held = npz_arrays(file)
            about = json_text(str(held.pop("about")))
            if about["format"] != FORMAT:
                raise ValueError(f"format {about['format']}, this version reads {FORMAT}")
            arrays: dict[str, Any] = {name: held[name] for name in ARRAYS}
            return _checked(Demonstrations(**{name: _joined(name, held) for name in OBSERVED}, **arrays, about=about))
    except UnreadableFileError as error:
        hint = "irsim-gym play --record writes such files, and creates one that does not exist"
        raise DemonstrationError(f"{error}; {hint}") from None


def save_demonstrations(path: Path, data: Demonstrations) -> None:
    """Write demonstrations to a file. The file appears only when it is complete."""
    arrays = {name: getattr(data, name) for name in ARRAYS}
    for name in OBSERVED:
        seen = getattr(data, name)
        arrays |= {f"{name}/{key}": rows for key, rows in seen.items()} if isinstance(seen, dict) else {name: seen}
    content = io.BytesIO()
    np.savez_compressed(content, about=np.array(json.dumps(plain(dict(data.about)))), **arrays)
    write_bytes(path, content.getvalue())


def describe_space(space: Space[Any]) -> dict[str, Any]:
    """Return a space as plain data: kind, shape, dtype and bounds. Equal bounds are given as a single number."""
    if isinstance(space, Dict):
        return {"kind": "Dict", "spaces": {name: describe_space(part) for name, part in space.spaces.items()}}
    if isinstance(space, Discrete):
        return {"kind": "Discrete", "n": int(space.n)}
    if isinstance(space, Box):
        low, high = (_bound(bound) for bound in (space.low, space.high))
        return {"kind": "Box", "shape": list(space.shape), "dtype": str(space.dtype), "low": low, "high": high}
    return {"kind": type(space).__name__}


def _bound(bound: Array) -> Any:
    """Return bounds as a list of numbers, or as a single one if all are equal. Infinite bounds are text, for JSON."""
    values = [value if np.isfinite(value) else str(value) for value in bound.ravel().tolist()]
    return values[0] if len(set(values)) == 1 else values


def _checked(data: Demonstrations) -> Demonstrations:
    """Return demonstrations, after checking that they are those of whole episodes of one environment.

    Raises:
        ValueError: Types, lengths or values of their arrays do not fit each other, or the described spaces.
    """
    for name in ARRAYS:
        rows, kinds = getattr(data, name), KINDS.get(name, "biuf")
        if rows.dtype.kind not in kinds or rows.ndim != 1 + (name == "actions" and rows.ndim > 1):
            raise ValueError(f"its {name} must be {WORDS[kinds]}, one for each row, got {rows.dtype} {rows.shape}")
    about: Mapping[str, Any] = data.about
    _check_rows("actions", data.actions, about["action_space"])
    for name in OBSERVED:
        seen, space = getattr(data, name), about["observation_space"]
        parts = seen if isinstance(seen, dict) else {"": seen}
        spaces = space["spaces"] if isinstance(seen, dict) else {"": space}
        for key, described in spaces.items():
            _check_rows(f"{name}/{key}".rstrip("/"), parts[key], described)
    for name in (*OBSERVED, *ARRAYS):
        value, of_episodes = getattr(data, name), name in ("final_observations", "levels", "outcomes")
        length = int(data.ends.sum()) if of_episodes else len(data.rewards)
        for rows in value.values() if isinstance(value, dict) else (value,):
            if len(rows) != length:
                raise ValueError(f"its {name} are {len(rows)}, not {length}")
    if len(data) and not (data.ends[-1] and (data.episode_starts == np.roll(data.ends, 1)).all()):
        raise ValueError("its episodes must start at the first step and after each end, and the last step be an end")
    if not ((data.levels >= 0) & np.isin(data.outcomes, list(Outcome))).all() or not np.isfinite(data.rewards).all():
        raise ValueError(f"its levels must be >= 0, its outcomes 0 to {max(Outcome)}, and its rewards finite")
    return data


def _check_rows(name: str, rows: Array, space: Mapping[str, Any]) -> None:
    """Check that rows lie in a space as ``describe_space`` describes it; numbers only, if it is of another kind.

    Raises:
        ValueError: They do not.
    """
    shape = () if space["kind"] == "Discrete" else tuple(space.get("shape", rows.shape[1:]))
    if rows.dtype.kind not in "biuf" or not rows.ndim or rows.shape[1:] != shape or np.isnan(rows).any():
        raise ValueError(f"its {name} must be numbers, each row of shape {shape}, got {rows.dtype} {rows.shape}")
    if name == "actions" and space["kind"] in ("Box", "Discrete"):
        ends = (0, space["n"] - 1) if "n" in space else (space["low"], space["high"])
        low, high = (np.reshape(np.array(end, np.float64), shape if np.size(end) > 1 else ()) for end in ends)
        if not ((rows >= low - CLOSE) & (rows <= high + CLOSE)).all():
            raise ValueError(f"its actions must lie within {ends[0]} and {ends[1]}")


def _joined(name: str, held: Mapping[str, Array]) -> Any:
    """Return the array of a name, or a dict of the arrays named ``name/...``."""
    if name in held:
        return held[name]
    parts = {key.removeprefix(f"{name}/"): rows for key, rows in held.items() if key.startswith(f"{name}/")}
    if not parts:
        raise ValueError(f"it has no {name}")
    return parts
