"""Every example runs, made short, and shows what it says it shows."""

from __future__ import annotations

import importlib.util
import json
import math
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

pytest.importorskip("matplotlib").use("Agg")
EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def example(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_each_has_a_test() -> None:
    tested = {name.removeprefix("test_") for name in globals() if name.startswith("test_")}
    assert {path.stem for path in EXAMPLES.iterdir() if path.suffix in (".py", ".ipynb")} <= tested


def test_paper_cases(tmp_path: Path) -> None:
    flights = example("paper_cases").main(tmp_path, seconds=1.5, reports=False)
    assert [flight.completed for flight in flights] == [True, True]
    assert (tmp_path / "paper_cases.svg").stat().st_size > 10_000
    assert (tmp_path / "paper-case2" / "flight.npy").is_file()


def test_own_path(tmp_path: Path) -> None:
    flight = example("own_path").main(tmp_path, seconds=3.0)
    assert flight.completed and float(np.nanmax(np.abs(flight.xi["h1"]))) < 0.5
    assert "hypot(x, y)" in (tmp_path / "tilted_circle.yaml").read_text(encoding="utf-8")


def test_gain_sweep(tmp_path: Path) -> None:
    errors = example("gain_sweep").main(tmp_path, seconds=1.5, count=2)
    assert len(errors) == 2 and all(0.0 < error < 100.0 for error in errors)
    assert (tmp_path / "gain_sweep.svg").is_file()


def test_held_back(tmp_path: Path) -> None:
    tracks = example("held_back").main(tmp_path, seconds=9.0, held_at=4.0)
    off = {who: max(abs(math.hypot(*s.p_n[:2]) - 5.0) for s in track) for who, track in tracks.items()}
    fastest = {who: max(math.hypot(*s.v_n) for s in track) for who, track in tracks.items()}
    assert off["path following"] < 0.5 and fastest["path following"] < 3.5
    assert off["time tracking"] > 2.0 * off["path following"] and fastest["time tracking"] > 3.7


def test_paper_and_own_path(monkeypatch: pytest.MonkeyPatch) -> None:
    notebook = json.loads((EXAMPLES / "paper_and_own_path.ipynb").read_text(encoding="utf-8"))
    cells = ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]
    assert not any(cell.get("outputs") for cell in notebook["cells"])
    names: dict[str, object] = {}
    exec(compile("\n".join(cells).replace("SECONDS = 20.0", "SECONDS = 2.0"), "notebook", "exec"), names)
    assert names["SECONDS"] == 2.0 and getattr(names["flight"], "completed", False)
