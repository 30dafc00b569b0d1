"""One crash and many: what goes in, what is refused, and where the work is done."""

from __future__ import annotations

import signal
import time
from typing import Any

import numpy as np
import pytest

from ridedown import load, simulate, simulate_many
from ridedown.errors import InvalidInput, SimulationStopped, UnknownName
from ridedown.scenario import substitute

PEAK = ["adult.acceleration.peak"]


def test_columns_and_single_numbers() -> None:
    p1 = load("p1")
    columns = simulate_many(p1, {"vehicle1.speed": [10.0, 12.0], "vehicle2.speed": [11.0, 11.0]}, outcomes=PEAK)
    mixed = simulate_many(p1, {"vehicle1.speed": [10.0, 12.0], "vehicle2.speed": 11.0}, outcomes=PEAK)
    np.testing.assert_array_equal(columns[PEAK[0]], mixed[PEAK[0]])
    one = simulate_many(p1, {"vehicle1.speed": 10.0, "vehicle2.speed": 11.0}, outcomes=PEAK)
    assert one[PEAK[0]].shape == (1,)
    assert one[PEAK[0]][0] == columns[PEAK[0]][0]


def test_no_table_is_one_crash() -> None:
    assert simulate_many(load("p1"), {}, outcomes=PEAK)[PEAK[0]].shape == (1,)


def test_no_rows() -> None:
    many = simulate_many(load("p1"), {"vehicle1.speed": []}, outcomes=PEAK)
    assert many[PEAK[0]].shape == (0,)
    assert many.failures() == {}


def test_whole_numbers_and_other_arrays() -> None:
    whole = simulate_many(load("p1"), {"vehicle1.speed": np.array([10, 12])}, outcomes=PEAK)
    single = simulate_many(load("p1"), {"vehicle1.speed": np.array([10.0, 12.0], dtype=np.float32)}, outcomes=PEAK)
    strided = simulate_many(load("p1"), {"vehicle1.speed": np.array([10.0, 0.0, 12.0, 0.0])[::2]}, outcomes=PEAK)
    np.testing.assert_array_equal(whole[PEAK[0]], single[PEAK[0]])
    np.testing.assert_array_equal(whole[PEAK[0]], strided[PEAK[0]])


def test_duration_may_differ_from_row_to_row() -> None:
    many = simulate_many(load("p1"), {"duration": [0.05, 0.1, 0.2]}, outcomes=["vehicle1.displacement.final"])
    np.testing.assert_allclose(many.time, [0.05, 0.1, 0.2], rtol=1e-15)
    response = simulate(load("p1"))
    at = response.at("vehicle1.displacement", [0.05, 0.1, 0.2])
    np.testing.assert_allclose(many["vehicle1.displacement.final"], at, rtol=1e-9)


def test_ragged_columns_are_refused() -> None:
    with pytest.raises(InvalidInput, match=r"vehicle2\.speed: got 3 rows; need 2, as in vehicle1\.speed"):
        simulate_many(load("p1"), {"vehicle1.speed": [10.0, 12.0], "vehicle2.speed": [1.0, 2.0, 3.0]})


@pytest.mark.parametrize("column", [["fast", "slow"], [[1.0, 2.0], [3.0]], object()])
def test_what_is_not_a_column_of_numbers_is_refused(column: object) -> None:
    with pytest.raises(InvalidInput, match=r"vehicle1\.speed: got .*; need a column of numbers"):
        simulate_many(load("p1"), {"vehicle1.speed": column})


def test_a_matrix_is_refused() -> None:
    with pytest.raises(InvalidInput, match=r"shape \(2, 2\); need a column"):
        simulate_many(load("p1"), {"vehicle1.speed": np.ones((2, 2))})


def test_an_unknown_path_is_answered_with_the_nearest() -> None:
    with pytest.raises(UnknownName, match=r"adult\.restraint\.stiffness"):
        simulate_many(load("p1"), {"adult.restraint.stifness": [1.0]})


@pytest.mark.parametrize("bad", [-1.0, 0.0, np.nan, np.inf])
def test_a_bad_row_is_named_before_anything_is_solved(bad: float) -> None:
    masses = np.full(5000, 1500.0)
    masses[4321] = bad
    with pytest.raises(InvalidInput, match=r"vehicle1\.mass.*4321"):
        simulate_many(load("p1"), {"vehicle1.mass": masses})


@pytest.mark.parametrize("threads", [0, -1, 1.5, True, "two"])
def test_threads_are_counted(threads: Any) -> None:
    with pytest.raises(InvalidInput, match="threads: got"):
        simulate_many(load("p1"), {}, threads=threads)


def test_what_stops_raises_with_the_part_computed() -> None:
    gives_way = substitute(load("p1"), {f"vehicle{n}.members.pieces.1.stiffness": 0.0 for n in (1, 2)})
    with pytest.raises(SimulationStopped, match=r"stopped at [\d.]+ ms: the bumper bar turned") as stopped:
        simulate(gives_way)
    assert 0.0 < stopped.value.response.end_time < 0.2
    assert simulate(gives_way, throw=False).end_time == stopped.value.response.end_time


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="no such timers here")
@pytest.mark.parametrize("threads", [1, 2])
def test_an_interrupt_is_heard_while_many_are_solved(threads: int) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    slow = {"duration": np.full(30_000, 10.0), "child.seat.mass": 0.003, "bar.inertia": 1e4}  # a minute of them
    before = signal.signal(signal.SIGALRM, interrupt)
    try:
        begin = time.monotonic()
        signal.setitimer(signal.ITIMER_REAL, 1.0)
        with pytest.raises(KeyboardInterrupt):
            simulate_many(load("p1"), slow, outcomes=PEAK, threads=threads)
        assert time.monotonic() - begin < 8.0
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def test_the_same_crash_twice_is_the_same_to_the_last_bit() -> None:
    one, two = simulate(load("example-offset")), simulate(load("example-offset"))
    times = np.linspace(0.0, 0.2, 57)
    for channel in one.channels:
        np.testing.assert_array_equal(one.at(channel, times), two.at(channel, times))
    assert one.events == two.events
