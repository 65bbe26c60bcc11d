"""The figure of docs/rivals.md: path errors side by side, and what being held back does."""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from trials.rivals.course import circle, figure_eight
from trials.rivals.figures import Figures
from trials.rivals.sorties import ATTITUDE, ITS_OWN, PX4, RATES, TRACKER, Sortie

COLOURS = {PX4: "#b0b7c3", ITS_OWN: "#b0b7c3", TRACKER: "#e08a2c", ATTITUDE: "#7fb7d6", RATES: "#1f6fa8"}
LEAST = 0.02
"""cm; below it a bar is drawn as high as this."""


def draw(results: dict[Sortie, Figures], path: Path) -> None:
    """Three panels: PX4's simulated vehicle, outdoors, held back."""
    plt.rcParams.update(
        {"font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "svg.hashsalt": "rivals"}
    )
    figure, (calm, windy, held) = plt.subplots(1, 3, figsize=(13.5, 4.2), layout="constrained")
    courses = [circle(3.0), circle(5.0), circle(7.0), figure_eight(3.0)]
    _bars(calm, [c.name for c in courses], {
        who: [[results[Sortie(who, "SIH", c)]] for c in courses] for who in (PX4, TRACKER, ATTITUDE, RATES)
    })  # fmt: skip
    calm.set_title("PX4's simulated vehicle: believed path error, RMS", loc="left")
    outside = [circle(3.0), circle(6.0), figure_eight(3.0)]
    _bars(windy, [c.name for c in outside], {
        who: [[f for s, f in results.items() if s[:3] == (who, "outdoor", c)] for c in outside]
        for who in (PX4, TRACKER, ATTITUDE, RATES)
    })  # fmt: skip
    windy.set_title("Outdoors, gusts and noise: worst seed", loc="left")
    _held(held, results)
    figure.legend(*calm.get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False)
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


def _bars(axes: plt.Axes, names: list[str], rows: dict[str, list[list[Figures]]]) -> None:
    width = 0.8 / len(rows)
    for k, (who, cells) in enumerate(rows.items()):
        heights = [max([LEAST, *(100.0 * f.path_rms for f in cell if not f.lost)]) for cell in cells]
        places = [i + (k - 0.5 * (len(rows) - 1)) * width for i in range(len(names))]
        bars = axes.bar(places, heights, width, color=COLOURS[who], label=who)
        axes.bar_label(bars, [f"{h:.1f}" for h in heights], fontsize=6.5, padding=1)
    axes.set_yscale("log")
    axes.set_ylabel("cm")
    axes.set_xticks(range(len(names)), [name.replace(" at ", "\n") + " m/s" for name in names])


def _held(axes: plt.Axes, results: dict[Sortie, Figures]) -> None:
    names = []
    for k, (who, speed) in enumerate((who, speed) for speed in (3.0, 6.0) for who in (PX4, TRACKER, ATTITUDE, RATES)):
        seen = results[Sortie(who, "calm", circle(speed), 24.0, 16.0, held=(12.0, 16.0))]
        names.append(f"{speed:g} m/s")
        place = k + (0.6 if speed > 5.0 else 0.0)
        if seen.lost:
            axes.text(place, 0.05, "ended by\na guard", rotation=90, fontsize=6.5, ha="center", va="bottom")
            continue
        bar = axes.bar(place, seen.path_max, 0.8, color=COLOURS[who])
        axes.bar_label(bar, [f"{seen.path_max:.2f}"], fontsize=6.5, padding=1)
    axes.set_xticks([1.5, 6.1], ["circle r5\n3 m/s", "circle r5\n6 m/s"])
    axes.set_ylabel("m")
    axes.set_title("Held for 4 s, let go: farthest from the path", loc="left")
