"""Loading of files from others without running code from them.

A file of Stable-Baselines3 holds weights, which are read as plain numbers, and pickled Python objects, which can run
any code. Here, objects are only unpickled if all their classes are known to be harmless. Other objects are left out if
only the training needs them.
"""

import base64
import io
import pickle
import warnings
import zipfile
from pathlib import Path
from typing import Any

from irsim_gym.base.errors import UntrustedCodeWarning
from irsim_gym.base.outside_files import json_object, json_text

HARMLESS: dict[str, frozenset[str]] = {
    module: frozenset(names) for module, names in json_object(Path(__file__).with_name("harmless.json")).items()
}
"""Names that a pickle may use, by module: creating these objects runs no code from the file."""

FORMER = {
    f"irsim_gym.{former}": f"irsim_gym.{now}"
    for now, places in {
        "sb3": "envs.sb3_buffers envs.sb3_gru envs.sb3_memory envs.sb3_normalize",
        "training": "training.hyperparameters",
    }.items()
    for former in places.split()
}
"""Where classes were in files of version 0.1, and where they are."""

NEEDED = frozenset({"action_space", "observation_space", "policy_class", "policy_kwargs", "train_freq"})
"""Objects that a policy needs to act. Only the training needs the others."""

STAND_INS: dict[str, Any] = {"clip_range": 0.0, "learning_rate": 0.0}
"""Replacements for objects that only the training needs; None for all others."""

SERIALIZED = ":serialized:"


class HarmlessUnpickler(pickle.Unpickler):
    """An unpickler that only accepts harmless classes."""

    def find_class(self, module: str, name: str) -> Any:
        """Return a class or function.

        Raises:
            UnpicklingError: If it is not known to be harmless.
        """
        module = FORMER.get(module, module)
        if name in HARMLESS.get(module, ()):
            return super().find_class(module, name)
        raise pickle.UnpicklingError(f"{module}.{name}")


def load_pickle(path: Path) -> Any:
    """Return the object in a file. Warn if loading it can run code."""
    content = path.read_bytes()
    try:
        return _harmless(content)
    except pickle.UnpicklingError as error:
        _warn(path, str(error))
        return pickle.loads(content)


def read_data(path: Path) -> dict[str, Any]:
    """Return the data of a Stable-Baselines3 model, with objects as text; call it within ``reading``."""
    with zipfile.ZipFile(path) as archive:
        return json_text(archive.read("data"))


def harmless_objects(path: Path) -> dict[str, Any]:
    """Return the argument ``custom_objects`` of ``model.load``: replacements for the pickled objects of a file.

    Warn if objects that the policy needs are not harmless: ``model.load`` unpickles them, which can run code.

    Args:
        path: File of a Stable-Baselines3 model.
    """
    data = read_data(path)
    objects: dict[str, Any] = {}
    suspects: list[str] = []
    for key, value in data.items():
        if not isinstance(value, dict) or SERIALIZED not in value:
            continue
        try:
            objects[key] = _harmless(base64.b64decode(value[SERIALIZED]))
        except Exception as error:
            if key in NEEDED:
                suspects.append(f"{key} ({error})")
            else:
                objects[key] = STAND_INS.get(key)
    if suspects:
        _warn(path, ", ".join(suspects))
    return objects


def _harmless(content: bytes) -> Any:
    return HarmlessUnpickler(io.BytesIO(content)).load()


def _warn(path: Path, what: str) -> None:
    warnings.warn(
        f"{path} holds Python objects that can run code as they are loaded: {what}. Load such files only from people "
        "whom you trust; see SECURITY.md",
        UntrustedCodeWarning,
        stacklevel=3,
    )
