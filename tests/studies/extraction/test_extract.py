"""Fronts that are known are found again in the tests that they give, with noise; and what cannot be extracted is refused."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from ridedown import load, simulate
from ridedown.errors import InvalidInput
from ridedown.scenario import CrashScenario, NetworkScenario
from ridedown.scenario.member import ForceDeflection
from ridedown.scenario.networks import Tie
from ridedown.signals.history import TimeHistory
from ridedown.signals.record import Barrier, ChannelInfo, TestRecord, Vehicle
from ridedown.studies.extraction.extract import Extraction, _cut, extract
from ridedown.studies.extraction.fit import FOLLOWED, Misfit, measured_curve, pieces_of, refined, scale_of
from ridedown.studies.extraction.measured import wall_test
from ridedown.studies.extraction.model import one_mass as form_of_one_mass
from ridedown.studies.extraction.model import two_masses as form_of_two_masses
from ridedown.studies.extraction.model import unloading_curve
from tests.studies.extraction import walls


def force(curve: ForceDeflection, at: np.ndarray) -> np.ndarray:
    """A curve's force at deflections [m]."""
    forces: np.ndarray = np.interp(at, *np.array(curve.points).T)
    return forces


def reach(curve: ForceDeflection) -> float:
    """Deflection of a curve's last point [m]."""
    return float(np.array(curve.points)[-1, 0])


def with_channels(
    record: TestRecord, curves: dict[str, TimeHistory], infos: dict[str, ChannelInfo] | None = None
) -> TestRecord:
    """A record in which some channels have other curves, and some are new."""

    def load_other(asked: ChannelInfo) -> TimeHistory:
        return curves[asked.key] if asked.key in curves else record.history(asked)

    return replace(record, channels={**record.channels, **(infos or {})}, load=load_other)


@pytest.fixture(scope="module")
def two() -> Extraction:
    """The made test of cabin and engine, 2 % of noise on every channel."""
    return extract(walls.record(walls.two_masses(), noise=0.02, seed=3))


class TestTwoMassesFoundAgain:
    def test_the_engine(self, two: Extraction) -> None:
        assert two.two is not None
        assert two.two.engine_mass == pytest.approx(walls.ENGINE, rel=0.03)

    def test_curves_and_unloading(self, two: Extraction) -> None:
        truth = {element.name: element for element in walls.two_masses().elements if element.law == "curve"}
        assert set(two.best.curves) == set(truth)
        for name, curve in two.best.curves.items():
            at = np.linspace(0.0, 0.98 * reach(curve), 50)
            wanted, got = force(truth[name], at), force(curve, at)
            rms = np.sqrt(np.mean((got - wanted) ** 2)) / wanted.max()
            assert rms < 0.05, name
            assert curve.unloading_stiffness == pytest.approx(truth[name].unloading_stiffness, rel=0.2), name

    def test_mounts(self, two: Extraction) -> None:
        mounts = next(element for element in two.best.scenario.elements if isinstance(element, Tie))
        assert mounts.damping == pytest.approx(6e3, rel=0.1)
        assert mounts.stiffness == pytest.approx(80e3, rel=0.2)

    def test_it_reproduces_the_test(self, two: Extraction) -> None:
        model, test = two.best.simulated, two.test
        assert model.crush == pytest.approx(test.crush, rel=0.005)
        assert model.stop == pytest.approx(test.stop, abs=0.0005)
        assert model.rebound == pytest.approx(test.rebound, rel=0.03)
        assert two.best.cabin.value > 0.95
        assert two.best.barrier.value > 0.95
        assert two.warnings == ()

    def test_one_mass_cannot_follow_the_wall(self, two: Extraction) -> None:
        assert two.one.barrier.value < two.two.barrier.value - 0.1

    def test_the_same_seed_finds_the_same(self, two: Extraction) -> None:
        again = extract(walls.record(walls.two_masses(), noise=0.02, seed=3))
        assert again.toml == two.toml


