"""The commands that train, evaluate and record policies, with their output."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.base.extras import require
from irsim_gym.evaluation.comparison.evaluate import Evaluation, evaluate_policies
from irsim_gym.evaluation.levels.level_survey import survey
from irsim_gym.evaluation.protocol.tables import PLAIN, legend, print_table
from irsim_gym.evaluation.requests.folders import check_free, check_no_results, evaluation_folder, free_file
from irsim_gym.evaluation.requests.inputs import check_folder, check_inputs
from irsim_gym.evaluation.requests.interruption import TrainingInterruptedError, ctrl_c_as_error
from irsim_gym.evaluation.requests.methods import read_methods
from irsim_gym.evaluation.requests.remembered import as_trained
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.scenario.reading.notes import doubts, notes
from irsim_gym.training.curves.learning_curve import successes
from irsim_gym.training.curves.score import MARKS, Point, reached, scenario_point, scenario_title, score_run
from irsim_gym.training.curves.verdict import look_command, verdict
from irsim_gym.training.requests.request_checks import check_level_files, check_request
from irsim_gym.training.requests.training_request import TrainingRequest
from irsim_gym.training.runs.extension import extend
from irsim_gym.training.settings.run import Run, Settings


def run_training(
    request: TrainingRequest,
    out: Path | None = None,
    *,
    resume: bool = False,
    overwrite: bool = False,
    dev_levels: int = 1000,
    more_steps: int | None = None,
) -> Run:
    """Train a policy, score the checkpoints, print the results, and return the run.

    Args:
        out: Folder of the run; None for the default folder.
        resume: Continue the run in the folder.
        overwrite: Replace the run in the folder.
        dev_levels: Number of ``dev`` levels on which each checkpoint is scored; 0 for no scores.
        more_steps: With ``resume``, let a finished run go on for so many steps; None to leave it as it is.
    """
    require("train", "irsim-gym train")
    from irsim_gym.training.requests.train import train

    check_request(request, lambda: check_folder(out), partial(_check_ways, resume, overwrite, more_steps))
    console = Console(stderr=True)
    settings = request.settings()
    folder, remark = (out, "") if out is not None else request.choose_folder(settings, resume, overwrite)
    run = Run(folder)
    continued = resume and run.exists()
    if more_steps is not None:
        replace(request, until=None).resumed_settings(run, settings)
        console.print(extend(run, more_steps, request.until), **PLAIN)
    if continued:
        settings = request.resumed_settings(run, settings)
    elif resume:
        console.print(f"no run in {run.folder} to continue: starting a new one", **PLAIN)
    until = _checked_until(settings, dev_levels)
    check_level_files(run.own_settings() if continued else settings, {"dev": dev_levels})
    if remark:
        console.print(remark, **PLAIN)
    remarks = list(_notes(settings))
    what = f"{settings.algorithm.upper()} on {scenario_title(settings)}, seed {settings.seed}"
    after = "" if settings.origin is None else f", from {settings.origin['policy']}"
    for line in (f"training {what}{after}, in {run.folder}", *(f"note: {note}" for note in remarks)):
        console.print(line, **PLAIN)
    how: dict[str, Any] = {"resume": resume, "overwrite": overwrite, "device": request.device, "console": console}
    how["on_checkpoint"] = until and partial(is_enough, until, dev_levels)
    try:
        with ctrl_c_as_error("stopped at once; the newest checkpoint is kept"):
            train(settings, run.folder, **how)
    except TrainingInterruptedError as stop:
        raise TrainingInterruptedError(f"{stop}. To go on, run the same command with --resume.", stop.signal) from None
    if dev_levels:
        _show_scores(run, dev_levels, console)
    print(f"policy: {run.policy}")
    return run


def _show_scores(run: Run, dev_levels: int, console: Console) -> None:
    """Score the checkpoints of a finished run, and print the table and the verdict."""
    with ctrl_c_as_error("the training is finished, but its scoring is not: run the same command to continue."):
        points = score_run(run, levels=dev_levels, console=console)
    print_table(table := marks_table(points))
    print(legend([table]))
    for line in _verdict_lines(run, points[-1]):
        console.print(line, **PLAIN)


def _check_ways(resume: bool, overwrite: bool, more_steps: int | None) -> None:
    if resume and overwrite:
        raise IrsimGymError("--resume continues a run and --overwrite replaces it: pass only one of them")
    if more_steps is not None and not resume:
        raise IrsimGymError("--more-steps lets a finished run go on: pass --resume too")


def _checked_until(settings: Settings, dev_levels: int) -> float | None:
    until = settings.hyperparameters.until
    if until is not None and not dev_levels:
        raise IrsimGymError("until is a success on dev levels: --dev-levels must be at least 1")
    return until


def is_enough(until: float, levels: int, run: Run) -> bool:
    """Return whether a run's newest checkpoint has reached a success on ``levels`` ``dev`` levels [%]."""
    point = score_run(run, levels=levels, console=Console(quiet=True), picture=False)[-1]
    return 100.0 * point["success"] >= until


