"""What a study file says of a bound, an optimisation and a solution box."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from ridedown.scenario.base import Check, Model
from ridedown.scenario.quantities import Deflection, Distance, Duration, Factor, Quantity, Share, Slack
from ridedown.studies.file.parameters import Grid, Raw
from ridedown.units import ACCELERATION

Peak = Annotated[float, Quantity(ACCELERATION, above=0.0, fix="A peak deceleration is a magnitude, without a sign.")]


class BuiltDesign(Model):
    """A restraint by what it did: name, peak deceleration, and excursions forward and, before that, rearward."""

    name: str = Field(description="what it is called")
    peak: Peak
    excursion: Distance
    rearward: Deflection = 0.0


class BoundOptions(Model):
    """What limiting performance is asked for.

    excursions, or an evenly spaced `grid` of them: the curve, at two or more that rise. excursion: of the ideal history; that
    of the first design, or the middle one, if left out. vehicle: whose pulse it is. occupants: of the scenario, or masses of
    theirs, to set beside it; designs: others, known by their numbers. rearward: room behind the occupant; seat: whether a seat
    is behind it at all. slack: that it moves before a restraint acts. horizon: until when it must be kept.
    """

    excursions: tuple[Deflection, ...] | None = Field(None, description="a list of lengths that rise")
    grid: Grid | None = Field(None, description="evenly spaced excursions")
    excursion: Distance | None = None
    vehicle: str = "vehicle1"
    occupants: tuple[str, ...] = ()
    designs: tuple[BuiltDesign, ...] = ()
    rearward: Deflection = 0.0
    seat: bool = Field(default=True, strict=True, description="whether a seat is behind the occupant")
    slack: Slack = 0.0
    horizon: Duration | None = None

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        both = self.excursions is not None and self.grid is not None
        yield Check("excursions", not both, "both excursions and a grid", "one of them", "Take one out.")
        given = self.excursions is not None or self.grid is not None
        yield Check("excursions", given, "nothing", "excursions, or a grid of them", 'As in ["100 mm", "200 mm", "300 mm"].')
        if self.excursions is not None:
            several = len(self.excursions) >= 2
            yield Check("excursions", several, f"a list of {len(self.excursions)}", "two or more", "Add the others.")
            rising = all(one < other for one, other in zip(self.excursions, self.excursions[1:], strict=False))
            yield Check("excursions", rising, "some that do not rise", "each larger than the one before", "Sort them.")
            free = self.slack == 0.0 or self.excursions[0] > self.slack
            yield Check("excursions.0", free, self.excursions[0], "more than the slack", "No restraint acts before.", "m")
        room = self.excursion is None or self.slack == 0.0 or self.excursion > self.slack
        yield Check("excursion", room, self.excursion or 0.0, "more than the slack", "No restraint acts before.", "m")
        seated = self.seat or self.rearward == 0.0
        yield Check("rearward", seated, self.rearward, "nothing where there is no seat", "Take it out.", "m")
        twice = next((name for name in self.occupants if self.occupants.count(name) > 1), "")
        yield Check("occupants", not twice, f"{twice} twice", "each once", "Take one out.")


Measures = Literal["mean", "mean-plus", "quantile", "worst", "probability"]


class Measured(Model):
    """An outcome, or a measure of it over a population (see `ridedown.studies.analysis.goals`).

    sigmas: how many standard deviations `mean-plus` adds. share: of the population, that a `quantile` is not exceeded by.
    above, below: of a `probability`, the value that the outcome is beyond.
    """

    outcome: str = Field(description="name of an outcome")
    measure: Measures = "mean"
    sigmas: float | None = None
    share: Share | None = None
    above: Raw | None = None
    below: Raw | None = None

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        for field, measure in (("sigmas", "mean-plus"), ("share", "quantile")):
            value = getattr(self, field)
            own = value is None or self.measure == measure
            yield Check(field, own, f'{field} with measure = "{self.measure}"', f'measure = "{measure}"', "Say so.")
            yield Check(field, self.measure != measure or value is not None, "nothing", f'a number with measure = "{measure}"')
        yield Check("share", self.share is None or 0.0 < self.share < 1.0, f"{self.share}", "a number between 0 and 1")
        beyond = [field for field in ("above", "below") if getattr(self, field) is not None]
        of_chance = self.measure == "probability"
        yield Check("above", of_chance or not beyond, f'a value with measure = "{self.measure}"', 'measure = "probability"')
        one = not of_chance or len(beyond) == 1
        yield Check("above", one, " and ".join(beyond) or "nothing", "above or below, the value that the outcome is beyond")


class Objective(Measured):
    """What is to be as small as can be, or as large."""

    sense: Literal["min", "max"] = "min"


class Constraint(Measured):
    """What a design must hold; with several sides, each of them. Of a `probability` the bounds are shares, from 0 to 1."""

    most: Raw | None = Field(None, description="largest value allowed, bare SI or with a unit")
    least: Raw | None = Field(None, description="smallest value allowed")

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        yield from super().checks()
        given = self.most is not None or self.least is not None
        yield Check("most", given, "nothing", "the largest value allowed, or `least`")


class OptimiseOptions(Model):
    """What is sought, and how hard.

    candidates: designs of a generation (64 for one objective, 100 for several); generations: at most (200, or 100).
    population_rows: drawn of the parameters with a distribution, the same for each design. reference: of the hypervolume, one
    value for each objective, SI.
    """

    objectives: tuple[Objective, ...] = Field((), description="what is to be small or large")
    constraints: tuple[Constraint, ...] = ()
    candidates: int | None = Field(None, strict=True, description="designs of a generation")
    generations: int | None = Field(None, strict=True, description="how many at most")
    population_rows: int = Field(64, strict=True, description="rows drawn of the distributions, for each design")
    algorithm: Literal["nsga2", "nsga3"] | None = None
    reference: tuple[float, ...] | None = None
    seed: int = Field(0, strict=True, description="a whole number from 0")

    @property
    def designs(self) -> tuple[int, int]:
        """Candidates and generations."""
        usual = (64, 200) if len(self.objectives) == 1 else (100, 100)
        return self.candidates or usual[0], self.generations or usual[1]

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        yield Check("objectives", bool(self.objectives), "none", "one or more", 'As in [{ outcome = "adult.clip_3ms" }].')
        for field, least in (("candidates", 8), ("generations", 1), ("population_rows", 1), ("seed", 0)):
            value = getattr(self, field)
            yield Check(field, value is None or value >= least, f"{value}", f"{least} or more")
        several = len(self.objectives) > 1
        yield Check("algorithm", several or self.algorithm is None, "one with one objective", "none", "Take it out.")
        count = len(self.objectives) if several else 0
        fits = self.reference is None or len(self.reference) == count
        yield Check("reference", fits, f"{len(self.reference or ())} values", f"{count}, one for each of several objectives")


class BoxOptions(Model):
    """How a solution box is sought and verified, see `ridedown.studies.analysis.box`."""

    size: Literal["volume", "shortest-side"] = "volume"
    bad_share: Share = Field(0.01, description="share of bad designs that is ruled out")
    confidence: Share = Field(0.95, description="with which it is")
    rows: int = Field(256, strict=True, description="rows of a round")
    rounds: int = Field(80, strict=True, description="rounds of the search")
    seed: int = Field(0, strict=True, description="a whole number from 0")

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        for field, least in (("rows", 16), ("rounds", 1), ("seed", 0)):
            yield Check(field, getattr(self, field) >= least, f"{getattr(self, field)}", f"{least} or more")
        for field in ("bad_share", "confidence"):
            value = getattr(self, field)
            yield Check(field, 0.0 < value < 1.0, f"{value}", "a number between 0 and 1")


class Member(Model):
    """One of the population that a design is for: values by path, and how much it counts."""

    values: dict[str, Raw] = Field(description="a table of paths and values")
    weight: Factor = 1.0
