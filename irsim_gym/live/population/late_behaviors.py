"""Behaviours that the file of a world names and that a module registers later."""

import importlib
import importlib.util
import sys
from pathlib import Path

from irsim_gym.base.errors import NoEffectWarning, warn_caller
from irsim_gym.live.population.carry import rebuild
from irsim_gym.live.session.session import Session
from irsim_gym.scenario.entries.pending import resolve_pending, unknown_groups


class LateBehaviors:
    """Resolves behaviours that were not registered when the file was read. They are needed by the first step.

    Args:
        session: The world's bodies.
    """

    def __init__(self, session: Session) -> None:
        self._session = session
        self._has_warned = False

    def warn_of_unknown_groups(self) -> None:
        """Warn once of groups whose behaviour is not registered."""
        if self._has_warned:
            return
        self._has_warned = True
        for message in unknown_groups(self._session.simulation.scenario):
            warn_caller(f"{message}; until then each member decides by itself, as in IR-SIM", NoEffectWarning)

    def load_behavior(self, behaviors: str) -> None:
        """Import a module that registers behaviours, and give them to the bodies whose file names them.

        The module registers them with ``irsim_gym.behavior``, or with ``irsim_gym.irsim`` as for IR-SIM. A module that
        was imported before does not run again. Nothing else in the world changes.

        Args:
            behaviors: Name of the module, as in ``import``. It is searched on Python's path, beside the running script,
                and beside the file of the world.

        Raises:
            ModuleNotFoundError: There is none.
            ScenarioError: The file's options do not fit a behaviour; the error lists every problem with its line.
        """
        session, now = self._session, self._session.simulation.scenario
        folders = [Path(sys.argv[0] or "script.py").resolve().parent]
        if now.file:
            folders.append(Path(now.file).resolve().parent)
        _import(behaviors, folders)
        session.scenario = resolve_pending(session.scenario)
        resolved = resolve_pending(now)
        if resolved is not now:
            session.replace(rebuild(session.simulation, resolved))


def _import(name: str, folders: list[Path]) -> None:
    """Import a module. If Python does not find it, search these folders."""
    top = name.split(".")[0]
    if top not in sys.modules and importlib.util.find_spec(top) is None:
        matches = (folder for folder in folders if (folder / f"{top}.py").is_file() or (folder / top).is_dir())
        folder = next(matches, None)
        if folder is None:
            where = ", ".join(dict.fromkeys(map(str, folders)))
            raise ModuleNotFoundError(f"no module named '{name}': Python finds none, nor is it in {where}", name=name)
        sys.path.insert(0, str(folder))
    try:
        importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name is not None and error.name.split(".")[0] == "irsim":
            error.add_note(f"in '{name}': what it imports from IR-SIM is in irsim_gym.irsim")
        raise
