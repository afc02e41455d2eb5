"""Keywords of Stable-Baselines3's own ``make_vec_env``: what they mean for worlds that are stepped together."""

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from stable_baselines3.common.monitor import ResultsWriter

from irsim_gym.base.errors import IrsimGymError, UnknownNameError, suggestion

SINGLES = "stable_baselines3.common.env_util.make_vec_env(id, ...) takes it and steps single environments"
FOR_SINGLES = {
    "wrapper_class": f"wraps single environments, which a batch does not have: {SINGLES}; around a batch goes a "
    "VecEnvWrapper, such as VecFrameStack",
    "wrapper_kwargs": f"is for a wrapper of single environments, which a batch does not have: {SINGLES}",
    "vec_env_cls": f"puts single environments together, and a batch is a VecEnv itself, with num_threads: {SINGLES}",
    "vec_env_kwargs": f"is for a VecEnv of single environments, and a batch is one itself, with num_threads: {SINGLES}",
}
MONITOR_KEYWORDS = ("info_keywords", "override_existing", "allow_early_resets", "reset_keywords")


def refuse_for_singles(parameters: dict[str, Any]) -> None:
    """Take what is for single environments out of keywords that are left over, where nothing is asked for.

    Raises:
        IrsimGymError: Something is; the message says who does it.
    """
    for name, reason in FOR_SINGLES.items():
        if parameters.pop(name, None):
            raise IrsimGymError(f"{name} {reason}")


def with_env_kwargs(given: dict[str, Any], env_kwargs: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return keywords with those of ``env_kwargs`` added.

    Args:
        given: Keywords; None stands for one that was not given.
        env_kwargs: More of them.

    Raises:
        TypeError: It is no mapping, or one is given twice.
    """
    if env_kwargs is not None and not isinstance(env_kwargs, Mapping):
        raise TypeError(
            f"env_kwargs must map names of keywords to values, such as {{'max_steps': 100}}, got {env_kwargs!r}"
        )
    for name in env_kwargs or {}:
        if given.get(name) is not None:
            raise TypeError(f"{name} is given twice, as a keyword and in env_kwargs")
    return {**given, **(env_kwargs or {})}


class MonitorFiles:
    """What ``Monitor`` would write around each world: ``<folder>/<number>.monitor.csv``, a row for each episode.

    Args:
        folder: Where; None for nowhere.
        numbers: The numbers of the worlds.
        env_id: What stands as the environment's id in the files.
        keywords: Those of ``Monitor``: ``info_keywords`` (keys of infos that rows and ``info["episode"]`` hold too) and
            ``override_existing`` (False appends).

    Attributes:
        started: When they were opened, by the clock of the system [s].

    Raises:
        UnknownNameError: ``Monitor`` has no such keyword.
        IrsimGymError: One asks for what a batch does not do.
    """

    def __init__(
        self,
        folder: str | Path | None = None,
        numbers: range = range(0),
        env_id: str | None = None,
        keywords: Mapping[str, Any] | None = None,
    ) -> None:
        given = dict(keywords or {})
        for name in given:
            if name not in MONITOR_KEYWORDS:
                raise UnknownNameError(f"monitor_kwargs: no keyword {name!r}{suggestion(name, MONITOR_KEYWORDS)}")
        if given.get("reset_keywords") or not given.get("allow_early_resets", True):
            raise IrsimGymError(
                "monitor_kwargs: worlds of a batch begin together, without reset_keywords and at any time; "
                f"{SINGLES}, each in a Monitor"
            )
        self.started = time.time()
        self.info_keywords: tuple[str, ...] = tuple(given.get("info_keywords", ()))
        self._writers: list[ResultsWriter] = []
        for number in () if folder is None else numbers:
            header: dict[str, float | str] = {"t_start": self.started, "env_id": str(env_id)}
            override = bool(given.get("override_existing", True))
            path = str(Path(folder or "") / str(number))
            self._writers.append(ResultsWriter(path, header, self.info_keywords, override))

    def episode(self, w: int, total: float, info: Mapping[str, Any]) -> dict[str, Any]:
        """Return the statistics of an episode that has just ended, and write them.

        Args:
            info: What is known about its end.
        """
        row = {"r": round(total, 6), "l": info["steps"], "t": round(time.time() - self.started, 6)}
        row.update((key, info[key]) for key in self.info_keywords)
        if self._writers:
            self._writers[w].write_row(row)
        return row

    def close(self) -> None:
        """Close the files. May be called twice."""
        for writer in self._writers:
            writer.close()

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_writers": []}
