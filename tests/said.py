"""What was said, by code: tests of behaviour outlive the words."""

import contextlib
from collections.abc import Iterable, Iterator
from typing import Any

import pytest

from estimators.errors import EstimationError
from estimators.sentences import Sentence


def codes(said: Any) -> list[str]:
    """Return the codes of a sentence or several, each before those of the sentences in its parameters."""
    if isinstance(said, Sentence):
        return [said.code, *(code for value in said.parameters.values() for code in codes(value))]
    if isinstance(said, str) or not isinstance(said, Iterable):
        return []
    return [code for one in said for code in codes(one)]


def sentence(said: Iterable[Any], code: str) -> Sentence:
    """Return the only sentence with this code, also from the parameters of others."""
    (found,) = [one for one in _all(said) if one.code == code]
    return found


def _all(said: Any) -> Iterator[Sentence]:
    if isinstance(said, Sentence):
        yield said
        for value in said.parameters.values():
            yield from _all(value)
    elif isinstance(said, Iterable) and not isinstance(said, str):
        for one in said:
            yield from _all(one)


@contextlib.contextmanager
def refuses(
    *wanted: str, error: type[Exception] = EstimationError, **parameters: Any
) -> Iterator[pytest.ExceptionInfo[Any]]:
    """Expect an error whose message is, or holds, one of these sentences, with these parameters."""
    with pytest.raises(error) as caught:
        yield caught
    found = [one for one in _all(caught.value.message) if one.code in wanted]
    assert found, f"{codes(caught.value.message)}: {caught.value.message}"
    assert {name: found[0].parameters[name] for name in parameters} == parameters
