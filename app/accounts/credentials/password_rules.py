"""Passwords that are too easy to guess, refused with what is wrong with them."""

import re
from itertools import pairwise

from app.errors import InvalidInput
from estimators.sentences import say

LEAST = 10
_TRIED_FIRST = """
password passwort password1 password12 password123 password1234 passw0rd p@ssw0rd letmein welcome welcome1
welcome123 administrator admin12345 changeme qwertyuiop qwerty12345 qwertz12345 iloveyou sunshine princess
football baseball superman trustno1 whatever starwars dragon123 monkey123 telemotion rehabilitation physiotherapy
therapist therapist1 patient123 1q2w3e4r5t 1qaz2wsx3edc zaq12wsx q1w2e3r4t5 asdfghjkl0 asdfghjkl123 abc123abc123
secret1234 mypassword summer2024 summer2025 summer2026 winter2024 winter2025 winter2026
"""
_COMMON = frozenset(_TRIED_FIRST.split())
_WORDS = """
password passwort kennwort passphrase letmein welcome willkommen hallo hello administrator admin changeme sunshine
princess football fussball baseball superman whatever starwars dragon monkey secret geheim schatz liebe love iloveyou
spring summer autumn fall winter fruehling frühling sommer herbst january february march april june july august
september october november december januar februar maerz märz juni juli oktober dezember monday tuesday wednesday
thursday friday saturday sunday montag dienstag mittwoch donnerstag freitag samstag sonntag telemotion rehabilitation
physiotherapy physiotherapie therapist therapeut therapie therapy patient klinik clinic hospital krankenhaus praxis
qwerty qwertz test login master user
"""
_EASY = re.compile(f"(?:my|mein)?(?:{'|'.join(sorted(_WORDS.split(), key=len, reverse=True))}){{1,2}}")
"""One or two of the words that are tried first, whatever follows them in figures and signs."""
_LEET = str.maketrans(
    {"@": "a", "4": "a", "3": "e", "0": "o", "$": "s", "5": "s", "7": "t", "1": "i", "!": "i"}
)
_ROWS = (
    "abcdefghijklmnopqrstuvwxyz",
    "01234567890123456789",
    "qwertyuiopasdfghjklzxcvbnm",
    "qwertzuiopasdfghjklyxcvbnm",
)


def check_password(password: str, *own: str, field: str = "password") -> None:
    """Refuse a password that is easily guessed.

    Parameters
    ----------
    *own : str
        What belongs to the person: e-mail address, name.
    field : str
        Of the request, for the answer.

    Raises
    ------
    InvalidInput
        With what is wrong.
    """
    plain = password.lower()
    letters = "".join(letter for letter in plain if letter.isalnum())
    if len(password) < LEAST:
        problem = say("password.short", least=LEAST)
    elif plain in _COMMON or letters.rstrip("0123456789") in _COMMON or _is_word_with_trimmings(plain):
        problem = say("password.common")
    elif len(set(plain)) < 5 or _repeats(letters):
        problem = say("password.repeats")
    elif _runs(letters) > len(letters) * 0.6:
        problem = say("password.row")
    elif any(_is_of(letters, text) for text in own):
        problem = say("password.own")
    else:
        return
    raise InvalidInput(problem, field=field)


def _is_word_with_trimmings(plain: str) -> bool:
    """Return whether a password is an easy word with figures and signs around it or in place of letters."""
    core = re.sub(r"[\W\d_]+$", "", plain)
    for number_one in "il":
        letters = core.translate(_LEET | {ord("1"): number_one})
        if _EASY.fullmatch(re.sub(r"[\W\d_]", "", letters)):
            return True
        # Figures before it are a year, not letters.
        if _EASY.fullmatch(re.sub(r"[\W_]", "", re.sub(r"^[\W\d_]+", "", core).translate(_LEET))):
            return True
    return False


def _repeats(text: str) -> bool:
    """Return whether a text is a shorter one, again and again."""
    return any(text == (text[:length] * len(text))[: len(text)] for length in range(1, len(text) // 2 + 1))


def _runs(text: str) -> int:
    """Return how many letters follow the one before in a row of neighbours, in either direction."""
    rows = [row for one in _ROWS for row in (one, one[::-1])]
    return sum(any(first + second in row for row in rows) for first, second in pairwise(text))


def _is_of(letters: str, own: str) -> bool:
    """Return whether a password is little else than something that belongs to the person."""
    plain = own.lower()
    parts = [plain, plain.partition("@")[0], *plain.replace("@", " ").replace(".", " ").split()]
    names = {"".join(letter for letter in part if letter.isalnum()) for part in parts}
    return any(len(name) >= 4 and name in letters and len(letters) - len(name) < 5 for name in names)
