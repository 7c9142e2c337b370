"""The report: what is in it, that it can be read by machines, and that names stay names."""

from __future__ import annotations

import base64
import io
import re
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

from evaluations import outcome, pictures, sequence, shifted, trace
from motes.video.sources import Source, open_source
from motes_lab.aggregate import Evaluation
from motes_lab.datasets.sot import Problem, Sequence
from motes_lab.protocols.trace import TrackerOutput
from motes_lab.report import sections as report_sections
from motes_lab.report.failures import MAX_PICTURES, Failure, choose, draw, failures
from motes_lab.report.reference import Reference
from motes_lab.report.speed_ratio import Comparisons
from motes_lab.report.tables import NO_VALUE, best, number, three_digits
from motes_lab.report.write import write_report
from motes_lab.scores import Outcome

NASTY = "<script>alert(1)</script> $x$ | `y` _z & \"q\" 'r'"
VOID = {"meta", "img", "br"}


class Page(HTMLParser):
    """A page taken apart; complains about elements that are not closed in order."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text: list[str] = []
        self.rows: list[list[str]] = []
        self._open: list[str] = []
        self.feed(text)
        self.close()
        assert not self._open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Take note of an element that begins."""
        self.tags.append((tag, dict(attrs)))
        assert len(dict(attrs)) == len(attrs), f"{tag} has an attribute twice"
        if tag not in VOID:
            self._open.append(tag)
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Take note of an element of a drawing that is closed at once."""
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        """Close an element."""
        assert self._open.pop() == tag

    def handle_data(self, data: str) -> None:
        """Take note of text."""
        if self._open and self._open[-1] not in ("style", "script"):
            self.text.append(data)
            if {"td", "th"} & set(self._open):
                self.rows[-1][-1] += data

    @property
    def words(self) -> str:
        """What is read, in one line."""
        return " ".join("".join(self.text).split())

    def all(self, tag: str) -> list[dict[str, str | None]]:
        """Return the attributes of all elements of a kind."""
        return [attributes for name, attributes in self.tags if name == tag]


def report(
    folder: Path,
    outcomes: list[Outcome],
    problems: list[Problem] | None = None,
    wanted: Comparisons = Comparisons(),  # noqa: B008
    title: str = "Some trackers",
) -> tuple[Page, str]:
    """Write a report; return its page, checked as every page is, and its summary."""
    folder.mkdir(exist_ok=True)
    write_report(folder, outcomes, problems or [], wanted, title)
    assert sorted(path.name for path in folder.iterdir()) == ["report.html", "summary.md"]
    html = (folder / "report.html").read_text(encoding="utf-8")
    page, summary = Page(html), (folder / "summary.md").read_text(encoding="utf-8")
    check_alone(page)
    check_ids(page)
    check_drawings(html)
    check_tables(page, summary)
    for text in (page.words, summary):
        assert not re.search(r"\bnan\b|\bNone\b|\binf\b", text)
    return page, summary


def check_alone(page: Page) -> None:
    """Nothing is loaded from anywhere."""
    assert len(page.all("script")) == 1
    for tag, attributes in page.tags:
        assert tag not in ("link", "iframe", "object", "base")
        for name in ("src", "href", "xlink:href", "srcset"):
            value = attributes.get(name)
            assert value is None or value.startswith(("#", "data:image/jpeg;base64,")), value


def check_ids(page: Page) -> None:
    """Ids are unique, and what is referred to is there."""
    ids = [str(attributes["id"]) for _, attributes in page.tags if "id" in attributes]
    assert len(set(ids)) == len(ids)
    for _, attributes in page.tags:
        for key, value in attributes.items():
            link = r"^#(.*)" if key.endswith("href") else r"url\(#([^)]*)\)"
            for name in re.findall(link, value or ""):
                assert name in ids


def check_drawings(html: str) -> None:
    for drawing in re.findall(r"<svg.*?</svg>", html, flags=re.DOTALL):
        ElementTree.fromstring(drawing)


def check_tables(page: Page, summary: str) -> None:
    """All rows of a table have as many columns; heads can be used without a mouse."""
    for block in summary.split("\n\n"):
        if block.startswith("|"):
            rows = [re.split(r"(?<!\\)\|", line)[1:-1] for line in block.splitlines()]
            assert len({len(row) for row in rows}) == 1
            assert set("".join(rows[1])) <= set(" -")
    assert all("\n" not in row for row in summary.splitlines())
    heads = [attributes for attributes in page.all("th") if attributes.get("scope") == "col"]
    assert len(heads) == len(page.all("button"))


def said(
    share: float, sure: bool = True, seconds: float = 0.002, frames: int = 20
) -> TrackerOutput:
    """Return a trace that is right for a share of the frames."""
    good = round(share * frames)
    boxes = shifted([0.0] * good + [90.0] * (frames - good))
    confidence = [0.9] * good + [0.2] * (frames - good) if sure else np.nan
    return trace(boxes, confidence, [False] * good + [True] * (frames - good), seconds=seconds)


def full(folder: Path) -> list[Outcome]:
    """Return three trackers on two sequences with pictures and one without; one tracker fails."""
    book, ant = (sequence(n, source=pictures(folder / n)) for n in ("Book", "Ant"))
    gone = sequence("Gone", source=folder / "gone.mp4")
    outcomes = []
    for where in (book, ant, gone):
        for seed in range(3):
            outcomes.append(outcome("ours", where, said(0.7 + seed / 10), seed))
        outcomes.append(outcome(NASTY, where, said(0.4, sure=False, seconds=0.04)))
        outcomes.append(
            outcome("_third", where, "It broke <here>." if where is ant else said(0.55))
        )
    return outcomes


REFERENCE = Reference(
    "others.csv", {"MIL": {"book": 0.31, "cow": 0.4}, "TLD<b>": {"book": 0.52, "gone": 0.9}}
)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Page, str, str]:
    """Return the page, the summary and the file of a report with all there is."""
    folder = tmp_path_factory.mktemp("report")
    problems = [Problem("sequence <Cow>", "the frame 7 is missing")]
    page, summary = report(
        folder / "out", full(folder), problems, Comparisons(REFERENCE), "Trackers & <others>"
    )
    return page, summary, (folder / "out" / "report.html").read_text(encoding="utf-8")


def test_report(made: tuple[Page, str, str]) -> None:
    page, summary, html = made
    for text in (page.words, summary.replace("\\", "")):
        for name in ("ours", NASTY, "_third", "Book", "Ant", "Gone", "MIL", "TLD<b>"):
            assert name in text
        for words in (
            "Trackers & <others>",
            "3 trackers on 3 sequences, 3 seeds for stochastic trackers.",
            "Passes: 15 ope; 1 of them failed.",
            "sequence <Cow>",
            "the frame 7 is missing",
            "_third on Ant, ope, seed 0",
            "It broke <here>.",
            "2 of 3",
        ):
            assert words in text
    assert page.all("title") == [{}]
    assert "<script>alert" not in html
    assert "2 problems" in page.words


def test_numbers_in_the_report(made: tuple[Page, str, str]) -> None:
    page, summary, _ = made
    rows = {row[0]: row for row in reversed(page.rows)}
    auc = 20 / 21
    assert rows["ours"][1:3] == ["3 of 3", f"{0.8 * auc:.3f} ± {0.1 * auc:.3f}"]
    assert rows["_third"][1:3] == ["2 of 3", f"{0.55 * auc:.3f}"]
    assert rows["Ant"][1:] == [f"{0.8 * auc:.3f} ± {0.1 * auc:.3f}", f"{0.4 * auc:.3f}", "failed"]
    text = summary.replace("\\", "")
    difference = (0.4 - 0.8) * auc
    assert f"| {difference:+.3f} | {difference:+.3f} to {difference:+.3f} | 0 of 3 | 0 |" in text
    # The reference has two of our sequences, and all have a number on one of them.
    assert (
        f"| Gone | {0.8 * auc:.3f} | {0.4 * auc:.3f} | {0.55 * auc:.3f} | – | **0.900** |" in text
    )
    assert f"| mean of 1 | **{0.8 * auc:.3f}** | {0.4 * auc:.3f} | {0.55 * auc:.3f} |" in text
    # Every tracker says that it is lost exactly where it is.
    assert text.count("| 1.000 | 1.000 | 1.000 |") == 3 - 1  # with one seed
    assert "| 1.000 ± 0.000 | 1.000 ± 0.000 | 1.000 ± 0.000 |" in text


def test_plots(made: tuple[Page, str, str]) -> None:
    """One success plot, one precision plot, and diagrams of the trackers with a confidence."""
    page, _, html = made
    figures = re.findall(r"<figure>.*?</figure>", html, flags=re.DOTALL)
    assert ["success-ope-" in figure for figure in figures].count(True) == 1
    assert ["precision-ope-" in figure for figure in figures].count(True) == 1
    assert [figure.count("<strong>") for figure in figures if "reliability-" in figure] == [1, 1]
    assert f"Without a confidence: {NASTY}." in page.words
    success = next(figure for figure in figures if "success-ope-" in figure)
    legend = [" ".join(words.split()) for words in Page(success).text if ": 0." in words]
    auc = 20 / 21
    assert legend == [
        f"ours: {0.8 * auc:.3f}",
        f"_third: {0.55 * auc:.3f}",
        f"{NASTY}: {0.4 * auc:.3f}",
    ]
    assert success.count("currentColor") > 5  # ink follows the page, by day and by night
    assert "#123456" not in html
    assert "#654321" not in html


# Pictures


def test_pictures_of_failures(made: tuple[Page, str, str]) -> None:
    page, _, _ = made
    shown = [str(attributes["alt"]) for attributes in page.all("img")]
    assert shown == [
        "Book, ours, frame 14: confidence 0.20, reported lost: yes",
        "Ant, ours, frame 14: confidence 0.20, reported lost: yes",
        f"Book, {NASTY}, frame 8: confidence none, reported lost: yes",
        f"Ant, {NASTY}, frame 8: confidence none, reported lost: yes",
        "Book, _third, frame 11: confidence 0.20, reported lost: yes",
    ]
    assert "No pictures of Gone: There is no file or folder" in page.words
    assert "8 failures, 5 shown" in page.words
    for attributes in page.all("img"):
        jpeg = base64.b64decode(str(attributes["src"]).split(",")[1])
        image = Image.open(io.BytesIO(jpeg))
        assert image.format == "JPEG"
        assert image.size == (int(str(attributes["width"])), int(str(attributes["height"])))


def failure(name: str, where: Sequence, frame: int = 3, dx: float = 0) -> Failure:
    return Failure(name, where, frame, shifted([0])[0], shifted([dx])[0], 0.5, False)


def test_a_picture_shows_truth_and_estimate(tmp_path: Path) -> None:
    book = sequence(source=pictures(tmp_path / "Book", size=(160, 120)))
    ((picture,), reasons) = draw([failure("a", book, frame=10, dx=60)])
    assert not reasons
    pixels = np.asarray(Image.open(io.BytesIO(picture.jpeg))).astype(int)
    assert pixels[5, 5] == pytest.approx(np.full(3, 150), abs=4)  # the frame with this number
    red, green, blue = np.moveaxis(pixels, 2, 0)
    columns = np.flatnonzero(((green > red + 40) & (green > blue + 40)).any(axis=0))
    assert columns.min() == pytest.approx(19, abs=3)  # the target is 20 … 39
    assert columns.max() == pytest.approx(40, abs=3)
    columns = np.flatnonzero(((red > green + 40) & (red > blue + 40)).any(axis=0))
    assert columns.min() == pytest.approx(79, abs=3)
    assert columns.max() == pytest.approx(100, abs=3)


def test_pictures_of_odd_estimates(tmp_path: Path) -> None:
    """An estimate may be absent, huge, far away or without area."""
    book = sequence(source=pictures(tmp_path / "Book"))
    odd = [[np.nan] * 4, [-1e12, 0, 1e13, 5], [1e300, 1e300, 1, 1], [10, 10, 0, 0]]
    found = [failure("a", book)._replace(estimate=np.array(box, float)) for box in odd]
    shown, reasons = draw(found)
    assert len(shown) == len(odd)
    assert not reasons


def test_each_film_is_decoded_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    opened = []

    def counted(source: str | Path, *, start: int, end: int) -> Source:
        opened.append((Path(source).name, start, end))
        return open_source(source, start=start, end=end)

    monkeypatch.setattr("motes_lab.report.failures.open_source", counted)
    report(tmp_path / "out", full(tmp_path))
    assert opened == [("Book", 8, 15), ("Ant", 8, 15), ("gone.mp4", 8, 15)]


def test_what_a_failure_is() -> None:
    def first(dx: list[float], absent: tuple[int, ...] = ()) -> list[int]:
        where = sequence(frames=len(dx), absent=absent)
        found = failures(Evaluation([outcome("a", where, trace(shifted(dx)))]))
        return [failure.frame for failure in found]

    assert first([0.0] * 3 + [90.0] * 5) == [3]
    assert first([0.0] * 3 + [90.0] * 4) == []  # too short
    assert first([0.0, *[90.0] * 4, 0.0, *[90.0] * 5, 0.0]) == [6]
    assert first([0.0] * 20) == []
    assert first([0.0, *[90.0] * 6], (3,)) == []  # no target in between
    assert first([0.0, *[np.nan] * 5]) == [1]


def test_failures_are_those_of_the_lowest_seed_in_one_pass() -> None:
    where = sequence()
    found = failures(
        Evaluation(
            [
                outcome("a", where, said(0.2), 2),
                outcome("a", where, said(0.5), 1),
                outcome("a", where, said(0.1), 0, "reset"),
            ]
        )
    )
    assert [failure.frame for failure in found] == [10]


def test_chosen_failures_are_spread() -> None:
    places = [sequence(f"s{i}") for i in range(20)]
    found = [failure(name, where) for name in "abcd" for where in places]
    chosen = choose(found)
    assert len(chosen) == MAX_PICTURES == 24
    for name in "abcd":
        assert sum(failure.tracker == name for failure in chosen) == 6
    names = [failure.sequence.name for failure in chosen]
    assert {names.count(name) for name in names} <= {1, 2}
    assert len(set(names)) == 20
    assert [failure.tracker for failure in chosen] == sorted(f.tracker for f in chosen)
    few = [failure("a", where) for where in places[:3]] + [failure("b", places[0])]
    assert choose(few) == few
    assert choose(few, 2) == [few[0], few[3]]
    assert choose([]) == []


# Whatever comes


@pytest.mark.slow
@pytest.mark.parametrize(
    "outcomes",
    [
        [],
        [outcome("a", sequence(), said(1))],
        [outcome("a", sequence(), said(0.5, sure=False))],
        [outcome("a", sequence(), "broken"), outcome("b", sequence(), "broken")],
        [outcome("a", sequence(), "broken"), outcome("b", sequence(), said(0.3))],
        [outcome("a", sequence(frames=1), trace(shifted([0]), 0.5))],
        [outcome("a", sequence(frames=0), trace(shifted([])))],
        [outcome("a", sequence(frames=3, absent=[0, 1, 2]), trace(shifted([0, 0, 0]), 0.5))],
        [outcome("a", sequence(frames=3), trace(shifted([0, 0, 0]), [np.nan, 0.5, np.nan]))],
        [outcome("a", sequence(frames=3), trace(shifted([np.nan] * 3)))],
        [outcome("a", sequence(frames=3), trace(shifted([0] * 3), seconds=0))],
        [outcome(name, sequence(), said(0.5), 0, "reset") for name in "ab"],
        [outcome(name, sequence(), said(0.5), 0, "sre", "shift-up") for name in "ab"],
        [
            outcome("a", sequence(), said(0.5), 0, protocol)
            for protocol in ("reset", "tre", "ope", "sre")
        ],
    ],
    ids=[
        *("nothing", "one", "no confidence", "all failed", "first failed", "a start alone"),
        *("no frames", "no target", "some confidence", "no regions", "no time", "resets only"),
        *("perturbed only", "all protocols"),
    ],
)
def test_reports_of_odd_runs(tmp_path: Path, outcomes: list[Outcome]) -> None:
    page, _ = report(tmp_path / "out", outcomes, wanted=Comparisons(REFERENCE))
    for one in outcomes:
        assert one.item.tracker in page.words
        assert one.item.sequence in page.words


@pytest.mark.slow
def test_protocols_have_their_own_parts(tmp_path: Path) -> None:
    book = sequence()
    page, summary = report(
        tmp_path / "out",
        [outcome("a", book, said(0.5), 0, name) for name in ("reset", "tre", "ope", "sre")],
    )
    order = [
        "One pass (OPE)",
        "Perturbed starts (SRE)",
        "Perturbed times (TRE)",
        "Restarted after failures (VOT)",
    ]
    heads = [line.removeprefix("## ") for line in summary.splitlines() if line.startswith("## ")]
    assert heads == order
    places = [page.words.index(name) for name in order]
    assert places == sorted(places)
    assert "robustness" in page.words


def test_references_that_have_no_sequence_in_common(tmp_path: Path) -> None:
    """Each has a number somewhere, but on no sequence all have one."""
    runs = [outcome("a", sequence(name), said(0.5)) for name in ("Book", "Cow")]
    others = Reference("others.csv", {"MIL": {"book": 0.3}, "TLD": {"cow": 0.5}})
    _, summary = report(tmp_path / "out", runs, wanted=Comparisons(others))
    assert "| Book | **0.476** | 0.300 | – |" in summary
    assert "| mean of 0 | – | – | – |" in summary


def test_problems_are_named_once() -> None:
    book, cup = sequence(), sequence("Cup")
    runs = [
        outcome("a", book, "broken", 1),
        outcome("a", book, "slow", 0, "sre", "shift-up"),
        outcome("a", book, said(1)),
        outcome("a", cup, "broken", 0),
        outcome("a", cup, "broken", 1),
        outcome("b", cup, "broken"),
    ]
    told = [Problem("sequence X", "empty")]
    assert report_sections.problems(told, runs) == [
        *told,
        Problem("a on Book, ope, seed 1", "broken"),
        Problem("a on Book, sre shift-up, seed 0", "slow"),
        Problem("a, b on Cup, 3 passes", "broken"),
    ]


def test_numbers_for_people() -> None:
    assert number(None).text == number(float("nan")).text == NO_VALUE
    assert number(0.12345).text == "0.123"
    assert [three_digits(v).text for v in (0.0123456, 0.5, 9.996, 12.34, 1234.5, 0.0)] == [
        *("0.0123", "0.500", "10.0", "12.3", "1234", "0"),
    ]
    assert three_digits(float("nan")).text == NO_VALUE


def test_a_score_of_nothing_is_not_the_best() -> None:
    """Trackers that report no loss have an F1 of 0, and none where nothing was lost."""
    assert not any(cell.best for cell in best([number(0.0), number(0.0), number(None)]))
    assert [cell.best for cell in best([number(0.0), number(0.2), number(None)])] == [
        False, True, False,
    ]  # fmt: skip
    assert [cell.best for cell in best([number(0.0), number(0.2)], -1)] == [True, False]
