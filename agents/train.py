"""The command ``irsim-gym train`` as a script: ``python agents/train.py --help``."""

from irsim_gym import cli

if __name__ == "__main__":
    cli.run(cli.train)
