"""What the 3D says of sensors that give nothing: one label for all, names as everywhere else."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.viewer.layers.words import words_in
from app.viewer.pose import SEGMENTS, measured_segments, track_from_frames
from app.viewer.scene import BodyScene
from app.viewer.stage import LoopbackServer
from estimators.body import BodyDimensions
from estimators.conventions import PLACEMENTS, SHOE_PLACEMENTS
from estimators.sentences import CATALOGUE

PAGE_WORDS = Path(__file__).resolve().parents[3] / "web" / "src" / "i18n" / "en" / "motion.ts"


def labels_seen(server, names=re.compile(r"/(lost|silent)$")):
    handles = server.scene._handle_from_node_name
    return [handle.text for name, handle in handles.items() if names.search(name) and handle.visible]


def test_one_label_when_nothing_comes_at_all(reaches) -> None:
    frames, _, _ = reaches
    track = track_from_frames(frames, BodyDimensions())
    measured = measured_segments(frames)
    server = LoopbackServer()
    try:
        scene = BodyScene(server, BodyDimensions(), measured)

        def say(lost: set[str]) -> list[str]:
            mask = np.tile([name in lost for name in SEGMENTS], (len(track), 1))
            scene.draw(replace(track, lost=mask), 0)
            return labels_seen(server)

        assert say(set()) == []
        assert say({"sternum"}) == ["Chest: no signal"]
        assert [type(one) for one in labels_seen(server)] == [str], (
            "the wire carries nothing that is only like text"
        )
        assert say(set(measured)) == ["No data from the sensors"]
        assert say({"sternum"}) == ["Chest: no signal"], "the others came back"
    finally:
        server.stop()


def test_the_picture_speaks_the_language_of_its_page(reaches) -> None:
    frames, _, _ = reaches
    track = track_from_frames(frames, BodyDimensions())
    measured = measured_segments(frames)
    server = LoopbackServer()
    try:
        scene = BodyScene(server, BodyDimensions(), measured, words=words_in("de"))
        for lost, said in (
            ({"sternum"}, "Brust: kein Signal"),
            (set(measured), "Keine Daten von den Sensoren"),
        ):
            mask = np.tile([name in lost for name in SEGMENTS], (len(track), 1))
            scene.draw(replace(track, lost=mask), 0)
            assert labels_seen(server) == [said]
            assert [type(one) for one in labels_seen(server)] == [str]
    finally:
        server.stop()


@pytest.mark.parametrize("placement", [*PLACEMENTS, *SHOE_PLACEMENTS])
def test_the_service_names_a_place_as_the_browser_does(placement: str) -> None:
    said = re.search(rf"'placement\.{placement}': '([^']+)'", PAGE_WORDS.read_text(encoding="utf-8"))
    assert said is not None
    assert CATALOGUE.name("place", placement).capitalize() == said[1]
