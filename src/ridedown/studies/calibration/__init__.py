"""Calibration: a model's parameters from tests, how sure they are, and what the tests cannot tell apart."""
