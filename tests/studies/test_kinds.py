"""Studies whose rows follow from one another or from no crash: bounds, optimisations, solution boxes, rare events."""

from __future__ import annotations

import numpy as np
import pytest

from ridedown import load, simulate
from ridedown.errors import InvalidInput, UnknownName
from ridedown.studies import query, run_study
from ridedown.studies.bound import Design, bound_study, gap_of
from ridedown.studies.results import finite
from ridedown.studies.store import read_manifest, read_results
from tests.studies.small import contents

BOUND = {
    "kind": "bound",
    "name": "Sled",
    "scenario": "sled-half-sine",
    "bound": {
        "excursions": ["100 mm", "200 mm", 0.3],
        "occupants": ["adult"],
        "designs": [{"name": "belt", "peak": "30 g", "excursion": "250 mm"}],
    },
}


def test_a_bound_study_is_what_bound_study_finds_and_is_kept_like_any_other(tmp_path):
    folder = run_study(BOUND, tmp_path / "out")
    sled = load("sled-half-sine")
    designs = [gap_of(simulate(sled), "adult"), Design("belt", 30 * 9.80665, 0.25)]
    direct = bound_study(sled, [0.1, 0.2, 0.3], designs=designs, name="Sled")
    said = read_results(folder)
    assert said is not None
    assert said["bound"] == finite(direct.as_json())
    rows = query(folder, "SELECT excursion, peak, peak_without_seat FROM results ORDER BY row").to_pydict()
    assert rows == {"excursion": [0.1, 0.2, 0.3], "peak": list(direct.peaks), "peak_without_seat": list(direct.unlimited)}
    assert {one["name"]: one["unit"] for one in read_manifest(folder)["columns"]}["peak"] == "m/s2"
    before = contents(folder)
    next((folder / "chunks").iterdir()).unlink()
    run_study(BOUND, folder, resume=True)
    assert contents(folder) == before
    assert read_results(folder) == said


def test_a_bound_of_a_crash_without_a_seat(tmp_path):
    options = {"grid": {"start": 0.1, "stop": "30 cm", "count": 2}, "seat": False, "slack": "50 mm", "vehicle": "vehicle2"}
    said = read_results(run_study({"kind": "bound", "scenario": "p1", "bound": options}, tmp_path / "out"))
    direct = bound_study(simulate(load("p1")), [0.1, 0.3], vehicle="vehicle2", rearward=np.inf, slack=0.05, name="p1")
    assert said is not None
    assert said["bound"] == finite(direct.as_json())


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"excursion": 0.3}, r"bound\.excursions: got nothing"),
        ({"excursions": [0.2, 0.1]}, "do not rise"),
        ({"excursions": [0.2]}, "two or more"),
        ({"excursions": ["1 kg", 0.2]}, r"bound\.excursions\.0: got \"1 kg\", a mass"),
        ({"excursions": [0.2, 0.3], "ocupants": ["adult"]}, r"bound\.ocupants.*\"occupants\""),
        ({"excursions": [0.2, 0.3], "occupants": ["adlt"]}, r"bound\.occupants\.0.*'adult'"),
        ({"excursions": [0.2, 0.3], "vehicle": "vehicle2"}, r"bound\.vehicle.*'vehicle1'"),
        ({"excursions": [0.2, 0.3], "slack": 0.25}, "more than the slack"),
        ({"grid": {"start": 0.4, "stop": 0.3, "count": 3}}, r"bound\.grid\.start"),
        ({"grid": {"start": 0.1, "stop": 0.3, "cuont": 3}}, r"bound\.grid\.cuont.*\"count\""),
    ],
)
def test_what_does_not_fit_a_bound_is_refused_before_anything_is_written(tmp_path, options, said):
    with pytest.raises((InvalidInput, UnknownName), match=said):
        run_study({**BOUND, "bound": options}, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_bound_has_no_parameters_and_no_one_else_a_bound(tmp_path):
    varied = [{"path": "adult.restraint.stiffness", "values": ["60 kN/m"]}]
    with pytest.raises(InvalidInput, match="parameters"):
        run_study({**BOUND, "parameters": varied}, tmp_path / "out")
    with pytest.raises(InvalidInput, match=r"\[bound\] with kind"):
        run_study({**BOUND, "kind": "sweep", "parameters": varied}, tmp_path / "out")