@pytest.mark.parametrize("seed", [0, 1, 3])
def test_without_engine_channels_the_engine_is_found_too(seed: int) -> None:
    found = extract(walls.record(walls.two_masses(), noise=0.02, seed=seed), engine=())
    assert found.test.engine is None
    assert found.best.engine_mass == pytest.approx(walls.ENGINE, rel=0.05)
    assert found.best.cabin.value > 0.9
    assert found.best.barrier.value > 0.9
    assert any("no engine channel" in text for text in found.warnings)


@pytest.fixture(scope="module")
def found() -> Extraction:
    """The made test of one mass, 2 % of noise on its two channels."""
    return extract(walls.record(walls.one_mass(), noise=0.02, barrier=False))


class TestOneMassFoundAgain:
    def test_curve_and_unloading(self, found: Extraction) -> None:
        assert found.two is None
        truth = walls.one_mass().vehicle1.right
        curve = found.best.curves["front"]
        at = np.linspace(0.0, reach(curve), 50)
        wanted = 2.0 * force(truth, at)
        assert np.sqrt(np.mean((force(curve, at) - wanted) ** 2)) < 0.05 * wanted.max()
        assert curve.unloading_stiffness == pytest.approx(2.0 * truth.unloading_stiffness, rel=0.05)

    def test_few_pieces(self, found: Extraction) -> None:
        assert len(found.best.scenario.vehicle1.right.points) <= 4

    def test_reached(self, found: Extraction) -> None:
        assert found.one.simulated.crush == pytest.approx(found.test.crush, rel=0.005)
        assert found.one.simulated.rebound == pytest.approx(found.test.rebound, rel=0.02)


def test_more_pieces_only_where_asked_for() -> None:
    record = walls.record(walls.two_masses(), barrier=False)
    one = extract(record, pieces=1)
    assert len(one.best.scenario.vehicle1.right.points) == 2
    assert any("rating" in text for text in one.warnings) == (one.one.cabin.value < 0.8)


def test_the_file_loads_runs_and_names_its_source(two: Extraction) -> None:
    scenario = load(tomllib.loads(two.toml))
    assert isinstance(scenario, NetworkScenario)
    assert scenario == two.best.scenario
    response = simulate(scenario)
    assert response.maximum("cabin.displacement").value == two.best.simulated.crush
    (source,) = scenario.sources
    assert (source.title, source.confidence) == ("a made wall test", "reconstructed")
    assert "made" in source.where
    assert two.toml.startswith("# Crush ")
    assert f"{two.best.barrier.value:.3f}" in two.toml


def test_only_points_that_were_reached_are_kept_and_the_response_stays() -> None:
    points = [(0.0, 2e4), (0.2, 9e4), (0.45, 11e4), (0.9, 3e5)]
    whole = load({"vehicle1": {"mass": 1500.0, "speed": 15.0, "members": unloading_curve(points, 6e6)}})
    crush = simulate(whole).maximum("vehicle1.right.deflection").value
    cut = _cut(whole.vehicle1.right, crush)["points"]
    assert cut[:3] == points[:3]
    assert cut[3][0] == pytest.approx(crush, rel=1e-4)
    assert _cut(whole.vehicle1.right, 0.9001)["points"] == points  # beyond the last point
    assert _cut(whole.vehicle1.right, 0.9)["points"] == points
    close = _cut(whole.vehicle1.right, 0.455)["points"]  # a point just before the end goes
    assert [d for d, _ in close] == [0.0, 0.2, 0.455]


def test_momentum_tells_that_the_data_belong_together(two: Extraction) -> None:
    assert two.momentum.ratio == pytest.approx(1.0, abs=0.03)  # the engine still moves a little when the cabin stands
    assert two.momentum.implied_mass == pytest.approx(walls.MASS, rel=0.03)


