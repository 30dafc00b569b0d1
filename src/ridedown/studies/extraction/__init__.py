"""Extraction: the front structure of a car from a test against a wall."""
