"""A run shown: tables, figures, and an HTML page that stands alone."""
