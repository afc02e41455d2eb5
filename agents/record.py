"""The command ``irsim-gym record`` as a script: ``python agents/record.py --help``."""

import sys

from irsim_gym.cli import main

if __name__ == "__main__":
    main(["record", *sys.argv[1:]])
