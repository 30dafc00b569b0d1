"""Where the numbers of a scenario are: paths, and the fields they lead to."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from ridedown.scenario.base import Model, quantities_of
from ridedown.scenario.kinds import Scenario
from ridedown.scenario.quantities import Number, Quantity
from ridedown.scenario.vehicle import Vehicle

Steps = tuple[str | int, ...]


class Place(NamedTuple):
    """Where a path leads: the field, what it may hold, and what it holds."""

    steps: Steps
    quantity: Quantity
    value: Number | None


def places(scenario: Scenario, *, everything: bool) -> Iterator[tuple[str, Place]]:
    """Paths and places of the numbers: each once, or `everything` that may be set, by every path that leads there."""
    for path, steps, model in roots(scenario):
        yield from _places_in(model, path, steps, everything=everything)


def place_at(scenario: Scenario, path: str) -> Place | None:
    """The place that a path of `places` leads to, `everything` included, found by going there; None where there is none.

    >>> from ridedown.scenario import load
    >>> place_at(load("p1"), "adult.restraint.slack").steps
    ('occupants', 0, 'restraint', 'slack')
    """
    found = None
    for start, steps, model in roots(scenario):
        if rest := _after(start, path):
            found = _place_in(model, rest, steps) or found
    return found


def roots(scenario: Scenario) -> Iterator[tuple[str, Steps, Model]]:
    """The scenario itself and the named things in it, each with its path."""
    yield "", (), scenario
    for field in ("vehicle1", "vehicle2", "bar", "pulse"):
        part = getattr(scenario, field, None)
        if part is not None:
            yield field, (field,), part
    for field in ("occupants", "masses", "elements"):
        for i, item in enumerate(getattr(scenario, field, ())):
            yield item.name, (field, i), item


def parts(model: Model, *, everything: bool) -> Iterator[tuple[str, Steps, Model]]:
    """The models inside a model, but not those that `roots` gives: what each is called in paths, and where it is."""
    if isinstance(model, Scenario):
        return
    if isinstance(model, Vehicle):
        if model.alike or everything:
            yield "members", ("members",), model.right
        if not model.alike or everything:
            yield "right", ("right",), model.right
            yield "left", ("left",), model.left
        return
    for field in type(model).model_fields:
        value = getattr(model, field)
        if isinstance(value, Model) and not isinstance(value, Scenario):  # a sled's crash is solved once, as it is
            yield field, (field,), value
        elif isinstance(value, tuple):
            for i, item in enumerate(value):
                if isinstance(item, Model):
                    yield getattr(item, "name", "") or f"{field}.{i}", (field, i), item


def replaced(node: Any, steps: Steps, value: Number) -> Any:
    """A copy of the model or tuple with the value put where the steps lead, and the other way of giving it taken out."""
    if not steps:
        return value
    first, rest = steps[0], steps[1:]
    if isinstance(first, int):
        return (*node[:first], replaced(node[first], rest, value), *node[first + 1 :])
    if isinstance(node, Vehicle) and first == "members":
        return _both_members(node, rest, value)
    update = {first: replaced(getattr(node, first), rest, value)}
    other = getattr(type(node), "alternatives", {}).get(first)
    return node.model_copy(update=update if other is None else {**update, other: None})


def joined(path: str, field: str) -> str:
    """A path, and a field of what it leads to."""
    return ".".join(filter(None, (path, field)))


def _both_members(vehicle: Vehicle, steps: Steps, value: Number) -> Vehicle:
    right = replaced(vehicle.right, steps, value)
    left = right if vehicle.alike else replaced(vehicle.left, steps, value)
    return vehicle.model_copy(update={"right": right, "left": left})


def _places_in(model: Model, path: str, steps: Steps, *, everything: bool) -> Iterator[tuple[str, Place]]:
    for field in type(model).model_fields:
        quantities = quantities_of(type(model), field)
        value = getattr(model, field)
        where = joined(path, field)
        if field == "points":
            for i, point in enumerate(value or ()):
                for j, (number, quantity) in enumerate(zip(point, quantities, strict=True)):
                    yield f"{where}.{i}.{j}", Place((*steps, field, i, j), quantity, number)
        elif quantities and not isinstance(value, tuple):
            yield where, Place((*steps, field), quantities[0], value)
    for label, way, part in parts(model, everything=everything):
        yield from _places_in(part, joined(path, label), (*steps, *way), everything=everything)


def _place_in(model: Model, path: str, steps: Steps) -> Place | None:
    """The place of a path that begins in the model."""
    field, _, rest = path.partition(".")
    found = None
    if field == "points" and rest:
        found = _point_in(model, rest, (*steps, field))
    elif path != "points" and path in type(model).model_fields:
        quantities, value = quantities_of(type(model), path), getattr(model, path)
        if quantities and not isinstance(value, tuple):
            found = Place((*steps, path), quantities[0], value)
    for label, way, part in parts(model, everything=True):
        if inner := _after(label, path):
            found = _place_in(part, inner, (*steps, *way)) or found
    return found


def _point_in(model: Model, path: str, steps: Steps) -> Place | None:
    """The place of one number of a table of points, as in `1.0`."""
    for i, point in enumerate(getattr(model, "points", None) or ()):
        for j, (number, quantity) in enumerate(zip(point, quantities_of(type(model), "points"), strict=True)):
            if path == f"{i}.{j}":
                return Place((*steps, i, j), quantity, number)
    return None


def _after(start: str, path: str) -> str:
    """What comes after the start of a path; nothing where it starts otherwise."""
    if not start:
        return path
    return path[len(start) + 1 :] if path.startswith(f"{start}.") else ""
