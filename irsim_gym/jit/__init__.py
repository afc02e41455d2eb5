"""The one way to Numba: the decorator for compiled code, and the recording of its calls."""

from irsim_gym.jit.kernels import Calls, Kernel, config, is_recording, kernel, record

__all__ = ["Calls", "Kernel", "config", "is_recording", "kernel", "record"]
