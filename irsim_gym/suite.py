"""The benchmark suite: its members, and records of runs."""

from irsim_gym.evaluation.suite.listing import reference_figures
from irsim_gym.evaluation.suite.members import Member, Suite, read_suite, shipped_suite
from irsim_gym.evaluation.suite.playing import play_suite
from irsim_gym.evaluation.suite.suite_record import SuiteRecord, read_record

__all__ = ["Member", "Suite", "SuiteRecord", "play_suite", "read_record", "read_suite", "reference_figures"]
__all__ += ["shipped_suite"]
