"""What all scenario models share: frozen, unknown keys refused, rules between fields, errors in one clear sentence."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterator, Mapping
from functools import cache
from typing import Annotated, Any, NamedTuple, Self, get_args, get_origin

import numpy as np
from pydantic import BaseModel, ConfigDict, StringConstraints, ValidationError, model_validator
from pydantic_core import ErrorDetails

from ridedown.errors import InvalidInput
from ridedown.scenario.quantities import Number, Quantity, Refused, Truth, show, wanted

NAME_PATTERN = r"^[A-Za-z_][A-Za-z0-9_-]*$"
Name = Annotated[str, StringConstraints(pattern=NAME_PATTERN, max_length=60)]
"""A name that channels and parameter paths are built from, so with no dot or space in it."""


NOT_YET: Any = None
"""Default of a field that `complete` fills in, so that it never is None in a model that is built."""


def without_default(schema: dict[str, Any]) -> None:
    """Take the default out of a field's JSON Schema: NOT_YET is no value that a file may hold."""
    schema.pop("default", None)


class Check(NamedTuple):
    """A rule between the fields of one model, for single values and columns alike."""

    field: str
    """Path of the field, from the model."""
    holds: Truth
    got: Number | str
    """The offending value(s), or words."""
    need: str
    fix: str = ""
    unit: str = ""

    def refusal(self) -> Refused | None:
        """None where the rule holds; else what is wrong, in the first row that breaks it."""
        if self.holds is True:
            return None
        holds = np.asarray(self.holds)
        if holds.all():
            return None
        row = int(np.argmin(holds)) if holds.ndim else None
        return Refused(describe(self.got, self.unit, row), self.need, self.fix, field=self.field)


def describe(got: Number | str, unit: str, row: int | None) -> str:
    """The value got, and in which row of a column."""
    if isinstance(got, str):
        shown = got
    else:
        shown = show(float(got[row]) if isinstance(got, np.ndarray) and got.ndim else float(got), unit)
    return shown if row is None else f"{shown} in row {row}"


class Model(BaseModel):
    """Base of every part of a scenario. Building one that breaks a rule raises InvalidInput."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    def __init__(self, /, **data: Any) -> None:
        try:
            super().__init__(**data)
        except ValidationError as error:
            raise invalid_input(error, type(self)) from None

    # Tells pydantic to build nested models without __init__, so that the errors of a whole file come with full paths.
    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]

    @classmethod
    def model_validate(cls, obj: Any, **options: Any) -> Self:
        """The model of a mapping. Raises: InvalidInput."""
        try:
            return super().model_validate(obj, **options)
        except ValidationError as error:
            raise invalid_input(error, cls) from None

    def complete(self) -> None:
        """Fill in what follows from other fields."""

    def checks(self) -> Iterator[Check]:
        """Rules between this model's fields, each pure arithmetic, so that columns pass the same rules."""
        return iter(())

    @model_validator(mode="after")
    def _complete_and_check(self) -> Self:
        self.complete()
        for check in self.checks():
            refused = check.refusal()
            if refused is not None:
                raise refused
        return self

    def _fill(self, **values: Any) -> None:
        # Only while being built: from then on the model is frozen.
        for field, value in values.items():
            object.__setattr__(self, field, value)


def exclusive(one: str, other: str, *, given: bool, fix: str) -> Check:
    """The rule that only one of two fields is given."""
    return Check(other, not given, f"both {one} and {other}", "one of them", fix)


def unused(stem: str, taken: set[str]) -> str:
    """The stem, or the stem with the first number from 2 that is free: adult, adult2, ..."""
    name, number = stem, 1
    while name in taken:
        number += 1
        name = f"{stem}{number}"
    return name


def quantities_in(annotation: Any) -> tuple[Quantity, ...]:
    """The quantities that a type is made of, in order."""
    if get_origin(annotation) is Annotated:
        return tuple(extra for extra in annotation.__metadata__ if isinstance(extra, Quantity))
    return tuple(quantity for argument in get_args(annotation) for quantity in quantities_in(argument))


@cache
def quantities_of(model: type[Model], field: str) -> tuple[Quantity, ...]:
    """The quantities of one field: one, two for curve points, or none."""
    info = model.model_fields[field]
    own = tuple(extra for extra in info.metadata if isinstance(extra, Quantity))
    return own or quantities_in(info.annotation)


def models_in(annotation: Any) -> list[type[Model]]:
    """The models that a type may hold."""
    if isinstance(annotation, type) and issubclass(annotation, Model):
        return [annotation]
    return [model for argument in get_args(annotation) for model in models_in(argument)]


