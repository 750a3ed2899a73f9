"""Hostile input: faults under laws, and random sequences; `aspect-control safety` runs all of them."""

import json

import numpy as np
import pytest

from aspect_control import controllers
from aspect_control.studies.safety import FAULTS, hostile_sequence, hostile_sequences, safety_table
from aspect_control.views import safety_report

SEQUENCES = 300


@pytest.fixture(scope="module")
def sequences():
    return hostile_sequences(SEQUENCES, seed=5)


def test_no_bound_is_broken_in_hostile_sequences(sequences):
    assert sequences.broken == []
    assert sequences.sequences == SEQUENCES
    assert set(sequences.laws) == {*controllers.available(), "thrashing"}
    assert set(sequences.faults) == {"none", *(fault.name for fault in FAULTS)}
    assert sequences.positioned > SEQUENCES / 4
    assert sequences.states["running"] + sequences.states["limiting"] < SEQUENCES / 4


def test_a_sequence_depends_on_the_seed_and_its_index_alone():
    assert hostile_sequence(5, 17) == hostile_sequence(5, 17)
    assert hostile_sequence(5, 17) != hostile_sequence(6, 17)
    assert hostile_sequences(1, seed=5, first=17).faults == {hostile_sequence(5, 17).fault: 1}


@pytest.mark.parametrize("law", ["jmdc"])
def test_every_fault_ends_bounded_in_a_stop_with_the_reason(law):
    words = {
        "q and v in degrees": "q is in degrees",
        "target in millimetres": "the target is in millimetres",
        "q and v swapped": "q and v are swapped",
        "start beyond a joint limit": "outside its limits",
        "posture of another target": "the posture does not belong to the target",
        "target out of reach": "the target is out of reach",
        "path out of reach": "would reach",
        "never reset": "was not reset",
        "target jumps by 0.5 m": "the target jumps by 0.5 m",
        "q in degrees from the middle on": "the measured position leaps",
        "q and v swapped from the middle on": "the measured position leaps",
        "q is not a number": "q must be finite",
        "target is none": "target must be a Target",
        "samples repeated": "the same sample has come 6 times",
        "four of five samples lost": "the clock runs away",
        "the law raises an exception": "a mistake in the law",
    }
    rows = safety_table(laws=[law])
    assert [row.fault for row in rows] == list(words) == [fault.name for fault in FAULTS]
    for row in rows:
        assert row.state in ("stopping", "stopped"), row
        assert words[row.fault] in row.reason, row
        assert row.share <= 1.0, row
        assert row.torque < 50.0, row
        assert np.isfinite(row.bare_torque), row
    assert max(row.bare_torque for row in rows) > 1e4


def test_the_report_has_a_row_a_fault_and_one_a_fault_and_law(sequences):
    rows = safety_table(laws=["pseudoinverse"], faults=FAULTS[:2])
    text = safety_report(rows, sequences)
    assert text.count("| q and v in degrees |") == 2
    assert f"{SEQUENCES} sequences of" in text
    assert "a bound was broken in 0 of them" in text
    json.dumps({"rows": [row.to_dict() for row in rows], "random": sequences.to_dict()}, allow_nan=False)
