"""The folder that keeps a study's rows, SQL over it, and what a finished study says."""
