"""Which rows a study has, and what is computed of each."""