class TestWrongMass:
    def test_a_little_wrong_is_warned_of(self) -> None:
        test = wall_test(walls.record(walls.one_mass()), mass=1.08 * walls.MASS)
        assert test.barrier is not None
        assert test.momentum.implied_mass == pytest.approx(walls.MASS, rel=0.005)
        assert any("kg would agree" in text for text in test.warnings)

    def test_another_than_the_record_says_is_taken_and_said(self) -> None:
        test = wall_test(walls.record(walls.one_mass()), mass=0.8 * walls.MASS, speed=1.1 * walls.SPEED)
        assert (test.mass, test.speed) == (0.8 * walls.MASS, 1.1 * walls.SPEED)
        for name, asked, recorded in (("mass", test.mass, walls.MASS), ("speed", test.speed, walls.SPEED)):
            (said,) = [text for text in test.warnings if text.startswith(f"{name}: {asked:.5g}")]
            assert f"the record says {recorded:.5g}" in said
        near = wall_test(walls.record(walls.one_mass()), mass=1.02 * walls.MASS)
        assert not any(text.startswith("mass") for text in near.warnings)

    def test_far_wrong_leaves_the_wall_out(self) -> None:
        found = extract(walls.record(walls.two_masses()), mass=2000.0)
        assert found.two is None
        assert any("not used" in text for text in found.warnings)
        assert isinstance(found.best.scenario, CrashScenario)

    def test_then_two_masses_are_refused(self) -> None:
        with pytest.raises(InvalidInput, match="masses: got 2 without the force on the wall"):
            extract(walls.record(walls.two_masses()), mass=2000.0, masses=2)


class TestRecordsThatEndEarly:
    def test_before_standstill(self) -> None:
        with pytest.raises(InvalidInput, match="still moves at"):
            wall_test(walls.record(walls.one_mass(), until=0.06))

    def test_before_the_rebound(self) -> None:
        found = extract(walls.record(walls.one_mass(), barrier=False, until=0.08))
        assert found.test.rebound is None
        assert any("restitution of 0.15 is assumed" in text for text in found.warnings)
        assert found.best.simulated.crush == pytest.approx(found.test.crush, rel=0.02)
        assert load(tomllib.loads(found.toml)) == found.best.scenario

    def test_beginning_late(self) -> None:
        record = walls.record(walls.one_mass(), barrier=False)
        late = [history.replaced(start=0.01) for _, history in record.readable()]
        with pytest.raises(InvalidInput, match="from the first contact"):
            wall_test(TestRecord.of([late[0]], identifier="late"), mass=1500, speed=15, channels=["seat_crossmember_left"])


class TestChannels:
    def test_none_found(self) -> None:
        with pytest.raises(InvalidInput, match="channels: got none that can be used"):
            wall_test(TestRecord.of([walls_history()], identifier="table"), mass=1500, speed=15)

    def test_named(self) -> None:
        test = wall_test(TestRecord.of([walls_history()], identifier="table"), mass=1500, speed=15, channels=["cabin"])
        assert test.used == ("cabin",)
        assert test.crush == pytest.approx(simulate(walls.one_mass()).maximum("vehicle1.displacement").value, rel=2e-3)

    def test_of_the_wrong_sign(self) -> None:
        history = walls_history()
        turned = history.replaced(values=-history.values)
        with pytest.raises(InvalidInput, match="Turn the sign"):
            wall_test(TestRecord.of([turned], identifier="table"), mass=1500, speed=15, channels=["cabin"])

    def test_that_differ(self) -> None:
        history = walls_history()
        drifting = history.replaced(values=history.values - 5.0 * (history.time > 0.0), name="drifting")
        record = TestRecord.of([history, drifting], identifier="table")
        test = wall_test(record, mass=1500, speed=15, channels=["cabin", "drifting"])
        assert any("does one drift" in text for text in test.warnings)

    def test_a_drifting_sensor_is_left_out(self) -> None:
        record = walls.record(walls.one_mass(), noise=0.001)
        good = record.history("1")
        third = good.replaced(values=good.values - 3.0 * (good.time > 0.0))
        info = replace(record.channel("1"), key="9", name="third")
        test = wall_test(with_channels(record, {"9": third}, {"9": info}))
        assert test.used == ("1", "2")
        assert any("channel 9" in text for text in test.notes)

    def test_an_engine_sensor_that_breaks_is_left_out(self) -> None:
        record = walls.record(walls.two_masses())
        broken = record.history("3")
        broken = broken.replaced(values=broken.values - 400.0 * (broken.time > 0.02))
        test = wall_test(with_channels(record, {"3": broken}))
        assert any("not used: engine channel 3" in text for text in test.notes)
        assert test.engine is not None


