"""HTML pages that stand alone: styles and figures inside, nothing fetched."""

from __future__ import annotations

from typing import Any

import jinja2

import ridedown


def render(package: str, template: str, **context: Any) -> str:
    """Fill in a template of `package`; it may extend `base.html`, the frame of every page."""
    environment = jinja2.Environment(
        loader=jinja2.ChoiceLoader([jinja2.PackageLoader(package), jinja2.PackageLoader("ridedown.report")]),
        autoescape=jinja2.select_autoescape(["html"]),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    return environment.get_template(template).render(version=ridedown.__version__, **context)