def invalid_input(error: ValidationError, model: type[Model]) -> InvalidInput:
    """One sentence for the first thing wrong; an unknown key goes first, for it explains the one that is missing."""
    details = error.errors(include_url=False)
    unknown = [detail for detail in details if detail["type"] == "extra_forbidden"]
    detail = (unknown or details)[0]
    # Parts in brackets are pydantic's choice among models, which no file contains.
    choices = [part for part in detail["loc"] if isinstance(part, str) and part.startswith("(")]
    path = [part for part in detail["loc"] if part not in choices]
    refused = _refusal(detail, path, _owners(model, path, choices))
    where = ".".join(str(part) for part in [*path, *filter(None, [refused.field])])
    return InvalidInput(f"{where}: {refused}" if where else f"scenario: {refused}")


def _owners(model: type[Model], path: list[int | str], choices: list[str]) -> list[type[Model]]:
    """The models that may own the last field of the path."""
    owners = [model]
    for part in path[:-1]:
        if isinstance(part, str):
            fields = [owner.model_fields[part] for owner in owners if part in owner.model_fields]
            owners = [found for field in fields for found in models_in(field.annotation)]
            chosen = [owner for owner in owners if f"({owner.__name__.lower()})" in choices]
            owners = chosen or owners  # a model inside the one that was chosen is no choice itself
    return owners


def _refusal(detail: ErrorDetails, path: list[int | str], owners: list[type[Model]]) -> Refused:
    context = detail.get("ctx", {})
    if isinstance(refused := context.get("error"), Refused):
        return refused
    field = str(path[-1]) if path else ""
    kind = detail["type"]
    if kind == "extra_forbidden":
        return _unknown_key(field, owners)
    if kind == "literal_error":
        return _not_among(detail["input"], context["expected"])
    if kind == "missing":
        return Refused("nothing", _wanted_by(field, owners))
    if kind == "too_long":
        return Refused(_shown(detail["input"]), f"a list of {context['max_length']}")
    message = detail["msg"]
    return Refused(_shown(detail["input"]), _WANTED.get(kind, message[:1].lower() + message[1:]))


_WANTED = {
    "model_type": "a table of fields",
    "model_attributes_type": "a table of fields",
    "string_pattern_mismatch": "a name of letters, digits, _ and -, starting with a letter",
    "string_type": "text",
    "string_too_long": "at most 60 characters",
    "bool_type": "true or false",
    "int_type": "a whole number",
    "tuple_type": "a list",
    "invalid_key": "text as the key",
}


def _wanted_by(field: str, owners: list[type[Model]]) -> str:
    """What a missing field should hold."""
    for owner in owners:
        if field in owner.model_fields and (quantities := quantities_of(owner, field)):
            return wanted(quantities[0].dimension)
    if field.isdigit():
        return "one more entry in the list"
    infos = [owner.model_fields[field] for owner in owners if field in owner.model_fields]
    if any(models_in(info.annotation) for info in infos):
        is_list = any(get_origin(info.annotation) is tuple for info in infos)
        return f"a list of tables [[{field}]]" if is_list else f"a table [{field}]"
    return next((info.description for info in infos if info.description), "a value")


def _unknown_key(key: str, owners: list[type[Model]]) -> Refused:
    known = sorted({field for owner in owners for field in owner.model_fields})
    near = difflib.get_close_matches(key, known, n=1)
    fix = f'Did you mean "{near[0]}"?' if near else ""
    return Refused("an unknown key", f"one of {', '.join(known)}" if not near else "a key of this table", fix)


def _not_among(value: object, expected: str) -> Refused:
    choices = expected.replace(" or ", ", ").replace("'", '"')
    near = difflib.get_close_matches(str(value), [c.strip('"') for c in choices.split(", ")], n=1)
    return Refused(_shown(value), f"one of {choices}", f'Did you mean "{near[0]}"?' if near else "")


def _shown(value: object) -> str:
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list | tuple):
        return f"a list of {len(value)}"
    text = f'"{value}"' if isinstance(value, str) else str(value)
    return text if len(text) <= 80 else text[:76] + '..."'


def of_known_kind(value: object, base: type[Model], kinds: Collection[str], wanted: str) -> object:
    """A model of the base, or a table whose `kind` is one that there is, before pydantic chooses by it.

    Raises: Refused, with the nearest kind; `wanted` says what else is needed.
    """
    if isinstance(value, base):
        return value
    if not isinstance(value, Mapping):
        raise Refused(f'"{value}"' if isinstance(value, str) else type(value).__name__, wanted)
    kind = value.get("kind")
    if not isinstance(kind, str) or kind not in kinds:
        near = difflib.get_close_matches(kind, kinds, n=1) if isinstance(kind, str) else []
        got = "nothing" if kind is None else f'"{kind}"'
        fix = f'Did you mean "{near[0]}"?' if near else ""
        raise Refused(got, "one of " + ", ".join(f'"{kind}"' for kind in kinds), fix, field="kind")
    return dict(value)