class TestMissingHeader:
    def test_mass(self) -> None:
        with pytest.raises(InvalidInput, match="mass: got nothing"):
            wall_test(walls.record(walls.one_mass(), header={"vehicles": (Vehicle(1, speed=15.0),)}))

    def test_speed(self) -> None:
        with pytest.raises(InvalidInput, match="speed: got nothing"):
            wall_test(walls.record(walls.one_mass(), header={"vehicles": (Vehicle(1, mass=1500.0),)}))

    def test_mass_that_is_none(self) -> None:
        with pytest.raises(InvalidInput, match="mass: got -1 kg"):
            wall_test(walls.record(walls.one_mass()), mass=-1.0)


class TestKindsOfTest:
    @pytest.mark.parametrize(
        ("fields", "said"),
        [
            ({"TSTCNF": "VTV"}, "two vehicles"),
            ({"TSTCNF": "ITV"}, "kind ITV"),
            ({"IMPANG": "90"}, "90 degrees"),
        ],
    )
    def test_refused(self, fields: dict[str, str], said: str) -> None:
        with pytest.raises(InvalidInput, match=said):
            wall_test(walls.record(walls.one_mass(), header={"fields": fields}))

    def test_two_vehicles_refused(self) -> None:
        vehicles = (Vehicle(1, mass=1500.0, speed=15.0), Vehicle(2, mass=1500.0, speed=15.0))
        with pytest.raises(InvalidInput, match="two vehicles"):
            wall_test(walls.record(walls.one_mass(), header={"vehicles": vehicles}))

    @pytest.mark.parametrize(("kind", "mass"), [("D", None), ("R", 1400.0)])
    def test_barriers_that_give_way_refused(self, kind: str, mass: float | None) -> None:
        barrier = Barrier(kind=kind, mass=mass)
        with pytest.raises(InvalidInput, match="fixed rigid wall"):
            wall_test(walls.record(walls.one_mass(), header={"barrier": barrier}))

    @pytest.mark.parametrize("fields", [{"OFFSET": "600"}, {"IMPANG": "30"}, {"IMPANG": "330"}])
    def test_offset_and_angle_warned_of(self, fields: dict[str, str]) -> None:
        test = wall_test(walls.record(walls.one_mass(), header={"fields": fields}))
        assert len(test.warnings) == 1

    def test_a_title_that_says_offset_warned_of(self) -> None:
        test = wall_test(walls.record(walls.one_mass(), header={"title": "40 % Offset, rigid"}))
        assert any("offset" in text for text in test.warnings)


class TestBarrierFile:
    def test_one_total(self) -> None:
        record = walls.record(walls.one_mass())
        wall = record.history("3").replaced(values=-record.history("3").values, name="total")  # either sign
        apart = TestRecord.of([wall], identifier="wall")
        test = wall_test(walls.record(walls.one_mass(), barrier=False), barrier=apart)
        assert test.barrier is not None
        assert test.momentum.ratio == pytest.approx(1.0, abs=0.01)

    def test_several_without_meaning_refused(self) -> None:
        wall = walls.record(walls.one_mass()).history("3")
        apart = TestRecord.of([wall, wall.renamed("other")], identifier="wall")
        with pytest.raises(InvalidInput, match="barrier: got the force channels"):
            wall_test(walls.record(walls.one_mass(), barrier=False), barrier=apart)

    def test_load_cells_are_added_up(self) -> None:
        record = walls.record(walls.one_mass())
        half = record.history("3").replaced(values=0.5 * record.history("3").values)
        second = replace(record.channel("3"), key="4", number=4)
        cells = with_channels(record, {"3": half, "4": half}, {"4": second})
        whole, added = wall_test(record), wall_test(cells)
        np.testing.assert_allclose(added.barrier, whole.barrier, rtol=0.0, atol=1e-6 * whole.barrier.max())

    def test_a_missing_load_cell_leaves_no_total(self) -> None:
        record = walls.record(walls.one_mass())
        infos = {**record.channels, "4": replace(record.channel("3"), key="4", number=4, readable=False)}
        test = wall_test(replace(record, channels=infos))
        assert test.barrier is None
        assert any("1 of 2 load cells" in text for text in test.notes)


