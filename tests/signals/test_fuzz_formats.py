"""Any bytes give a record or InvalidInput: 3,000 changed tests of each format with fixed seeds, and 300 of hypothesis' own.

The first 100,000 seeds of each were run by hand as well. They found one thing, three times over: a control character that
Python calls a blank before a number (seed 50,014 of ISO-MME).
"""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ridedown.errors import InvalidInput
from ridedown.signals import isomme_text
from ridedown.signals.ev5_curves import MAX_SAMPLES, Grid, read_curve
from ridedown.signals.isomme import read_isomme
from ridedown.signals.isomme_extras import amended, barrier, fields, filter_of, occupants, restraints
from ridedown.signals.record import ChannelInfo
from tests.signals.fuzzing import SOUND, MemoryTree, exercise, test_of

SEEDS = 3000


@pytest.mark.parametrize("kind", SOUND)
def test_changed_tests_are_read_or_refused(kind):
    accepted = sum(exercise(kind, test_of(SOUND[kind], seed)) is not None for seed in range(SEEDS))
    assert SEEDS // 10 < accepted < SEEDS  # the changes neither spare the readers nor stop them at the door


@pytest.mark.parametrize(("kind", "seed"), [("ISO-MME", 50_014)])
def test_what_the_long_run_found_stays_mended(kind, seed):
    exercise(kind, test_of(SOUND[kind], seed))


def test_a_control_character_before_a_value_is_refused_with_its_line():
    files = dict(SOUND["ISO-MME"])
    files["Channel/t7.001"] = files["Channel/t7.001"].replace(b"\n-1.25\n", b"\n\x1c1\n")
    record = read_isomme(MemoryTree(files))
    with pytest.raises(InvalidInput, match=r"t7\.001:17: got '1'; need one finite number"):
        record.history(1)


@settings(max_examples=300)
@given(kind=st.sampled_from(list(SOUND)), noise=st.binary(max_size=400), which=st.integers(0, 4), after=st.integers(0, 3000))
def test_noise_anywhere_is_read_or_refused(kind, noise, which, after):
    files = dict(SOUND[kind])
    name = sorted(files)[which % len(files)]
    files[name] = files[name][:after] + noise
    exercise(kind, files)


@given(st.text(max_size=300))
def test_any_json_under_our_keys_does_no_harm(text):
    for found in (occupants([text]), restraints([text])):
        assert isinstance(found, tuple)
    barrier(text)
    fields(text)
    filter_of(text)
    amended(ChannelInfo("1"), isomme_text.Descriptors(((".Meaning", text),), "t.001", (1,)))


@pytest.mark.parametrize(
    "text",
    [
        "[" * 50_000,
        '{"seat": "01", "official": {"HIC": {"value": 1e999}}}',
        '{"seat": "01", "official": {"HIC": {"value": NaN}}}',
        '{"seat": "01", "official": [1], "vehicle": true, "fields": {"a": 1}}',
        '{"seat": "01", "official": {"HIC": {"value": ' + "9" * 400 + "}}}",
        '{"steps": [{"class": -1}]}',
        '{"steps": [{"class": "a"}, 3]}',
    ],
)
def test_json_that_is_not_as_written_counts_as_not_there(text):
    for occupant in occupants([text]):
        assert occupant.official == {}
        assert occupant.vehicle == 1
    assert filter_of(text) is None
    assert restraints([text]) == () or restraints([text])[0].seat == "01"


def test_absurd_counts_in_a_header_cost_nothing():
    files = dict(SOUND["EV5"])
    files["v7.EV5"] = files["v7.EV5"].replace(b"|-2|3|100|", b"|-999999999|999999999|100|")
    record = exercise("EV5", files)
    assert "ends early" in record.faults()[-1] or "times" in " ".join(record.faults())


def test_absurd_lengths_are_refused():
    with pytest.raises(InvalidInput, match="need at most"):
        read_curve("1\n" * (MAX_SAMPLES + 1), Grid(0, 1, 1e-4), "v1.001")
