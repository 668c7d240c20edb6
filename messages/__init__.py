"""Sentences of the service and of the library: a file a language, each code with its words in ICU MessageFormat.

The browser client reads the same files (`web/src/i18n`).
"""

import json
from pathlib import Path


def messages_in(language: str) -> dict[str, str]:
    """Return the words of every code in a language, `en` or `de`.

    English has no titles of file formats, filters and measures: these are written where the things are.
    """
    words: dict[str, str] = json.loads(Path(__file__).with_name(f"{language}.json").read_text("utf-8"))
    return words
