"""Flies a mission of each kind and draws it: docs/gallery.md, with a picture and the file of each.

The pictures show the path, and the flight on it coloured by its speed; the arrows are the nose.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import tempfile
from pathlib import Path

import matplotlib as mpl
import numpy as np

from companion.cli.check import check_sortie
from companion.cli.finish import Ending
from companion.cli.output import Output
from companion.cli.simulate import Simulation, in_lockstep
from companion.config.syntax.file_lookup import SHIPPED
from companion.library.orders import Sortie, read_sortie, read_world
from companion.library.simulation import at_home
from companion.record.table import load_table
from companion.world import World

mpl.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from mpl_toolkits.mplot3d.art3d import Line3DCollection

KINDS = {
    "circle": "circle",
    "ellipse": "ellipse",
    "figure8": "lissajous",
    "lissajous": "lissajous, with three numbers that are not alike",
    "line": "line",
    "polyline": "polyline",
    "spline": "spline",
    "expression": "expression",
    "helix": "helix",
    "circle_r5": "implicit",
    "survey": "plan",
}
"""The shipped missions that are flown, and the kind of path of each."""
LONGEST = 110.0
"""s of following."""
NOSES = 24
HEAD = """\
# The paths there are

Each was flown in simulation (`companion sim NAME`), on an x500 at the level of rates. The line is the path, its colour
the speed of the flight on it, the arrows the nose. `companion new KIND` writes a commented file of any of these to
begin from; `companion check NAME` says what it asks of a vehicle. Made by `make gallery`.
"""


def flown(sortie: Sortie, folder: Path) -> dict[str, np.ndarray]:
    """The true positions (NED, m), speeds (m/s), headings (rad) and path errors (m) of one flight while it followed."""
    mission = sortie.mission
    slowest = np.array([abs(mission.alpha(float(s))) for s in np.linspace(0.0, mission.table.length, 300)])
    once = float(mission.table.length * np.mean(1.0 / slowest)) + 3.0
    simulation = Simulation(sortie, read_world("ideal", 0), False, min(once, LONGEST), folder, Ending(True, 2.0))
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        code = in_lockstep(simulation)
    if code != 0:
        raise SystemExit(f"{mission.name}: not flown")
    table = load_table(folder / "flight.npy")
    rows = table[np.isfinite(table["path_error"]) & (table["fresh"] == 1) & (np.abs(table["alpha"]) > 0.0)]
    return {
        "p": np.stack([rows["north"], rows["east"], rows["down"]], axis=1),
        "speed": np.sqrt(rows["v_north"] ** 2 + rows["v_east"] ** 2 + rows["v_down"] ** 2),
        "yaw": rows["yaw"],
        "error": rows["path_error"],
    }


def picture(sortie: Sortie, flight: dict[str, np.ndarray], file: Path) -> None:
    """Draw it: x east, y north, height."""
    path = at_home(sortie.mission, World())[0].table.samples(1500)[1]
    figure = plt.figure(figsize=(5.6, 4.2))
    axes: Axes = figure.add_axes((0.0, 0.02, 0.82, 0.98), projection="3d")
    axes.plot(path[:, 1], path[:, 0], -path[:, 2], color="0.75", linewidth=3.0, zorder=1)
    low = float(-path[:, 2].max()) - 0.25 * float(np.ptp(path[:, :2]))
    axes.plot(path[:, 1], path[:, 0], low, color="0.9", linewidth=1.0)  # its shadow
    points = flight["p"][:: max(1, len(flight["p"]) // 900)]
    colours = flight["speed"][:: max(1, len(flight["p"]) // 900)]
    xyz = np.stack([points[:, 1], points[:, 0], -points[:, 2]], axis=1)
    line = Line3DCollection(np.stack([xyz[:-1], xyz[1:]], axis=1), cmap="viridis", linewidth=1.6, zorder=3)
    line.set_array(colours[:-1])
    line.set_clim(0.0, max(1.0, float(colours.max())))
    axes.add_collection(line)
    gone = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(flight["p"], axis=0), axis=1))])
    chosen = np.searchsorted(gone, np.linspace(0.0, 0.999 * gone[-1], NOSES))
    at, yaw = flight["p"][chosen], flight["yaw"][chosen]
    size = 0.09 * float(np.ptp(path[:, :2], axis=0).max())
    axes.quiver(at[:, 1], at[:, 0], -at[:, 2], np.sin(yaw) * size, np.cos(yaw) * size, 0.0 * yaw,
                color="tab:red", linewidth=0.8, arrow_length_ratio=0.35)  # fmt: skip
    axes.set_xlabel("east, m", size=8)
    axes.set_ylabel("north, m", size=8)
    axes.set_zlabel("height, m", size=8, labelpad=2.0)
    axes.tick_params(labelsize=7)
    axes.locator_params(nbins=5)
    axes.view_init(elev=32.0, azim=-62.0)
    spans = [float(np.ptp(limits)) for limits in (axes.get_xlim(), axes.get_ylim(), axes.get_zlim())]
    axes.set_box_aspect(spans, zoom=0.95)  # a metre is as long along each axis
    bar = figure.colorbar(line, cax=figure.add_axes((0.89, 0.25, 0.025, 0.5)))
    bar.set_label("m/s", size=8)
    bar.ax.tick_params(labelsize=7)
    figure.savefig(file, dpi=90)
    plt.close(figure)


def main() -> None:
    """Write the page and its pictures."""
    options = argparse.ArgumentParser()
    options.add_argument("--docs", type=Path, default=Path(__file__).resolve().parent.parent / "docs")
    options.add_argument("--only", choices=KINDS, help="one picture, and no page")
    given = options.parse_args()
    pictures = given.docs / "gallery"
    pictures.mkdir(exist_ok=True)
    page = [HEAD]
    for name, kind in KINDS.items():
        if given.only not in (None, name):
            continue
        sortie = check_sortie(read_sortie(name, None, Output.RATES, direct=True))[0]
        with tempfile.TemporaryDirectory() as folder:
            flight = flown(sortie, Path(folder))
        picture(sortie, flight, pictures / f"{name}.png")
        settled = flight["error"][len(flight["error"]) // 4 :]
        said = f"{1000.0 * float(settled.max()):.0f} mm from the path at most, once settled"
        print(f"{name}: {said}")
        text = (SHIPPED / "missions" / f"{name}.yaml").read_text(encoding="utf-8").split("\n", 1)[1]
        page.append(f"\n## {kind}\n\n![{name}](gallery/{name}.png)\n\n`{name}`: {said}.\n\n```yaml\n{text}```\n")
    if given.only is None:
        (given.docs / "gallery.md").write_text("".join(page), encoding="utf-8")


if __name__ == "__main__":
    main()
