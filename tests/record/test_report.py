"""The report: one page that needs nothing else, true to the summary, sensible for every flight folder."""

from __future__ import annotations

import dataclasses
import json
import re
import shutil
import sys
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from companion.cli.commands import app
from companion.config.syntax.faults import ConfigError
from companion.flight.phases import Phase
from companion.record import report
from companion.record.report import errors, figures, motion, write_report, zoom
from companion.record.report.curves import points_along, points_to_draw
from companion.record.report.evidence import Evidence, read_evidence
from companion.record.report.figures import inline
from companion.record.report.page import page_text
from companion.record.report.style import drawing
from companion.record.report.text import number_text
from companion.record.summary import summary
from companion.vehicle import CompanionError, OutputLevel

pytestmark = pytest.mark.xdist_group("report")

HOSTILE = "<script>alert('x')</script>&\"<img src=x onerror=alert(1)>"
MISSION = """
mission: {name}
frame: enu
path: {{kind: implicit, constants: {{r: 2.0}}, h1: "hypot(x, y) - r", h2: z - 10, near: [0, 2, 10]}}
speed: 2.0
yaw: 0.0
"""


def fly(mission: str, directory: Path, duration: float, settle: float) -> Path:
    """A lockstep flight."""
    words = ["sim", mission, "--output", "motors", "--record", str(directory)]
    result = CliRunner().invoke(app, [*words, "--duration", str(duration), "--settle", str(settle)])
    assert result.exit_code == 0, result.output
    return directory


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A completed flight of more than a lap under a hostile name, and its report."""
    directory = tmp_path_factory.mktemp("flights")
    mission = directory / "mission.yaml"
    mission.write_text(MISSION.format(name=json.dumps(HOSTILE)), encoding="utf-8")
    flight = fly(str(mission), directory / "flight", 8.0, 3.0)
    write_report(flight)
    return flight


@pytest.fixture
def copy(flown: Path, tmp_path: Path) -> Path:
    """The same flight, to spoil."""
    return Path(shutil.copytree(flown, tmp_path / "copy", ignore=shutil.ignore_patterns("report.html", "link.tlog")))


def cut(directory: Path, rows: int) -> None:
    """What a daemon leaves behind that is killed after so many ticks: no summary."""
    (directory / "summary.json").unlink()
    np.save(directory / "flight.npy", np.load(directory / "flight.npy")[:rows])


def ticks_until(directory: Path, phase: Phase) -> int:
    """How many ticks came before a phase."""
    return int(np.argmax(np.load(directory / "flight.npy")["phase"] == list(Phase).index(phase)))


class Reader(HTMLParser):
    """What a browser would see: tags that do not match, what is loaded, ids, the text."""

    VOID = frozenset({"meta", "br", "hr", "img", "input", "link"})

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str]] = []
        self.text = ""
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += [(name, value or "") for name, value in attributes]
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += [(name, value or "") for name, value in attributes]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data

    def values(self, name: str) -> list[str]:
        """Of every attribute of that name."""
        return [value for key, value in self.attributes if key == name]


def page_of(directory: Path) -> str:
    """The page without its figures, which take their time."""
    return page_text(read_evidence(directory), [])


def read(directory: Path) -> Reader:
    """The report of a flight folder, well-formed or not at all."""
    reader = Reader(write_report(directory).read_text(encoding="utf-8"))
    assert reader.open == []
    return reader


def test_the_page_needs_nothing_else(flown: Path) -> None:
    text = (flown / "report.html").read_text(encoding="utf-8")
    reader = Reader(text)
    assert reader.open == []
    assert "http:" not in text and "https:" not in text and "@import" not in text
    assert not {"link", "img", "iframe", "object", "embed"} & set(reader.tags)
    assert not reader.values("src")
    assert all(value.startswith("#") for value in reader.values("href"))
    assert re.findall(r"url\(([^)]*)\)", text) and all(u.startswith("#") for u in re.findall(r"url\(([^)]*)\)", text))
    without_library = re.sub(r'<script type="text/plain" id="plotly-packed">.*?</script>', "", text)
    assert len(without_library) < 1_000_000 and len(text) < 4_000_000


def test_ids_are_the_pages_own(flown: Path) -> None:
    text = (flown / "report.html").read_text(encoding="utf-8")
    reader = Reader(text)
    ids = reader.values("id")
    assert len(ids) == len(set(ids))
    named = {value[1:] for value in reader.values("href")} | set(re.findall(r"url\(#([^)]*)\)", text))
    assert named <= set(ids)


def test_every_figure_is_there_with_its_sentence(flown: Path) -> None:
    text = (flown / "report.html").read_text(encoding="utf-8")
    names = re.findall(r'<figure id="figure-([\w-]+)">', text)
    drawn = ["above", "space", "errors-time", "errors-path", "speed-yaw", "motion", "motion-late"]
    assert names == [*drawn, "machine", "surroundings"]  # at motors too the vehicle is estimated
    captions = re.findall(r"<figcaption><b>Figure (\d+)\.</b> (.*?)</figcaption>", text)
    assert [int(number) for number, _ in captions] == list(range(1, 10))
    assert all(caption.endswith(".") and caption.count(". ") <= 1 for _, caption in captions)
    for label in ("east, m", "north, m", "up, m", "speed, m/s", "path error, cm", "G1 path error, cm",
                  "G2 speed error, m/s", "G3 yaw error, deg", "displacement along the path s, m", "Thrust, N",
                  "Roll and pitch, deg", "Motor commands, N", "time since following began, s"):  # fmt: skip
        assert label in re.sub(r"\s+", " ", text), label
    assert "lockstep" in text and "no latency to measure" in text


def test_the_key_figures_are_the_summarys(flown: Path) -> None:
    text = (flown / "report.html").read_text(encoding="utf-8")
    summary = json.loads((flown / "summary.json").read_text(encoding="utf-8"))
    shown = {float(value) for value in re.findall(r'<data value="([^"]*)">', text)}
    for part in (summary["follow"], summary["settled"], summary["truth"]["settled"]):
        for key in ("path_error_m", "speed_error_mps", "yaw_error_deg"):
            assert {part[key]["rms"], part[key]["max"]} <= shown
        assert {part["duration_s"], part["distance_m"], part["laps"]} <= shown
    settled = summary["settled"]
    assert {settled["roll_max_deg"], settled["pitch_max_deg"], settled["tilt_max_deg"]} <= shown
    assert {settled["thrust_n"]["min"], settled["thrust_n"]["max"], settled["motor"]["max"]} <= shown
    row = re.search(r"Path error \(G1\), largest.*?</tr>", text)
    assert row is not None
    words = re.findall(r'<data value="[^"]*">(.*?)</data>', row[0])
    assert words[0] == number_text(100.0 * summary["follow"]["path_error_m"]["max"])
    # the settled figures above the panels are the same, in the panels' units
    panel = f"settled: rms {number_text(settled['yaw_error_deg']['rms'])}, largest {number_text(settled['yaw_error_deg']['max'])}"
    assert panel.replace("<", "&lt;") in text
    assert "settled from 3 s" in text


def test_what_a_file_says_is_text(flown: Path) -> None:
    text = (flown / "report.html").read_text(encoding="utf-8")
    assert HOSTILE in Reader(text).text
    ours = (
        '<script type="application/json" class="chart">',
        '<script type="text/plain" id="plotly-packed">',
        "<script>",
    )
    found = re.findall(r"<script[^>]*>", text)
    assert set(found) == set(ours) and found.count("<script>") == 1
    assert "<img" not in text


def test_the_same_flight_gives_the_same_page(flown: Path) -> None:
    before = (flown / "report.html").read_bytes()
    assert write_report(flown).read_bytes() == before


def test_notes_stand_out(copy: Path) -> None:
    summary = json.loads((copy / "summary.json").read_text(encoding="utf-8"))
    summary["notes"] = ["the motors go <negative>"]
    (copy / "summary.json").write_text(json.dumps(summary), encoding="utf-8")
    assert '<div class="notes"><h2>Take note</h2><ul><li>The motors go &lt;negative&gt;.</li>' in page_of(copy)


def test_an_aborted_flight_says_why(copy: Path) -> None:
    summary = json.loads((copy / "summary.json").read_text(encoding="utf-8"))
    summary |= {"outcome": "aborted", "reason": "state is stale"}
    (copy / "summary.json").write_text(json.dumps(summary), encoding="utf-8")
    text = page_of(copy)
    assert re.search(
        r'<p class="outcome aborted">Aborted after following the path for 8\.00\s?s .*: state is stale\.', text
    )


def test_while_the_pilot_has_it_nothing_is_followed_and_nothing_is_late(flown: Path) -> None:
    """He takes it for 6 s: no gap between setpoints, no following, and what comes after settles anew."""
    table, plan = np.load(flown / "flight.npy"), read_evidence(flown).plan
    whole = summary(plan, table, None, 1.0, "completed", None, None)
    followed = np.flatnonzero(table["phase"] == list(Phase).index(Phase.FOLLOW))
    middle = followed[len(followed) // 2]
    table["phase"][middle - 10 : middle] = list(Phase).index(Phase.STAND_BY)
    for clock in ("t_boot", "now"):
        table[clock][middle:] += 6.0
    table["speed"][middle : middle + 100] = 0.0  # from a hover again
    interrupted = summary(plan, table, None, 1.0, "completed", None, None)
    assert interrupted["loop"]["gap_max_ms"] == pytest.approx(whole["loop"]["gap_max_ms"])
    assert interrupted["follow"]["duration_s"] == pytest.approx(whole["follow"]["duration_s"], abs=0.1)
    assert interrupted["follow"]["speed_error_mps"]["max"] > 1.9
    assert interrupted["settled"]["speed_error_mps"]["max"] <= whole["settled"]["speed_error_mps"]["max"]


def test_a_killed_flight_is_told_from_its_record(copy: Path) -> None:
    cut(copy, 1200)
    reader = read(copy)
    assert "the record ends in the middle of the flight" in reader.text and "(follow)" in reader.text
    assert "The folder holds no summary" in reader.text
    assert reader.tags.count("figure") == 8


def test_a_flight_whose_summary_was_cut_short_keeps_its_outcome(copy: Path) -> None:
    (copy / "summary.json").write_text('{"schema": "companion.fl', encoding="utf-8")
    (copy / "truth.npy").unlink()
    text = page_of(copy)
    assert "Completed: followed the path" in text
    assert "Settled, true" not in text


@pytest.mark.parametrize("more", [0, 1, 3])
def test_a_flight_that_hardly_followed(copy: Path, more: int) -> None:
    cut(copy, ticks_until(copy, Phase.FOLLOW) + more)
    reader = read(copy)
    assert "Aborted" in reader.text
    assert ("never came to follow" in reader.text) == (more < 2)


def test_an_empty_record(copy: Path) -> None:
    cut(copy, 0)
    np.save(copy / "truth.npy", np.load(copy / "truth.npy")[:0])
    reader = read(copy)
    assert "the record ends before the first tick" in reader.text and "figure" not in reader.tags
    (copy / "truth.npy").unlink()
    assert "the record ends before the first tick" in page_of(copy)


def test_a_summary_of_another_shape(copy: Path) -> None:
    parts = dict.fromkeys(("vehicle", "output", "phases", "follow", "settled", "loop"), "odd")
    (copy / "summary.json").write_text(
        json.dumps({"mission": 3, "outcome": None, "notes": {"a": 1}, **parts}), encoding="utf-8"
    )
    assert "Aborted" in read(copy).text


def test_not_a_flight_folder(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"resolved\.json is missing; expected a flight folder"):
        write_report(tmp_path)


def test_without_matplotlib_it_says_what_to_install(flown: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.startswith(f"{report.__name__}.")]:
        monkeypatch.delitem(sys.modules, name)
    for name in ("figures", "maps", "curves", "style", "errors", "motion", "vehicle"):
        monkeypatch.delattr(report, name)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(CompanionError, match=re.escape("pip install 'px4-path-companion[report]'")):
        write_report(flown)


def in_real_time(evidence: Evidence) -> Evidence:
    """The same flight as if it had been flown in real time: uneven gaps, and latencies."""
    table = evidence.table.copy()
    chance = np.random.default_rng(0)
    table["now"] += chance.uniform(0.0, 1e-3, len(table))
    table["latency"] = chance.uniform(2e-4, 9e-4, len(table))
    return dataclasses.replace(evidence, table=table, resolved={**evidence.resolved, "epoch": 1.8e9})


def test_a_real_time_flight_shows_its_timing_and_date(flown: Path) -> None:
    evidence = in_real_time(read_evidence(flown))
    text = page_text(evidence, figures.figure_sections(evidence))
    assert 'id="figure-gaps"' in text and 'id="figure-latency"' in text
    assert "gap between setpoints, ms" in text and "state to setpoint, ms" in text
    assert "15 January 2027" in text and "simulated, in real time" in text
    text = page_text(dataclasses.replace(evidence, truth=None), [])
    assert "real-time flight" in text and "simulated" not in text


@pytest.mark.parametrize("level", [OutputLevel.RATES, OutputLevel.ATTITUDE])
def test_other_levels_show_rates_instead_of_motors(flown: Path, level: OutputLevel) -> None:
    evidence = read_evidence(flown)
    plan = dataclasses.replace(evidence.plan, level=level)
    table = evidence.table.copy()
    table["sent_4"] = 0.5
    evidence = dataclasses.replace(evidence, plan=plan, table=table)
    with drawing():
        text = inline(motion.motion_figure(evidence, motion.whole(evidence)), "motion", "rates")
    assert "Body rate p, deg/s" in text and "setpoint" in text
    assert "Motor commands, N" not in text


@pytest.mark.parametrize(
    ("value", "words"),
    [(0.0, "0"), (0.00004, "< 0.0001"), (0.02424, "0.0242"), (0.5, "0.500"), (66.4428, "66.44"), (-101.04, "−101.0"),
     (4321.0, "4321")],
)  # fmt: skip
def test_numbers_read_well(value: float, words: str) -> None:
    assert number_text(value) == words


def test_thinning_loses_no_spike() -> None:
    t = np.linspace(0.0, 60.0, 60_001)
    y = np.sin(t)
    y[31_234] = 9.0
    y[60_000] = -7.0
    y[100] = np.nan
    chosen = points_to_draw(y)
    assert len(chosen) <= 1700
    assert {0, 31_234, 60_000} <= set(chosen)
    hover = np.concatenate([np.zeros((5000, 3)), np.linspace([0.0, 0.0, 0.0], [10.0, 0.0, 0.0], 5000)])
    track = points_along(hover, 100)
    assert np.max(np.linalg.norm(np.diff(hover[track], axis=0), axis=1)) < 0.2


def test_what_is_believed_and_what_is_true_stand_side_by_side(flown: Path) -> None:
    text = (flown / "report.html").read_text(encoding="utf-8")
    truth = json.loads((flown / "summary.json").read_text(encoding="utf-8"))["truth"]["settled"]
    tiles = re.search(r'<dl class="tiles">.*?</dl>', text, re.DOTALL)
    assert tiles is not None
    for key in ("path_error_m", "speed_error_mps", "yaw_error_deg"):
        assert f'<b><data value="{truth[key]["rms"]!r}">' in tiles[0]
    assert "rms, estimated" in tiles[0] and "rms, true" in tiles[0]


def test_the_world_and_the_version_stand_in_the_page(flown: Path) -> None:
    facts = re.search(r'<p class="facts">.*?</p>', (flown / "report.html").read_text(encoding="utf-8"))
    assert facts is not None
    assert all(word in facts[0] for word in ("world ideal", "still air", "seed 0", "companion 0."))


def held(evidence: Evidence) -> Evidence:
    """The same flight, told that somebody held it from 3 to 4 s."""
    page = {"kind": "hold", "what": "held still", "from_s": 3.0, "to_s": 4.0, "after": "start"}
    return dataclasses.replace(evidence, resolved={**evidence.resolved, "simulation": {"events": [page]}})


def test_what_happened_is_told_shaded_and_marked(flown: Path) -> None:
    evidence = held(read_evidence(flown))
    first = float(evidence.estimated["t_boot"][0])
    (hold,) = [each for each in evidence.flight_events if each.kind == "hold"]
    assert (hold.begin, hold.end) == pytest.approx((3.0 - first, 4.0 - first), abs=0.01)
    assert hold.ahead == pytest.approx(2.0, abs=0.1)
    text = page_text(evidence, figures.figure_sections(evidence))
    assert "held still for 1.0 s" in text and "a timetable: 2.0 m ahead" in text and "held 1.0 s" in text
    charts = [json.loads(each) for each in re.findall(r'class="chart">(.*?)</script>', text)]
    spans = [shape for shape in charts[1]["layout"]["shapes"] if shape["type"] == "rect"]
    assert len(spans) == 3 and all(span["x0"] == pytest.approx(hold.begin) for span in spans)


def test_what_is_zoomed_into_is_what_is_drawn(flown: Path) -> None:
    evidence = read_evidence(flown)
    with drawing():
        figure = errors.over_time(evidence)
        inline(figure, "errors-time", "errors")
        chart = json.loads(zoom.chart(figure))
    estimated = [trace for trace in chart["data"] if trace["name"] == "as estimated"]
    assert [trace["yaxis"] for trace in estimated] == ["y", "y2", "y3"]
    assert sum(trace["showlegend"] for trace in estimated) == 1
    error = 100.0 * evidence.estimated["path_error"]
    assert max(estimated[0]["y"]) == pytest.approx(np.max(error), rel=1e-4)
    assert chart["layout"]["xaxis3"]["title"]["text"] == "time since following began, s"


def test_a_flight_writes_its_page_and_never_fails_for_want_of_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    words = ["sim", "circle_r5", "--duration", "1", "--settle", "0.5", "--report", "--record"]
    assert CliRunner().invoke(app, [*words, str(tmp_path / "with")]).exit_code == 0
    assert (tmp_path / "with" / "report.html").is_file()

    def missing(directory: Path) -> Path:
        raise CompanionError("the report draws with matplotlib: pip install 'px4-path-companion[report]'")

    monkeypatch.setattr(report, "write_report", missing)
    without = CliRunner().invoke(app, [*words, str(tmp_path / "without")])
    assert without.exit_code == 0 and without.stderr.count("pip install 'px4-path-companion[report]'") == 1
    monkeypatch.setattr(report, "write_report", lambda directory: 1 / 0)
    broken = CliRunner().invoke(app, [*words, str(tmp_path / "broken")])
    assert broken.exit_code == 0 and "ZeroDivisionError" in broken.stderr


@pytest.mark.parametrize("name", ["resolved.json", "mission.yaml", "vehicle.yaml", "flight.npy"])
def test_the_broken_file_is_named(copy: Path, name: str) -> None:
    (copy / name).write_text("- garbage", encoding="utf-8")
    for command in ("report", "replay"):
        broken = CliRunner().invoke(app, [command, str(copy)])
        assert isinstance(broken.exception, ConfigError) and str(copy / name) in str(broken.exception)
