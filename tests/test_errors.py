"""Messages that people can read, whatever they quote."""

import pytest

from motes.cli import main
from motes.cli.streams import log
from motes.core.errors import LONGEST, ConfigError, MotesError, clear


@pytest.mark.parametrize(
    ("text", "line"),
    [("a name, été.", "a name, été."), ("a\x1b[31mb\x00\n\udcb2c", "a\\x1b[31mb\\x00 \\udcb2c")],
)
def test_a_message_has_no_characters_that_cannot_be_shown(text: str, line: str) -> None:
    assert clear(text) == str(MotesError(text)) == str(ConfigError(text)) == line


def test_a_long_message_is_cut_in_the_middle() -> None:
    line = clear("begin" + 50_000 * "a" + "end")
    assert len(line) <= LONGEST
    assert line.startswith("begin")
    assert line.endswith("end")
    assert clear("a" * LONGEST) == "a" * LONGEST


def test_the_program_prints_clear_lines(capsys: pytest.CaptureFixture[str]) -> None:
    log("sequence \x1b[31m")
    assert main(["track", "--\udcb2" + "x" * 5000]) == 2
    first, second = capsys.readouterr().err.splitlines()
    assert first == "motes: sequence \\x1b[31m"
    assert second.startswith("motes: error: ")
    assert len(second) < LONGEST + 20
    assert second.isprintable()
