"""Export of policies: from a run's folder, or from a ``policy.zip`` and the results of its training."""

import hashlib
import io
import zipfile
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from stable_baselines3.common.base_class import BaseAlgorithm

from irsim_gym.base.errors import IrsimGymError, report_together
from irsim_gym.base.outside_files import json_object, reading
from irsim_gym.base.version import __version__
from irsim_gym.evaluation.comparison.evaluate import evaluate_policies
from irsim_gym.evaluation.measures.metrics import Summary
from irsim_gym.evaluation.policies.reference_policies import policy_kinds
from irsim_gym.evaluation.protocol.tables import plain, write_bytes, write_json
from irsim_gym.evaluation.requests.inputs import check_folder, check_trained
from irsim_gym.evaluation.saved_policies import cards
from irsim_gym.evaluation.saved_policies.checkpoint_files import POLICY, list_checkpoints, load_progress
from irsim_gym.evaluation.saved_policies.policies import SavedPolicy, load_policy, policy_file
from irsim_gym.evaluation.saved_policies.run_folder import CONFIG_KIND
from irsim_gym.evaluation.saved_policies.shelf import SUFFIX, ShelfPolicy, policy_arrays
from irsim_gym.evaluation.saved_policies.snapshot import Snapshot
from irsim_gym.tasks import Episodes
from irsim_gym.tasks.terms.term import Needs, needs_of
from irsim_gym.training.export.exported_network import ExportedNetwork, export_network
from irsim_gym.training.export.results_files import SeedResults, read_results
from irsim_gym.training.settings.run import Settings, run_of

MEASURED = "played by the exported policy"
"""Source of results that the export measures itself."""


def export(
    source: Path,
    name: str,
    folder: Path,
    *,
    results: Sequence[Path] = (),
    levels: int = 1000,
    weaknesses: Sequence[str] = (),
    overwrite: bool = False,
) -> Path:
    """Write the file and the card of a policy, and return the path of the file.

    Args:
        source: A run's folder, one of its checkpoints, or a ``policy.zip``.
        name: Name of the exported policy.
        results: Files with results of the policy for its card, see ``read_results``. Without any, the exported policy
            is evaluated, in each scenario of a mixture.
        levels: Number of ``test`` levels of this evaluation.
        weaknesses: Known weaknesses, in sentences.
        overwrite: Replace an existing policy of this name, and its card.

    Raises:
        IrsimGymError: If the policy cannot be exported, the settings and the cost of its training are unknown, or the
            card would replace a file that is no card.
    """
    target = folder / f"{name}{SUFFIX}"
    _check(source, name, target, results, overwrite)
    loaded = load_policy(source)
    if not isinstance(loaded, SavedPolicy) or not isinstance(loaded.model, BaseAlgorithm):
        raise IrsimGymError(f"{source} is not a trained policy of Stable-Baselines3")
    network = export_network(loaded.model, loaded.normalization)
    parts = [part for file in results for part in read_results(file, source)]
    settings, training = _training(source, parts)
    run = run_of(policy_file(source))
    scenario = _scenario(settings, run.snapshot() or settings.snapshot())
    complete = run.own_settings() if run.exists() else settings  # with the run's own copy of its scenario
    episodes = complete.request().episodes(1)
    network.form["perception"] = complete.perception().to_plain()
    driver = ShelfPolicy(network.form, network.arrays)
    SavedPolicy(driver).check(episodes)
    content = _content(network)
    card = cards.PolicyCard(
        name=name,
        scenario=scenario,
        observation=_terms(episodes),
        needs=_needs(episodes),
        action=_action(episodes),
        network=cards.CardNetwork(layers=network.layers, weights=network.weights),
        training=training,
        results=_given(parts, scenario) or _evaluated(settings, complete, driver, levels),
        weaknesses=tuple(weaknesses),
        sha256=hashlib.sha256(content).hexdigest(),
        size=len(content),
        exported_by=__version__,
    )
    write_bytes(target, content)
    write_json(cards.card_file(target), card.model_dump())
    return target


def _check(source: Path, name: str, target: Path, results: Sequence[Path], overwrite: bool) -> None:
    """Check the arguments of ``export``, and report all problems together."""
    asked = (lambda: check_trained(source), lambda: _check_name(name), lambda: _check_target(target, overwrite))
    report_together(*asked, lambda: check_folder(target.parent), *(partial(_check_results, file) for file in results))


def _check_results(file: Path) -> None:
    if not file.is_file():
        raise IrsimGymError(f"--results: no file {file}; irsim-gym evaluate writes summary.json")


def _check_name(name: str) -> None:
    if not name.isidentifier():
        raise IrsimGymError(f"the name of a policy must consist of letters, digits and _, got '{name}'")
    if name in policy_kinds():
        raise IrsimGymError(f"'{name}' is the name of a behavior: choose another one")


def _check_target(target: Path, overwrite: bool) -> None:
    """Check that a policy and its card may be written: the card must never replace another kind of file."""
    existing = [file for file in (target, cards.card_file(target)) if file.exists()]
    if existing and not overwrite:
        raise IrsimGymError(f"{existing[0]} exists: choose another name or folder, or replace it with --overwrite")
    cards.read_card(target)


