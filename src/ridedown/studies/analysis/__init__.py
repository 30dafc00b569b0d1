"""Samples, rare events, sensitivity, optima, fronts, boxes: of any function of named columns, crashes or not."""
