"""QGroundControl's .plan -> plans."""

from __future__ import annotations

import math
from typing import Any

from companion.config.plan.polygons import is_polygon, refuse
from companion.config.plan.waypoints import is_waypoints, waypoints_from
from companion.config.syntax.document import Document
from companion.config.syntax.faults import ConfigError, Fault, Key
from companion.config.syntax.json_text import parse_json
from companion.geodesy import Home
from companion.mavlink_common import MAV_AUTOPILOT_GENERIC, MAV_AUTOPILOT_PX4
from companion.plans.items import FenceArea, Item, Place, Plan
from companion.plans.scan import StructureScan, scan_items

SUFFIXES = (".plan", ".waypoints")
MULTIROTORS = frozenset({2, 13, 14, 15, 29, 35})
"""MAV_TYPE."""
LANDING_PATTERNS = {"fwLandingPattern": "a fixed wing's landing", "vtolLandingPattern": "a VTOL's landing"}
FAULTS_MAX = 50
"""faults told of one file: more are the same one again."""


def plan_from(text: str, file: str) -> tuple[Plan, Document]:
    """The plan in a file's ``text``, and the document that knows its lines. ConfigError with every fault."""
    if is_polygon(file):
        refuse(text, file)
    if is_waypoints(text, file):
        return waypoints_from(text, file)
    document = parse_json(text, file)
    reader = _Reader(document)
    plan = reader.plan()
    if reader.faults:
        raise ConfigError(reader.faults[:FAULTS_MAX])
    return plan, document


