"""The same crash, put together from other parts or in another order."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ridedown import simulate
from ridedown.scenario import CrashScenario, NetworkScenario
from tests import samples
from tests.compare import SMALLEST, assert_alike, continuous
from tests.samples import examples

SEEDS = st.integers(0, 10**6)
FORCES = ("stiffness", "damping", "initial_force", "unloading_stiffness")
RTOL = 1e-8


def _share(element: dict[str, Any], part: float) -> dict[str, Any]:
    """An element with that part of its force."""
    shared = element | {key: part * element[key] for key in FORCES if key in element}
    if "pieces" in element:
        shared["pieces"] = [piece | {"stiffness": part * piece["stiffness"]} for piece in element["pieces"]]
    if "points" in element:
        shared["points"] = [[d, part * f] for d, f in element["points"]]
    return shared


@examples(25)
@given(seed=SEEDS, part=st.floats(0.05, 0.95))
def test_every_element_split_into_two_in_parallel(seed: int, part: float) -> None:
    data = samples.network_data(np.random.default_rng(seed), softening=False)
    halves = [
        _share(element, share) | {"name": f"{element['name']}{which}"}
        for element in data["elements"]
        for which, share in (("", part), ("b", 1.0 - part))
    ]
    whole, split = simulate(NetworkScenario(**data)), simulate(NetworkScenario(**data | {"elements": halves}))
    assert_alike(whole, split, rtol=RTOL)
    for element in data["elements"]:
        force = f"{element['name']}.force"
        total = split.peak(force).value / part
        assert total == pytest.approx(whole.peak(force).value, rel=RTOL, abs=RTOL * SMALLEST["N"] / part)


@examples(15)
@given(seed=SEEDS, part=st.floats(0.05, 0.95))
def test_right_and_left_member_share_as_they_may_where_nothing_turns(seed: int, part: float) -> None:
    rng = np.random.default_rng(seed)
    data = samples.crash_data(rng, softening=False)
    member = samples.member(rng, softening=False)
    data.get("bar", {}).pop("lateral_offset", None)
    data.get("bar", {}).pop("inertia", None)
    own = {key: data["vehicle1"][key] for key in ("mass", "speed")}
    even = CrashScenario(**data | {"vehicle1": own | {"members": member}})
    uneven = CrashScenario(
        **data | {"vehicle1": own | {"right": _share(member, 2 * part), "left": _share(member, 2 - 2 * part)}}
    )
    assert_alike(simulate(even), simulate(uneven), rtol=RTOL)


@examples(20)
@given(seed=SEEDS, shuffle=st.randoms(use_true_random=False))
def test_the_order_of_masses_and_elements(seed: int, shuffle: Any) -> None:
    data = samples.network_data(np.random.default_rng(seed), softening=False)
    other = {key: shuffle.sample(data[key], len(data[key])) for key in ("masses", "elements")}
    one, two = simulate(NetworkScenario(**data)), simulate(NetworkScenario(**data | other))
    assert_alike(one, two, rtol=RTOL)


@examples(20)
@given(seed=SEEDS)
def test_the_order_of_occupants(seed: int) -> None:
    data = samples.crash_data(np.random.default_rng(seed), softening=False)
    occupants = [{"name": f"o{i}", **occupant} for i, occupant in enumerate(data["occupants"])]
    one = simulate(CrashScenario(**data | {"occupants": occupants}), throw=False)
    two = simulate(CrashScenario(**data | {"occupants": occupants[::-1]}), throw=False)
    assert_alike(one, two, rtol=RTOL)


@examples(15)
@given(seed=SEEDS)
def test_uncoupled_occupants_do_not_know_of_each_other(seed: int) -> None:
    data = samples.crash_data(np.random.default_rng(seed), softening=False)
    occupants = [{"name": f"o{i}", **occupant, "coupled": False} for i, occupant in enumerate(data["occupants"])]
    together = simulate(CrashScenario(**data | {"occupants": occupants}), throw=False)
    alone = simulate(CrashScenario(**data | {"occupants": occupants[:1]}), throw=False)
    assert_alike(alone, together, rtol=RTOL, channels=continuous(alone))
