"""The command ``irsim-gym evaluate`` as a script: ``python agents/evaluate.py --help``."""

from irsim_gym import cli

if __name__ == "__main__":
    cli.run(cli.evaluate)
