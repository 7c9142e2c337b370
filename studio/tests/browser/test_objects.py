"""Objects on the page: drawn, tracked, corrected and taken home."""

import shlex
from collections.abc import Callable
from pathlib import Path

import pytest

from browsers import FRAMES, MIDDLE, START, Shown
from motes.cli import main

pytestmark = pytest.mark.slow


def repeated(command: str, files: dict[str, str], films: Path, at: Path) -> bytes:
    """Run a command line that the page has shown, and return its rows."""
    for name, text in files.items():
        (at / name).write_text(text)
    words = shlex.split(command)
    assert words[:3] == ["motes", "track", "film.mp4"]
    assert main([*words[1:2], str(films / "film.mp4"), *words[3:-1], str(at / "again.csv")]) == 0
    return (at / "again.csv").read_bytes()


def test_tracks_are_made_corrected_and_taken_home(
    shown: Shown, films: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    shown.open(tracker="nummiaro")
    number = shown.draw()
    assert shown.state("s.session.objects[0].keyframes[0].region.length") == 4
    shown.page.locator("#track").click()
    shown.tracked()
    shown.page.get_by_label("Objects", exact=True).get_by_text("Object 1").first.wait_for()

    shown.go(30)
    x, y, *_ = shown.state(f"(({{ x, y }}) => [x, y])(s.rows.get({number})[30])")
    shown.drag((x, y), (x + 3, y + 2))
    shown.until("s.session.objects[0].keyframes.length === 2")
    shown.settle()
    assert shown.state("s.session.objects[0].keyframes.map(({ frame }) => frame)") == [0, 30]
    assert shown.state("s.session.objects[0].corrections") == 1
    shown.page.locator(".effort").get_by_text("1 correction of Object 1").wait_for()

    shown.page.get_by_role("button", name="Export and import").click()
    with shown.page.expect_download() as download:
        shown.page.get_by_role("button", name="Export", exact=True).click()
    download.value.save_as(tmp_path / "page.csv")
    shown.page.keyboard.press("Escape")
    shown.page.get_by_role("button", name="Command line").click()
    shown.page.get_by_role("button", name="Copy Command").click()
    shown.page.get_by_text("Copied", exact=True).wait_for()
    command = shown.page.evaluate("navigator.clipboard.readText()")
    titles = shown.page.locator(".code pre").evaluate_all("all => all.map(one => one.ariaLabel)")
    texts = shown.page.locator(".code pre").all_inner_texts()
    files = dict(zip(titles[1:], texts[1:], strict=True))
    assert (tmp_path / "page.csv").read_bytes() == repeated(command, files, films, tmp_path)


def test_what_a_tracker_sees_is_asked_for_where_its_object_is(shown: Shown) -> None:
    asked: list[str] = []
    shown.page.on("request", lambda request: asked.append(request.url.rpartition("/")[2]))
    shown.open()
    shown.draw()
    shown.track()
    shown.go(20)
    shown.page.keyboard.press("s")
    shown.until("s.session.objects.length === 2")
    shown.settle()
    shown.state("app.store.set({ selected: 2 })")
    shown.go(5)
    shown.page.evaluate("new Promise((done) => setTimeout(done, 300))")  # it asks after a pause
    shown.go(25)
    shown.until("s.looked?.object === 2 && s.looked.frame === 25")
    assert "5?object=2" not in asked


def test_doubtful_frames_are_those_after_a_correction(shown: Shown) -> None:
    shown.open()
    shown.draw()
    shown.track()
    doubt = "{ frame: 5, gain: 9, reasons: ['lost'] }"
    shown.state("s.rows.get(1)[5].time = 65")  # as in a film whose rate varies
    shown.state(f"app.store.set({{ doubts: new Map([[1, [{doubt}]]]), tab: 'doubts' }})")
    shown.page.locator(".doubt").get_by_text("1:05").wait_for()
    shown.go(20)
    shown.page.keyboard.press("k")
    shown.until("s.session.objects[0].keyframes.length === 2")
    shown.until("!s.doubts.get(1).some(({ gain }) => gain === 9)")


def test_marks_and_identities_change_and_are_taken_back(shown: Shown) -> None:
    shown.open()
    shown.draw()
    press = shown.page.keyboard.press
    shown.go(20)
    press("k")
    shown.until("s.session.objects[0].keyframes.length === 2")
    shown.go(30)
    press("a")
    shown.until("s.session.objects[0].absent.length === 1")
    press("Control+z")
    shown.until("s.session.objects[0].absent.length === 0 && s.session.redo")
    press("Control+y")
    shown.until("s.session.objects[0].absent.length === 1")
    press("a")
    shown.until("s.session.objects[0].absent.length === 0")
    shown.go(10)
    press("s")
    shown.until("s.session.objects.length === 2")
    shown.page.get_by_role("button", name="Object 1", exact=False).first.click()
    other = shown.state("s.session.objects.find(({ object }) => object !== s.selected).object")
    shown.page.get_by_label("Join with").select_option(str(other))
    shown.until("s.session.objects.length === 1")
    assert shown.state("s.session.objects[0].keyframes.map(({ frame }) => frame)") in (
        [0, 20], [0, 10, 20],
    )  # fmt: skip


def test_a_run_is_followed_with_what_the_tracker_sees(shown: Shown) -> None:
    """The first frame, whose picture is there before, needs nothing: what was drawn is shown."""
    shown.open()
    shown.take("nummiaro", "particles = 20000")  # mean shift may be ready before a second overlay
    shown.draw()
    shown.page.evaluate(
        "import('/static/main.js').then(({ app }) => { window.seen = [];"
        "app.store.on(['picture'], ({ pictured, overlays }) => "
        "pictured && window.seen.push(Boolean(overlays.get(1)?.has(pictured)))); })"
    )
    shown.track()
    shown.wait("window.seen.length > 0")  # a picture that is known is shown with the next paint
    assert shown.page.evaluate("window.seen.every(Boolean)")


def test_two_people_see_the_same_session(visit: Callable[[], Shown]) -> None:
    one, two = visit(), visit()
    session = one.open()
    two.page.goto(f"{two.address}#{session}")
    two.until("s.pictured === 0")
    one.draw()
    two.until("s.session.objects.length === 1")
    two.track()
    one.tracked()
    rows = "[...s.rows.get(1).map(({ x, y, a }) => [x, y, a])]"
    assert one.state(rows) == two.state(rows)
    three = visit()
    three.open()
    assert three.state("s.session.objects.length") == 0


def test_a_slow_network_loses_pictures_but_no_rows(shown: Shown) -> None:
    shown.open()
    shown.draw()
    network = shown.context.new_cdp_session(shown.page)
    network.send("Network.enable")
    slow = {"latency": 300, "downloadThroughput": 40_000, "uploadThroughput": 40_000}
    network.send("Network.emulateNetworkConditions", {"offline": False, **slow})
    shown.track()
    assert shown.state("s.rows.get(1).filter(Boolean).length") == FRAMES
    shown.until("s.pictured === s.frame")


def test_a_film_is_seen_while_it_plays_over_a_slow_network(shown: Shown) -> None:
    shown.open()
    network = shown.context.new_cdp_session(shown.page)
    network.send("Network.enable")
    slow = {"latency": 600, "downloadThroughput": -1, "uploadThroughput": -1}
    network.send("Network.emulateNetworkConditions", {"offline": False, **slow})
    # On a busy machine the film plays as slowly as the page is drawn.
    shown.page.evaluate(
        "let last = performance.now(), clock = 0; const now = performance.now.bind(performance);"
        "performance.now = () => { const at = now(); clock += Math.min(at - last, 20); last = at;"
        "return clock; };"
    )
    shown.page.evaluate(
        f"{START} {{ window.seen = []; app.store.on(['picture'], ({{ playing, pictured }}) => "
        "playing && window.seen.push(pictured)); app.store.set({ speed: 0.5, playing: true }); })"
    )
    shown.until(f"!s.playing && s.pictured === {FRAMES - 1}")
    assert {*shown.page.evaluate("window.seen")} - {0, 1, FRAMES - 1}


def test_drawing_needs_no_pointer(shown: Shown) -> None:
    page = shown.page
    shown.film().focus()
    page.keyboard.press("Enter")
    shown.until("s.pictured === 0")
    shown.take("mean_shift")
    for key in ("b", "Enter", "ArrowRight", "Shift+ArrowDown", "Control+ArrowRight"):
        page.keyboard.press(key)
    region = shown.state("s.draft.region")
    assert region[0] != MIDDLE[0]
    page.keyboard.press("Enter")
    shown.until("s.session.objects.length === 1 && !s.draft")
    shown.track()
    for key in ("Home", "f", "f", "ArrowRight", "d"):
        page.keyboard.press(key)
    shown.until("s.frame === 2")
    shown.go(7)
    for key in ("Enter", "ArrowLeft", "]", "Enter"):
        page.keyboard.press(key)
    shown.until("s.session.objects[0].keyframes.length === 2 && !s.draft")
    page.keyboard.press(",")
    shown.until("s.frame === 0")
    page.keyboard.press("Space")
    shown.until("s.frame > 3")
    page.keyboard.press("Space")
    page.keyboard.press("?")
    page.get_by_role("heading", name="Keys").wait_for()


def test_the_first_frame_stays_when_a_followed_run_goes_on(shown: Shown) -> None:
    page = shown.page
    shown.open()
    shown.draw()
    shown.track()
    ways: tuple[Callable[[], None], ...] = (
        lambda: page.keyboard.press("Home"),
        lambda: page.keyboard.press(","),
        lambda: page.get_by_role("button", name="First frame (Home)").click(),
    )
    for goes in ways:
        page.evaluate(f"{START} app.store.set({{ frame: 30, following: true }}))")
        goes()
        page.evaluate(f"{START} app.store.set({{ newest: {{ object: 1, frame: 35 }} }}))")
        assert shown.state("[s.frame, s.following]") == [0, False]


def test_what_is_typed_stays_while_the_session_changes(shown: Shown) -> None:
    page = shown.page
    shown.open()
    shown.draw()
    name = page.locator("#left").get_by_label("Name", exact=True)
    name.click()
    name.press("End")
    page.keyboard.type(" and more")
    for changes in ({"color": "#009e73"}, {"name": "other"}):  # as from another page
        page.evaluate(
            "(changes) => import('/static/main.js')"
            ".then(({ app }) => app.actions.change(1, changes))",
            changes,
        )
    shown.until("s.session.objects[0].name === 'other'")
    page.evaluate("() => new Promise((drawn) => setTimeout(drawn, 100))")
    page.keyboard.type("!")
    assert name.input_value() == "Object 1 and more!"
    name.press("Enter")
    shown.until("s.session.objects[0].name === 'Object 1 and more!'")
    page.keyboard.press("b")  # a key again; it was typed into the name
    shown.until("s.tool === 'box'")
    page.get_by_role("heading", name="Object 1 and more!").wait_for()
    page.get_by_role("tab", name="Count").click()
    page.evaluate(
        "() => import('/static/main.js').then(({ app }) => app.actions.setPlaces(() => ({ lines: ["
        "{ points: [40, 120, 280, 120], name: '', label: ['left', 'right'] }] })))"
    )
    line = page.get_by_label("Name of line 1", exact=True)
    line.fill("door")
    line.press("Tab")
    shown.until("s.session.places.lines[0].name === 'door'")
    page.get_by_role("button", name="Remove door").or_(
        page.get_by_role("button", name="Remove line 1")
    ).wait_for()
    assert page.evaluate("document.activeElement.getAttribute('aria-label')") == "Remove line 1"


def test_handles_are_those_that_can_be_dragged(shown: Shown) -> None:
    """A tracker's newest ellipse is drawn while it runs; the handles are those of the box."""
    shown.open()
    shown.draw()
    shown.go(5)
    row = [5, 0.2, 165, 119, 30, 40, 0.3, 0.9, "tracking", 0.1, 9, None, None, [1], False, 1, None]
    ellipse = {"object": 1, "frame": 5, "ellipse": [165, 119, 30, 40, 0.3]}
    overlay = {**ellipse, "covariance": [1, 0, 1], "particles": [], "weights": []}
    turned, corners = shown.page.evaluate(
        "([row, overlay]) => "
        "Promise.all([import('/static/main.js'), import('/static/messages.js')])"
        ".then(async ([{ app: { store } }, { MESSAGES }]) => {"
        "const [drawn, context] = [{ arc: 0, rect: 0 }, CanvasRenderingContext2D.prototype];"
        "for (const name of ['arc', 'rect']) { const draw = context[name];"
        "context[name] = function (...given) { drawn[name] += 1; draw.apply(this, given); }; }"
        "MESSAGES.rows(store, { object: 1, rows: [row] }); MESSAGES.overlay(store, overlay);"
        "Object.assign(drawn, { arc: 0, rect: 0 }); store.touch('session');"
        "await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));"
        "return [drawn.arc, drawn.rect]; })",
        [row, overlay],
    )
    assert (turned, corners % 4) == (0, 0)
    assert corners
