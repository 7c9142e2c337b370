"""The page itself: its protocol, films, many objects, accessibility, and what may go wrong."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any, get_args

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser

from browsers import CORNERS, FRAMES, START, Shown, film
from motes_studio import commands, messages, protocol
from studios import SLOW, Program

pytestmark = pytest.mark.slow

SIZES = [(1280, 720), (3840, 2160), (1024, 700)]
CUT = """() => [...document.querySelectorAll('button, select, input, h2, .caption')]
    .filter((one) => one.checkVisibility() && !one.closest('.unseen') && !one.matches('.unseen'))
    .filter((one) => { const { left, right, width } = one.getBoundingClientRect();
        return width && (left < -1 || right > innerWidth + 1); })
    .map((one) => one.outerHTML)"""
"""What of the page sticks out of the window."""
WIDER = """() => [...document.querySelectorAll('#left, #right, #tools, #transport, ' +
    '.check, .action .grow, #transport button')]
    .filter((one) => one.checkVisibility() && one.scrollWidth > one.clientWidth)
    .map((one) => one.outerHTML.slice(0, 80))"""
"""What of the bars and panels is cut off, or lies over what stands beside it."""


def test_page_and_server_have_the_same_protocol(shown: Shown) -> None:
    tables = shown.page.evaluate(
        "Promise.all([import('/static/protocol.js'), import('/static/messages.js')])"
        ".then(([one, two]) => "
        "[one.COMMANDS, one.ROW, one.SCENE_OBJECT, Object.keys(two.MESSAGES)])"
    )
    orders, row, scene_object, answers = tables
    definitions = protocol.schema()["$defs"]

    def described(kinds: Any) -> dict[str, set[str]]:
        found = [definitions[kind.__name__]["properties"] for kind in get_args(kinds)]
        return {each["type"]["enum"][0]: set(each) - {"type", "id"} for each in found}

    assert {name: set(fields) for name, fields in orders.items()} == described(commands.Command)
    assert {*answers, "reply"} == set(described(messages.Message))
    assert tuple(row) == messages.Row.__struct_fields__
    assert tuple(scene_object) == messages.SceneObject.__struct_fields__


def test_all_that_moves_is_counted(shown: Shown) -> None:
    page = shown.page
    shown.open()
    page.get_by_role("button", name="Draw a line that is counted").click()
    shown.drag((40, 120), (160, 118), (280, 120))
    shown.until("s.session.places.lines.length === 1")
    page.get_by_role("button", name="Draw a zone that is counted").click()
    for point in ((60, 60), (200, 60), (200, 180)):
        page.mouse.click(*shown.at(*point))
    page.keyboard.press("Enter")
    shown.until("s.session.places.zones.length === 1 && !s.corners.length")
    page.get_by_role("button", name="Click four points of the ground").click()
    for point in ((20, 20), (300, 20), (300, 220), (20, 220)):
        page.mouse.click(*shown.at(*point))
    page.get_by_label("X of point 2").fill("7")
    page.get_by_role("button", name="Set the ground").click()
    shown.until("s.session.places.ground?.length === 4")
    assert shown.state("s.session.places.ground[1][2]") == 7
    page.get_by_label("Name of line 1", exact=True).fill("door")
    page.get_by_label("Name of line 1", exact=True).press("Enter")
    shown.until("s.session.places.lines[0].name === 'door'")
    names = page.get_by_role("textbox", name="Name of crossings of line 1")
    assert [names.nth(at).input_value() for at in (0, 1)] == ["in", "out"]
    page.get_by_role("button", name="Track all that moves").click()
    shown.until(
        "[...s.jobs.values()].some(({ kind, status }) => kind === 'watch' && status === 'done')"
    )
    shown.until(f"s.scene.filter(Boolean).length === {FRAMES} && s.counts")
    page.get_by_role("row", name="Objects now").wait_for()
    lists = shown.page.request.get(f"{shown.address}api/sessions").json()
    card = next(each for each in lists if each["id"] == shown.state("s.session.id"))
    assert (card["objects"], card["counted"]) == (0, True)
    page.get_by_role("button", name="Export and import").click()
    page.get_by_label("Format of the rows").select_option("mot")
    with page.expect_download() as download:
        page.get_by_role("button", name="Rows of all objects").click()
    assert download.value.suggested_filename == "film-watched.txt"
    page.keyboard.press("Escape")
    shown.draw()
    page.get_by_role("button", name="Command line").click()
    commands = page.locator("pre[aria-label=Command]")
    commands.nth(1).wait_for()
    assert [each.split()[1] for each in commands.all_inner_texts()] == ["track", "watch"]


def test_films_come_by_upload_and_drop(shown: Shown, tmp_path: Path) -> None:
    page = shown.page
    page.locator("#file").set_input_files(film(tmp_path / "mine.mp4", frames=5))
    shown.until("s.film?.name === 'mine.mp4' && s.pictured === 0")
    page.goto(shown.address)
    (tmp_path / "list.mp4").write_text("#EXTM3U\nhttp://example.org/film.mp4\n")
    page.locator("#file").set_input_files(tmp_path / "list.mp4")
    page.get_by_role("alert").get_by_text("list.mp4 was not taken").wait_for()
    page.evaluate(
        """async () => {
        const film = await (await fetch('/static/logo.svg')).blob();
        const dropped = new DataTransfer();
        dropped.items.add(new File([film], 'picture.svg'));
        document.dispatchEvent(new DragEvent('drop', { dataTransfer: dropped, bubbles: true }));
    }"""
    )
    page.get_by_role("alert").get_by_text("picture.svg was not taken").wait_for()


def test_rows_come_while_a_run_goes_on_which_is_stopped(shown: Shown) -> None:
    page = shown.page
    shown.open()
    shown.take("nummiaro", SLOW)
    shown.draw(key="e")
    page.keyboard.press("t")
    status = "[...s.jobs.values()].at(-1)?.status"
    shown.until(f"{status} === 'running' && s.rows.get(1)?.length > 2")
    page.get_by_role("button", name="Stop").click()
    shown.until(f"{status} === 'stopped'")
    assert 0 < shown.state("s.rows.get(1).filter(Boolean).length") < FRAMES


def test_a_session_that_is_gone_leads_home(shown: Shown) -> None:
    shown.page.goto(f"{shown.address}#0123456789abcdef")
    shown.page.get_by_role("alert").locator("span").first.wait_for()
    shown.page.get_by_role("heading", name="See, correct and trust tracks").wait_for()


def test_rows_come_back_by_import(shown: Shown, tmp_path: Path) -> None:
    page = shown.page
    shown.open()
    shown.draw()
    shown.track()
    page.keyboard.press("x")
    with page.expect_download() as download:
        page.get_by_role("button", name="Export", exact=True).click()
    download.value.save_as(tmp_path / "rows.csv")
    read = page.get_by_label("Format of the file").locator("option").all_inner_texts()
    assert not any(option.startswith(("masks", "deeplabcut")) for option in read)
    page.get_by_label("File to import").set_input_files(tmp_path / "rows.csv")
    shown.until("s.session.objects.length === 2")
    page.get_by_text("rows.csv was imported.").wait_for()
    mixed = tmp_path / "mixed.xml"
    shape = "frame='0' outside='0' keyframe='1'"
    mixed.write_text(
        "<annotations><version>1.1</version><track id='0' label='car'>"
        f"<box {shape} xtl='10' ytl='10' xbr='50' ybr='40'/></track>"
        f"<track id='1' label='car'><cuboid {shape}/></track></annotations>"
    )
    page.get_by_label("File to import").set_input_files(mixed)
    page.get_by_text("mixed.xml was imported, without").wait_for()
    odd, chosen = tmp_path / "odd.txt", page.get_by_label("File to import")
    odd.write_text("10,20,30,40\n" * FRAMES)
    chosen.set_input_files(odd)
    page.get_by_text("odd.txt: it has four numbers a line").wait_for()
    assert chosen.input_value() == ""  # so that the same file can be chosen again
    page.get_by_label("Format of the file").select_option("otb")
    chosen.set_input_files(odd)
    page.get_by_text("odd.txt was imported.").wait_for()
    page.get_by_role("dialog").get_by_role("combobox").first.select_option("Object 1")
    page.locator("select:has(option[value=corrections])").select_option("corrections")
    with page.expect_download() as download:
        page.get_by_role("button", name="Export", exact=True).click()
    assert download.value.suggested_filename.endswith(".csv.run.json")
    page.keyboard.press("Escape")
    shown.until(f"s.rows.get(2)?.filter(Boolean).length === {FRAMES}")


def test_hostile_messages_are_refused_and_the_page_goes_on(shown: Shown) -> None:
    session = shown.open()
    answers = shown.page.evaluate(
        """(session) => new Promise((resolve) => {
        const socket = new WebSocket(`ws://${location.host}/api/sessions/${session}/ws`);
        const answers = [];
        const bad = ['', 'null', '{"type": "track"}',
            '{"type": "add_object", "id": 1, "frame": -1}',
            JSON.stringify({ type: 'track', id: 2, objects: Array(5000).fill(1) }),
            JSON.stringify({ type: 'remove_object', id: 3, object: 99 })];
        socket.onopen = () => bad.forEach((text) => socket.send(text));
        socket.onmessage = ({ data }) => {
            const message = JSON.parse(data);
            if (message.type === 'reply') answers.push(message);
            if (answers.length === bad.length) { socket.close(); resolve(answers); }
        };
    })""",
        session,
    )
    assert all(answer["error"] for answer in answers)
    assert "\n" not in "".join(answer["error"] for answer in answers)
    shown.draw()


def test_a_killed_server_loses_nothing(browser: Browser, films: Path, tmp_path: Path) -> None:
    first = Program(films, tmp_path)
    shown = Shown(browser, first.address)
    try:
        session = shown.open()
        shown.draw()
        shown.track()
        shown.go(20)
        shown.page.keyboard.press("k")
        shown.until("s.session.objects[0].keyframes.length === 2")
        shown.settle()
        known = "s.rows.get(1).map(({ x, y, a, final }) => [x, y, a, final])"
        rows = shown.state(known)
        shown.until("s.looked?.frame === 20")
        first.kill()
        shown.until("!s.connected")
        shown.page.evaluate(f"{START} app.store.set({{ looked: null }}))")
        shown.page.keyboard.press("k")
        shown.page.get_by_role("alert").get_by_text("does not answer").first.wait_for()
        second = Program(films, tmp_path, first.port)
        try:
            shown.until("s.connected && s.looked?.frame === 20")
            shown.page.goto(shown.address)
            shown.page.get_by_label("Sessions", exact=True).get_by_role("link").first.click()
            shown.until(f"s.session?.id === '{session}' && s.rows.get(1)?.length === {FRAMES}")
            assert (
                shown.state("s.rows.get(1).map(({ x, y, a, final }) => [x, y, a, final])") == rows
            )
            shown.page.keyboard.press("Control+z")
            shown.until("s.session.objects[0].keyframes.length === 1")
        finally:
            second.close()
    finally:
        shown.close()
        first.close()


def test_axe_finds_nothing(visit: Callable[..., Shown]) -> None:
    # axe is put into the page by a tool; the policy of the page would refuse it
    shown = visit(bypass_csp=True)
    page = shown.page

    def check(where: str) -> None:
        for colors in ("light", "dark"):
            page.emulate_media(color_scheme=colors)
            page.add_style_tag(content="* { transition: none !important; }")  # at once
            only = {"runOnly": ["color-contrast"]} if colors == "dark" else {}
            found = Axe().run(page, options=only).response["violations"]
            lines = [(one["id"], one["nodes"][0]["failureSummary"][:300]) for one in found]
            assert not lines, (where, colors, lines)

    check("films")
    shown.open()
    shown.draw()
    page.get_by_role("tab", name="Count").click()
    check("an object")
    shown.track()
    for tab in ("Layers", "Doubts"):
        page.get_by_role("tab", name=tab).click()
        check(tab)
    for key in ("?", "x", "c"):
        page.keyboard.press(key)
        page.locator("dialog[open]").wait_for()
        check(f"dialog of {key}")
        page.keyboard.press("Escape")


def test_nothing_sticks_out_of_the_window(shown: Shown) -> None:
    for width, height in SIZES:
        shown.page.set_viewport_size({"width": width, "height": height})
        assert shown.page.evaluate(CUT) == []
    shown.open()
    shown.draw()
    shown.draw((20, 20), (60, 60))  # one can be joined with the other
    absent = shown.page.get_by_role("button", name="Absent from")
    assert absent.evaluate("({ scrollWidth, clientWidth }) => scrollWidth <= clientWidth")
    for width, height in SIZES:
        shown.page.set_viewport_size({"width": width, "height": height})
        assert shown.page.evaluate(CUT) == []
        heights = shown.page.evaluate(
            "['tools', 'stage', 'transport', 'strip', 'timeline']"
            ".map((name) => document.getElementById(name).getBoundingClientRect())"
            ".map(({ top, bottom }) => [top, bottom])"
        )
        assert all(above[1] <= below[0] + 1 for above, below in pairwise(heights))
        assert heights[-1][1] <= height + 1


def test_a_film_of_one_frame_has_one(shown: Shown, films: Path) -> None:
    film(films / "still.mp4", frames=1)
    shown.page.reload()
    shown.open("still.mp4")
    shown.page.locator("#title").get_by_text("320 × 240, 1 frame", exact=True).wait_for()


def test_a_narrow_window_has_all_of_its_bars(shown: Shown) -> None:
    """While a run goes on, and with a long name."""
    shown.open()
    shown.draw()
    job = "{ job: 1, kind: 'track', status: 'running', done: 8, total: 99, rate: 12, left: 99 }"
    change = f"app.actions.change(1, {{ name: '{'a long name ' * 8}' }})"
    shown.page.evaluate(f"{START} {change})")
    shown.page.evaluate(f"{START} app.store.set({{ jobs: new Map([[1, {job}]]) }}))")
    for width, height in [(900, 700), *SIZES]:
        shown.page.set_viewport_size({"width": width, "height": height})
        assert shown.page.evaluate(WIDER) == [], width


def test_fingers_draw_and_zoom(visit: Callable[..., Shown]) -> None:
    shown = visit(has_touch=True)
    shown.open()
    shown.page.keyboard.press("b")
    touch = shown.context.new_cdp_session(shown.page)

    def send(kind: str, *points: tuple[float, float]) -> None:
        given: list[dict[str, Any]] = [
            {"x": x, "y": y, "id": at} for at, (x, y) in enumerate(points)
        ]
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": given})

    first, last = shown.at(*CORNERS[0]), shown.at(*CORNERS[1])
    send("touchStart", first)
    send("touchMove", last)
    send("touchEnd")
    shown.until("s.session.objects.length === 1 && !s.draft")
    x, y = first
    send("touchStart", (x, y), (x + 50, y))
    send("touchMove", (x - 50, y), (x + 100, y))
    send("touchEnd")
    shown.until("s.view?.scale > 2")


def test_a_folder_without_film_offers_those_of_the_demo(browser: Browser, tmp_path: Path) -> None:
    """They are made after a click, and offered again when the first is there."""
    empty = tmp_path / "empty"
    empty.mkdir()
    program = Program(empty, tmp_path / "data")
    try:
        shown = Shown(browser, program.address)
        page, films = shown.page, shown.page.get_by_label("Films", exact=True)
        films.get_by_text("There is no film in the folder").wait_for()
        films.get_by_role("button", name="A player among others").click()
        shown.until("s.pictured === 0")
        page.get_by_text("Draw a box or an ellipse around an object").wait_for()
        assert shown.state("[s.film.name, s.film.frames]") == ["sample-player.mp4", 200]
        page.get_by_text("Press B and drag a box around an object").wait_for()
        smoothing = "document.querySelector('#stage canvas').getContext('2d').imageSmoothingQuality"
        assert page.evaluate(smoothing) == "high"
        page.locator("#play").click()
        shown.wait(f"{smoothing} === 'low'")
        page.keyboard.press("Home")
        shown.wait(f"{smoothing} === 'high'")
        page.goto(program.address)
        films.get_by_role("button", name="Cars to count").wait_for()
        assert films.get_by_role("button").count() == 3
        answer = page.evaluate("fetch('/api/samples/cat', {method: 'POST'}).then((a) => a.text())")
        assert "There is no sample film 'cat'; take one of beetle, street, player." in answer
        shown.close()
    finally:
        program.close()


def test_a_film_that_was_left_untouched_opens_the_same_session(shown: Shown) -> None:
    first = shown.open()
    shown.page.goto(shown.address)
    shown.until("s.session === null && s.sessions")
    assert shown.open() == first


def test_a_click_on_a_film_opens_its_work(shown: Shown) -> None:
    first = shown.open()
    shown.draw()
    for again in (True, False):
        shown.page.goto(shown.address)
        shown.until("s.session === null && s.sessions")
        films = shown.page.get_by_label("Films", exact=True).locator("li")
        film = films.filter(has_text="film.mp4")  # other tests have sent others
        film.get_by_role("button").nth(0 if again else 1).click()
        shown.until("s.session && s.pictured === 0")
        assert (shown.state("s.session.id") == first) is again


def test_all_objects_are_taken_home_and_enter_is_enough(shown: Shown) -> None:
    page = shown.page
    shown.open()
    shown.draw()
    shown.track()
    page.get_by_text("Another tracker or seed drops the rows").wait_for()
    shown.draw()  # and not tracked
    page.keyboard.press("x")
    page.get_by_text("Without those that are not tracked to their end: Object 2.").wait_for()
    with page.expect_download() as download:
        page.keyboard.press("Enter")
    assert download.value.suggested_filename == "film-Object_1.csv"
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Absent from").click()
    page.get_by_role("dialog").wait_for()
    page.keyboard.press("Control+a")
    page.keyboard.type("1")
    page.keyboard.press("Enter")
    page.get_by_role("dialog").wait_for(state="hidden")


def test_absent_frames_are_gaps_in_the_timeline(shown: Shown) -> None:
    found = shown.page.evaluate(
        """() => import('/static/series.js').then(({ columns, LANES }) => {
        const here = { status: 'tracking', x: 5, y: 5, a: 2, b: 8, confidence: 1, distance: 1,
            effective_sample_size: 1, belief: 1, cue_weights: [1], supporting: 1,
            milliseconds: 1 };
        const none = { x: null, y: null, a: null, b: null, confidence: null, distance: null,
            effective_sample_size: null, belief: null, cue_weights: [0], supporting: null,
            milliseconds: null };
        const rows = [here, here, { status: 'absent', ...none }, { status: 'lost', ...none },
            { ...here, x: 9 }, here].map((row, frame) => ({ ...row, frame }));
        const span = { first: 0, last: 5, count: 6 };
        const of = (name) => columns(rows, LANES.find((lane) => lane.name === name).value, span);
        return [of('size'), of('speed'), columns(rows, (row) => row.cue_weights[0], span)];
    })"""
    )
    size, speed, cue = found
    assert size == [[8, 8], [8, 8], None, None, [8, 8], [8, 8]]
    assert speed == [None, [0, 0], None, None, None, [4, 4]]
    assert cue[2] is None


def test_menus_show_few_trackers_and_more(shown: Shown) -> None:
    shown.open(tracker="default")
    shown.draw()
    menu = shown.page.locator("#left").get_by_label("Tracker")
    words = "(menu) => [...menu.options].map(({ textContent }) => textContent)"
    assert menu.evaluate(words) == ["default", "nummiaro", "More …", "From a file …"]
    shown.choose_tracker("#left", "maggio")
    shown.until("s.session.objects[0].preset === 'maggio'")
    shown.page.get_by_role("tab", name="Count").click()
    shown.choose_tracker("#right", "zhao_pei")
    assert shown.page.locator("#right").get_by_label("Tracker").input_value() == "zhao_pei"


def test_colors_are_switched_and_kept(shown: Shown) -> None:
    theme = "document.documentElement.dataset.theme"
    assert shown.page.evaluate(theme) == "light"
    shown.page.get_by_role("button", name="Light or dark").click()
    shown.wait(f"{theme} === 'dark'")
    shown.page.reload()
    shown.wait(f"{theme} === 'dark'")


def test_the_timeline_and_the_wheel_go_to_frames(shown: Shown) -> None:
    shown.open()
    box = shown.page.locator("canvas.timeline").bounding_box()
    assert box is not None
    shown.page.mouse.click(box["x"] + 132 + 0.51 * (box["width"] - 132), box["y"] + 40)
    shown.until("s.pictured === 20")
    shown.page.mouse.wheel(0, -300)
    shown.until("s.range !== null")
    strip = shown.page.locator("canvas.thumbnails").bounding_box()
    assert strip is not None
    shown.page.mouse.click(strip["x"] + strip["width"] - 2, strip["y"] + 10)
    shown.until(f"s.pictured === {FRAMES - 1}")
    shown.page.mouse.move(*shown.at(100, 100))
    shown.page.mouse.wheel(0, -200)
    shown.until("s.view !== null")
