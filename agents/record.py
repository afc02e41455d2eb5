"""The command ``irsim-gym record`` as a script: ``python agents/record.py --help``."""

from irsim_gym import cli

if __name__ == "__main__":
    cli.run(cli.record)
