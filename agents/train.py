"""The command ``irsim-gym train`` as a script: ``python agents/train.py --help``."""

import sys

from irsim_gym.cli import main

if __name__ == "__main__":
    main(["train", *sys.argv[1:]])
