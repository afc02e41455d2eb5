"""Put the results of several training seeds of a team into one JSON file, one picture and the tables of README.md.

    cd runs/circle_swap
    for n in 4 8; do irsim-gym evaluate circle_swap seed_* --team --set n_robots=$n --out test_$n; done
    cd ../..
    python agents/studies/summarize_teams.py circle_swap runs/circle_swap/seed_* --test runs/circle_swap/test_[48]

writes results/circle_swap.json and .png beside this file, copies the policies to policies/, and prints a table for each
test. The tests may differ in the values of the scenario's parameters; each has to hold all the runs. With
`--json-only`, nothing but results/NAME.json is written.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from summarize import HERE, write

from irsim_gym.training import markdown_table, seed_cells


def main() -> None:
    """Read the runs and the tests, and write the results."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario")
    parser.add_argument("runs", nargs="+", type=Path)
    parser.add_argument("--test", required=True, nargs="+", type=Path, help="folders of `irsim-gym evaluate --team`")
    parser.add_argument("--name", help="of the files that are written (default: the scenario)")
    parser.add_argument("--json-only", action="store_true", help="draw no picture and copy no policies")
    parser.add_argument("--out", type=Path, default=HERE, help="where results/ and policies/ are (default: agents)")
    asked = parser.parse_args()
    summary = write(asked.scenario, asked.runs, asked.test, asked.name, asked.out, json_only=asked.json_only)
    for test in summary["conditions"]:
        csr = f"median CSR of the seeds {100 * summary['median_test_csr'][test]:.1f} %"
        print(f"{test}: {csr}\n", *markdown_table(*seed_cells(summary, test)), "", sep="\n")


if __name__ == "__main__":
    main()
