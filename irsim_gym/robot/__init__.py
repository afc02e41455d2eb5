"""Policies for robots: a policy as one ONNX file, its contract, and the driver beside it."""
