"""A scenario's numbers by path, and scenarios whose numbers are columns: one value per crash."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ridedown.errors import InvalidInput, UnknownName
from ridedown.scenario.base import Model, describe, quantities_of
from ridedown.scenario.kinds import S, Scenario
from ridedown.scenario.quantities import Number, Quantity, Refused, wanted
from ridedown.scenario.vehicle import Vehicle

Steps = tuple[str | int, ...]


class Parameter(NamedTuple):
    """One number of a scenario: its path, value and SI unit."""

    path: str
    value: Number
    unit: str


class _Place(NamedTuple):
    """Where a path leads: the field, what it may hold, and what it holds."""

    steps: Steps
    quantity: Quantity
    value: Number | None


def parameters(scenario: Scenario) -> tuple[Parameter, ...]:
    """All numbers of a scenario that `substitute` can replace, by path.

    Members alike are listed once, as `vehicle1.members...`; `vehicle1.right...` and `vehicle1.left...` can also be set.
    """
    return tuple(
        Parameter(path, place.value, place.quantity.unit)
        for path, place in _places(scenario, everything=False)
        if place.value is not None
    )


def substitute(scenario: S, values: Mapping[str, ArrayLike | str]) -> S:
    """A copy of a scenario whose named fields hold other values: single ones, or columns of shape (R,), SI.

    The values pass the same rules as a file's, row by row. Setting `damping_ratio` where `damping` was given replaces
    it, and the other way round; so with `lateral_offset` and `overlap`.

    >>> from ridedown.scenario import load, lower
    >>> many = substitute(load("p1"), {"vehicle1.mass": [1400.0, 1500.0, 1600.0]})
    >>> lower(many).size
    3

    Raises: UnknownName for a path that the scenario has not; InvalidInput for a value that breaks a rule, naming the
    path and the first row.
    """
    places = dict(_places(scenario, everything=True))
    rows: dict[int, str] = {}
    changed: S = scenario
    for path, given in values.items():
        if path not in places:
            raise UnknownName.among("parameter", path, places)
        place = places[path]
        value = _checked(path, given, place.quantity)
        if isinstance(value, np.ndarray):
            rows.setdefault(value.size, path)
        changed = _replaced(changed, place.steps, value)
    if len(rows) > 1:
        (size, path), (other_size, other) = list(rows.items())[:2]
        raise InvalidInput(f"{other}: got {other_size} rows; need {size}, as in {path}. Give columns of one length.")
    for path, model in _models(changed):
        for check in model.checks():
            refused = check.refusal()
            if refused is not None:
                raise InvalidInput(f"{_joined(path, refused.field)}: {refused}")
    return changed


def quantities(scenario: Scenario) -> dict[str, Quantity]:
    """What every number that may be set is, by every path that leads there."""
    return {path: place.quantity for path, place in _places(scenario, everything=True)}


def broken_rules(scenario: Scenario, columns: Mapping[str, NDArray[np.float64]]) -> dict[str, NDArray[np.bool_]]:
    """The rows of a table of columns, (R,) each, that `substitute` would refuse: each rule broken, in words, to a mask (R,).

    Rules between fields are looked at in the rows whose values are all within their own bounds.

    Raises: UnknownName for a path that the scenario has not.
    """
    places = dict(_places(scenario, everything=True))
    broken: dict[str, NDArray[np.bool_]] = {}
    changed: Scenario = scenario
    rows = max((column.size for column in columns.values()), default=0)
    within = np.ones(rows, dtype=np.bool_)
    for path, column in columns.items():
        if path not in places:
            raise UnknownName.among("parameter", path, places)
        quantity = places[path].quantity
        ok = np.isfinite(column) & np.broadcast_to(quantity.holds(column), column.shape)
        if not ok.all():
            broken[f"{path}: need a finite number {quantity.rule}".rstrip()] = ~ok
            within &= ok
    for path, column in columns.items():
        changed = _replaced(changed, places[path].steps, column[within])
    for path, model in _models(changed):
        for check in model.checks():
            holds = np.broadcast_to(np.asarray(check.holds), int(within.sum()))
            if not holds.all():
                mask = np.zeros(rows, dtype=np.bool_)
                mask[within] = ~holds
                broken[f"{_joined(path, check.field)}: need {check.need}"] = mask
    return broken


def _checked(path: str, given: ArrayLike | str, quantity: Quantity) -> Number:
    """The value or column in SI, within the field's own bounds."""
    try:
        if isinstance(given, str) or np.ndim(given) == 0:
            return quantity.read(given.item() if isinstance(given, np.ndarray | np.generic) else given)
        array = np.asarray(given)
        if array.ndim != 1 or array.dtype.kind not in "fiu":
            got = f"an array of shape {array.shape} and type {array.dtype}"
            raise Refused(got, "a column of numbers, shape (R,)", "Give one value per crash.")
        column = array.astype(np.float64)
        for ok, rule in (
            (np.isfinite(column), f"a finite number, {wanted(quantity.dimension)}"),
            (np.broadcast_to(quantity.holds(column), column.shape), quantity.rule),
        ):
            if not ok.all():
                raise Refused(describe(column, quantity.unit, int(np.argmin(ok))), rule, quantity.fix)
    except Refused as refused:
        raise InvalidInput(f"{path}: {refused}") from None
    return column


