"""Wrong input and refusals: each is said where it is seen, and nothing is lost by it."""

from pathlib import Path

import pytest

from browsers import START, Shown

pytestmark = pytest.mark.slow

ABSENT = "Absent from … to …"


def drawn(shown: Shown) -> None:
    """Open the film, and draw an object."""
    shown.open()
    shown.draw()


def mark_absent(shown: Shown, first: str, last: str) -> None:
    """Ask for an absence in the dialog, which may be open."""
    page = shown.page
    if not page.get_by_role("dialog").is_visible():
        page.get_by_role("button", name=ABSENT).click()
    page.get_by_role("spinbutton", name="First frame").fill(first)
    page.get_by_role("spinbutton", name="Last frame").fill(last)
    page.get_by_role("button", name="Mark as absent").click()


def test_a_wrong_frame_is_said_and_asked_for_again(shown: Shown) -> None:
    drawn(shown)
    alerts = shown.page.get_by_role("alert")
    for first in ("", "2.5"):
        mark_absent(shown, first, "5")
        alerts.get_by_text("First frame: give a whole number from 0 to").wait_for()
        alerts.evaluate_all("all => all.map((one) => one.replaceChildren())")
    mark_absent(shown, "3", "5")
    shown.until("s.session.objects[0].absent.length === 1")
    assert shown.state("s.session.objects[0].absent") == [[3, 5]]
    assert shown.state("s.session.objects[0].keyframes.length") == 1


def test_a_command_that_cannot_be_read_does_not_stop_those_after_it(shown: Shown) -> None:
    drawn(shown)
    lines = "Array(51).fill({ points: [0, 0, 9, 9], name: '', label: ['in', 'out'] })"
    shown.page.evaluate(f"{START} void app.actions.setPlaces(() => ({{ lines: {lines} }})))")
    shown.page.get_by_role("alert").get_by_text("This message is no command").wait_for()
    shown.page.evaluate(f"{START} void app.actions.change(1, {{ name: 'cup' }}))")
    shown.until("s.session.objects[0].name === 'cup'")


def test_refusals_are_shown_in_the_dialog_that_is_open(shown: Shown, tmp_path: Path) -> None:
    page = shown.page
    drawn(shown)
    page.keyboard.press("x")
    (tmp_path / "none.csv").write_text("none\n")
    page.get_by_label("File to import").set_input_files(tmp_path / "none.csv")
    alert = page.get_by_role("dialog").get_by_role("alert")
    alert.get_by_text("Not imported: The format of none.csv is not clear").wait_for()
    alert.get_by_role("button", name="Close this message").click()
    assert not alert.get_by_text("none.csv").count()
    page.keyboard.press("Escape")
    page.get_by_role("dialog").wait_for(state="hidden")
    page.evaluate(f"{START} void app.actions.join(99))")
    page.get_by_role("alert").get_by_text("There is no object 99").wait_for()
