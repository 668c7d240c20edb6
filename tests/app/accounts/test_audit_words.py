"""Every code of the audit trail has words: patients read the trail, and `session.series` says nothing to them."""

import ast
import re
from pathlib import Path

from messages import messages_in

ROOT = Path(__file__).resolve().parents[3]
CODE = re.compile(r"[a-z_]+(\.[a-z_]+)+")


def named() -> set[str]:
    words = "".join(path.read_text("utf-8") for path in (ROOT / "web/src/i18n/en").rglob("*.ts"))
    return set(re.findall(r"'audit\.([a-z_.]+)':", words))


def written() -> set[str]:
    """Every text of the service that is made like a code and speaks of what codes speak of."""
    texts = {
        node.value
        for path in (ROOT / "app").rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and CODE.fullmatch(node.value)
    }
    about = {code.split(".")[0] for code in named() if "." in code} | {"backup", "settings"}
    # `patient.id` is a column, `patient.json` a file of the export; sentences have codes of their own.
    codes = {text for text in texts if text.split(".")[0] in about and not text.endswith((".id", ".json"))}
    return codes - set(messages_in("en"))


def test_every_audit_code_has_words():
    assert {"patient.read", "session.series", "source.retire"} <= written(), (
        "the codes are not found any more"
    )
    assert sorted(written() - named()) == []