def _replaced(node: Any, steps: Steps, value: Number) -> Any:
    """A copy of the model or tuple with the value put where the steps lead."""
    if not steps:
        return value
    first, rest = steps[0], steps[1:]
    if isinstance(first, int):
        return (*node[:first], _replaced(node[first], rest, value), *node[first + 1 :])
    if isinstance(node, Vehicle) and first == "members":
        return _both_members(node, rest, value)
    update = {first: _replaced(getattr(node, first), rest, value)}
    other = getattr(type(node), "alternatives", {}).get(first)
    return node.model_copy(update=update if other is None else {**update, other: None})


def _both_members(vehicle: Vehicle, steps: Steps, value: Number) -> Vehicle:
    right = _replaced(vehicle.right, steps, value)
    left = right if vehicle.alike else _replaced(vehicle.left, steps, value)
    return vehicle.model_copy(update={"right": right, "left": left})


def _places(scenario: Scenario, *, everything: bool) -> Iterator[tuple[str, _Place]]:
    """Paths and places of the numbers: each once, or `everything` that may be set, by every path that leads there."""
    for path, steps, model in _roots(scenario):
        yield from _places_in(model, path, steps, everything=everything)


def _roots(scenario: Scenario) -> Iterator[tuple[str, Steps, Model]]:
    """The scenario itself and the named things in it, each with its path."""
    yield "", (), scenario
    for field in ("vehicle1", "vehicle2", "bar", "pulse"):
        part = getattr(scenario, field, None)
        if part is not None:
            yield field, (field,), part
    for field in ("occupants", "masses", "elements"):
        for i, item in enumerate(getattr(scenario, field, ())):
            yield item.name, (field, i), item


def _places_in(model: Model, path: str, steps: Steps, *, everything: bool) -> Iterator[tuple[str, _Place]]:
    for field in type(model).model_fields:
        quantities = quantities_of(type(model), field)
        value = getattr(model, field)
        where = _joined(path, field)
        if field == "points":
            for i, point in enumerate(value or ()):
                for j, (number, quantity) in enumerate(zip(point, quantities, strict=True)):
                    yield f"{where}.{i}.{j}", _Place((*steps, field, i, j), quantity, number)
        elif quantities and not isinstance(value, tuple):
            yield where, _Place((*steps, field), quantities[0], value)
    for label, way, part in _parts(model, everything=everything):
        yield from _places_in(part, _joined(path, label), (*steps, *way), everything=everything)


def _parts(model: Model, *, everything: bool) -> Iterator[tuple[str, Steps, Model]]:
    """The models inside a model, but not those that `_roots` gives: what each is called in paths, and where it is."""
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


def _models(scenario: Scenario) -> Iterator[tuple[str, Model]]:
    """Every model in a scenario with its path."""
    waiting = [(path, model) for path, _, model in _roots(scenario)]
    for path, model in waiting:
        yield path, model
        waiting += [(_joined(path, label), part) for label, _, part in _parts(model, everything=False)]


def _joined(path: str, field: str) -> str:
    return ".".join(filter(None, (path, field)))
