"""The study file: scenarios, parameters, outcomes, limits, and the options of each kind."""
