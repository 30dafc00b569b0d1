"""Solution boxes in polytopes of which the largest box is known."""

import numpy as np
import pytest

from ridedown.errors import InvalidInput
from ridedown.studies.analysis.box import solution_box
from ridedown.studies.analysis.evaluation import Limit

UNIT = {"a": (0.0, 1.0), "b": (0.0, 1.0)}


def bad_share_of(box, model, limit):
    rows = np.random.default_rng(99).random((200_000, len(box.ranges)))
    table = {name: low + rows[:, i] * (high - low) for i, (name, (low, high)) in enumerate(box.ranges.items())}
    return float((limit.excess(model(table)[limit.outcome]) > 0.0).mean())


@pytest.mark.parametrize(
    ("size", "corner", "share"),
    [("volume", (0.25, 0.5), 0.125), ("shortest-side", (1 / 3, 1 / 3), 1 / 9)],
)
def test_the_largest_box_under_a_line(size, corner, share):
    def model(table):
        return {"sum": 2.0 * table["a"] + table["b"]}

    limit = Limit("sum", most=1.0)
    found = solution_box(model, UNIT, [limit], size=size, rows=128, rounds=60, seed=0)
    assert found.share == pytest.approx(share, rel=0.03)
    assert [high for _, high in found.ranges.values()] == pytest.approx(
        corner, abs=0.06
    )  # the volume is flat about its largest
    assert all(low == 0.0 for low, _ in found.ranges.values())
    assert found.binding == ("sum <= 1",)
    assert found.verified == 368  # ln(0.05 / 2) / ln(0.99)
    assert bad_share_of(found, model, limit) < found.bad_share <= 0.01


def test_three_parameters_of_their_own_units_and_one_that_is_free():
    def model(table):
        return {"sum": table["k"] / 100e3 + table["s"] / 0.1 + 0.0 * table["m"]}

    ranges = {"k": (0.0, 100e3), "s": (0.0, 0.1), "m": (50.0, 100.0)}
    limit = Limit("sum", most=1.0)
    found = solution_box(model, ranges, [limit], rows=128, rounds=60, seed=0)
    assert found.free == ("m",)
    assert found.ranges["m"] == (50.0, 100.0)
    assert found.share == pytest.approx(0.25, rel=0.03)
    assert bad_share_of(found, model, limit) < 0.01


def test_an_island_is_found_and_two_limits_bind():
    def model(table):
        return {"low": table["a"] + table["b"], "high": table["a"] - table["b"]}

    # |a - 0.7| + |b - 0.3| < 0.1 or so: a small rhombus, of which the largest box is the square of half its area
    limits = [Limit("low", most=1.1), Limit("low", least=0.9), Limit("high", most=0.5), Limit("high", least=0.3)]
    found = solution_box(model, UNIT, limits, rows=128, rounds=60, seed=0)
    assert found.share == pytest.approx(0.01, rel=0.06)
    assert set(found.binding) == {limit.rule for limit in limits}


def test_more_parameters():
    ranges = {f"x{i}": (0.0, 1.0) for i in range(6)}

    def model(table):
        return {"sum": sum(table.values())}

    limit = Limit("sum", most=3.0)
    found = solution_box(model, ranges, [limit], rows=128, rounds=50, seed=0)
    assert found.share > 0.5**6  # the largest box wholly good; with less than a hundredth bad it may be larger
    assert bad_share_of(found, model, limit) < 0.01


def test_the_confidence_is_earned():
    # over many seeds, boxes that were verified hold what they state as often as they state
    broken = 0
    for seed in range(10):
        found = solution_box(
            lambda t: {"d": (t["a"] - 0.5) ** 2 + (t["b"] - 0.5) ** 2},
            UNIT,
            [Limit("d", most=0.1)],
            rows=64,
            rounds=10,
            bad_share=0.02,
            confidence=0.9,
            seed=seed,
        )
        assert found.verified > 0
        broken += (
            bad_share_of(found, lambda t: {"d": (t["a"] - 0.5) ** 2 + (t["b"] - 0.5) ** 2}, Limit("d", most=0.1))
            > found.bad_share
        )
    assert broken <= 3  # of 10 at 90 %, more than 3 once in eighty times


def test_nothing_good_and_all_failed():
    found = solution_box(lambda t: {"y": t["a"]}, UNIT, [Limit("y", most=-1.0)], rows=64, rounds=5, seed=0)
    assert (found.ranges, found.share, found.verified) == ({}, 0.0, 0)
    assert "No design was found" in found.warnings[0]
    lost = solution_box(lambda t: {"y": np.full(t["a"].size, np.nan)}, UNIT, [Limit("y", most=1.0)], rows=64, rounds=5, seed=0)
    assert lost.ranges == {}
    assert lost.failed == lost.evaluations > 0


def test_failed_rows_are_bad():
    found = solution_box(lambda t: {"y": np.where(t["a"] > 0.5, np.nan, 0.0)}, UNIT, [Limit("y", most=1.0)], rounds=30, seed=0)
    assert found.ranges["a"][1] <= 0.505
    assert found.free == ("b",)


def test_same_seed_same_box_whatever_the_batch():
    def found(seed, batch):
        return solution_box(
            lambda t: {"y": t["a"] * t["b"]}, UNIT, [Limit("y", most=0.3)], rows=32, rounds=5, seed=seed, batch=batch
        )

    assert found(0, 13) == found(0, 10_000)
    assert found(0, 13) != found(1, 13)


def test_refuses():
    for options, sentence in (
        ({"size": "area"}, "size: got 'area'; need volume or shortest-side"),
        ({"bad_share": 0.0}, "bad_share: got 0.0"),
        ({"rows": 1}, "rows: got 1"),
    ):
        with pytest.raises(InvalidInput, match=sentence):
            solution_box(lambda t: {"y": t["a"]}, UNIT, [Limit("y", most=1.0)], **options)
    with pytest.raises(InvalidInput, match="limits: got none"):
        solution_box(lambda t: {"y": t["a"]}, UNIT, [])
