"""Words at the ends of lines: none lies over another, each is at its own line, and what has no place is told."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from matplotlib.text import Text

from ridedown.report.study_axes import Bar, Quantity
from ridedown.report.study_sweep import carpet_plot
from ridedown.report.style import new_axes
from ridedown.report.tags import Tag, place_tags

STIFFNESS, RATIO = Quantity("stiffness", "N/m"), Quantity("ratio", "")
WAY, PEAK = Quantity("excursion", "m"), Quantity("peak", "m/s2")
G = 9.80665


def extents_of(axes):
    renderer = axes.figure.canvas.get_renderer()
    return [Text.get_window_extent(word, renderer) for word in axes.texts]


def assert_legible(axes):
    """No two words over each other, and none beyond the axes."""
    axes.figure.canvas.draw()
    frame = axes.get_window_extent()
    extents = extents_of(axes)
    for one, other in combinations(extents, 2):
        assert not one.overlaps(other)
    for extent in extents:
        assert frame.x0 <= extent.x0 <= extent.x1 <= frame.x1
        assert frame.y0 <= extent.y0 <= extent.y1 <= frame.y1


@pytest.mark.parametrize("limits", [((), ()), ([Bar(0.5)], [Bar(25.0 * G)])])
@pytest.mark.parametrize(("stiffnesses", "ratios"), [(3, 3), (12, 12), (3, 12), (12, 3)])
def test_labels_of_a_carpet_never_overlap(stiffnesses, ratios, limits):
    k, z = np.linspace(20e3, 100e3, stiffnesses), np.linspace(0.1, 0.9, ratios)
    stiff, damped = np.meshgrid(k, z, indexing="ij")
    grids = 100.0 / np.sqrt(stiff), G * (10.0 + stiff / 5e3 + 3.0 * damped)
    plot = carpet_plot(STIFFNESS, RATIO, WAY, PEAK, (k, z), grids, limits=limits)
    axes = plot.figure.axes[0]
    assert_legible(axes)
    drawn = min(stiffnesses, 7) + min(ratios, 7)
    unnamed = sum(int(said.split(" of the ")[0]) for said in plot.description.split("no room to name ")[1:])
    assert len(axes.texts) == drawn - unnamed
    assert len(axes.texts) >= 0.7 * drawn
    assert {STIFFNESS.text(k[0], unit=False), STIFFNESS.text(k[-1], unit=False)} <= {word.get_text() for word in axes.texts}
    assert ("7 of 12 values of ratio are drawn." in plot.description) == (ratios == 12)


def fan(count, apart):
    """Lines from the left that end above each other, so many pixels apart."""
    axes = new_axes("a fan", xlabel="x", ylabel="y")
    axes.set_xlim(0.0, 10.0)
    axes.set_ylim(0.0, 300.0)
    step = 300.0 * apart / axes.get_window_extent().height
    tags = [Tag(f"line {k}", np.array([0.0, 7.0]), np.array([150.0, 60.0 + k * step]), "#000000") for k in range(count)]
    for tag in tags:
        axes.plot(tag.x, tag.y)
    return axes, tags


def test_a_word_is_at_the_end_of_its_own_line():
    axes, tags = fan(6, 20.0)
    assert place_tags(axes, [tags]) == ()
    assert_legible(axes)
    ends = axes.transData.transform([(tag.x[-1], tag.y[-1]) for tag in tags])
    for word, extent in zip(axes.texts, extents_of(axes), strict=True):
        middle = 0.5 * (extent.x0 + extent.x1), 0.5 * (extent.y0 + extent.y1)
        assert int(word.get_text().split()[1]) == int(np.argmin(np.hypot(*(ends - middle).T)))
        assert not word.arrow_patch.get_visible()  # next to its end it needs no leader line


def test_where_ends_crowd_the_outermost_are_named_and_the_others_told():
    axes, tags = fan(9, 4.0)
    left_out = place_tags(axes, [tags])
    assert_legible(axes)
    named = [word.get_text() for word in axes.texts]
    assert {"line 0", "line 8"} <= set(named)
    assert len(named) + len(left_out) == 9
    assert {tag.text for tag in left_out}.isdisjoint(named)
    assert left_out


def test_lines_that_end_in_one_point_are_all_named_about_it():
    axes, _ = fan(0, 1.0)
    tags = [Tag(f"line {k}", np.array([0.0, 5.0]), np.array([y, 150.0]), "#000000") for k, y in enumerate((0.0, 150.0, 300.0))]
    assert place_tags(axes, [tags]) == ()
    assert_legible(axes)


def test_a_line_without_values_has_no_word():
    axes, _ = fan(0, 1.0)
    gone = Tag("gone", np.array([np.nan, 1.0]), np.array([1.0, np.nan]), "#000000")
    ends_early = Tag("early", np.array([0.0, 5.0, 6.0]), np.array([100.0, 100.0, np.nan]), "#000000")
    assert place_tags(axes, [[gone, ends_early]]) == ()
    assert [word.get_text() for word in axes.texts] == ["early"]
    assert axes.texts[0].xy == (5.0, 100.0)
