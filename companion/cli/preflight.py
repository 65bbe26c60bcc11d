"""``preflight``: the vehicle's parameters looked at before a flight; the curve and the fence put on its map."""

from __future__ import annotations

import json
from typing import Any

from companion.cli.finish import COMPLETED, FAILED, NO_VEHICLE, refuse
from companion.cli.terminal import say
from companion.config.plan.qgroundcontrol import plan_from
from companion.flight.link_needs import RATE_WANTED
from companion.library.orders import Sortie
from companion.mavlink.upload import CURVE_POINTS
from companion.mission import Origin
from companion.places.origins import PlaceError, placed
from companion.places.words import words_of_place
from companion.plain_text import printable
from companion.services.audit import Finding, Weight, audit_parameters
from companion.services.plan_check import differences
from companion.services.vehicle import ConnectedVehicle, NoVehicleHeardError, ServiceError, connect_vehicle


def preflight(url: str, sortie: Sortie | None, *, upload: bool, as_json: bool) -> int:
    """Look, and upload where asked to; the exit code: 1 where something is not to be flown with."""
    try:
        with connect_vehicle(url) as vehicle:
            findings = audit_parameters(vehicle.parameters())
            rate = vehicle.state_rate()
            words = [] if sortie is None else _place(vehicle, sortie, upload)
    except NoVehicleHeardError as error:
        say(str(error))
        return NO_VEHICLE
    except (ServiceError, PlaceError) as error:
        return refuse(str(error), as_json)
    dangers = [finding for finding in findings if finding.weight is Weight.DANGER]
    slow = rate < RATE_WANTED
    if as_json:
        print(json.dumps(_document(findings, rate, words), indent=2))
    else:
        _print(findings, rate, words)
    return FAILED if dangers or slow else COMPLETED


def _place(vehicle: ConnectedVehicle, sortie: Sortie, upload: bool) -> list[str]:
    """Where the path would run, and what was uploaded."""
    where = vehicle.location()
    mission = placed(sortie.mission, Origin.TAKEOFF, where)
    words = str(words_of_place(sortie.mission, Origin.TAKEOFF, where)).splitlines()
    attached = sortie.mission_source.attached
    if attached is not None and attached[0].lower().endswith(".plan"):
        words += differences(plan_from(attached[1], attached[0])[0], attached[1], vehicle.read_plan(attached[1]))
    if upload:
        assert where.frame is not None
        _, points = mission.table.samples(CURVE_POINTS)
        curve = [(float(x), float(y), float(z)) for x, y, z in points]
        vehicle.upload(curve, mission.fence_n, where.frame)
        areas = 0 if mission.fence_n is None else len(mission.fence_n.areas)
        fence = f", and a fence of {areas} area{'' if areas == 1 else 's'}" if areas else ""
        words.append(f"uploaded: the curve as {CURVE_POINTS} waypoints{fence}")
    return words


def _document(findings: list[Finding], rate: float, words: list[str]) -> dict[str, Any]:
    return {
        "schema": "companion.preflight/1",
        "ok": all(finding.weight is not Weight.DANGER for finding in findings) and rate >= RATE_WANTED,
        "verdict": verdict(findings, rate),
        "state_rate_hz": round(rate, 1),
        "parameters": [finding._asdict() | {"weight": finding.weight.value} for finding in findings],
        "path": words,
    }


def _print(findings: list[Finding], rate: float, words: list[str]) -> None:
    marks = {Weight.FINE: "ok    ", Weight.ADVICE: "advice", Weight.DANGER: "DANGER"}
    for finding in findings:
        line = f"{marks[finding.weight]}  {finding.parameter:18}{finding.said:24}"
        print(line.rstrip() if finding.weight is Weight.FINE else f"{line}advised: {finding.advised}; {finding.why}")
    enough = "" if rate >= RATE_WANTED else f", {RATE_WANTED:g} are needed: raise the link's speed"
    print(f"{marks[Weight.DANGER if enough else Weight.FINE]}  {rate:.0f} states a second arrive{enough}")
    for line in words:
        print(printable(f"        {line}"))
    print(f"\n{verdict(findings, rate)}")


def verdict(findings: list[Finding], rate: float) -> str:
    """Whether to fly with these parameters, in one sentence."""
    dangers = [f"{each.parameter} is {each.said}" for each in findings if each.weight is Weight.DANGER]
    if rate < RATE_WANTED:
        dangers.append(f"only {rate:.0f} states a second arrive")
    if dangers:
        return f"Do not fly: {'; '.join(dangers)}."
    advised = [each.parameter for each in findings if each.weight is Weight.ADVICE]
    if advised:
        return f"Can be flown. Better first: {', '.join(advised)}."
    return "Ready to fly: every parameter that we look at is as advised."
