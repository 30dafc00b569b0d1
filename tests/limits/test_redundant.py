"""Which of several accelerometers is believed."""

from __future__ import annotations

import numpy as np
import pytest

from ridedown.limits.redundant import Sensor, choose

T = np.linspace(0.0, 0.3, 301)
STOP = -16.0 * np.minimum(T / 0.1, 1.0)


def sensor(name: str, side: str, drift: float = 0.0, kick: float = 0.0) -> Sensor:
    return Sensor(name, side, STOP + drift * T + np.where(T > 0.12, kick, 0.0))


def test_the_sensor_that_drifts_is_left_out_and_says_by_how_much() -> None:
    choice = choose([sensor("a", "left", drift=3.0), sensor("b", "right"), sensor("c", "left", drift=0.2)])
    assert choice.chosen == (1, 2)
    assert choice.rejected == (choice.rejected[0],)
    assert choice.rejected[0].startswith("a: 0.5")
    assert "0.87 m/s at the end" in choice.rejected[0]


def test_a_mount_that_moves_late_is_left_out() -> None:
    assert choose([sensor("a", "left", kick=1.0), sensor("b", "left"), sensor("c", "right")]).chosen == (1, 2)


def test_one_of_either_side_is_taken_even_where_two_of_one_side_agree_better() -> None:
    turning = 0.3 * np.sin(T / 0.05)
    left = [Sensor("a", "left", STOP + turning), Sensor("b", "left", STOP + turning)]
    choice = choose([*left, Sensor("c", "right", STOP - turning)])
    assert choice.chosen == (0, 2)


def test_without_sides_the_pair_that_agrees_best_is_taken_with_a_remark() -> None:
    choice = choose([sensor("a", "", drift=1.0), sensor("b", ""), sensor("c", "", drift=0.1)])
    assert choice.chosen == (1, 2)
    assert any("turning is not averaged out" in remark for remark in choice.remarks)


def test_a_pair_that_does_not_agree_is_called_doubtful() -> None:
    choice = choose([sensor("a", "left", drift=8.0), sensor("b", "right", drift=-8.0)])
    assert any("doubtful" in remark for remark in choice.remarks)
    assert not any("doubtful" in remark for remark in choose([sensor("a", "left"), sensor("b", "right", drift=0.1)]).remarks)


def test_a_single_sensor_is_taken_and_said_to_be_alone() -> None:
    choice = choose([sensor("a", "left", drift=9.0)])
    assert choice.chosen == (0,)
    assert "only sensor" in choice.remarks[0]


@pytest.mark.parametrize("order", [(0, 1, 2, 3), (3, 2, 1, 0), (2, 0, 3, 1)])
def test_the_order_of_the_channels_does_not_matter(order: tuple[int, ...]) -> None:
    all_of_them = [sensor("a", "left", drift=3.0), sensor("b", "right"), sensor("c", "left"), sensor("d", "right", drift=1.0)]
    mixed = [all_of_them[i] for i in order]
    assert {mixed[i].name for i in choose(mixed).chosen} == {"b", "c"}
