"""What a sampler hands to a learner: the experience of many agents as flat arrays, and what follows from it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Flags, Floats, Ints, Rays
from irsim_gym.envs.parts.observations import concatenated, on_each
from irsim_gym.envs.parts.spaces import Observation


@dataclass(frozen=True)
class Fragment:
    """Experience of agents as flat arrays: all steps of the first agent, then those of the second, and so on.

    Rows in which an agent waited are left out. A piece is a sequence of rows of one agent in one episode. It ends with
    a row that is ``terminated`` or ``cut``. A row is cut by the time limit, where sampling paused, and where a fragment
    was divided.

    Attributes:
        observation: Observation before the step, ``(n_rows, ...)``, or a dict of such arrays.
        action: Action before it was clipped to its bounds, ``(n_rows, ...)``.
        log_probability: Logarithm of the probability (density) of the action, ``(n_rows,)``.
        distribution: Parameters of the distribution from which the action was drawn, ``(n_rows, n_parameters)``.
        reward: Reward of the step, ``(n_rows,)``.
        terminated: Whether the episode ended with this step, ``(n_rows,)``.
        cut: Whether the piece ends with this row while the episode goes on or was truncated, ``(n_rows,)``.
        following: Observation after each cut row, ``(n_cuts, ...)``. Learners bootstrap from its value.
        steps: Number of sampled rows, including those in which agents waited.
    """

    observation: Observation
    action: NDArray[Any]
    log_probability: Rays
    distribution: Rays
    reward: Rays
    terminated: Flags
    cut: Flags
    following: Observation
    steps: int

    def __len__(self) -> int:
        return len(self.reward)

    def __getitem__(self, rows: slice) -> Self:
        """Return consecutive rows; see ``slice``."""
        return self.slice(rows)

    def slice(self, rows: slice, len_lookback_buffer: int | None = None) -> Self:
        """Return consecutive rows. If they end inside a piece, its last row here is cut.

        Args:
            rows: Which rows; the step of the slice must be 1.
            len_lookback_buffer: Ignored; RLlib passes it to episodes.

        Raises:
            ValueError: The step of the slice is not 1.
        """
        start, stop, step = rows.indices(len(self))
        if step != 1:
            raise ValueError("a fragment is divided into rows without gaps")
        chosen = slice(start, max(start, stop))
        cut = self.cut[chosen].copy()
        before = int(self.cut[:start].sum())
        following = on_each(self.following, lambda array: array[before : before + int(cut.sum())])
        if len(cut) and not (cut[-1] or self.terminated[stop - 1]):
            cut[-1] = True
            following = concatenated([following, on_each(self.observation, lambda array: array[stop : stop + 1])])
        return replace(
            self,
            observation=on_each(self.observation, lambda array: array[chosen]),
            **{name: getattr(self, name)[chosen] for name in COLUMNS},
            cut=cut,
            following=following,
            steps=len(cut),
        )


COLUMNS = ("action", "log_probability", "distribution", "reward", "terminated")
"""Arrays of a fragment with a row for each step, beside observations and cuts."""


def joined(fragments: Sequence[Fragment]) -> Fragment:
    """Return fragments one after the other, as one."""
    if len(fragments) == 1:
        return fragments[0]
    return Fragment(
        observation=concatenated([one.observation for one in fragments]),
        **{name: np.concatenate([getattr(one, name) for one in fragments]) for name in COLUMNS},
        cut=np.concatenate([one.cut for one in fragments]),
        following=concatenated([one.following for one in fragments]),
        steps=sum(one.steps for one in fragments),
    )


def advantages(fragment: Fragment, values: Rays, after: Rays, *, gamma: float, lambda_: float) -> Floats:
    """Return the generalised advantage estimates of all rows, ``(n_rows,)``.

    Source: Schulman et al., "High-Dimensional Continuous Control Using Generalized Advantage Estimation", 2016.

    Args:
        values: Value of each row's observation, ``(n_rows,)``.
        after: Value of each observation in ``following``, ``(n_cuts,)``.
        lambda_: Between the error of one step (0) and the whole sum of rewards (1).
    """
    ends = fragment.terminated | fragment.cut
    following = np.append(values[1:], 0.0)
    following[fragment.terminated] = 0.0
    following[fragment.cut] = after
    errors = fragment.reward + gamma * following - values
    return _sums(errors, ends, gamma * lambda_)


def _sums(errors: Floats, ends: Flags, factor: float) -> Floats:
    """Return discounted sums to the end of each piece: pieces side by side, one step of all at a time."""
    last = np.flatnonzero(ends)
    first = np.append(0, last[:-1] + 1)
    lengths = last - first + 1
    found = np.zeros(len(errors))
    sums = np.zeros(len(last))
    order = np.argsort(-lengths, kind="stable")
    last, lengths = last[order], lengths[order]
    n_longer = np.searchsorted(-lengths, -np.arange(1, lengths.max(initial=0) + 1), side="right")
    for back, n in enumerate(n_longer.tolist()):
        rows = last[:n] - back
        sums[:n] = errors[rows] + factor * sums[:n]
        found[rows] = sums[:n]
    return found


class FragmentWriter:
    """Collects the steps of rows (world, slot), which are then put one after the other for each row.

    Args:
        n_rows: Worlds times slots.
        n_steps: Steps that there is room for.
    """

    def __init__(self, n_rows: int, n_steps: int) -> None:
        self.n_rows, self.n_steps = n_rows, n_steps
        self._arrays: dict[str, NDArray[Any]] = {}
        self._parts: tuple[str, ...] = ()
        self._cuts: list[tuple[Ints, int, Observation]] = []
        self._t = 0

    def note(self, observation: Observation, columns: dict[str, NDArray[Any]]) -> None:
        """Take what was before and in a step: what each row saw, and the columns of ``Fragment`` and ``acted``."""
        seen = observation if isinstance(observation, dict) else {"": observation}
        self._parts = tuple(seen) if isinstance(observation, dict) else ()
        for name, array in [*((f"seen/{name}", array) for name, array in seen.items()), *columns.items()]:
            if name not in self._arrays:
                self._arrays[name] = np.empty((self.n_rows, self.n_steps, *array.shape[1:]), array.dtype)
            self._arrays[name][:, self._t] = array

    def note_cuts(self, rows: Ints, following: Observation) -> None:
        """Take the observations that follow on this step in rows that are cut, and go on with the next step."""
        if len(rows):
            self._cuts.append((rows, self._t, on_each(following, lambda array: array[rows])))
        self._t += 1

    def fragment(self) -> Fragment:
        """Return what was noted."""
        flat = {name: array[:, : self._t].reshape(-1, *array.shape[2:]) for name, array in self._arrays.items()}
        acted = flat.pop("acted")
        cut = np.zeros(len(acted), np.bool_)
        places = [rows * self._t + t for rows, t, _ in self._cuts]
        place = np.concatenate(places) if places else np.zeros(0, np.int64)
        cut[place] = True
        chosen = {name: array if acted.all() else array[acted] for name, array in flat.items()}
        seen: Any = {name: chosen.pop(f"seen/{name}") for name in self._parts or ("",)}
        order = np.argsort(place)
        after = (
            concatenated([part for _, _, part in self._cuts]) if places else on_each(_lone(seen), lambda one: one[:0])
        )
        return Fragment(
            observation=_lone(seen),
            **chosen,
            cut=cut[acted],
            following=on_each(after, lambda array: array[order]),
            steps=len(acted),
        )


def _lone(seen: dict[str, NDArray[Any]]) -> Observation:
    return seen[""] if list(seen) == [""] else seen