def _notes(settings: Settings) -> Iterator[str]:
    """Yield warnings of settings that are valid but probably not intended."""
    hyper = settings.hyperparameters
    if hyper.team is not None and max(len(part.load_task()[1].agents) for part in settings.parts()) == 1:
        yield "this team has one robot; --team needs several"
    starts = hyper.arguments.get("learning_starts", 0)
    if starts >= hyper.n_timesteps:
        yield f"the run learns nothing: learning_starts is {starts:,}, and the run has {hyper.n_timesteps:,} steps"
    for part in settings.parts():
        scenario, task = part.load_task()
        warned = set(doubts(scenario)) | set(scenario.ignored)
        further = [note for note in notes(scenario) if note not in warned]
        yield from (f"{note.path}: {note.message}" for note in (*further, *survey(scenario, task)))


def _verdict_lines(run: Run, last: Point) -> list[str]:
    """Return advice for a training that ended near 0 % success; for a mixture, for each such scenario."""
    settings, lines = run.settings(), list[str]()
    is_mixed = bool(settings.mixture)
    for name, part, stored in zip(settings.names, settings.parts(), run.own_settings().parts(), strict=True):
        scenario, task = stored.load_task()
        look = look_command(part.scenario, run.folder, team=settings.is_team, task=part.task)
        text = verdict(scenario_point(last, name) if is_mixed else last, scenario, task, look)
        lines += [f"{name}:", *text] if is_mixed and text else text
    return lines


def marks_table(points: Sequence[Point]) -> Table:
    """Return a table of when each success rate was reached for good, and of the last checkpoint's score."""
    last = points[-1]
    whose = "success of whole teams" if "individual_success" in last else "success"
    table = Table(title=f"{whose} on {last['levels']:,} dev levels", title_justify="left")
    for head in ("mark", "training time [s]", "steps"):
        table.add_column(Text(head), justify="right")
    for mark in MARKS:
        point = reached(points, mark)
        row = (f"{point['training_seconds']:.1f}", f"{point['steps']:,}") if point else ("-", "-")
        table.add_row(f"{mark:.0%}", *row)
    table.add_row(f"end: {last['success']:.1%}", f"{last['training_seconds']:.1f}", f"{last['steps']:,}")
    for name, share in successes(last).items():
        table.add_row(Text(f"{name}: {share:.1%}"), "", "")
    return table


def run_evaluation(
    request: ScenarioRequest,
    policies: Sequence[str],
    *,
    levels: int,
    split: str,
    out: Path | None = None,
    references: bool = True,
    overwrite: bool = False,
) -> Evaluation:
    """Evaluate policies of single robots or of teams, print the tables, write the files, and return the results.

    Raises:
        IrsimGymError: If there is no policy, or ``out`` already holds results.
    """
    if not policies and not references:
        raise IrsimGymError("nothing to evaluate: name a policy, or keep the references")
    request, methods, folder = requested_evaluation(request, policies, split, out, overwrite, "evaluation")
    how: dict[str, Any] = {"levels": levels, "split": split, "references": references}
    evaluation = evaluate_policies(request, methods, folder=folder, **how)
    print_evaluation(evaluation)
    print(f"rows, summary and table: {folder}")
    return evaluation


def requested_evaluation(
    request: ScenarioRequest, policies: Sequence[str], split: str, out: Path | None, overwrite: bool, kind: str
) -> tuple[ScenarioRequest, dict[str, tuple[str, ...]], Path]:
    """Check an evaluation, and return its request with the parameters of training, its methods, and its folder."""
    check_inputs(request, partial(check_no_results, out, overwrite), policies=policies, split=split, folder=out)
    methods = {method.name: method.sources for method in read_methods(policies)}
    request = as_trained(request, [source for seeds in methods.values() for source in seeds])
    named = str(request.scenario), split, request.parameters, request.team
    return request, methods, out or evaluation_folder(*named, overwrite=overwrite, kind=kind)


def print_evaluation(evaluation: Evaluation) -> None:
    """Print the tables of an evaluation, and what their columns mean."""
    for table in evaluation.tables:
        print_table(table)
    print(evaluation.legend)


def run_record(
    request: ScenarioRequest,
    policies: Sequence[str],
    levels: Sequence[int],
    split: str,
    out: Path | None,
    kind: str,
    *,
    overwrite: bool = False,
) -> None:
    """Write a film or a replay page of policies, and print the file's name.

    Args:
        policies: Policies, as ``load_policy`` takes them.
        out: File to write; None for a default name in ``runs``, numbered. A name that ends in ``.html`` means a replay
            page.
        kind: ``film`` or ``replay``.
        overwrite: Replace an existing file.
    """
    from irsim_gym.evaluation.comparison.record import check_output, record_film, record_html

    names_page = out is not None and out.suffix.lower() == ".html"
    kind = "replay" if kind == "film" and names_page else kind
    checks = partial(check_output, out, kind), partial(check_free, out, overwrite)
    check_inputs(request, *checks, policies=policies, split=split)
    request = as_trained(request, policies)
    path = out or free_file(Path("runs") / ("film.mp4" if kind == "film" else "replay.html"), overwrite)
    write = record_film if kind == "film" else record_html
    print(write(request, policies, levels, path, split=split))
