"""Demonstrations for imitation learning: the observations and actions of a driver, in one file.

The file is an ``.npz`` archive of NumPy with the arrays of ``Demonstrations``. Dict observations are stored as
``observations/NAME``. ``about`` is a JSON text that describes the environment.
"""

from __future__ import annotations

import io
import json
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium import Space
from gymnasium.spaces import Box, Dict, Discrete
from numpy.typing import NDArray

from irsim_gym.arraytypes import Flags, Floats, Ints
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.tables import plain, write_bytes

FORMAT = 1
OBSERVED = ("observations", "final_observations")

UNREADABLE = (OSError, ValueError, KeyError, TypeError, EOFError, RuntimeError, zipfile.BadZipFile, zlib.error)
"""Errors that NumPy and JSON raise for broken files and for files of another kind."""

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
        """Observation after each step, in the same form as ``observations``."""
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


ARRAYS = tuple(field.name for field in fields(Demonstrations) if field.name not in (*OBSERVED, "about"))


def load_demonstrations(path: str | Path) -> Demonstrations:
    """Read demonstrations from a file that ``irsim-gym play --record`` or ``record_demonstrations`` wrote.

    Raises:
        FileNotFoundError: If the file does not exist.
        DemonstrationError: If the file is broken or of another kind.
    """
    try:
        # Open the file here: NumPy would not close a broken one.
        with Path(path).open("rb") as content, np.load(content, allow_pickle=False) as file:
            held = {name: file[name] for name in file.files}
        about = json.loads(str(held.pop("about")))
        if about["format"] != FORMAT:
            raise DemonstrationError(f"{path}: format {about['format']}, this version reads {FORMAT}")
        arrays: dict[str, Any] = {name: held[name] for name in ARRAYS}
        return _checked(Demonstrations(**{name: _joined(name, held) for name in OBSERVED}, **arrays, about=about))
    except FileNotFoundError:
        raise
    except UNREADABLE as error:
        if isinstance(error, DemonstrationError):
            raise
        raise DemonstrationError(
            f"{path}: not a file of demonstrations ({_what_is_wrong(Path(path), error)})"
        ) from None


def _what_is_wrong(path: Path, error: Exception) -> str:
    """Return why a file holds no demonstrations, and how to make one that does."""
    if not path.is_file() or zipfile.is_zipfile(path):
        return str(error)
    found = "it is empty" if path.stat().st_size == 0 else "it is not a complete .npz archive"
    return f"{found}; irsim-gym play --record writes such files, and creates one that does not exist"


def save_demonstrations(path: Path, found: Demonstrations) -> None:
    """Write demonstrations to a file. The file appears only when it is complete."""
    arrays = {name: getattr(found, name) for name in ARRAYS}
    for name in OBSERVED:
        seen = getattr(found, name)
        arrays |= {f"{name}/{key}": rows for key, rows in seen.items()} if isinstance(seen, dict) else {name: seen}
    content = io.BytesIO()
    np.savez_compressed(content, about=np.array(json.dumps(plain(dict(found.about)))), **arrays)
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


def _checked(found: Demonstrations) -> Demonstrations:
    """Return demonstrations, after checking that the lengths of their arrays match."""
    for name in (*OBSERVED, *ARRAYS):
        value, of_episodes = getattr(found, name), name in ("final_observations", "levels", "outcomes")
        wanted = int(found.ends.sum()) if of_episodes else len(found.rewards)
        for rows in value.values() if isinstance(value, dict) else (value,):
            if len(rows) != wanted:
                raise ValueError(f"its {name} are {len(rows)}, not {wanted}")
    return found


def _joined(name: str, held: Mapping[str, Array]) -> Any:
    """Return the array of a name, or a dict of the arrays named ``name/...``."""
    if name in held:
        return held[name]
    parts = {key.removeprefix(f"{name}/"): rows for key, rows in held.items() if key.startswith(f"{name}/")}
    if not parts:
        raise ValueError(f"it has no {name}")
    return parts
