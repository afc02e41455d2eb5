"""How kernels are compiled, take structs, draw numbers and are recorded.

No kernel of the simulator.
"""

from irsim_gym.base.kernels.decorator import Calls, Kernel, config, is_recording, kernel, record

__all__ = ["Calls", "Kernel", "config", "is_recording", "kernel", "record"]
