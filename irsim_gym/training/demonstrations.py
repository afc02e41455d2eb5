"""Demonstrations for imitation learning: observations and actions of a driver, in one file.

The file is NumPy's ``.npz``. Its arrays are those of ``Demonstrations``, observations in a dict as
``observations/NAME``; ``about`` is a text in JSON with what the environment was.
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
"""What reading a file raises that is something else, or broken."""

Array = NDArray[Any]
Observations = Array | dict[str, Array]


class DemonstrationError(IrsimGymError, ValueError):
    """A file of demonstrations that cannot be used."""


@dataclass(frozen=True)
class Demonstrations:
    """Steps of whole episodes, one after another, in the order in which they were driven.

    Attributes:
        observations: What was seen before each step, ``(n_steps, ...)``, or a dict of such arrays.
        actions: What was done then, as the environment takes it: ``(n_steps, action_dim)`` in [-1, 1], or
            ``(n_steps,)`` choices.
        rewards: What it was paid, ``(n_steps,)``.
        terminations: The step ended its episode, ``(n_steps,)``.
        truncations: The step was cut off: by the time limit, or because the driver stopped there, ``(n_steps,)``.
        episode_starts: The step is the first of an episode, ``(n_steps,)``.
        by_hand: A person drove, not a behaviour, ``(n_steps,)``.
        final_observations: What was seen after the last step of each episode, ``(n_episodes, ...)``, or a dict.
        levels: Level of each episode, ``(n_episodes,)``.
        outcomes: How it ended, numbers of ``irsim_gym.tasks.Outcome``, 0 where the driver stopped, ``(n_episodes,)``.
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
        """How many episodes there are."""
        return len(self.levels)

    @property
    def ends(self) -> Flags:
        """The step is the last of an episode, ``(n_steps,)``."""
        return np.asarray(self.terminations | self.truncations)

    @property
    def next_observations(self) -> Observations:
        """What was seen after each step, in the form of ``observations``."""
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
        FileNotFoundError: There is none.
        DemonstrationError: It holds something else.
    """
    try:
        # Opened here: NumPy would leave a broken file open.
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
    """Return what a file is that holds no demonstrations, and what would be one."""
    if not path.is_file() or zipfile.is_zipfile(path):
        return str(error)
    found = "it is empty" if path.stat().st_size == 0 else "it is not a complete .npz archive"
    return f"{found}; irsim-gym play --record writes such files, and creates one that does not exist"


def save_demonstrations(path: Path, found: Demonstrations) -> None:
    """Write demonstrations to a file that appears only when it is whole."""
    arrays = {name: getattr(found, name) for name in ARRAYS}
    for name in OBSERVED:
        seen = getattr(found, name)
        arrays |= {f"{name}/{key}": rows for key, rows in seen.items()} if isinstance(seen, dict) else {name: seen}
    content = io.BytesIO()
    np.savez_compressed(content, about=np.array(json.dumps(plain(dict(found.about)))), **arrays)
    write_bytes(path, content.getvalue())


def describe_space(space: Space[Any]) -> dict[str, Any]:
    """Return a space as plain data: kind, shape, type and bounds (numbers where all are the same)."""
    if isinstance(space, Dict):
        return {"kind": "Dict", "spaces": {name: describe_space(part) for name, part in space.spaces.items()}}
    if isinstance(space, Discrete):
        return {"kind": "Discrete", "n": int(space.n)}
    if isinstance(space, Box):
        low, high = (_bound(bound) for bound in (space.low, space.high))
        return {"kind": "Box", "shape": list(space.shape), "dtype": str(space.dtype), "low": low, "high": high}
    return {"kind": type(space).__name__}


def _bound(bound: Array) -> Any:
    """Return bounds as numbers, infinite ones as text, which JSON has: one where all are the same."""
    values = [value if np.isfinite(value) else str(value) for value in bound.ravel().tolist()]
    return values[0] if len(set(values)) == 1 else values


def _checked(found: Demonstrations) -> Demonstrations:
    """Return demonstrations whose arrays belong together."""
    for name in (*OBSERVED, *ARRAYS):
        value, of_episodes = getattr(found, name), name in ("final_observations", "levels", "outcomes")
        wanted = int(found.ends.sum()) if of_episodes else len(found.rewards)
        for rows in value.values() if isinstance(value, dict) else (value,):
            if len(rows) != wanted:
                raise ValueError(f"its {name} are {len(rows)}, not {wanted}")
    return found


def _joined(name: str, held: Mapping[str, Array]) -> Any:
    """Return an array, or the dict of those that are called ``name/...``."""
    if name in held:
        return held[name]
    parts = {key.removeprefix(f"{name}/"): rows for key, rows in held.items() if key.startswith(f"{name}/")}
    if not parts:
        raise ValueError(f"it has no {name}")
    return parts
