"""The page itself: its protocol, films, many objects, accessibility, and what may go wrong."""

from collections.abc import Callable
from itertools import combinations, pairwise
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, BrowserContext, Route

from browsers import CORNERS, FRAMES, MIDDLE, START, Shown, film, visitors
from motes import Box, VideoWriter
from motes_studio import commands, messages, protocol
from studios import SLOW, Program
from waiting import wait_until

pytestmark = pytest.mark.slow

SIZES = [(1280, 720), (3840, 2160), (1024, 700), (800, 600), (390, 844)]
CUT = """() => [...document.querySelectorAll('button, select, input, label, h2, .caption')]
    .filter((one) => one.checkVisibility() && !one.closest('.unseen') && !one.matches('.unseen'))
    .filter((one) => { const { left, right, width } = one.getBoundingClientRect();
        return width && (left < -1 || right > innerWidth + 1); })
    .map((one) => one.outerHTML)"""
"""What of the page sticks out of the window."""


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


def drop(shown: Shown, files: dict[str, bytes]) -> None:
    """Drop files on the page."""
    shown.page.evaluate(
        """(files) => {
        const dropped = new DataTransfer();
        for (const [name, bytes] of files) {
            dropped.items.add(new File([Uint8Array.from(bytes)], name));
        }
        document.dispatchEvent(new DragEvent('drop', { dataTransfer: dropped, bubbles: true }));
    }""",
        [[name, [*data]] for name, data in files.items()],
    )


def test_films_come_by_upload_and_drop(shown: Shown, tmp_path: Path) -> None:
    page = shown.page
    page.locator("#file").set_input_files(film(tmp_path / "mine.mp4", frames=5))
    shown.until("s.film?.name === 'mine.mp4' && s.pictured === 0")
    shown.home()
    (tmp_path / "list.mp4").write_text("#EXTM3U\nhttp://example.org/film.mp4\n")
    page.locator("#file").set_input_files(tmp_path / "list.mp4")
    page.get_by_role("alert").get_by_text("list.mp4 was not taken").wait_for()
    drop(shown, {"picture.svg": b"<svg/>", "other.svg": b"<svg/>"})
    page.get_by_role("alert").get_by_text("picture.svg was not taken").wait_for()
    page.get_by_role("alert").get_by_text("Only picture.svg is sent").wait_for()


def test_what_is_dropped_on_an_open_film_is_a_film_or_its_rows(
    shown: Shown, tmp_path: Path
) -> None:
    """Rows were refused as a film, and a film came without a sign of progress."""
    page = shown.page
    shown.open()
    lines = [f"{n},1,{100 + n},80,60,80,1,1,1,-1\n" for n in range(1, FRAMES + 1)]
    drop(shown, {"rows.txt": "".join(lines).encode()})
    page.get_by_text("rows.txt was imported.").wait_for()
    shown.until("s.session.objects.length === 1")
    drop(shown, {"odd.dat": b"what is it"})
    page.get_by_role("alert").get_by_text("Export and import (X) has a menu of formats").wait_for()
    held: list[Route] = []
    page.route("**/api/uploads*", lambda route: held.append(route))
    drop(shown, {"late.mp4": film(tmp_path / "late.mp4", frames=5).read_bytes()})
    progress = page.get_by_role("progressbar", name="Sending late.mp4")
    progress.wait_for()
    wait_until(lambda: shown.state("1") and held)
    held[0].continue_()
    shown.until("s.film?.name === 'late.mp4' && s.pictured === 0")
    progress.wait_for(state="hidden")


def test_rows_come_while_a_run_goes_on_which_is_stopped(shown: Shown) -> None:
    page = shown.page
    shown.open()
    shown.take("nummiaro", SLOW)
    shown.draw(key="e")
    page.keyboard.press("t")
    status = "[...s.jobs.values()].at(-1)?.status"
    stop = "document.querySelector('button[title=Stop]')"
    shown.until(f"s.rows.get(1)?.length > 2 && {stop}.checkVisibility()")
    page.evaluate(f"{stop}.click()")  # at once: other clicks wait for a frame of the page
    shown.until(f"{status} === 'stopped'")
    assert 0 < shown.state("s.rows.get(1).filter(Boolean).length") < FRAMES


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


