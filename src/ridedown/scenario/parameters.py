"""A scenario's numbers by path, and scenarios whose numbers are columns: one value per crash."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ridedown.errors import InvalidInput, UnknownName
from ridedown.scenario.base import Check, Model, describe
from ridedown.scenario.kinds import S, Scenario
from ridedown.scenario.places import Place, Steps, joined, parts, place_at, places, replaced, roots
from ridedown.scenario.quantities import Number, Quantity, Refused, wanted


class Parameter(NamedTuple):
    """One number of a scenario: its path, value and SI unit."""

    path: str
    value: Number
    unit: str


def parameters(scenario: Scenario) -> tuple[Parameter, ...]:
    """All numbers of a scenario that `substitute` can replace, by path.

    Members alike are listed once, as `vehicle1.members...`; `vehicle1.right...` and `vehicle1.left...` can also be set.
    """
    return tuple(
        Parameter(path, place.value, place.quantity.unit)
        for path, place in places(scenario, everything=False)
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
    rows: dict[int, str] = {}
    changed: S = scenario
    for path, given in values.items():
        place = _place(scenario, path)
        value = _checked(path, given, place.quantity)
        if isinstance(value, np.ndarray):
            rows.setdefault(value.size, path)
        changed = replaced(changed, place.steps, value)
    if len(rows) > 1:
        (size, path), (other_size, other) = list(rows.items())[:2]
        raise InvalidInput(f"{other}: got {other_size} rows; need {size}, as in {path}. Give columns of one length.")
    for path, check in _rules(changed, scenario):
        refused = check.refusal()
        if refused is not None:
            raise InvalidInput(f"{joined(path, refused.field)}: {refused}")
    _SOUND[id(changed)] = changed
    return changed


def quantities(scenario: Scenario) -> dict[str, Quantity]:
    """What every number that may be set is, by every path that leads there."""
    return {path: place.quantity for path, place in places(scenario, everything=True)}


def broken_rules(scenario: Scenario, columns: Mapping[str, NDArray[np.float64]]) -> dict[str, NDArray[np.bool_]]:
    """The rows of a table of columns, (R,) each, that `substitute` would refuse: each rule broken, in words, to a mask (R,).

    Rules between fields are looked at in the rows whose values are all within their own bounds.

    Raises: UnknownName for a path that the scenario has not.
    """
    broken: dict[str, NDArray[np.bool_]] = {}
    changed: Scenario = scenario
    rows = max((column.size for column in columns.values()), default=0)
    within = np.ones(rows, dtype=np.bool_)
    found: list[Steps] = []
    for path, column in columns.items():
        steps, quantity, _ = _place(scenario, path)
        found.append(steps)
        ok = np.isfinite(column) & np.broadcast_to(quantity.holds(column), column.shape)
        if not ok.all():
            broken[f"{path}: need a finite number {quantity.rule}".rstrip()] = ~ok
            within &= ok
    if not within.any():
        return broken
    for steps, column in zip(found, columns.values(), strict=True):
        changed = replaced(changed, steps, column[within])
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # what breaks one rule may leave others no answer
        for path, check in _rules(changed, scenario):
            holds = np.broadcast_to(np.asarray(check.holds), int(within.sum()))
            if not holds.all():
                mask = np.zeros(rows, dtype=np.bool_)
                mask[within] = ~holds
                broken[f"{joined(path, check.field)}: need {check.need}"] = mask
    return broken


def _place(scenario: Scenario, path: str) -> Place:
    """The place of a path. Raises: UnknownName, with the nearest paths."""
    place = place_at(scenario, path)
    if place is None:
        raise UnknownName.among("parameter", path, quantities(scenario))
    return place


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


_SOUND: WeakValueDictionary[int, Scenario] = WeakValueDictionary()
"""Scenarios that keep all rules, by their identity: frozen, so they go on keeping them. A copy is another scenario."""


def _is_sound(scenario: Scenario) -> bool:
    if _SOUND.get(id(scenario)) is not scenario:
        if any(check.refusal() for _, model in _models(scenario) for check in model.checks()):
            return False
        _SOUND[id(scenario)] = scenario
    return True


def _rules(changed: Scenario, before: Scenario) -> Iterator[tuple[str, Check]]:
    """The rules that a changed scenario may break, each with its model's path.

    A model looks at itself and at what is in it. So where all kept the rules before, only those can break one that were
    replaced, and replaced is everything on the way to a number that changed.
    """
    for path, model in _models(changed, before if _is_sound(before) else None):
        for check in model.checks():
            yield path, check


def _models(scenario: Scenario, before: Scenario | None = None) -> Iterator[tuple[str, Model]]:
    """Every model in a scenario with its path, but those that are the same object in the scenario `before`."""
    known = {} if before is None else {steps: model for _, steps, model in roots(before)}
    waiting = [(path, model, known.get(steps)) for path, steps, model in roots(scenario)]
    for path, model, earlier in waiting:
        if model is earlier:
            continue
        yield path, model
        inside = {} if earlier is None else {label: part for label, _, part in parts(earlier, everything=False)}
        waiting += [(joined(path, label), part, inside.get(label)) for label, _, part in parts(model, everything=False)]
