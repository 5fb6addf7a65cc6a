"""The types of the page are those of the messages."""

from __future__ import annotations

import pytest

from kinetograph.studio.typescript import DECLARATIONS, declarations


def test_the_page_has_the_types_of_the_messages() -> None:
    if not DECLARATIONS.exists():
        pytest.skip("the client's source is not part of this installation")
    assert DECLARATIONS.read_text(encoding="utf-8") == declarations(), "run: python -m kinetograph.studio.typescript"


def test_types_say_what_may_be_left_out_and_what_is_chosen_from() -> None:
    text = declarations()
    assert '  kind: "edit";\n  part: string;\n  value: any;\n  label?: string;' in text
    assert 'export type Mode = "walk" | "keys" | "duet" | "sensors";' in text
    assert "path?: [number, number, number][];" in text
    assert "time?: number | [number, number] | null;" in text or "time?: null | number | [number, number];" in text
