"""A world that learns of behaviours after it was loaded."""

from __future__ import annotations

import importlib
import importlib.util
import sys
import warnings
from pathlib import Path

from irsim_gym.errors import NoEffectWarning
from irsim_gym.live.carry import rebuild
from irsim_gym.live.population import Population
from irsim_gym.scenario import Scenario
from irsim_gym.scenario.pending import settle, unknown_groups


class Taught(Population):
    """What makes behaviours known that a world's file names.

    A world may be loaded from a file with behaviours that nobody has registered yet; they have to be known at the
    first step.
    """

    _loaded: Scenario
    _has_told = False

    def _tell_of_unknown_groups(self) -> None:
        """Warn, at the first step, of groups whose behaviour nobody has registered."""
        self._has_told = True
        for message in unknown_groups(self.simulation.scenario):
            told = f"{message}; until then each member decides by itself, as in IR-SIM"
            warnings.warn(told, NoEffectWarning, stacklevel=3)

    def load_behavior(self, behaviors: str) -> None:
        """Import a module that registers behaviours, and let those bodies have them whose file names them.

        The module registers them with ``irsim_gym.behavior``, or as for IR-SIM with ``irsim_gym.irsim``. A module that
        is imported already is not run again. Nothing else of the world changes.

        Args:
            behaviors: The module's name, as after ``import``. It is searched where Python searches, beside the running
                script, and beside the world's file.

        Raises:
            ModuleNotFoundError: There is none.
            ScenarioError: The file's options do not fit a behaviour; the error lists every problem with its line.
        """
        _import(behaviors, [Path(sys.argv[0] or "script.py").resolve().parent, *self._folders()])
        self._loaded = settle(self._loaded)
        now = self.simulation.scenario
        settled = settle(now)
        if settled is not now:
            self._follow(rebuild(self.simulation, settled))

    def _folders(self) -> list[Path]:
        file = self.simulation.scenario.file
        return [Path(file).resolve().parent] if file else []


def _import(name: str, folders: list[Path]) -> None:
    """Import a module; where Python does not find it, from one of these folders."""
    top = name.split(".")[0]
    if top not in sys.modules and importlib.util.find_spec(top) is None:
        found = (folder for folder in folders if (folder / f"{top}.py").is_file() or (folder / top).is_dir())
        folder = next(found, None)
        if folder is None:
            where = ", ".join(dict.fromkeys(map(str, folders)))
            raise ModuleNotFoundError(
                f"no module named '{name}': Python does not find it, nor is it in {where}", name=name
            )
        sys.path.insert(0, str(folder))
    try:
        importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name is not None and error.name.split(".")[0] == "irsim":
            error.add_note(f"in '{name}': what it imports from IR-SIM is in irsim_gym.irsim")
        raise