def _content(network: ExportedNetwork) -> bytes:
    """Return the bytes of the file, which holds arrays and text but no objects. Equal networks give equal bytes."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, array in policy_arrays(network.form, network.arrays).items():
            part = io.BytesIO()
            np.lib.format.write_array(part, np.asarray(array, order="C"), allow_pickle=False)
            archive.writestr(zipfile.ZipInfo(f"{name}.npy"), part.getvalue(), zipfile.ZIP_DEFLATED)
    return content.getvalue()


def _training(source: Path, parts: Sequence[SeedResults]) -> tuple[Settings, cards.CardTraining]:
    """Return the settings and the cost of a policy's training.

    Raises:
        IrsimGymError: If they are unknown: the policy is not in a run's folder, and no results name them.
    """
    record = next((part.run for part in parts if part.run is not None), None) or _run_record(source)
    if record is None:
        raise IrsimGymError(
            f"the settings and the cost of the training of {source} are not known: name the run's folder, or give "
            "--results with a file of agents/studies/summarize.py"
        )
    settings = Settings.from_plain(record["settings"])
    seeds = next((part.seeds for part in parts if part.seeds), (settings.seed,))
    return settings, cards.CardTraining(
        algorithm=settings.algorithm,
        hyperparameters=settings.hyperparameters.to_plain(),
        seed=settings.seed,
        seeds=seeds,
        machine=record["machine"],
        mixture=tuple(
            cards.CardPart(name=Path(item.scenario).name, parameters=plain(dict(item.parameters)), share=item.share)
            for item in settings.mixture
        ),
        **{name: record[name] for name in ("steps", "training_seconds", "cpu_seconds")},
    )


def _run_record(source: Path) -> dict[str, Any] | None:
    """Return the settings, the machine and the cost of a run, until a checkpoint if the source is one.

    The result is None for a file outside a run's folder.
    """
    run = run_of(policy_file(source))
    if not run.exists():
        return None
    checkpoints = list_checkpoints(run.checkpoints)
    chosen = [path for path in checkpoints if source in (path, path / POLICY)]
    if not chosen and (not run.finished() or not checkpoints):
        raise IrsimGymError(f"{run.folder} is not finished: resume it, or export one of its checkpoints")
    last = (chosen or checkpoints)[-1]
    progress = load_progress(last)
    cost = {name: getattr(progress, name) for name in ("steps", "training_seconds", "cpu_seconds")}
    with reading(run.config, CONFIG_KIND):
        config = json_object(run.config)
        return {"settings": config["settings"], "machine": config["machine"], **cost}


def _scenario(settings: Settings, snapshot: Snapshot) -> cards.CardScenario:
    """Return what a card says of the scenario: of files the name alone, not the folders of a machine."""
    return cards.CardScenario(
        name=Path(settings.scenario).name,
        parameters=plain(dict(settings.parameters)),
        task=None if settings.task is None else Path(settings.task).name,
        team=settings.hyperparameters.team,
        sha256=snapshot.digest,
    )


def _terms(episodes: Episodes) -> tuple[cards.CardTerm, ...]:
    columns = {name: low.shape for name, low, _ in episodes.observation_terms}
    images = {name: image.shape[2:] for name, image in episodes.view.images.items()}
    return tuple(cards.CardTerm(name=name, shape=shape) for name, shape in {**columns, **images}.items())


def _needs(episodes: Episodes) -> Needs | None:
    """Return what a robot must have to observe what a policy observes; None where a plugin does not say."""
    kinds = [term.options for term in episodes.terms["observations"]]
    return None if any(item.needs is None for item in kinds) else needs_of(kinds)


def _action(episodes: Episodes) -> cards.CardAction:
    term = episodes.terms["action"][0]
    components = tuple(name for name, _ in term.components[0])
    return cards.CardAction(name=term.name, components=components, choices=episodes.n_discrete or None)


def _given(parts: Sequence[SeedResults], scenario: cards.CardScenario) -> tuple[cards.CardResult, ...]:
    """Return the results that files contain, without the name of the card's own scenario."""
    stem = Path(scenario.name).stem
    results = (part.result for part in parts)
    return tuple(item.model_copy(update={"scenario": None}) if item.scenario == stem else item for item in results)


def _evaluated(settings: Settings, place: Settings, driver: ShelfPolicy, levels: int) -> tuple[cards.CardResult, ...]:
    """Evaluate the exported policy in each scenario that it was trained in, and return the results."""
    parts = zip(settings.parts(), place.parts(), strict=True)
    results = [_evaluate(part, where, driver, levels) for part, where in parts]
    first = results[0].scenario
    return tuple(item.model_copy(update={"scenario": None}) if item.scenario == first else item for item in results)


def _evaluate(settings: Settings, place: Settings, driver: ShelfPolicy, levels: int) -> cards.CardResult:
    """Evaluate the exported policy on ``test`` levels of one scenario, whose copy ``place`` names."""
    request, name = place.request(), Path(settings.scenario).name
    evaluation = evaluate_policies(request, {name: driver}, levels=levels, references=False)
    figures: Any = evaluation.summaries[0]
    success = figures.success if isinstance(figures, Summary) else figures.cooperative_success
    return cards.CardResult(
        split=evaluation.split,
        levels=levels,
        level_hash=evaluation.level_set.hash,
        parameters=plain(dict(settings.parameters)),
        team=request.team,
        success=plain(success),
        individual_success=plain(figures.individual_success) if request.team else None,
        collision=figures.collision.value,
        timeout=figures.timeout.value,
        spl=figures.spl,
        seeds={},
        source=MEASURED,
        scenario=name,
    )