class _Reader:
    """Reads one .plan; what is wrong goes into ``faults``."""

    def __init__(self, document: Document) -> None:
        self._document = document
        self.faults: list[Fault] = []

    def plan(self) -> Plan:
        """All of it."""
        root = self._document.data
        if not isinstance(root, dict) or root.get("fileType") != "Plan":
            self._fault(("fileType",), 'is not "Plan"; expected a .plan, as QGroundControl saves it today')
            return Plan(())
        self._version(root, ("version",), 1)
        mission = self._mapping(root, ("mission",))
        notes = []
        if mission is None:
            return Plan(())
        self._version(mission, ("mission", "version"), 2)
        if mission.get("firmwareType", MAV_AUTOPILOT_PX4) not in (MAV_AUTOPILOT_PX4, MAV_AUTOPILOT_GENERIC):
            notes.append("the plan was made for another autopilot than PX4")
        if mission.get("vehicleType", 2) not in MULTIROTORS:
            notes.append("the plan was made for another kind of vehicle than a multirotor")
        speed = mission.get("hoverSpeed")
        if speed is not None and (not _is_number(speed) or not 0.0 < speed <= 100.0):
            self._fault(("mission", "hoverSpeed"), f"{_printable(speed)} is no speed; expected 0 to 100 m/s")
            speed = None
        return Plan(
            items=tuple(self._items(mission)),
            home=self._home(mission.get("plannedHomePosition")),
            speed=None if speed is None else float(speed),
            fence=tuple(self._fence(root)),
            rally=tuple(self._rally(root)),
            notes=tuple(notes),
        )

    def _home(self, given: Any) -> Home | None:
        """None, or an altitude of None, where it is not known: ground stations write 0 for that."""
        if given is None:
            return None
        key: Key = ("mission", "plannedHomePosition")
        if isinstance(given, list) and len(given) == 3 and given[2] is None:
            given = given[:2]
        read = self._numbers(given, key, 2 if isinstance(given, list) and len(given) == 2 else 3)
        if read is None or (read[0] == 0.0 and read[1] == 0.0):
            return None
        if abs(read[0]) > 89.0 or abs(read[1]) > 180.0 or (len(read) == 3 and not abs(read[2]) < 10_000.0):
            self._fault(key, f"{', '.join(f'{value:g}' for value in read)} is no place on the earth")
            return None
        return Home(read[0], read[1], read[2] or None if len(read) == 3 else None)

    def _items(self, mission: dict[str, Any]) -> list[Item]:
        found: list[Item] = []
        for i, given in enumerate(self._list(mission, ("mission", "items"))):
            key: Key = ("mission", "items", i)
            if not isinstance(given, dict):
                self._fault(key, f"{_printable(given)} is not an item")
            elif given.get("type") == "ComplexItem":
                found += self._complex(given, key, found[-1].number + 1 if found else 1)
            elif given.get("type") == "SimpleItem":
                found += self._simple(given, key)
            else:
                kinds = "SimpleItem or ComplexItem"
                self._fault((*key, "type"), f"{_printable(given.get('type'))} is not known; expected {kinds}")
        return found

    def _simple(self, given: dict[str, Any], key: Key) -> list[Item]:
        whole = []
        for name, default in (("command", None), ("frame", None), ("doJumpId", 0)):
            value: Any = given.get(name, default)
            if not _is_number(value) or int(value) != value or not 0 <= value < 1e6:
                wrong = "missing" if value is None else f"{_printable(value)} is not a whole number"
                self._fault((*key, name), f"{wrong}; expected one from 0 up")
                return []
            whole.append(int(value))
        params = given.get("params")
        if not isinstance(params, list) or len(params) != 7:
            self._fault((*key, "params"), "expected a list of seven numbers or nulls")
            return []
        for j, value in enumerate(params):
            if value is not None and not _is_number(value):
                self._fault((*key, "params", j), f"{_printable(value)} is not a number")
                return []
        values = tuple(math.nan if value is None else float(value) for value in params)
        return [Item(whole[0], whole[1], values, whole[2] or int(key[2]) + 1, key)]

    def _complex(self, given: dict[str, Any], key: Key, number: int) -> list[Item]:
        kind = given.get("complexItemType")
        if kind in ("survey", "CorridorScan"):
            inner = (*key, "TransectStyleComplexItem")
            style = given.get("TransectStyleComplexItem")
            if not isinstance(style, dict) or not isinstance(style.get("Items"), list) or not style["Items"]:
                message = "no waypoints in it (Items); open the plan in QGroundControl and save it again"
                self._fault(inner, message)
                return []
            found: list[Item] = []
            for i, item in enumerate(style["Items"]):
                if isinstance(item, dict):
                    found += self._simple(item, (*inner, "Items", i))
                else:
                    self._fault((*inner, "Items", i), f"{_printable(item)} is not an item")
            return found
        if kind == "StructureScan":
            return self._scan(given, key, number)
        if kind in LANDING_PATTERNS:
            self._fault((*key, "complexItemType"), f"{LANDING_PATTERNS[kind]} is not for a quadrotor")
        else:
            known = "survey, CorridorScan or StructureScan"
            self._fault((*key, "complexItemType"), f"{_printable(kind)} is not known; expected {known}")
        return []

    def _scan(self, given: dict[str, Any], key: Key, number: int) -> list[Item]:
        before = len(self.faults)
        self._version(given, (*key, "version"), 3)
        camera = given.get("CameraCalc")
        camera = camera if isinstance(camera, dict) else {}
        names = ("EntranceAltitude", "ScanBottomAlt", "StructureHeight", "Layers")
        values = [self._number(given.get(name), (*key, name)) for name in names]
        for name in ("DistanceToSurface", "AdjustedFootprintFrontal"):
            values.append(self._number(camera.get(name), (*key, "CameraCalc", name)))
        corners = self._corners(given.get("polygon"), (*key, "polygon"))
        if len(self.faults) > before:
            return []
        entrance, bottom, top, layers, distance, layer_height = values
        if not 1.0 <= layers <= 1000.0:
            self._fault((*key, "Layers"), f"{layers:g} layers; expected 1 to 1000")
            return []
        from_top = given.get("StartFromTop") is True
        scan = StructureScan(corners, distance, entrance, bottom, top, int(layers), layer_height, from_top)
        try:
            return scan_items(scan, number, key)
        except (ValueError, ArithmeticError) as error:
            self._fault((*key, "polygon"), str(error))
            return []

    def _fence(self, root: dict[str, Any]) -> list[FenceArea]:
        given = root.get("geoFence")
        if not isinstance(given, dict) or given.get("version") == 1:
            return []  # an old plan's empty fence
        if given.get("polygons") or given.get("circles"):
            self._version(given, ("geoFence", "version"), 2)
        areas = []
        for i, area in enumerate(self._list(given, ("geoFence", "polygons"))):
            key: Key = ("geoFence", "polygons", i)
            corners = self._corners(area.get("polygon") if isinstance(area, dict) else None, (*key, "polygon"))
            areas.append(FenceArea(corners, None, not isinstance(area, dict) or area.get("inclusion") is not False))
        for i, area in enumerate(self._list(given, ("geoFence", "circles"))):
            key = ("geoFence", "circles", i, "circle")
            circle = area.get("circle") if isinstance(area, dict) else None
            circle = circle if isinstance(circle, dict) else {}
            center = self._numbers(circle.get("center"), (*key, "center"), 2)
            radius = self._number(circle.get("radius"), (*key, "radius"))
            if radius <= 0.0:
                self._fault((*key, "radius"), f"{radius:g} m; expected more than 0")
            if center is not None:
                areas.append(FenceArea(((center[0], center[1]),), radius, area.get("inclusion") is not False))
        return areas

    def _rally(self, root: dict[str, Any]) -> list[Place]:
        given = root.get("rallyPoints")
        if not isinstance(given, dict) or given.get("version") == 1:
            return []
        points = self._list(given, ("rallyPoints", "points"))
        read = [self._numbers(p, ("rallyPoints", "points", i), 3) for i, p in enumerate(points)]
        return [Place(p[0], p[1], p[2], False) for p in read if p is not None]

    def _corners(self, given: Any, key: Key) -> tuple[tuple[float, float], ...]:
        if not isinstance(given, list) or len(given) < 3:
            self._fault(key, "expected three corners or more, each [latitude, longitude]")
            return ()
        read = [self._numbers(corner, (*key, i), 2) for i, corner in enumerate(given)]
        return tuple((corner[0], corner[1]) for corner in read if corner is not None)

    def _numbers(self, given: Any, key: Key, count: int) -> list[float] | None:
        if not isinstance(given, list) or len(given) != count or not all(map(_is_number, given)):
            self._fault(
                key, f"{_printable(given)}; expected {count} numbers: latitude, longitude" + ", altitude" * (count - 2)
            )
            return None
        return [float(value) for value in given]

    def _number(self, given: Any, key: Key) -> float:
        if _is_number(given) and abs(given) < 1e6:
            return float(given)
        self._fault(key, f"{_printable(given)} is not a number that makes sense here")
        return 1.0

    def _mapping(self, holder: dict[str, Any], key: Key) -> dict[str, Any] | None:
        given = holder.get(str(key[-1]))
        if isinstance(given, dict):
            return given
        self._fault(key, "missing; expected a mission" if given is None else f"{_printable(given)} is not a mission")
        return None

    def _list(self, holder: dict[str, Any], key: Key) -> list[Any]:
        given = holder.get(str(key[-1]))
        if isinstance(given, list):
            return given
        if given is not None or key[0] == "mission":
            self._fault(key, "missing; expected a list" if given is None else f"{_printable(given)} is not a list")
        return []

    def _version(self, holder: dict[str, Any], key: Key, known: int) -> None:
        if holder.get("version", known) != known:
            self._fault(key, f"version {_printable(holder.get('version'))} is not known; expected {known}")

    def _fault(self, key: Key, message: str) -> None:
        if len(self.faults) < FAULTS_MAX:
            self.faults.append(self._document.fault(key, message))


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _printable(value: Any) -> str:
    text = "nothing" if value is None else repr(value)
    return text if len(text) <= 40 else text[:37] + "..."
