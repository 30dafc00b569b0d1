"""Designs: which rows of parameters a study runs, each row by its number alone.

A design of d columns gives rows in the open unit cube; `Variables` makes them values of distributed parameters. Any range of
rows can be asked for, in any order and on any machine, and a row is the same whatever it is asked for with.

References:
    S. Joe, F. Y. Kuo, Constructing Sobol sequences with better two-dimensional projections, SIAM J. Sci. Comput. 30, 2008.
    J. Matousek, On the L2-discrepancy for anchored boxes, J. Complexity 14, 1998 (scrambling by linear matrices and a shift).
    M. D. McKay, R. J. Beckman, W. J. Conover, A comparison of three methods for selecting values of input variables,
        Technometrics 21, 1979 (Latin hypercube).
    A. B. Owen, Scrambled net variance for integrals of smooth functions, Ann. Stat. 25, 1997.
    J. Black, P. Rogaway, Ciphers with arbitrary finite domains, CT-RSA 2002 (the keyed permutation: a Feistel network over
        a x b >= n, walked on until it falls below n).
    J. K. Salmon et al., Parallel random numbers: as easy as 1, 2, 3, SC 2011 (Philox).
    D. Kurowicka, R. Cooke, Uncertainty analysis with high dimensional dependence modelling, 2006, section 3.2
        (rank correlation of the normal copula, 2 sin(pi r / 6); Pearson 1907).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtri

from ridedown.errors import InvalidInput, UnknownName
from ridedown.studies.distributions import Distribution

Floats = NDArray[np.float64]
Seed = int | np.random.Generator | None
"""A whole number from 0, a generator that one is drawn from, or None for another one each time."""

_WORDS = NDArray[np.uint64]

_SOBOL_BITS = 52  # so that the middle of a cell, a bit finer, is a double still
_HELD = 1 << 16  # a permutation of fewer rows is drawn and held: its every order is as likely as any other
_ROUNDS = 8


def seed_of(seed: Seed | object) -> int:
    """The whole number that stands for a seed: itself, or one drawn from the generator or from the system.

    >>> seed_of(0)
    0

    Raises: InvalidInput for a seed below 0 or of another type.
    """
    if isinstance(seed, np.random.Generator):
        return int(seed.integers(1 << 62))
    if seed is None:
        return int(np.random.default_rng().integers(1 << 62))
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
        raise InvalidInput(f"seed: got {seed!r}; need a whole number of 0 or more. Leave it out for another one each time.")
    return int(seed)


class Design(Protocol):
    """Rows in the unit cube by their numbers."""

    @property
    def dimensions(self) -> int:
        """Number of columns."""

    def rows(self, start: int, stop: int) -> Floats:
        """Rows start <= row < stop, shape (stop - start, d), each number greater than 0 and less than 1."""


@dataclass(frozen=True, slots=True)
class Random:
    """Independent rows, each drawn by a counter that is the row's number.

    >>> draw = Random(2, seed=0)
    >>> bool((draw.rows(10, 20)[5] == draw.rows(15, 16)).all())
    True
    """

    dimensions: int
    seed: int

    def __post_init__(self) -> None:
        _at_least_one(self.dimensions, "dimensions")
        seed_of(self.seed)

    def rows(self, start: int, stop: int) -> Floats:
        """Rows start <= row < stop, (R, d)."""
        _check_range(start, stop)
        draws = -(-self.dimensions // 4)  # Philox gives four words for each count
        stream = np.random.Philox(np.random.SeedSequence(self.seed))
        stream.advance(start * draws)
        words = stream.random_raw((stop - start) * 4 * draws).reshape(stop - start, 4 * draws)
        return _middles(np.asarray(words[:, : self.dimensions], dtype=np.uint64))


@dataclass(frozen=True, slots=True)
class Sobol:
    """The Sobol sequence, scrambled by the seed: rows fill the cube evenly, best where their number is a power of two.

    >>> points = Sobol(3, seed=0).rows(0, 1024)
    >>> np.abs(points.mean(axis=0) - 0.5).max() < 1e-3
    np.True_
    """

    dimensions: int
    seed: int
    _columns: _WORDS = field(init=False, repr=False, compare=False)
    _shift: _WORDS = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        from scipy.stats import qmc  # noqa: PLC0415  slow to import

        _at_least_one(self.dimensions, "dimensions")
        if self.dimensions > qmc.Sobol.MAXDIM:
            raise InvalidInput(
                f"dimensions: got {self.dimensions}; need <= {qmc.Sobol.MAXDIM}. Take a Latin hypercube or random rows."
            )
        engine = qmc.Sobol(self.dimensions, bits=_SOBOL_BITS, rng=np.random.default_rng(seed_of(self.seed)))
        # scipy's own way to a row far out goes through all that lie before it, and fails with more than 32 bits; the generator
        # matrices give a row at once. A test holds the rows against scipy's.
        object.__setattr__(self, "_columns", np.array(engine._sv, dtype=np.uint64))  # type: ignore[attr-defined]  # noqa: SLF001
        object.__setattr__(self, "_shift", np.array(engine._shift, dtype=np.uint64))  # type: ignore[attr-defined]  # noqa: SLF001

    def rows(self, start: int, stop: int) -> Floats:
        """Rows start <= row < stop, (R, d)."""
        _check_range(start, stop)
        if stop > 1 << _SOBOL_BITS:
            raise InvalidInput(f"rows: got up to {stop}; need <= 2^{_SOBOL_BITS}. There are no more.")
        width = max(1, (max(stop - start, 1) - 1).bit_length())
        block = self._block(width)
        parts = []
        for number in range(start >> width, ((stop - 1) >> width) + 1 if stop > start else start >> width):
            # The sequence is linear in the Gray code of the row (Antonov and Saleev 1979), and the code of a row is that of its
            # block and that of its place in the block, one upon the other.
            base = number << width
            words = block ^ self._at(base)
            parts.append(words[max(start - base, 0) : stop - base])
        words = np.concatenate(parts) if parts else np.empty((0, self.dimensions), dtype=np.uint64)
        found: Floats = (words.astype(np.float64) + 0.5) * 2.0**-_SOBOL_BITS
        return found

    def _block(self, width: int) -> _WORDS:
        """The first 2^width rows, without the shift: each half is the one before it backwards, and one column on top."""
        block = np.zeros((1, self.dimensions), dtype=np.uint64)
        for j in range(width):
            block = np.concatenate([block, block[::-1] ^ self._columns[:, j]])
        return block

    def _at(self, row: int) -> _WORDS:
        gray = row ^ (row >> 1)
        word = self._shift
        for j in range(gray.bit_length()):
            if gray >> j & 1:
                word = word ^ self._columns[:, j]
        return word


@dataclass(frozen=True, slots=True)
class Scramblings:
    """Several independent scramblings of one Sobol sequence, `size` rows of each, one after the other.

    How their results differ tells how exact their mean is (Owen 1997), which the rows of one scrambling do not.

    >>> Scramblings(2, seed=0, size=1024, count=8).rows(1024, 1025).shape
    (1, 2)
    """

    dimensions: int
    seed: int
    size: int
    count: int
    _designs: tuple[Sobol, ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        for name in ("dimensions", "size", "count"):
            _at_least_one(getattr(self, name), name)
        seeds = np.random.SeedSequence(seed_of(self.seed)).generate_state(self.count, np.uint64)
        object.__setattr__(self, "_designs", tuple(Sobol(self.dimensions, int(seed >> 1)) for seed in seeds))

    def rows(self, start: int, stop: int) -> Floats:
        """Rows start <= row < stop, (R, d)."""
        _check_range(start, stop)
        if stop > self.size * self.count:
            raise InvalidInput(f"rows: got up to {stop}; need <= {self.size * self.count}, {self.count} times {self.size}.")
        parts = [np.empty((0, self.dimensions))]
        while start < stop:
            number, place = divmod(start, self.size)
            end = min(stop - number * self.size, self.size)
            parts.append(self._designs[number].rows(place, end))
            start = number * self.size + end
        return np.concatenate(parts)


@dataclass(frozen=True, slots=True)
class LatinHypercube:
    """n rows of which each column has one in every n-th part of the unit interval.

    The order of the parts is a permutation that is computed row by row, so that 10^9 rows need no memory. Up to 65,536 rows
    it is drawn and held.

    >>> points = LatinHypercube(2, seed=0, size=5).rows(0, 5)
    >>> np.sort((points * 5).astype(int), axis=0)[:, 0]
    array([0, 1, 2, 3, 4])
    """

    dimensions: int
    seed: int
    size: int
    _held: NDArray[np.int64] | None = field(init=False, repr=False, compare=False)
    _keys: _WORDS = field(init=False, repr=False, compare=False)
    _jitter: Random = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        _at_least_one(self.dimensions, "dimensions")
        _at_least_one(self.size, "size")
        for_order, for_jitter = np.random.SeedSequence(seed_of(self.seed)).spawn(2)
        rng = np.random.default_rng(for_order)
        keys = rng.integers(1 << 63, size=(self.dimensions, _ROUNDS), dtype=np.uint64)
        held = None
        if self.size <= _HELD:
            held = np.stack([rng.permutation(self.size) for _ in range(self.dimensions)], axis=1)
        object.__setattr__(self, "_held", held)
        object.__setattr__(self, "_keys", keys)
        object.__setattr__(self, "_jitter", Random(self.dimensions, int(for_jitter.generate_state(1, np.uint64)[0] >> 1)))

    def rows(self, start: int, stop: int) -> Floats:
        """Rows start <= row < stop, (R, d)."""
        _check_range(start, stop)
        if stop > self.size:
            raise InvalidInput(f"rows: got up to {stop}; need <= {self.size}, the size of the design.")
        if self._held is not None:
            places = self._held[start:stop]
        else:
            numbers = np.arange(start, stop, dtype=np.uint64)
            places = np.stack([_permuted(numbers, self.size, keys) for keys in self._keys], axis=1).astype(np.int64)
        # within (0, 1) even where a part is narrower than what is between two doubles
        return np.clip((places + self._jitter.rows(start, stop)) / self.size, 2.0**-54, 1.0 - 2.0**-53)


@dataclass(frozen=True, slots=True)
class Grid:
    """All combinations of the levels of some columns, by row; the last column changes fastest.

    >>> grid = Grid({"stiffness": [1.0, 2.0], "slack": [0.0, 0.01, 0.02]})
    >>> grid.size
    6
    >>> {name: values.tolist() for name, values in grid.columns(2, 5).items()}
    {'stiffness': [1.0, 2.0, 2.0], 'slack': [0.02, 0.0, 0.01]}
    """

    levels: Mapping[str, ArrayLike]
    _levels: tuple[Floats, ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        found = []
        for name, given in self.levels.items():
            column = np.asarray(given, dtype=np.float64)
            if column.ndim != 1 or not column.size or not np.isfinite(column).all():
                raise InvalidInput(f"{name}: got levels of shape {column.shape}; need a list of finite numbers, at least one.")
            found.append(column)
        if not found:
            raise InvalidInput("levels: got none; need at least one column. Name what varies.")
        object.__setattr__(self, "_levels", tuple(found))

    @property
    def size(self) -> int:
        """Number of rows in all."""
        size = 1
        for column in self._levels:
            size *= column.size
        return size

    def columns(self, start: int, stop: int) -> dict[str, Floats]:
        """Values of rows start <= row < stop, a column (R,) for each name."""
        _check_range(start, stop)
        if stop > self.size:
            raise InvalidInput(f"rows: got up to {stop}; need <= {self.size}, the size of the grid.")
        left = np.arange(start, stop, dtype=np.int64)
        found: dict[str, Floats] = {}
        for name, column in reversed(list(zip(self.levels, self._levels, strict=True))):
            left, place = np.divmod(left, column.size)
            found[name] = column[place]
        return {name: found[name] for name in self.levels}


@dataclass(frozen=True, slots=True, eq=False)
class Variables:
    """Parameters that vary: a distribution for each, and the rank correlations (Spearman) between some of them.

    Correlated parameters are joined by the normal copula. A Latin hypercube keeps its even parts only in the first of the
    parameters that are correlated.

    >>> from ridedown.studies.distributions import Normal, Uniform
    >>> both = {"stiffness": Normal(mean=10.0, sd=1.0), "slack": Uniform(lower=0.0, upper=1.0)}
    >>> drawn = Variables(both, {("stiffness", "slack"): 0.8}).columns(Sobol(2, seed=0).rows(0, 4096))
    >>> from scipy.stats import spearmanr
    >>> round(float(spearmanr(drawn["stiffness"], drawn["slack"]).statistic), 2)
    0.8
    """

    distributions: Mapping[str, Distribution]
    correlations: Mapping[tuple[str, str], float] = field(default_factory=dict)
    _root: Floats | None = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if not self.distributions:
            raise InvalidInput("parameters: got none; need at least one. Name what varies.")
        ranks = rank_matrix(tuple(self.distributions), self.correlations)
        root = np.linalg.cholesky(normal_matrix(ranks, tuple(self.distributions))) if self.correlations else None
        object.__setattr__(self, "_root", root)

    @property
    def names(self) -> tuple[str, ...]:
        """The parameters, in the order of the columns."""
        return tuple(self.distributions)

    def columns(self, unit: Floats) -> dict[str, Floats]:
        """Values of rows of the unit cube, (R, d): a column (R,) for each name, SI."""
        if self._root is not None:
            return self.columns_from_normal(ndtri(unit))
        return {name: one.ppf(unit[:, i]) for i, (name, one) in enumerate(self.distributions.items())}

    def columns_from_normal(self, z: Floats) -> dict[str, Floats]:
        """Values of rows of independent standard normals, (R, d): a column (R,) for each name, SI."""
        if self._root is not None:
            z = z @ self._root.T
        return {name: one.from_normal(z[:, i]) for i, (name, one) in enumerate(self.distributions.items())}


def check_correlation(
    one: str, other: str, rank: float, names: Sequence[str], given: Collection[frozenset[str]], where: str = "correlation"
) -> None:
    """Check a pair of parameters and their rank correlation, beside the pairs that are given already.

    Raises: UnknownName for a name that is not among the names; InvalidInput for a pair with itself or twice, or a correlation
    that is not between -1 and 1; each says `where`.
    """
    for name in (one, other):
        if name not in names:
            raise UnknownName.among(where, name, names)
    if one == other or frozenset((one, other)) in given:
        what = "itself" if one == other else f"{other} twice"
        raise InvalidInput(f"{where}: got {one} with {what}; need each pair of two parameters once. Take it out.")
    if not -1.0 < rank < 1.0:
        raise InvalidInput(
            f"{where}: got {rank:g} between {one} and {other}; need > -1 and < 1. "
            "Parameters that go wholly together are one parameter."
        )


def rank_matrix(names: Sequence[str], correlations: Mapping[tuple[str, str], float]) -> Floats:
    """The matrix (d, d) of pairs of names and their rank correlation.

    Raises: UnknownName and InvalidInput as `check_correlation` does.
    """
    matrix = np.eye(len(names))
    given: set[frozenset[str]] = set()
    for (one, other), value in correlations.items():
        check_correlation(one, other, value, names, given)
        given.add(frozenset((one, other)))
        i, j = names.index(one), names.index(other)
        matrix[i, j] = matrix[j, i] = value
    return matrix


def normal_matrix(ranks: Floats, names: Sequence[str]) -> Floats:
    """Correlations (d, d) of the normals whose ranks correlate as given: r = 2 sin(pi rho / 6).

    Raises: InvalidInput where no parameters can be so correlated, naming the pair that stands out most.
    """
    matrix: Floats = 2.0 * np.sin(np.pi / 6.0 * ranks)
    np.fill_diagonal(matrix, 1.0)
    values, vectors = np.linalg.eigh(matrix)
    if values[0] > 1e-10:
        return matrix
    # The quadratic form of this vector is not positive; the pair that pulls it down the most is the one to change.
    worst = vectors[:, 0]
    pulls = matrix * np.outer(worst, worst)
    np.fill_diagonal(pulls, np.inf)
    i, j = divmod(int(np.argmin(pulls)), len(names))
    raise InvalidInput(
        f"correlation: got {ranks[i, j]:g} between {names[i]} and {names[j]}, which the other correlations rule out; "
        f"need a positive definite matrix (its least eigenvalue is {values[0]:.3g}). Bring this one nearer to what they imply."
    )


def _middles(words: _WORDS) -> Floats:
    """The middles of the 2^52 cells of the unit interval that the upper bits name: never 0, never 1."""
    found: Floats = ((words >> np.uint64(12)).astype(np.float64) + 0.5) * 2.0**-52
    return found


def _permuted(numbers: _WORDS, size: int, keys: _WORDS) -> _WORDS:
    """Where a keyed permutation of 0 ... size - 1 puts the numbers, (R,)."""
    a = int(np.ceil(np.sqrt(size)))
    b = -(-size // a)
    found = numbers.copy()
    waiting = np.arange(found.size)
    # a b is barely more than the size, so that few have to be put on a second time
    while waiting.size:
        found[waiting] = _feistel(found[waiting], a, b, keys)
        waiting = waiting[found[waiting] >= size]
    return found


def _feistel(numbers: _WORDS, a: int, b: int, keys: _WORDS) -> _WORDS:
    """A permutation of 0 ... a b - 1: two digits, of which each in turn is moved on by a hash of the other."""
    left, right = np.divmod(numbers, np.uint64(b))  # left < a, right < b
    for i, key in enumerate(keys):
        if i % 2:
            right = (right + _hash(left, key) % np.uint64(b)) % np.uint64(b)
        else:
            left = (left + _hash(right, key) % np.uint64(a)) % np.uint64(a)
    found: _WORDS = left * np.uint64(b) + right
    return found


def _hash(numbers: _WORDS, key: np.uint64) -> _WORDS:
    """SplitMix64 (Steele, Lea, Flood 2014) of the numbers and a key."""
    with np.errstate(over="ignore"):
        z = (numbers ^ key) + np.uint64(0x9E3779B97F4A7C15)
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        return np.asarray(z ^ (z >> np.uint64(31)), dtype=np.uint64)


def _at_least_one(value: object, name: str) -> None:
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 1:
        raise InvalidInput(f"{name}: got {value!r}; need a whole number of 1 or more.")


def _check_range(start: int, stop: int) -> None:
    if not 0 <= start <= stop:
        raise InvalidInput(f"rows: got {start} to {stop}; need 0 <= start <= stop. Rows count from 0.")