def test_a_page_that_is_loaded_again_shows_the_same_frame(shown: Shown) -> None:
    """It began at the first frame; a link to a session leads to a frame, too."""
    page = shown.page
    session = shown.open()
    shown.go(20)
    shown.wait(f"location.hash === '#{session}/20'")
    page.reload()
    shown.until("s.pictured === 20")
    shown.go(21)
    shown.wait(f"location.hash === '#{session}/21'")
    page.evaluate(f"location.hash = '#{session}/999'")
    shown.until(f"s.pictured === {FRAMES - 1}")
    page.locator("#brand").click()
    shown.wait("location.hash === '' && !document.getElementById('home').hidden")


def test_names_do_not_hide_each_other(shown: Shown) -> None:
    """Where objects were near to each other, only the last name could be read."""
    places = shown.page.evaluate(
        "import('/static/layers.js').then(({ drawLabel }) => { const names = [];"
        "const context = document.createElement('canvas').getContext('2d');"
        "for (const x of [100, 105, 120, 100]) "
        "drawLabel(context, [x, 60, 20, 20], 'Object 1', { color: '#fff', scale: 1 }, names);"
        "return names.map(({ left, low, width, height }) => [left, low - height, width, height]);"
        "})"
    )
    boxes = [Box(*each) for each in places]
    assert len(boxes) == 4
    for one, other in combinations(boxes, 2):
        apart_x = abs(one.x - other.x) >= one.width
        assert apart_x or abs(one.y - other.y) >= one.height


def test_the_ground_has_the_metres_that_are_typed(shown: Shown) -> None:
    """A square of one metre stood there, so that all speeds were invented."""
    page = shown.page
    shown.open()
    page.get_by_role("button", name="Click four points of the ground").click()
    for point in [(20, 20), (70, 20), (70, 60), (20, 60)]:
        page.mouse.click(*shown.at(*point))
    page.get_by_role("button", name="Set the ground").click()
    page.get_by_role("alert").get_by_text("X of point 1: give a number").wait_for()
    for at, (x, y) in enumerate([(0, 0), (5, 0), (5, 4), (0, 4)], start=1):
        page.get_by_label(f"X of point {at}").fill(str(x))
        page.get_by_label(f"Y of point {at}").fill(str(y))
    page.get_by_role("button", name="Set the ground").click()
    shown.until("s.session.places.ground?.length === 4")
    assert shown.state("s.session.places.ground.map((point) => point.slice(2)).flat()") == [
        0, 0, 5, 0, 5, 4, 0, 4,
    ]  # fmt: skip


def test_a_killed_server_loses_nothing(
    context: BrowserContext, films: Path, tmp_path: Path
) -> None:
    first = Program(films, tmp_path)
    shown = Shown(context, first.address)
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
        # Some pictures came while it was tracked; where requests are routed, none is kept.
        shown.page.route("**/frames/*", lambda route: route.continue_())
        shown.page.evaluate(f"{START} app.pictures.clear())")
        shown.page.keyboard.press("End")
        said = f"Frame {FRAMES - 1} cannot be shown: The server does not answer."
        shown.page.get_by_role("alert").get_by_text(said).wait_for()
        shown.go(20)
        second = Program(films, tmp_path, first.port)
        try:
            shown.until("s.connected && s.looked?.frame === 20")
            shown.home()
            shown.page.get_by_label("Sessions", exact=True).get_by_role("link").first.click()
            shown.until(f"s.session?.id === '{session}' && s.rows.get(1)?.length === {FRAMES}")
            found = shown.state("s.rows.get(1).map(({ x, y, a, final }) => [x, y, a, final])")
            assert found == rows
            shown.page.keyboard.press("Control+z")
            shown.until("s.session.objects[0].keyframes.length === 1")
        finally:
            second.close()
    finally:
        shown.close()
        first.close()


