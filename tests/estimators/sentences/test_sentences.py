"""Sentences: formats of places, the way through pickle and JSON, and what the words become meanwhile."""

import copy
import json
import pickle
from pathlib import Path

import numpy as np
import pytest

from estimators.errors import CalibrationError
from estimators.sentences import Catalogue, Sentence, for_json
from estimators.sentences._message import parsed
from messages import messages_in

FORMATS = json.loads((Path(__file__).parents[2] / "data" / "sentence_formats.json").read_text())
ENGLISH = messages_in("en")
WORDS = Catalogue(
    {
        **ENGLISH,
        "test.moved": "The {place, code, place} moved by {angle_rad, number, deg}.",
        "test.again": "{count, plural, one {Repeat {count} step.} other {Repeat {count} steps.}}",
        "test.failed": "That failed: {reason}",
    }
)


@pytest.mark.parametrize(("words", "value", "expected"), FORMATS)
def test_a_place_is_written_in_its_format(words, value, expected):
    value = WORDS.restored(value)
    assert Catalogue({**ENGLISH, "test": words}).say("test", x=value) == expected


def test_a_sentence_is_text_that_knows_its_code():
    moved = WORDS.say("test.moved", place="forearm_left", angle_rad=np.float64(0.2))
    assert moved == "The left forearm moved by 11°."
    assert for_json(moved) == {
        "code": "test.moved",
        "params": {"place": "forearm_left", "angle_rad": 0.2},
        "text": "The left forearm moved by 11°.",
    }
    assert CalibrationError(moved).message is moved


@pytest.mark.parametrize(
    "text",
    [
        "the sensor's place",
        "{}",
        "{x",
        "x}",
        "{x, date}",
        "{x, select, other {a}}",
        "{x, plural, one {a}}",
        "{x, plural, one {a other {b}}",
        "{x, plural, one {a} other {b}",
        "{x, number, '{'}",
    ],
)
def test_what_is_no_message_is_refused(text):
    with pytest.raises(ValueError, match="not a message"):
        parsed(text)


@pytest.mark.parametrize(
    "way",
    [
        copy.deepcopy,
        lambda s: pickle.loads(pickle.dumps(s)),
        lambda s: WORDS.restored(json.loads(json.dumps(for_json(s)))),
    ],
)
def test_a_sentence_comes_back_from_copies_pickle_and_json(way):
    inner = WORDS.say("test.moved", place="pelvis", angle_rad=0.1)
    outer = WORDS.say("test.failed", reason=inner)
    back = way(outer)
    assert isinstance(back, Sentence)
    assert isinstance(back.parameters["reason"], Sentence)
    assert back == outer
    assert for_json(back) == for_json(outer)


@pytest.mark.parametrize("angle_rad", [np.inf, -np.inf, np.nan, np.float32("inf")])
def test_what_is_no_number_goes_through_json_and_is_not_zero(angle_rad):
    said = WORDS.say("test.moved", place="pelvis", angle_rad=angle_rad)
    sent = json.dumps(for_json(said), allow_nan=False)
    back = WORDS.restored(json.loads(sent))
    assert (back, back.code) == (said, "test.moved")
    np.testing.assert_equal(float(json.loads(sent)["params"]["angle_rad"]), float(angle_rad))


def test_stored_sentences_take_todays_words_and_keep_theirs_when_the_code_is_gone():
    stored = for_json(WORDS.say("test.again", count=2))
    later = Catalogue({"test.again": "{count, plural, one {Once more.} other {{count} more.}}"})
    assert later.restored(stored) == "2 more."
    assert Catalogue({}).restored(stored) == "Repeat 2 steps."
    assert Catalogue({}).restored(["Plain."]) == ["Plain."]


def test_several_sentences_are_said_as_one():
    once, twice = WORDS.say("test.again", count=1), WORDS.say("test.again", count=2)
    assert WORDS.together([]) == ""
    assert WORDS.together([once, ""]) is once
    both = WORDS.together([once, twice])
    assert both == "Repeat 1 step. Repeat 2 steps."
    assert isinstance(both, Sentence)


@pytest.mark.parametrize("parameters", [{}, {"place": "pelvis"}])
def test_a_missing_parameter_is_refused(parameters):
    with pytest.raises(KeyError):
        WORDS.say("test.moved", **parameters)
