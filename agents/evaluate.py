"""The command ``irsim-gym evaluate`` as a script: ``python agents/evaluate.py --help``."""

import sys

from irsim_gym.cli import main

if __name__ == "__main__":
    main(["evaluate", *sys.argv[1:]])
