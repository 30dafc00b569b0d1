"""Networks put together by hand, and their channels."""

from __future__ import annotations

import numpy as np
import pytest

from ridedown.errors import UnknownName
from ridedown.network import Builder, Curve, Family, KelvinVoigt, Law, Linear, Network, Threshold, channels
from ridedown.network.channels import find


def crash(**speed: float | np.ndarray) -> Network:
    """A car at a wall, a child in a seat in it, and a bar that the car's front has an arm on."""
    builder = Builder()
    car = builder.body("car", mass=1500.0, speed=speed.get("car", 10.0))
    seat = builder.body("seat", mass=5.0, speed=10.0, parent=car)
    child = builder.body("child", mass=18.0, speed=11.0, parent=seat)
    bar = builder.bar("bar", inertia=157.0, conjugate=False)
    builder.element("front", Curve((0.0, 0.3), (5e3, 35e3), (1e5, 4e5)), deflection={car: 1.0}, lever=(bar, -0.9))
    builder.element("back", Curve((0.0,), (0.0,), (1e5,), unloading=1e6), deflection={car: 1.0})
    builder.element("harness", Threshold(49e3, 900.0, 0.005), deflection={child: 1.0, seat: -1.0})
    builder.element("mount", KelvinVoigt(50e3, 500.0), deflection={seat: 1.0, car: -1.0}, acts_on=(seat,))
    builder.element("tether", Linear(1e3), deflection={child: 1.0, car: -1.0})
    return builder.build(duration=0.2)


def terms(network: Network, e: int) -> dict[str, float]:
    span = slice(int(network.term_start[e]), int(network.term_start[e + 1]))
    names = [network.coordinates[i] for i in network.term_coordinate[span]]
    return dict(zip(names, network.term_sign[span].tolist(), strict=True))


def test_deflections_are_in_relative_coordinates() -> None:
    network = crash()
    # what two bodies have in common drops out: a slack is met without cancellation
    assert terms(network, 0) == {"car": 1.0}
    assert terms(network, 2) == {"child": 1.0}
    assert terms(network, 3) == {"seat": 1.0}
    assert terms(network, 4) == {"child": 1.0, "seat": 1.0}


def test_rates_are_relative_too() -> None:
    network = crash()
    np.testing.assert_array_equal(network.rate[:, 0], [10.0, 0.0, 1.0, 0.0])
    assert network.chain(2) == [2, 1, 0]


def test_laws_and_their_numbers() -> None:
    network = crash()
    assert [Law(law) for law in network.law] == [Law.ELASTIC, Law.PLASTIC, Law.THRESHOLD, Law.KELVIN_VOIGT, Law.LINEAR]
    np.testing.assert_array_equal(network.piece_start, [0, 2, 3, 3, 3, 3])
    np.testing.assert_array_equal(network.stiffness[:, 0], [0.0, 1e6, 49e3, 50e3, 1e3])
    assert network.lever.tolist() == [3, -1, -1, -1, -1]
    assert network.is_rotation.tolist() == [False, False, False, True]


def test_uncoupled_elements_act_on_some() -> None:
    network = crash()
    start = network.reaction_start
    acted_on = [network.reaction_coordinate[start[e] : start[e + 1]].tolist() for e in range(5)]
    assert acted_on == [[0], [0], [2, 1], [1], [2, 0]]


def test_columns_and_single_values() -> None:
    assert crash().size == 1
    many = crash(car=np.array([10.0, 12.0, 14.0]))
    assert many.size == 3
    np.testing.assert_array_equal(many.rate[0], [10.0, 12.0, 14.0])
    np.testing.assert_array_equal(many.rate[1], [0.0, -2.0, -4.0])  # the seat keeps its own speed
    np.testing.assert_array_equal(many.duration, [0.2] * 3)
    assert crash().widened(4).rate.shape == (4, 4)
    assert many.widened(3) is many


def test_channels_of_every_kind() -> None:
    known = channels(crash())
    assert known["child.relative_displacement"].terms == ((Family.POSITION, 2, 1.0),)
    assert known["child.excursion"].terms == ((Family.POSITION, 2, 1.0), (Family.POSITION, 1, 1.0))
    assert len(known["child.velocity"].terms) == 3
    assert known["bar"].unit == "rad"
    assert known["bar_rate"].unit == "rad/s"
    assert known["front.force"].unit == "N"
    assert "car.excursion" not in known
    assert len(known) == 2 + 3 + 2 * 7 + 5 * 3


def test_an_unknown_channel_offers_the_nearest() -> None:
    with pytest.raises(UnknownName, match=r"child\.excursion"):
        find(channels(crash()), "child.excusion")
