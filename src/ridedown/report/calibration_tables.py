"""A calibration as tables: parameters, channels, numbers, predictions, correlations."""

from __future__ import annotations

from collections.abc import Sequence

from ridedown.report.tables import NONE, Column, Table, number
from ridedown.studies import Calibrated
from ridedown.studies.calibration.fitted import FittedChannel, FittedNumber
from ridedown.studies.calibration.wording import in_words


def tables(found: Calibrated) -> tuple[Table, ...]:
    """All of them, in the order to read them in; those with no row are left out."""
    fitted, predicted = ([c for c in found.channels if c.fitted is kind] for kind in (True, False))
    made = (
        parameters(found),
        channels("Channels: model against measured", fitted),
        numbers("Numbers: model against what was asked", [n for n in found.numbers if n.fitted]),
        channels("Predicted channels, not fitted", predicted),
        numbers("Predicted numbers, not fitted", [n for n in found.numbers if not n.fitted]),
        posterior(found),
    )
    return tuple(table for table in made if table.rows)


def parameters(found: Calibrated) -> Table:
    """Each parameter with its band and bounds."""
    made, agreed = found.starts
    stopped = "; interrupted: the best so far" if found.interrupted else ""
    return Table(
        f"Parameters; {agreed} of {made} searches ended here, {found.tried} candidates{stopped}",
        (
            Column("Parameter", numeric=False),
            Column("Value"),
            Column("95 % band, from"),
            Column("to"),
            Column("Bounds", numeric=False),
            Column("Remark", numeric=False),
        ),
        tuple(
            (
                p.name,
                in_words(p.value, p.unit),
                in_words(p.low, p.unit),
                in_words(p.high, p.unit),
                f"{in_words(p.lower, p.unit)} to {in_words(p.upper, p.unit)}" + (" (log)" if p.by_ratio else ""),
                "at its bound" if p.at_bound else _noted(found, p.name),
            )
            for p in found.parameters
        ),
    )


def _noted(found: Calibrated, name: str) -> str:
    noted = [each for one in found.confounded for each in one.names]
    noted += found.beyond.names if found.beyond else ()
    return "see the notes" if name in noted else NONE


def channels(caption: str, found: Sequence[FittedChannel]) -> Table:
    """How each channel agrees with what was measured."""
    return Table(
        caption,
        (
            Column("Case", numeric=False),
            Column("Channel", numeric=False),
            Column("CFC"),
            Column("Window", "ms"),
            Column("ISO/TS 18571"),
            Column("Grade", numeric=False),
            Column("Peak"),
            Column("measured"),
            Column("error", "%"),
            Column("its time", "ms"),
            Column("RMS"),
            Column("In wide band", "%"),
        ),
        tuple(
            (
                c.case,
                c.name,
                number(c.cfc, 0),
                f"{number(c.times[0], 0, scale=1e3)}–{number(c.times[-1], 0, scale=1e3)}",
                number(None if c.rating is None else c.rating.value, 3),
                NONE if c.rating is None else c.rating.grade,
                in_words(c.peak.value, c.unit),
                NONE if c.measured_peak is None else in_words(c.measured_peak.value, c.unit),
                number(c.peak_error, 1, scale=100.0),
                number(c.peak_time_error, 1, scale=1e3),
                in_words(c.rms, c.unit),
                number(c.within, 0, scale=100.0),
            )
            for c in found
        ),
    ).without_empty_columns()


def numbers(caption: str, found: Sequence[FittedNumber]) -> Table:
    """Each number beside what it should be."""
    return Table(
        caption,
        (
            Column("Case", numeric=False),
            Column("Outcome", numeric=False),
            Column("Model"),
            Column("95 % band, from"),
            Column("to"),
            Column("Asked", numeric=False),
            Column("Met", numeric=False),
        ),
        tuple(
            (
                n.case,
                n.name,
                in_words(n.model, n.unit),
                in_words(n.low, n.unit),
                in_words(n.high, n.unit),
                _asked(n),
                NONE if n.met is None else ("yes" if n.met else "NO"),
            )
            for n in found
        ),
    ).without_empty_columns()


def correlations(found: Calibrated) -> Table:
    """Correlation of every two parameters."""
    names = [p.name for p in found.parameters]
    return Table(
        "Correlations of the parameters",
        (Column("Parameter", numeric=False), *(Column(str(i)) for i in range(1, len(names) + 1))),
        tuple(
            (f"{i}  {name}", *(number(float(value), 2) for value in row))
            for i, (name, row) in enumerate(zip(names, found.correlation, strict=True), 1)
        ),
    )


def posterior(found: Calibrated) -> Table:
    """Quantiles of the posterior, where it was sampled."""
    columns = (Column("Parameter", numeric=False), Column("2.5 %"), Column("50 %"), Column("97.5 %"))
    if found.posterior is None:
        return Table("", columns, ())
    drawn = found.posterior
    return Table(
        f"Posterior: {len(drawn.draws)} draws, {drawn.acceptance:.0%} accepted, tied over {drawn.autocorrelation:.0f} steps",
        columns,
        tuple((p.name, *(in_words(q, p.unit) for q in drawn.quantiles(p.name))) for p in found.parameters),
    )


def _asked(n: FittedNumber) -> str:
    if n.wanted is not None:
        sign = "within" if n.rounded else "\u00b1"
        return f"{in_words(n.wanted, n.unit)}" + ("" if n.sigma is None else f" {sign} {in_words(n.sigma, n.unit)}")
    said = [f"{word} {in_words(x, n.unit)}" for word, x in (("at least", n.least), ("at most", n.most)) if x is not None]
    return " and ".join(said) or NONE
