"""Mutation testing: do the tests notice when the code is wrong? See CONTRIBUTING.md."""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import campaign
import mutants
import report
import selection
from cosmic_ray.work_db import WorkDB, use_db
from cosmic_ray.work_item import TestOutcome

ROOT = Path(__file__).parents[2]


def main() -> None:
    """Measure, draw, play and report; what is done already in the folder is not done again."""
    options = _options()
    folder: Path = (options.folder or ROOT / "build" / f"mutation-{options.part}").resolve()
    if not options.compiled and (options.tests or not (folder / "tests.json").exists()):
        selection.measure(ROOT, folder, options.tests or selection.TESTS[options.part], options.slowest)
    known = selection.read(folder)
    session, about = folder / "session.sqlite", folder / "session.json"
    with use_db(str(session)) as db:
        if not about.exists():
            _draw(db, about, options.part, options.count, options.seed)
        names = {item.job_id for item in db.pending_work_items}
        if options.survivors:
            alive = {job for job, result in db.results if result.test_outcome is TestOutcome.SURVIVED}
            names |= alive - report.equivalents()
        if options.again:
            names |= {item.job_id for item in db.work_items}
        if options.only:
            names = {name for name in names if any(part in name for part in options.only)}
        rules = campaign.Rules(ROOT, folder, known, options.budget, options.workers, options.compiled)
        campaign.play(db, names, rules)
        report.write(db, json.loads(about.read_text(encoding="utf-8")))
    if not options.compiled:  # in a process of its own: whether kernels are compiled is settled when they are imported
        subprocess.run([sys.executable, __file__, *sys.argv[1:], "--compiled"], check=True)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--part", choices=sorted(mutants.PARTS), default="core", help="which files are mutated")
    parser.add_argument("--folder", type=Path, help="where the session lies (build/mutation-PART)")
    parser.add_argument("--count", type=int, default=640, help="mutants of a new session")
    parser.add_argument("--seed", type=int, default=14, help="of their choice")
    parser.add_argument("--workers", type=int, default=2, help="mutants that are played at a time")
    parser.add_argument("--budget", type=float, default=15.0, help="seconds that the tests of a mutant may take")
    parser.add_argument("--survivors", action="store_true", help="play again what is alive, with today's tests")
    parser.add_argument("--again", action="store_true", help="play all again")
    parser.add_argument("--only", nargs="+", help="play those alone whose names hold one of these")
    parser.add_argument("--compiled", action="store_true", help="play those that nobody reaches in plain Python")
    parser.add_argument("--tests", nargs="*", help="measure these tests anew, and leave what is known of others")
    parser.add_argument("--slowest", type=float, default=selection.SLOWEST, help="how long a test may take [s]")
    return parser.parse_args()


def _draw(db: WorkDB, about: Path, part: str, count: int, seed: int) -> None:
    items, population = mutants.sample(ROOT, part, count, seed)
    db.clear()
    db.add_work_items(items)
    commit = subprocess.run(["git", "rev-parse", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=False)
    facts = {"part": part, "commit": commit.stdout.strip(), "seed": seed, "count": count, "population": population}
    about.write_text(json.dumps(facts, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
