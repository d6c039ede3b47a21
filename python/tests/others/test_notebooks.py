"""The notebooks run, and show what is saved in them: texts alike, numbers as they are shown."""

from __future__ import annotations

import html
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from conftest import repository

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")

FOLDER = repository() / "docs" / "python"
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e-?\d+)?")


def texts(notebook: Any) -> Iterator[tuple[int, str]]:
    """What each cell shows as text; of pages and tables the words alone, of pictures that there is one."""
    for k, cell in enumerate(notebook.cells):
        for output in cell.get("outputs", []):
            data = output.get("data", {})
            yield k, output.get("text", "") + data.get("text/plain", "")
            drawn = re.sub(r"<(svg|style|iframe)\b.*?</\1>", "[picture]", data.get("text/html", ""), flags=re.S)
            yield k, html.unescape(re.sub(r"<[^>]*>", " ", drawn))


def last_digit(number: str) -> float:
    """What the last digit of a number stands for; nothing of a whole number, which is a count."""
    if number.lstrip("-").isdigit():
        return 0.0
    digits, _, exponent = number.partition("e")
    return float(10.0 ** (int(exponent or 0) - len(digits.partition(".")[2])))


def is_shown(now: str, saved: str) -> bool:
    """Whether words are the same, and numbers differ by their last digit at most."""
    if NUMBER.sub("#", now).split() != NUMBER.sub("#", saved).split():
        return False
    pairs = zip(NUMBER.findall(now), NUMBER.findall(saved), strict=True)
    return all(abs(float(a) - float(b)) <= 1.001 * last_digit(b) for a, b in pairs)


@pytest.mark.parametrize("name", ["identify", "what_is_missing"])
def test_a_notebook_shows_what_is_saved_in_it(name: str, tmp_path: Path) -> None:
    saved = nbformat.read(FOLDER / f"{name}.ipynb", as_version=4)
    now = nbformat.read(FOLDER / f"{name}.ipynb", as_version=4)
    nbclient.NotebookClient(now, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
    shown, kept = list(texts(now)), list(texts(saved))
    assert [k for k, _ in shown] == [k for k, _ in kept]
    stale = [(k, new) for (k, new), (_, old) in zip(shown, kept, strict=True) if not is_shown(new, old)]
    assert not stale, f"{name}.ipynb: execute it again, cells show: {stale}"


def test_words_and_digits_are_compared() -> None:
    assert is_shown("0.34 mm of 12", "0.33 mm  of 12") and is_shown("1e-3 m", "1e-3 m")
    for now in ("0.36 mm of 12", "0.34 m of 12", "0.34 mm", "0.34 mm of 13"):
        assert not is_shown(now, "0.34 mm of 12"), now
