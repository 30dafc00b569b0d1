"""Figures of studies: what is drawn is what was given, in the units that are written, and what is said holds."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.contour import QuadContourSet
from matplotlib.text import Text

from ridedown import load
from ridedown.report import study_bound
from ridedown.report.study_axes import LIMIT, Bar, Quantity
from ridedown.report.study_designs import box_plot, progress_plot, rare_plot, slice_plot, tried_plot
from ridedown.report.study_optimise import front_plot, parallel_plot
from ridedown.report.study_sample import cumulative_plot, distribution_plot
from ridedown.report.study_sensitivity import Interval, effect_plot, index_plot, tornado_plot
from ridedown.report.study_sweep import carpet_plot, line_plot, map_plot
from ridedown.studies.bound import Design, bound_study

STIFFNESS, RATIO = Quantity("stiffness", "N/m"), Quantity("ratio", "")
WAY, PEAK = Quantity("excursion", "m"), Quantity("peak", "m/s2")
G = 9.80665


def axes_of(plot):
    return plot.figure.axes[0]


def labels_of(plot):
    return axes_of(plot).get_legend_handles_labels()[1]


def grids():
    k, z = np.linspace(20e3, 100e3, 9), np.linspace(0.1, 0.9, 5)
    stiff, damped = np.meshgrid(k, z, indexing="ij")
    return k, z, 100.0 / np.sqrt(stiff), G * (10.0 + stiff / 5e3 + 3.0 * damped)


# sweep


def test_line_is_in_order_and_in_its_units():
    plot = line_plot(STIFFNESS, WAY, [3e4, 1e4, 2e4, 4e4], [0.2, 0.4, 0.3, np.nan], limits=[Bar(0.25)])
    x, y = axes_of(plot).lines[0].get_data()
    np.testing.assert_allclose(x, [10.0, 20.0, 30.0])
    np.testing.assert_allclose(y, [400.0, 300.0, 200.0])
    assert "Least 200 mm at 30 kN/m, largest 400 mm at 10 kN/m." in plot.description
    assert "Limit, at most 250 mm: 1 of 3 rows keep to it." in plot.description
    assert axes_of(plot).get_xlabel() == "stiffness, kN/m"


def test_map_says_where_the_least_is_and_draws_the_limit():
    k, z, way, _ = grids()
    plot = map_plot(STIFFNESS, RATIO, WAY, k, z, way.T, limits=[Bar(0.5)])
    assert "Least 316.2 mm at 100 kN/m" in plot.description
    assert f"{int((way <= 0.5).sum())} of 45 rows keep to it" in plot.description
    assert "limit at most 500 mm; beyond is hatched" in [text.get_text() for text in axes_of(plot).texts]
    drawn = [c for c in axes_of(plot).collections if any(to_hex(e) == LIMIT.lower() for e in np.atleast_2d(c.get_edgecolor()))]
    assert drawn  # a line in the limit's colour
    assert plot.figure.axes[1].get_ylabel() == "excursion, mm"


@pytest.mark.parametrize("value", [0.3, np.nan])
def test_a_map_of_nothing_that_varies_is_no_error(value):
    plot = map_plot(STIFFNESS, RATIO, WAY, [1e4, 2e4], [0.1, 0.2], np.full((2, 2), value), limits=[Bar(0.2)])
    assert ("The same everywhere: 300 mm" in plot.description) or ("No row has it" in plot.description)


@pytest.mark.parametrize("size", [1e-18, 1e-8])
def test_a_map_of_rounding_is_one_of_nothing(size):
    turn = Quantity("turn", "rad")
    grid = size * np.array([[1.0, -1.0], [0.5, 0.0]])
    assert "The same everywhere" in map_plot(STIFFNESS, RATIO, turn, [1e4, 2e4], [0.1, 0.2], grid).description
    level = 0.3 * (1.0 + 1e-15 * np.array([[0.0, 1.0], [0.5, 0.0]]))
    assert "The same everywhere: 300 mm" in map_plot(STIFFNESS, RATIO, WAY, [1e4, 2e4], [0.1, 0.2], level).description


def test_a_map_has_no_hole_where_the_least_is_a_last_bit_below_a_level():
    force = Quantity("force", "N")
    grid = np.tile([5500.0, 5500.0, 5999.999999999996], (3, 1))  # as a load limiter holds its force
    grid[0, 0] = 5499.999999999999
    plot = map_plot(STIFFNESS, RATIO, force, [1e4, 2e4, 3e4], [0.1, 0.2, 0.3], grid)
    (filled,) = [c for c in axes_of(plot).collections if isinstance(c, QuadContourSet) and c.filled]
    assert any(path.contains_point((15.0, 0.2)) for path in filled.get_paths())


def test_failed_rows_leave_a_hole_in_a_map():
    k, z, way, _ = grids()
    way[0, 0] = np.nan
    plot = map_plot(STIFFNESS, RATIO, WAY, k, z, way.T)
    assert len(plot.svg) > 1000
    assert f"largest {WAY.text(float(np.nanmax(way)))}" in plot.description


def test_carpet_has_a_line_for_each_level_both_ways():
    k, z, way, peak = grids()
    plot = carpet_plot(STIFFNESS, RATIO, WAY, PEAK, (k, z), (way, peak), limits=([Bar(0.5)], [Bar(25.0 * G)]))
    lines = [line for line in axes_of(plot).lines if len(line.get_xdata()) > 2]
    assert len(lines) == 7 + 5  # of nine levels seven are drawn
    np.testing.assert_allclose(lines[0].get_xdata(), 1e3 * way[0])
    np.testing.assert_allclose(lines[-1].get_ydata(), peak[:, -1] / G)
    kept = int(((way <= 0.5) & (peak <= 25.0 * G)).sum())
    assert f"{kept} of 45 designs keep to the limits" in plot.description
    assert labels_of(plot)[:2] == ["same stiffness, kN/m", "same ratio"]


# sample


def test_distribution_has_area_one_and_marks_what_breaks_the_limit():
    values = np.random.default_rng(1).normal(0.3, 0.02, 50_000)
    said = ["exceeded by 2.3 % (2.2 to 2.4 %)"]
    plot = distribution_plot(WAY, values, limits=[Bar(0.34)], said=said, quantiles={0.5: 0.3})
    bars = axes_of(plot).patches
    assert sum(bar.get_height() * bar.get_width() for bar in bars) == pytest.approx(1.0, abs=2e-3)
    for bar in bars:
        assert (to_hex(bar.get_facecolor()) == LIMIT.lower()) == (bar.get_x() >= 340.0)
    assert "exceeded by 2.3 % (2.2 to 2.4 %)" in plot.description
    assert "50 % are at most 300 mm." in plot.description
    assert any("exceeded by 2.3 %" in text.get_text() for text in axes_of(plot).texts)


def test_cumulative_counts_the_rows_above():
    values = np.arange(1.0, 1001.0) / 1e3
    plot = cumulative_plot(WAY, values, limits=[Bar(0.9)])
    x, share = (np.asarray(data) for data in axes_of(plot).lines[0].get_data())
    np.testing.assert_allclose(share, 1.0 - x / 1001.0, rtol=1e-12)
    assert axes_of(plot).get_yscale() == "log"
    plot.figure.canvas.draw()
    assert "10 %" in [label.get_text() for label in axes_of(plot).get_yticklabels()]


@pytest.mark.parametrize("values", [[], [np.nan], [0.3, 0.3, 0.3]])
def test_a_distribution_of_nothing_is_no_error(values):
    assert distribution_plot(WAY, values, limits=[Bar(0.2)]).svg
    assert cumulative_plot(WAY, values, limits=[Bar(0.2)]).svg


# sensitivity


def test_indices_are_in_order_with_their_intervals():
    first = {"a": Interval(0.2, 0.15, 0.25), "b": Interval(0.6, 0.55, 0.65)}
    total = {"a": Interval(0.3, 0.25, 0.4), "b": Interval(0.7, 0.6, 0.8)}
    plot = index_plot("chest", first, total)
    assert [label.get_text() for label in axes_of(plot).get_yticklabels()] == ["b", "a"]
    assert [bar.get_width() for bar in axes_of(plot).patches] == [0.7, 0.3, 0.6, 0.2]
    low, high = axes_of(plot).collections[0].get_segments()[1][:, 0]
    assert (low, high) == pytest.approx((0.25, 0.4))
    assert "b total 0.700, first 0.600" in plot.description


def test_an_index_that_rounds_to_nothing_has_no_sign():
    nothing = {"belt": Interval(-1e-5, -2e-5, 1e-5), "bag": Interval(0.5, 0.4, 0.6)}
    assert "belt total 0.000, first 0.000" in index_plot("chest", nothing, nothing).description


def test_effects_are_in_the_units_of_the_outcome():
    plot = effect_plot(WAY, {"a": Interval(0.1, 0.08, 0.12)}, {"a": 0.03})
    assert axes_of(plot).patches[0].get_width() == pytest.approx(100.0)
    deviation = next(line for line in axes_of(plot).lines if line.get_marker() == "D")
    assert deviation.get_xdata()[0] == pytest.approx(30.0)


def test_tornado_compares_the_ends_of_each_parameter():
    rng = np.random.default_rng(3)
    strong, weak = rng.uniform(0.0, 1.0, 40_000), rng.uniform(0.0, 1.0, 40_000)
    plot = tornado_plot(WAY, {Quantity("weak"): weak, Quantity("strong"): strong}, strong + 0.1 * weak)
    assert [label.get_text() for label in axes_of(plot).get_yticklabels()] == ["strong", "weak"]
    widths = [bar.get_width() for bar in axes_of(plot).patches]
    np.testing.assert_allclose(widths, [-450.0, 450.0, -45.0, 45.0], atol=12.0)  # means of tenths, and of 4000 rows each


def test_values_beside_a_bar_without_length_are_both_legible():
    rng = np.random.default_rng(3)
    strong, idle = rng.uniform(20e3, 100e3, 2000), rng.uniform(0.1, 0.9, 2000)
    plot = tornado_plot(WAY, {STIFFNESS: strong, RATIO: idle}, strong / 1e5)
    plot.figure.canvas.draw()
    words = [Text.get_window_extent(text) for text in axes_of(plot).texts]
    assert len(words) == 4
    assert not any(one.overlaps(other) for one, other in combinations(words, 2))


def test_room_and_seat_back_are_named(bound):
    words = [text.get_text() for text in axes_of(study_bound.excursion_plot(bound)).texts]
    assert words == ["room in front, 250 mm", "seat back, 0 mm"]


@pytest.mark.parametrize("count", [2, 33])
def test_labels_of_contours_are_whole_and_apart(count):
    k, z = np.linspace(20e3, 100e3, count), np.linspace(0.1, 0.9, count)
    stiff, damped = np.meshgrid(k, z)
    plot = map_plot(STIFFNESS, RATIO, WAY, k, z, 0.3 + stiff / 1e6 + 0.2 * damped)
    plot.figure.canvas.draw()
    frame = axes_of(plot).get_window_extent()
    words = [text.get_window_extent() for text in axes_of(plot).texts]
    assert len(words) >= 5
    assert not any(one.overlaps(other) for one, other in combinations(words, 2))
    assert all(frame.x0 < one.x0 and one.x1 < frame.x1 and frame.y0 < one.y0 and one.y1 < frame.y1 for one in words)


def test_many_parameters_are_cut_and_that_is_said():
    total = {f"p{i}": Interval(i / 20, i / 20, i / 20) for i in range(20)}
    plot = index_plot("chest", total, total)
    assert len(axes_of(plot).get_yticks()) == 15
    assert "The 15 largest of 20." in plot.description


# optimise


def test_front_shows_the_chosen_and_the_built():
    points = [0.2, 0.3, 0.4], [300.0, 250.0, 220.0]
    plot = front_plot(WAY, PEAK, points, chosen=1, beside={"as built": (0.35, 290.0)}, bound=([0.2, 0.4], [150.0, 100.0]))
    assert labels_of(plot) == ["front", "no restraint can do better", "as built", "chosen"]
    chosen = next(line for line in axes_of(plot).lines if line.get_label() == "chosen")
    assert (chosen.get_xdata()[0], chosen.get_ydata()[0]) == pytest.approx((300.0, 250.0 / G))
    assert "Chosen: 300 mm, 25.49 g." in plot.description


def test_parallel_axes_go_from_the_least_to_the_largest():
    columns = [np.array([1e4, 3e4, 2e4]), np.array([0.5, 0.5, 0.5]), np.array([0.3, 0.1, 0.2])]
    plot = parallel_plot([STIFFNESS, RATIO, WAY], columns, chosen=1)
    lines = [line for line in axes_of(plot).lines if len(line.get_xdata()) == 3]
    assert len(lines) == 4
    np.testing.assert_allclose(lines[-1].get_ydata(), [1.0, 0.5, 0.0])
    texts = [text.get_text() for text in axes_of(plot).texts]
    assert {"10 kN/m", "30 kN/m", "100 mm", "300 mm"} <= set(texts)


# bound


@pytest.fixture(scope="module")
def bound():
    return bound_study(load("sled-half-sine"), np.linspace(0.05, 0.4, 8), designs=[Design("belt", 300.0, 0.25)])


def test_bound_curve_has_the_design_above_it(bound):
    plot = study_bound.curve_plot(bound)
    np.testing.assert_allclose(axes_of(plot).lines[0].get_ydata(), bound.peaks / G)
    assert labels_of(plot) == ["least possible", "the same with no seat behind", "belt", "OLC"]
    assert f"{100 * bound.gaps[0].ratio:.0f} %" in plot.description


def test_designs_that_are_close_to_each_other_are_told_apart(bound):
    near = [Design(f"belt {k}", 300.0 + 2.0 * k, 0.25 + 0.005 * k) for k in range(4)]
    plot = study_bound.curve_plot(bound_study(load("sled-half-sine"), np.linspace(0.05, 0.4, 8), designs=near))
    plot.figure.canvas.draw()
    words = [text for text in axes_of(plot).texts if text.get_text()]
    extents = [Text.get_window_extent(text) for text in words]
    assert len(words) >= 2
    assert not any(one.overlaps(other) for one, other in combinations(extents, 2))


def test_ideal_history_never_passes_the_bound(bound):
    plot = study_bound.history_plot(bound)
    vehicle, occupant = (np.asarray(line.get_ydata()) for line in axes_of(plot).lines[:2])
    assert occupant.max() == pytest.approx(bound.ideal.peak_g, rel=1e-12)
    assert vehicle.max() > occupant.max()
    place = np.asarray(axes_of(study_bound.excursion_plot(bound)).lines[0].get_ydata())
    assert place.max() <= 250.0 + 1e-6


def test_tables_of_a_bound(bound):
    (row,) = study_bound.table(bound).rows
    assert row[:3] == ("belt", "30.6", "250")
    assert len(study_bound.curve_table(bound).rows) == 8


# designs


def points_of(plot):
    """Points by the label of their group."""
    return {line.get_label(): np.array(line.get_xydata()) for line in axes_of(plot).get_lines()}


def test_designs_tried_are_told_apart_and_the_chosen_marked():
    stiffness, peaks = np.array([40e3, 60e3, 80e3]), G * np.array([20.0, 25.0, 30.0])
    plot = tried_plot(STIFFNESS, PEAK, stiffness, peaks, np.array([False, True, True]), (60e3, 25 * G))
    points = points_of(plot)
    np.testing.assert_allclose(points["holds all constraints"], [[60.0, 25.0], [80.0, 30.0]])
    np.testing.assert_allclose(points["breaks one"], [[40.0, 20.0]])
    np.testing.assert_allclose(points["chosen"], [[60.0, 25.0]])
    assert "2 hold all constraints" in plot.description
    assert axes_of(plot).get_xlabel() == "stiffness, kN/m"


def test_progress_counts_only_designs_that_hold_their_constraints():
    peaks, held = G * np.array([20.0, 40.0, 30.0, 35.0]), np.array([False, True, True, True])
    (line,) = axes_of(progress_plot(PEAK, 3 * np.arange(1, 5), peaks, held)).get_lines()
    np.testing.assert_allclose(line.get_xydata(), [[6.0, 40.0], [9.0, 30.0], [12.0, 30.0]])
    (line,) = axes_of(progress_plot(PEAK, np.arange(1, 5), peaks, held, largest=True)).get_lines()
    np.testing.assert_allclose(line.get_ydata(), [40.0, 40.0, 40.0])


def test_a_box_is_drawn_within_its_ranges():
    plot = box_plot({STIFFNESS: (40e3, 60e3), RATIO: (0.0, 0.5)}, {STIFFNESS: (20e3, 120e3), RATIO: (0.0, 1.0)})
    bars = [(bar.get_x(), bar.get_width()) for bar in axes_of(plot).patches]
    np.testing.assert_allclose(bars, [(0.0, 100.0), (20.0, 20.0), (0.0, 100.0), (0.0, 50.0)])
    assert "stiffness 40 kN/m to 60 kN/m of 20 kN/m to 120 kN/m" in plot.description
    assert "40 to 60 kN/m" in [text.get_text() for text in axes_of(plot).texts]


def test_a_cut_through_a_box_shows_which_limit_a_row_breaks():
    stiffness, ratio = np.array([30e3, 50e3, 110e3]), np.array([0.9, 0.3, 0.3])
    broken = {"way at most 200 mm": np.array([True, False, False]), "peak at most 30 g": np.array([True, False, True])}
    sides, ranges = ((40e3, 60e3), (0.0, 0.5)), ((20e3, 120e3), (0.0, 1.0))
    plot = slice_plot(STIFFNESS, RATIO, (stiffness, ratio), broken, sides, ranges)
    points = points_of(plot)
    np.testing.assert_allclose(points["holds all limits"], [[50.0, 0.3]])
    np.testing.assert_allclose(points["breaks way at most 200 mm"], [[30.0, 0.9]])  # of several the first
    np.testing.assert_allclose(points["breaks peak at most 30 g"], [[110.0, 0.3]])
    (box,) = axes_of(plot).patches
    assert (box.get_x(), box.get_width(), box.get_height()) == pytest.approx((40.0, 20.0, 0.5))
    assert axes_of(plot).get_title() == ""  # one title, on the left
    assert axes_of(plot).get_title(loc="left").startswith("A cut through the box")


def test_rows_of_a_rare_event_are_told_apart():
    stiffness, ratio = np.array([30e3, 50e3]), np.array([0.9, 0.3])
    plot = rare_plot(STIFFNESS, RATIO, (stiffness, ratio), np.array([True, False]), (40e3, 0.5), "way at most 350 mm")
    points = points_of(plot)
    np.testing.assert_allclose(points["beyond it"], [[30.0, 0.9]])
    np.testing.assert_allclose(points["the likeliest beyond it"], [[40.0, 0.5]])
    assert "1 of them beyond it" in plot.description


def test_many_points_are_thinned():
    rng = np.random.default_rng(0)
    x, y = rng.random(5000), rng.random(5000)
    plot = tried_plot(RATIO, RATIO, x, y, np.ones(5000, dtype=bool), (0.5, 0.5))
    assert 500 <= len(points_of(plot)["holds all constraints"]) <= 700
    assert len(plot.svg) < 300_000


# whatever the names


LONG = "driver.restraints.belt.load_limiter.second_force", "vehicle1.members.pieces.0.stiffness"
LONG_OUTCOMES = "offset.driver.chest.acceleration.peak_time", "weighted.driver.restraint.force.max"


def figures_with_long_names():
    x, y = (Quantity(name, "N/m") for name in LONG)
    a, b = Quantity(LONG_OUTCOMES[0], "s"), Quantity(LONG_OUTCOMES[1], "N")
    k, z, way, peak = grids()
    one = np.linspace(0.1, 0.9, 30)
    held, sides = one > 0.4, {x: (2e4, 2.1e4), y: (9.9e4, 10e4)}
    ranges = {x: (1e4, 10e4), y: (1e4, 10e4)}
    found = {name: Interval(0.5, 0.4, 0.6) for name in LONG}
    words = f"{a.name} at most 100 ms"
    return {
        "line": line_plot(x, a, one, one, limits=[Bar(0.5)]),
        "map": map_plot(x, y, a, k, z, way.T, limits=[Bar(0.5)]),
        "carpet": carpet_plot(x, y, a, b, (k, z), (way, peak), limits=([Bar(0.5)], [Bar(25.0 * G)])),
        "distribution": distribution_plot(a, one, limits=[Bar(0.8)], said=["exceeded by 2.3 % (2.2 to 2.4 %)"]),
        "cumulative": cumulative_plot(a, one, limits=[Bar(0.8)]),
        "index": index_plot(a.name, found, found),
        "effect": effect_plot(a, found, dict.fromkeys(LONG, 0.1)),
        "tornado": tornado_plot(a, {x: one, y: one[::-1]}, one),
        "front": front_plot(a, b, ([0.2, 0.3], [300.0, 250.0]), chosen=1, beside={"as built": (0.25, 290.0)}),
        "parallel": parallel_plot([x, y, a, b] * 2, [one, one, one, one] * 2, chosen=0),
        "tried": tried_plot(x, a, one, one, held, (0.5, 0.5)),
        "progress": progress_plot(a, np.linspace(0.0, 17.6e6, 30), one, held),
        "box": box_plot(sides, ranges),
        "slice": slice_plot(x, y, (1e5 * one, 1e5 * one), {words: held}, tuple(sides.values()), tuple(ranges.values())),
        "rare": rare_plot(x, y, (one, one), held, (0.5, 0.5), words),
    }


def texts_of(figure):
    for axes in figure.axes:
        yield from (axes.title, axes.xaxis.label, axes.yaxis.label, *axes.texts)
        yield from (axes._left_title, axes._right_title)  # matplotlib has no public way to them
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            places = zip(axis.get_majorticklocs(), axis.get_majorticklabels(), strict=True)
            yield from (label for place, label in places if low <= place <= high)
        if (legend := axes.get_legend()) is not None:
            yield from legend.get_texts()


@pytest.mark.parametrize("kind", figures_with_long_names())
def test_no_words_are_cut_off_however_long_the_names(kind):
    figure = figures_with_long_names()[kind].figure
    figure.canvas.draw()
    whole, renderer = figure.bbox, figure.canvas.get_renderer()
    for text in texts_of(figure):
        if not text.get_text() or not text.get_visible():
            continue
        extent = Text.get_window_extent(text, renderer)
        assert whole.x0 <= extent.x0, text
        assert extent.x1 <= whole.x1, text
        assert whole.y0 <= extent.y0, text
        assert extent.y1 <= whole.y1, text
    axes = figure.axes[0]
    if axes.get_ylabel():
        low, high = sorted(axes.get_ylim())
        ticks = zip(axes.get_yticks(), axes.get_yticklabels(), strict=True)
        beside = axes.yaxis.label.get_window_extent(renderer)
        assert not any(beside.overlaps(text.get_window_extent(renderer)) for at, text in ticks if low <= at <= high)
