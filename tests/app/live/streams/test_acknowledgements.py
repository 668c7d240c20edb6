"""What a gateway hears: made anew when something has changed, and only then."""

from app.live.session.ledger import GIVE_UP_AFTER_S, REPORT_AFTER_S, Acknowledgements, SequenceLedger
from app.network.ranges import SequenceRanges


def ledger_of(received: list[tuple[int, int]], durable: list[tuple[int, int]]) -> SequenceLedger:
    return SequenceLedger(received=SequenceRanges(received), durable=SequenceRanges(durable))


def test_the_same_message_is_given_until_something_changes() -> None:
    ledger, heard = ledger_of([(0, 30)], [(0, 20)]), Acknowledgements("s")
    first = heard.next(ledger, "ready")
    assert (first.acknowledged, first.highest, first.missing, first.state) == (19, 19, [], "ready")
    ledger.received.add_range(30, 40)
    assert heard.next(ledger, "ready") is first, "what only waits for its commit changes nothing"
    ledger.durable.add_range(20, 25)
    second = heard.next(ledger, "ready")
    assert (second.acknowledged, second.highest) == (24, 24)
    third = heard.next(ledger, "recording")
    assert third is not second
    assert third.state == "recording"
    assert heard.next(ledger, "recording") is third


def test_a_hole_is_asked_for_then_given_up() -> None:
    ledger = ledger_of([(0, 10), (12, 30)], [(0, 10), (12, 30)])
    assert ledger.review(0.1) == []
    assert ledger.review(REPORT_AFTER_S) == [(10, 12)]
    assert ledger.acknowledged == 9
    assert ledger.review(GIVE_UP_AFTER_S) == []
    assert ledger.acknowledged == 29, "given up"
    assert ledger.holes() == []
    assert list(ledger.durable) == [(0, 10), (12, 30)]
    ledger.received.add_range(31, 33)
    assert ledger.review(0.5) == [], "a new hole is young, whatever was asked for before it"
    assert ledger.review(REPORT_AFTER_S) == [(30, 31)]


def test_a_message_asks_for_what_lies_below_the_highest_that_is_stored() -> None:
    ledger, heard = ledger_of([(0, 10), (12, 30)], [(0, 10)]), Acknowledgements("s")
    ledger.review(REPORT_AFTER_S)
    ledger.review(REPORT_AFTER_S)
    assert heard.next(ledger, "ready").missing == []
    ledger.durable.add_range(12, 20)
    assert heard.next(ledger, "ready").missing == [(10, 12)]