def test_axe_finds_nothing(shown: Shown) -> None:
    page = shown.page
    # axe is put into the page by a tool; the policy of the page would refuse it
    shown.context.new_cdp_session(page).send("Page.setBypassCSP", {"enabled": True})
    page.reload()
    shown.listed()

    def check(where: str) -> None:
        shown.painted()
        for colors in ("light", "dark"):
            page.emulate_media(color_scheme=colors)
            page.add_style_tag(content="* { transition: none !important; }")  # at once
            options: dict[str, list[str]] = {"resultTypes": ["violations"]}
            if colors == "dark":
                options["runOnly"] = ["color-contrast"]
            found = Axe().run(page, options=options).response["violations"]
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
        shown.painted()
        assert shown.page.evaluate(CUT) == []
    shown.open()
    shown.draw()
    shown.draw((20, 20), (60, 60))  # one can be joined with the other
    absent = shown.page.get_by_role("button", name="Absent from")
    assert absent.evaluate("({ scrollWidth, clientWidth }) => scrollWidth <= clientWidth")
    for width, height in SIZES:
        shown.page.set_viewport_size({"width": width, "height": height})
        shown.painted()
        assert shown.page.evaluate(CUT) == []
        heights = shown.page.evaluate(
            "['tools', 'stage', 'transport', 'strip', 'timeline']"
            ".map((name) => document.getElementById(name).getBoundingClientRect())"
            ".map(({ top, bottom }) => [top, bottom])"
        )
        assert all(above[1] <= below[0] + 1 for above, below in pairwise(heights))
        assert heights[-1][1] <= height + 1
    shown.page.evaluate(f"{START} app.store.set({{ tool: 'ground', corners: [[9, 9]] }}))")
    for tab in ("Layers", "Doubts", "Count"):
        shown.page.get_by_role("tab", name=tab).click()
        shown.painted()
        assert shown.page.evaluate(CUT) == []
    film = "{ ...s.session.film, name: 'long '.repeat(40) }"
    shown.state(f"app.store.set({{ connected: false, session: {{ ...s.session, film: {film} }} }})")
    lost = shown.page.get_by_text("The server does not answer")
    assert lost.evaluate("({ scrollWidth, clientWidth }) => scrollWidth <= clientWidth")


def test_the_time_is_seen_where_it_takes_no_row_of_its_own(shown: Shown) -> None:
    """It was hidden below a width of 1400 pixels."""
    shown.open()
    time, player = shown.page.locator(".time"), shown.page.locator("#transport")
    for width, height in SIZES:
        shown.page.set_viewport_size({"width": width, "height": height})
        shown.painted()
        seen, high = time.is_visible(), player.evaluate("(one) => one.clientHeight")
        assert seen or width == 1024
        time.evaluate("(one) => (one.hidden = !one.hidden)")
        assert player.evaluate("(one) => one.clientHeight") == high
        time.evaluate("(one) => (one.hidden = !one.hidden)")


def test_a_film_of_varying_rate_plays_by_the_times_of_its_frames(
    visit: Callable[[], Shown], films: Path
) -> None:
    """It played evenly: 20 frames of 20 ms and 20 of 200 ms took 97 ms each."""
    times = [0.02 * n for n in range(20)] + [0.4 + 0.2 * n for n in range(20)]
    with VideoWriter(films / "varying.mkv", 25) as writer:
        for n, time in enumerate(times):
            writer.write(np.full((64, 64, 3), 5 * n, np.uint8), time)
    shown = visit()
    shown.open("varying.mkv")
    shown.until(f"s.times.length === {len(times)}")
    every = f"for (let n = 0; n < {len(times)}; n += 1) await app.pictures.want(n);"
    shown.page.evaluate(
        f"{START} (async () => {{ {every} }})())"
    )  # on a busy machine some are late
    shown.page.clock.install()
    shown.page.keyboard.press("Space")
    shown.page.clock.run_for(1100)
    assert shown.state("s.frame") in (22, 23)
    shown.go(39)
    shown.page.get_by_text("0:04 / 0:04").wait_for()


def test_a_long_message_stays_for_longer(shown: Shown) -> None:
    """What an export leaves out, with a long name of a film, was gone after four seconds."""
    page = shown.page
    page.clock.install()
    page.evaluate(
        "import('/static/announce.js').then(({ announce }) => {"
        "announce('short'); announce('long '.repeat(50)); })"
    )
    page.clock.run_for(10_000)
    assert not page.get_by_text("short", exact=True).count()
    assert page.get_by_text("long long").count()


