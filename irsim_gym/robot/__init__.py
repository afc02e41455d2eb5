"""A policy leaves for a robot: one ONNX file, its contract, a driver.

Nothing that trains, and no simulator in what is written.
"""
