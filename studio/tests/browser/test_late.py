"""What comes late, twice or out of turn: answers, pictures, clicks."""

from typing import Any

import pytest
from playwright.sync_api import Route

from browsers import CORNERS, START, Shown
from waiting import wait_until

pytestmark = pytest.mark.slow


def do(shown: Shown, script: str) -> Any:
    """Run a script with the page's `app`."""
    return shown.page.evaluate(f"{START} {{ {script} }})")


def test_actions_wait_for_the_answers_to_those_before(shown: Shown) -> None:
    shown.open()
    do(shown, "app.store.set({ tracker: { preset: 'mean_shift', config: null, seed: 0 } });")
    draft = "{ object: null, frame: 0, color: '#000000', region: [135, 79, 60, 80] }"
    line = "{ points: [40, 120, 280, 120], name: '', label: ['in', 'out'] }"
    do(shown, f"for (const one of [1, 2]) app.actions.commit({draft}); app.actions.track();")
    do(shown, f"for (const one of [1, 2]) app.actions.setPlaces(({{ lines }}) => ({{ lines: "
              f"[...lines, {line}] }}));")  # fmt: skip
    shown.until("s.session.places.lines.length === 2")
    assert shown.state("s.session.objects.map(({ name }) => name)") == ["Object 1", "Object 2"]
    assert shown.state("new Set(s.session.objects.map(({ color }) => color)).size") == 2
    assert shown.state("s.session.objects.every(({ tracked }) => tracked)")
    do(shown, "app.actions.toggleAbsent(); app.actions.toggleAbsent();")
    do(shown, "app.actions.change(1, { name: 'last' });")
    shown.until("s.session.objects[0].name === 'last'")
    assert shown.state("s.session.objects.map(({ absent }) => absent.length)") == [0, 0]
    shown.settle()
    do(
        shown,
        f"app.store.set({{ selected: 1 }}); app.actions.remove(); app.actions.commit({draft});",
    )
    shown.until("s.session.objects.length === 2 && s.session.objects[1].name === 'Object 3'")


def test_a_draft_is_sent_once_and_the_next_one_stays(shown: Shown) -> None:
    shown.open()
    shown.page.keyboard.press("b")
    shown.page.keyboard.press("Enter")
    do(
        shown,
        "const key = { key: 'Enter', bubbles: true };"
        "for (const one of [1, 2]) document.body.dispatchEvent(new KeyboardEvent('keydown', key));"
        "app.store.set({ draft: { frame: 0, color: '#000000', region: [9, 9, 9, 9] } });",
    )
    do(shown, "return app.actions.change(1, { name: 'first' });")
    assert shown.state("[s.session.objects.length, s.draft?.region[0]]") == [1, 9]


def test_a_button_that_is_pressed_is_not_replaced(shown: Shown) -> None:
    page = shown.page
    shown.open()
    shown.draw()
    shown.go(20)
    page.get_by_role("button", name="Keyframe", exact=False).and_(page.locator(".action")).hover()
    page.mouse.down()
    do(shown, "return app.actions.change(1, { name: 'other' });")
    shown.painted()
    page.mouse.up()
    shown.until("s.session.objects[0].keyframes.length === 2")
    page.locator(".effort").get_by_text("of other").wait_for()


def test_a_late_picture_does_not_move_the_film_away(shown: Shown) -> None:
    held: list[Route] = []
    shown.page.route("**/frames/30.jpg*", lambda route: held.append(route))
    shown.open()
    shown.page.keyboard.press("b")
    do(shown, "app.store.set({ frame: 30, following: true });")
    shown.painted()
    shown.until("s.awaited.has(30)")
    wait_until(lambda: shown.state("1") and held)  # to ask lets the route be called
    shown.page.mouse.move(*shown.at(*CORNERS[0]))
    shown.page.mouse.down()
    shown.painted()  # from here on the first frame's picture is asked for
    shown.until("!s.awaited.has(0)")
    for route in held:
        route.continue_()
    shown.until("!s.awaited.has(30)")
    shown.page.mouse.move(*shown.at(*CORNERS[1]), steps=3)
    shown.page.mouse.up()
    shown.until("s.session.objects.length === 1 && !s.draft")
    assert shown.state("[s.frame, s.pictured, s.following]") == [0, 0, False]
    assert shown.state("s.session.objects[0].keyframes[0].frame") == 0


def test_what_a_tracker_saw_stays_until_its_picture_has_come(shown: Shown) -> None:
    kept = do(
        shown,
        "return import('/static/messages.js').then(({ MESSAGES }) => { const { store } = app;"
        "store.set({ pictured: 1, awaited: new Set([0]) });"
        "for (let frame = 0; frame < 60; frame += 1) MESSAGES.overlay(store, { object: 1, frame });"
        "const kept = [...store.state.overlays.get(1).keys()];"
        "MESSAGES.rows(store, { object: 1, rows: [], reset: true });"
        "return [kept, store.state.overlays.size]; });",
    )
    assert kept == [[0, 1, *range(10, 60)], 0]


def test_a_run_of_several_objects_is_followed_where_one_is(shown: Shown) -> None:
    """The film leapt between the frames in which each of them was tracked."""
    followed = do(
        shown,
        "return import('/static/messages.js').then(({ MESSAGES }) => { const { store } = app;"
        "const now = performance.now; let time = 5000; performance.now = () => time;"
        "store.set({ selected: 2 }); const seen = [];"
        "const news = [[1, 9], [3, 5], [1, 10], [2, 3], [1, 11], [2, 4], [3, 6]];"
        "for (const [object, frame] of news) {"
        "time += 100; MESSAGES.overlay(store, { object, frame });"
        "seen.push([store.state.newest.object, store.state.newest.frame]); }"
        "time += 2000; MESSAGES.overlay(store, { object: 3, frame: 7 });"
        "seen.push([store.state.newest.object, store.state.newest.frame]);"
        "performance.now = now; return seen; });",
    )
    assert followed == [[1, 9], [1, 9], [1, 10], [2, 3], [2, 3], [2, 4], [2, 4], [3, 7]]


def test_a_session_that_is_removed_elsewhere_leads_home(shown: Shown) -> None:
    session = shown.open()
    shown.page.evaluate(f"fetch('/api/sessions/{session}', {{ method: 'DELETE' }})")
    shown.page.get_by_role("heading", name="See, correct and trust tracks").wait_for()
    shown.page.get_by_role("alert").locator("span").first.wait_for()