def test_fingers_draw_and_zoom(shown: Shown) -> None:
    touch = shown.context.new_cdp_session(shown.page)
    touch.send("Emulation.setTouchEmulationEnabled", {"enabled": True})
    shown.open()
    shown.page.keyboard.press("b")

    def send(kind: str, *points: tuple[float, float]) -> None:
        given: list[dict[str, Any]] = [{"x": x, "y": y, "id": n} for n, (x, y) in enumerate(points)]
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


def test_a_screen_for_fingers_has_hints_without_keys_and_wide_handles(
    browser: Browser, studio: Program
) -> None:
    """Hints named keys, and a handle reached 11 pixels."""
    context = visitors(browser, has_touch=True, is_mobile=True)
    shown = Shown(context, studio.address)
    shown.open()
    page, touch = shown.page, context.new_cdp_session(shown.page)

    def drag(*points: tuple[float, float]) -> None:
        for kind, at in zip(("touchStart", "touchMove"), points, strict=True):
            given = [{"x": at[0], "y": at[1]}]
            touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": given})
        touch.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})

    page.get_by_text("then tap Track").wait_for()
    page.get_by_role("button", name="Draw a box").tap()
    drag(shown.at(*CORNERS[0]), shown.at(*CORNERS[1]))
    shown.until("s.session.objects.length === 1 && !s.draft")
    size = "s.session.objects[0].keyframes[0].region.slice(2)"
    wide, high = shown.state(size)
    x, y = shown.at(*CORNERS[1])
    drag((x - 12, y - 12), (x + 30, y + 30))
    shown.until(f"{size}[0] > {wide} && {size}[1] > {high} && !s.draft")
    drag(shown.at(*MIDDLE), shown.at(*CORNERS[0]))
    shown.until(f"s.session.objects[0].keyframes[0].region[0] < {CORNERS[0][0]} && !s.draft")
    assert not page.locator("kbd").first.is_visible()
    for tool in ("zone", "ground"):
        # Chrome may take a tap soon after a drag for a part of it.
        page.get_by_role("button", name=tool).first.evaluate("tool => tool.click()")
        page.locator(".hint").get_by_text("Tap").wait_for()
    shown.close()
    context.close()


def test_a_folder_without_film_offers_those_of_the_demo(
    context: BrowserContext, tmp_path: Path
) -> None:
    """They are made after a click, and offered again when the first is there."""
    empty = tmp_path / "empty"
    empty.mkdir()
    program = Program(empty, tmp_path / "data")
    try:
        shown = Shown(context, program.address)
        page, films = shown.page, shown.page.get_by_label("Films", exact=True)
        films.get_by_text("There is no film in the folder").wait_for()
        films.get_by_role("button", name="A player among others").click()
        shown.until("s.pictured === 0")
        page.get_by_text("Draw a box or an ellipse around an object").wait_for()
        assert shown.state("[s.film.name, s.film.frames]") == ["sample-player.mp4", 200]
        page.get_by_text("Press B and drag a box around an object").wait_for()
        smoothing = "document.querySelector('#stage canvas').getContext('2d').imageSmoothingQuality"
        shown.wait(f"{smoothing} === 'high'")  # with the next paint
        page.locator("#play").click()
        shown.wait(f"{smoothing} === 'low'")
        page.keyboard.press("Home")
        shown.wait(f"{smoothing} === 'high'")
        shown.home()
        films.get_by_role("button", name="Cars to count").wait_for()
        assert films.get_by_role("button").count() == 3
        answer = page.evaluate("fetch('/api/samples/cat', {method: 'POST'}).then((a) => a.text())")
        assert "There is no sample film 'cat'; take one of beetle, street, player." in answer
        shown.close()
    finally:
        program.close()


def test_all_objects_are_taken_home_and_enter_is_enough(shown: Shown) -> None:
    page = shown.page
    shown.open()
    shown.draw()
    shown.track()
    page.get_by_text("Another tracker or seed drops the rows").wait_for()
    shown.draw((20, 20), (60, 60))  # and not tracked
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
