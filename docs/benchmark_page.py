"""Write the end of docs/benchmarks.md: the reference rows of configs/suite_references.json, and what is played.

python docs/benchmark_page.py [FOLDER]    # FOLDER: a run of the suite, whose benchmarks take the place of these rows
"""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path
from textwrap import fill

from irsim_gym.evaluation.protocol.tables import plain, write_text
from irsim_gym.evaluation.suite import suite_tables
from irsim_gym.evaluation.suite.members import Member, shipped_suite
from irsim_gym.evaluation.suite.scores import overall
from irsim_gym.evaluation.suite.suite_record import SuiteRecord, read_record
from irsim_gym.scenario.specs.library import references_file

PAGE = Path(__file__).parent / "benchmarks.md"
MARK = "<!-- Below: made by docs/benchmark_page.py. Do not edit. -->\n"
ROUNDED = 6
WIDTH = 120
DISTURBED = 250
"""Levels of each disturbed benchmark; those of the others are in the reference rows."""
BEHAVIOURS = """`random` draws each action, `dash`
drives straight at its goal. Behaviours know the state of the world (`pursuit:known=seen`, `dwa`: what
they have scanned), and learn nothing. A dash: not played, or the policy cannot drive these robots;
where it was tried, a note of the benchmark says why it cannot.
"""
ROBOT = (
    "Behaviours know their true pose here, too; what they scan is as bad as what policies scan. Shipped policies "
    "observe as in training: those named `..._robot` are told the latency and predict. Rows without a latency have not "
    "been played for it, or have no 5 points to lose.\n"
)


def main(folder: Path | None = None) -> None:
    """Take over a run, and write the page."""
    if folder is not None:
        take_over(folder)
    text = PAGE.read_text(encoding="utf-8")
    write_text(PAGE, text[: text.index(MARK) + len(MARK)] + tables())


def take_over(folder: Path) -> None:
    """Keep the figures of a run as the reference rows of its benchmarks, whole; those of all others stay.

    The latencies of a disturbed benchmark are those of the one without disturbances, too: they are found without. The
    record names the processors of all runs.
    """
    run = read_record(folder)
    record = reference_record()
    levels = DISTURBED if all(shipped_suite().members[name].disturbed for name in run.members) else record.levels
    if (run.split, run.levels) != (record.split, levels):
        raise SystemExit(f"{folder} holds {run.levels} {run.split} levels, not {levels} {record.split} levels")
    unplayed = [
        f"{method} in {member}"
        for member in run.members
        for method, policies in run.methods.items()
        if len(run.done(member, method)) < len(policies)
    ]
    if unplayed:
        raise SystemExit(f"{folder} is not finished, `irsim-gym suite run` continues it: {', '.join(unplayed)}")
    for key in ("members", "figures", "runs", "methods"):
        getattr(record, key).update(getattr(run, key))
    for name, rows in run.figures.items():
        for method, figures in record.figures.get(_undisturbed(name), {}).items():
            figures["latency_at_loss"] = rows.get(method, figures).get("latency_at_loss")
    plain_part = _part(record, False)
    success = {
        member: {method: [scores["success"]["value"]] for method, scores in figures.items()}
        for member, figures in plain_part.figures.items()
    }
    record.overall = overall(success, list(plain_part.methods))
    before, now = record.machine["processor"], run.machine["processor"]
    record.machine = run.machine | {"processor": before if now in before else f"{before} and {now}"}
    data = plain(record)
    for key in ("figures", "overall"):
        data[key] = _rounded(data[key])
    order = {name: number for number, name in enumerate(shipped_suite().members)}
    for key in ("members", "figures", "runs"):
        data[key] = dict(sorted(data[key].items(), key=lambda item: order[item[0]]))
    lines = [f"{json.dumps(key)}: {_compact(value)}" for key, value in data.items()]
    write_text(references_file(), "{\n" + ",\n".join(lines) + "\n}\n")


def tables() -> str:
    """Return what the page says below its mark."""
    record = reference_record()
    members = shipped_suite().members
    plain, robot = (_part(record, disturbed) for disturbed in (False, True))
    parts = [_made(plain, f"full,shift,singletons {{}} --levels {record.levels}", BEHAVIOURS), _overview(plain)]
    parts += ["### The tier robot\n", _made(robot, f"robot {{}} --levels {DISTURBED} --latency", ROBOT)]
    parts += [_overview(robot), "## Benchmarks\n"]
    for name, member in members.items():
        parts.append(f"### {name}\n\n{member.asks}\n\n![Levels of {name}](benchmarks/{picture(member)}.png)\n")
        if name in record.figures:
            parts.append(suite_tables.member_markdown(record, name).split("\n", 2)[2])
    return "\n" + "\n".join(_wrapped(line) for line in "\n".join(parts).split("\n"))


def reference_record() -> SuiteRecord:
    """Return the reference rows."""
    return SuiteRecord(**json.loads(references_file().read_text(encoding="utf-8")))


def picture(member: Member) -> str:
    """Return the name of the picture of a benchmark: that of the first one with the same levels."""
    members = shipped_suite().members.values()
    return next(one.name for one in members if (one.scenario, one.parameters) == (member.scenario, member.parameters))


def _part(record: SuiteRecord, disturbed: bool) -> SuiteRecord:
    """Return the rows of benchmarks with or without disturbances, and who played these."""
    members = shipped_suite().members
    figures = {name: rows for name, rows in record.figures.items() if bool(members[name].disturbed) == disturbed}
    methods = {name: those for name, those in record.methods.items() if any(name in rows for rows in figures.values())}
    return replace(record, figures=figures, methods=methods)


def _undisturbed(name: str) -> str:
    """Return the name of the benchmark that equals another one but for its disturbances."""
    plain_one, members = replace(shipped_suite().members[name], disturbed=""), shipped_suite().members.values()
    return next(
        one.name for one in members if replace(plain_one, name=one.name, asks=one.asks, differs=one.differs) == one
    )


def _overview(record: SuiteRecord) -> str:
    return suite_tables.overview(record).split("\n", 2)[2]


def _wrapped(line: str) -> str:
    return line if line[:1] in ("|", "!", "#") else fill(line, WIDTH, break_on_hyphens=False)


def _made(record: SuiteRecord, command: str, words: str) -> str:
    """Return the command of the rows, the version, the processors and what is to be known of the policies."""
    methods = " ".join(source if name == source else f"{name}={source}" for name, (source,) in _sources(record).items())
    machine = record.machine
    return (
        f"`irsim-gym suite run {command.format(methods)}`\n\n"
        f"irsim_gym {machine['versions']['irsim_gym']}, {machine['processor']}. {words}"
    )


def _sources(record: SuiteRecord) -> dict[str, list[str]]:
    return {name: [entry["source"] for entry in entries] for name, entries in record.methods.items()}


def _rounded(value: object) -> object:
    if isinstance(value, dict):
        return {key: _rounded(each) for key, each in value.items()}
    if isinstance(value, list):
        return [_rounded(each) for each in value]
    return round(value, ROUNDED) if isinstance(value, float) else value


def _compact(value: object) -> str:
    """Return JSON with a line for each entry of a mapping, so that differences can be read."""
    if not isinstance(value, dict) or not value:
        return json.dumps(value)
    return "{\n" + ",\n".join(f" {json.dumps(key)}: {json.dumps(each)}" for key, each in value.items()) + "\n}"


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else None)