class TestSteps:
    def test_pieces_stop_where_the_curve_is_followed(self) -> None:
        x = np.linspace(0.0, 0.7, 200)
        knots, forces = pieces_of(x, np.where(x < 0.3, 1e5, 3e5) + 1e4 * np.sin(80.0 * x), 8)
        assert knots.size <= 5
        off = np.interp(x, knots, forces) - (np.where(x < 0.3, 1e5, 3e5) + 1e4 * np.sin(80.0 * x))
        assert np.sqrt(np.mean(off**2)) <= 1.1 * FOLLOWED * 3.1e5

    def test_a_cut_leaves_the_curves_as_they_were(self) -> None:
        scale = scale_of(wall_test(walls.record(walls.two_masses())))
        form, numbers = form_of_two_masses(scale, 0.2, 0.4, 0.2, np.array([0.1, 0.5, 0.4]))
        before = form.scenario(numbers)
        cuts = list(form.splits(numbers, 8))
        assert len(cuts) == 6  # two pieces of each of three curves
        for finer, more, new in cuts:
            for old, element in zip(before.elements, finer.scenario(more).elements, strict=True):
                if element.law == "curve":
                    at = np.linspace(0.0, 1.0, 300)
                    np.testing.assert_allclose(force(element, at), force(old, at), rtol=1e-9, atol=1e-3)
            moved = more.copy()
            moved[new] += 0.1
            assert finer.scenario(moved) != finer.scenario(more)

    def test_the_table_and_the_scenario_hold_the_same_numbers(self) -> None:
        test = wall_test(walls.record(walls.one_mass(), barrier=False))
        form, numbers = form_of_one_mass(scale_of(test), np.array([0.0, 0.4, 1.0]), np.array([0.1, 0.5, 0.9]), 1.5)
        members = form.scenario(numbers).vehicle1.right
        table = form.columns(numbers[np.newaxis])
        assert members.points is not None
        assert members.points[1] == (table["vehicle1.members.points.1.0"][0], table["vehicle1.members.points.1.1"][0])
        assert members.unloading_stiffness == table["vehicle1.members.unloading_stiffness"][0]

    def test_least_squares_makes_the_misfit_less(self) -> None:
        test = wall_test(walls.record(walls.one_mass(), barrier=False))
        form, numbers = form_of_one_mass(scale_of(test), np.array([0.0, 0.5, 1.0]), np.array([0.2, 0.4, 0.9]), 1.5)
        misfit = Misfit(test, with_barrier=False)
        before = misfit(form, numbers[np.newaxis])[0]
        after = refined(misfit, form, numbers, 30)
        assert after.cost < 0.1 * float(before @ before)
        assert misfit.rms(after.misfit) < 0.05

    def test_the_measured_curve_is_mass_times_deceleration(self) -> None:
        test = wall_test(walls.record(walls.one_mass(), barrier=False))
        deflections, forces = measured_curve(test)
        assert deflections[-1] == test.crush
        assert np.trapezoid(forces, deflections) == pytest.approx(0.5 * test.mass * test.speed**2, rel=0.02)


@pytest.mark.parametrize(
    ("given", "said"),
    [({"masses": 3}, "masses: got 3"), ({"pieces": 0}, "pieces: got 0"), ({"seed": -1}, "seed: got -1; need a whole number")],
)
def test_options_that_may_not_be(given: dict[str, int], said: str) -> None:
    with pytest.raises(InvalidInput, match=said):
        extract(walls.record(walls.one_mass(), barrier=False), **given)


@pytest.mark.parametrize("field", ["channels", "engine"])
def test_channels_along_another_axis_are_refused(field: str) -> None:
    cabin = walls_history()
    across = cabin.replaced(name="across", code="11SEBELE0000ACYA")
    record = TestRecord.of([cabin, across], identifier="wall")
    given: dict[str, Any] = {"channels": ["cabin"], field: ["across"]}
    with pytest.raises(InvalidInput, match=f"{field}: got 'across', along y; need an acceleration along x"):
        extract(record, mass=1500.0, speed=14.0, **given)


def walls_history() -> TimeHistory:
    """The cabin of the made test of one mass, alone, with no meaning but its name."""
    return walls.record(walls.one_mass(), barrier=False).history("1").renamed("cabin")
