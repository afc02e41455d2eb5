"""Pictures as arrays: areas with smooth edges on kernels, without a drawing library."""
