"""The function ``irsim_gym.load_policy``: a trained policy for a loop of one's own."""

from pathlib import Path

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.base.extras import require
from irsim_gym.evaluation.saved_policies.shelf import SUFFIX, ShelfPolicy, read_policy, shelf_file, shelf_files


def load_policy(source: str | Path) -> ShelfPolicy:
    """Return a trained policy with ``predict``, as models of Stable-Baselines3 have it.

    ``policy.predict(observation)`` takes observations as the environment of its training gives them: their
    normalisation is a part of the policy. Shipped policies and exported files need no PyTorch; runs do, until they are
    exported.

    Args:
        source: Folder of a run (its policy, or that of its newest checkpoint if it is not finished), a ``policy.zip``,
            the name of a shipped policy (``irsim-gym policies list``), or a file of ``irsim-gym policies export``.

    Raises:
        UnknownNameError: There is no shipped policy of that name.
        IrsimGymError: There is no policy, it cannot be read, or its network is one of one's own.
        MissingExtraError: It is that of a run, and PyTorch is not installed.
    """
    path = Path(source)
    if path.suffix == SUFFIX:
        return read_policy(path)
    if str(source) in shelf_files() or not (path.suffix or len(path.parts) > 1 or path.exists()):
        return read_policy(shelf_file(str(source)))
    require("train", f"{source}: a policy.zip")
    from irsim_gym.evaluation.saved_policies import policies

    loaded = policies.load_policy(path)
    if not isinstance(loaded, policies.SavedPolicy) or isinstance(loaded.model, ShelfPolicy):
        raise IrsimGymError(f"{source} is no trained policy")
    from irsim_gym.training.export.exported_network import export_network

    network = export_network(loaded.model, loaded.normalization)
    if loaded.perception is not None:
        network.form["perception"] = loaded.perception.to_plain()
    return ShelfPolicy(network.form, network.arrays)
