"""From orders and a vehicle that has made itself known to a plan, or to why it is not flown."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from companion.daemon.orders import Orders
from companion.flight import geometry, output
from companion.flight.conduct import Conduct, ControlAuthority, caught
from companion.frames import Vec3
from companion.geodesy import LocalFrame
from companion.mavlink.link import Identity, Link
from companion.mavlink.parameters import TUNING, Parameters
from companion.mavlink.peer import source_words
from companion.mavlink.telemetry import Telemetry
from companion.mission import Mission
from companion.paths.arc import ArcTable
from companion.places.origins import NotKnownError, VehicleLocation, placed
from companion.places.words import words_of_place
from companion.plan import Plan, prepared
from companion.vehicle import TILT_MARGIN, CompanionError, Landed, OutputLevel, Tuning, Vehicle, VehicleState
from companion.xrce.commands import Commands
from companion.xrce.flight_mode import level_refused

PLACE_WITHIN = 30.0
"""s after its first heartbeat for the vehicle to know where it is, if the mission asks for that. Engineering choice."""
MISSING_SAID_AFTER, GIVEN_UP_AFTER = 5.0, 60.0
"""s after which what the vehicle has not said is named, and after its first heartbeat the flight is given up. Issue 11,
rule 10: named within 10 s; engineering choice."""
IDENTITY_WITHIN = 5.0
"""s after its first heartbeat for the vehicle to say what it can do, where that matters. Engineering choice."""
HOME_ALTITUDE_AGREES = 1.0
"""m by which the home of a plan and the vehicle's may differ in height, where that matters. Engineering choice."""
FLOOR = 1.0
"""m above the ground: the floor where none was ordered. Engineering choice."""
UNDER_THE_PATH = 0.5
"""m the floor stays below the lowest point of the path at least. Engineering choice."""
SAMPLES = 200
"""points of the path among which the lowest is looked for. Engineering choice."""


@dataclass
class Preparation:
    """What is found out before a flight. ``notes``: lines for people. ``refusal``: why there will be none, in a
    sentence. ``changed``: parameters set for the flight and not yet back, and what they were. ``restoring``: whether
    they are being set back. ``heard_at``: s, the first heartbeat. ``xrce``:
    what setpoints go through, if not through the link."""

    link: Link
    telemetry: Telemetry
    parameters: Parameters
    notes: list[str]
    refusal: str | None = None
    changed: dict[str, float] = field(default_factory=dict)
    restoring: bool = False
    heard_at: float | None = None
    choice: output.Choice | None = None
    state_heard: bool = False
    xrce: Commands | None = None
    _lacking: str | None = None
    _lacking_since: float = 0.0
    _lacking_said: bool = False

    def on_heartbeat(self, vehicle: Vehicle, system: int, now: float) -> None:
        """The vehicle was heard: the first time, ask for the parameters that matter."""
        if self.heard_at is None:
            self.heard_at = now
            if self.link.is_px4:
                self.parameters.ask(TUNING.values(), system, now)
                if self.xrce is not None:
                    self.parameters.ask(geometry.names(vehicle), system, now)

    def plan(self, orders: Orders, state: VehicleState | None, now: float) -> Plan | None:
        """The plan once everything for it is known; until then None, and for good once there is a refusal."""
        identity = self.link.identity
        if identity is None or self.refusal is not None:
            return None
        self.refusal = self._reason_to_refuse(orders, identity, now)
        if self.refusal is not None:
            return None
        self.state_heard = self.state_heard or state is not None
        lacks = self._lacks(orders, identity, now)
        if lacks is not None:
            self._say_missing(f"for the vehicle to say {lacks}", now)
            if self._heard_for(now) > GIVEN_UP_AFTER:
                self.refusal = f"within {GIVEN_UP_AFTER:g} s the vehicle has not said {lacks}"
            return None
        if state is None:
            return None
        try:
            return self._make_plan(orders, state, now)
        except NotKnownError as error:
            self._say_missing(f"because {error}", now)
            if self._heard_for(now) > PLACE_WITHIN:
                self.refusal = str(error)
        except CompanionError as error:
            self.refusal = str(error)
        return None

    def _lacks(self, orders: Orders, identity: Identity, now: float) -> str | None:
        """What the vehicle has not said yet, by its MAVLink name; None: the plan can be made."""
        status = self.telemetry.status.known_at(now)
        if not (self.parameters.settled and self.link.is_set_up):
            return "the answers to what was asked of it (PARAM_VALUE, COMMAND_ACK)"
        if self.xrce is not None and (lacking := self.xrce.missing) is not None:
            return lacking
        if orders.level is OutputLevel.MOTORS and self.xrce is None and identity.direct_motors is None:
            return "what it can do (AUTOPILOT_VERSION)"
        if not self.state_heard:
            refused = ", ".join(self.telemetry.refused)
            return f"its state (ODOMETRY){': what comes is ' + refused if refused else ''}"
        if status.landed is None:
            return "whether it stands or flies (EXTENDED_SYS_STATE)"
        return "whether it is armed (HEARTBEAT)" if status.armed is None else None

    def _say_missing(self, lacks: str, now: float) -> None:
        """Say what is waited for once it is missing for a while, and when that changes."""
        if lacks != self._lacking:
            self._lacking, self._lacking_since, self._lacking_said = lacks, now, False
        elif not self._lacking_said and now - self._lacking_since > MISSING_SAID_AFTER:
            self._lacking_said = True
            self.notes.append(f"waiting {lacks}")

    def restore(self, now: float) -> None:
        """Set back what was set for the flight."""
        self.restoring = True
        for name, was in self.changed.items():
            self.parameters.change(name, was, now)

    def report_restored(self) -> None:
        """Say what the vehicle has made of being set back, once that is known."""
        if not self.restoring or not self.parameters.settled:
            return
        self.restoring = False
        for name, was in self.changed.items():
            value = self.parameters.value(name)
            if value is not None and math.isclose(value, was, rel_tol=1e-6):
                self.notes.append(f"{name} set back to {was:g}")
            else:
                self.notes.append(f"{name} may still be {value:g}: the vehicle did not answer; set it back to {was:g}")
        self.changed.clear()

    def _make_plan(self, orders: Orders, state: VehicleState, now: float) -> Plan | None:
        tuning, vehicle = self.parameters.tuning(), orders.vehicle
        mixes = orders.level is not OutputLevel.MOTORS or self.xrce is not None
        another = output.another_vehicle(vehicle, tuning) if mixes else None
        if another is not None:
            raise CompanionError(another)
        if self.choice is None:
            consent, over = orders.set_parameters, self.xrce is not None
            self._compare(vehicle)
            if self.xrce is not None and self.xrce.flight_mode is not None:
                name = self.xrce.flight_mode.name
                self.notes.append(f"the flight mode {name} is registered; OFFBOARD in a line means {name}")
            self.choice = output.chosen(orders.level, tuning, auto=orders.auto, consent=consent, over_xrce=over)
            self._set_parameters(orders, self.choice, now)
            if not self.parameters.settled:
                return None
        where = self._location(state)
        mission: Mission = placed(orders.mission, orders.origin, where)
        heights_agree(mission, where)
        self.notes += str(words_of_place(orders.mission, orders.origin, where)).splitlines()
        stands_at = state.p_n if where.on_ground else None
        conduct = complete_conduct(orders.conduct, vehicle, tuning, mission.table, where.home_n, stands_at)
        if self.xrce is not None and self.xrce.level.without_rate_loop:
            conduct = caught(conduct, vehicle)
        if orders.objection is not None and conduct.limits.ground is not None:
            objection = orders.objection(mission, conduct.limits.ground)
            if objection is not None:
                raise CompanionError(f"in its place here, {objection}")
        origin_n = mission.placement.origin_n
        plan = prepared(mission, vehicle, self.choice.level, origin_n, orders.duration, tuning, conduct, orders.learned)
        if plan.path_pole is not None:
            self.notes.append(
                f"gains: auto: the path's poles at {plan.path_pole:.1f} 1/s, slower if the commands are rough"
            )
        return plan

    def _compare(self, vehicle: Vehicle) -> None:
        """The vehicle file's rotors with PX4's own, where we command them past its rate loop. CompanionError: they
        differ."""
        if self.xrce is None or not self.xrce.level.without_rate_loop:
            return
        told = {name: self.parameters.value(name) for name in geometry.names(vehicle)}
        found = geometry.differences(vehicle, told)
        if found:
            raise CompanionError(f"{'; '.join(found)}; give the vehicle's own file with --vehicle, or set CA_ROTOR*")
        self.notes += [output.NO_LONGER[self.xrce.level], geometry.curve_words(told)]

    def _location(self, state: VehicleState) -> VehicleLocation:
        home, origin = self.telemetry.home, self.telemetry.origin
        return VehicleLocation(
            state.p_n,
            self.telemetry.status.last.landed is Landed.ON_GROUND,
            None if origin is None else LocalFrame(*origin),
            None if home is None else home[:3],
            None if home is None else home.p_n,
        )

    def _set_parameters(self, orders: Orders, choice: output.Choice, now: float) -> None:
        """Set the parameters that a level needs."""
        self.notes.append(choice.why)
        if orders.has_xrce and not orders.over_xrce:
            self.notes.append(output.NOT_ASKED)
        if orders.conduct.authority in (ControlAuthority.REHEARSAL, ControlAuthority.BENCH):
            return  # nothing is commanded, nor set
        for name, value in choice.settings:
            was = self.parameters.value(name)
            if was is not None:
                self.changed[name] = was
                self.parameters.change(name, value, now)

    @property
    def is_ours(self) -> bool:
        """Whether what answered is an autopilot that can be flown; True as long as none has."""
        return self.link.identity is None or self.link.is_px4

    def _reason_to_refuse(self, orders: Orders, identity: Identity, now: float) -> str | None:
        if not self.is_ours:
            return (
                f"the autopilot that answered is not PX4 (MAV_AUTOPILOT {identity.autopilot}); nothing was sent to it"
            )
        ambiguity = self.ambiguity()
        if self.xrce is not None:
            own = self.xrce.flight_mode is not None and orders.level not in orders.mode_levels
            return ambiguity or self.xrce.refusal or (level_refused(orders.level) if own else None)
        refused = ambiguity or output.unreachable(orders.vehicle, orders.level, identity.direct_motors)
        if refused is not None or orders.level is not OutputLevel.MOTORS:
            return refused
        if identity.direct_motors is None and self._heard_for(now) > IDENTITY_WITHIN:
            return "the vehicle does not say what it can do (AUTOPILOT_VERSION), so motor commands are not sent to it"
        return None

    def ambiguity(self) -> str | None:
        """Why it is not certain which vehicle is ours; None where it is."""
        identity = self.link.identity
        if identity is None:
            return None
        if self.link.others:
            systems = ", ".join(str(system) for system in sorted({identity.system, *self.link.others}))
            return f"two autopilots speak on the link (systems {systems}); connect to the one that is to fly"
        peers = self.link.peers
        if peers.rival is not None:
            ours = f"system {identity.system} at {source_words(peers.heard)}"
            return f"two vehicles are heard, {ours} and {peers.rival}; switch one off, or connect to one alone"
        if self.link.replaced is not None:
            was, is_now = self.link.replaced
            return (
                f"another vehicle answers as system {identity.system}: its uid is {is_now} and was {was}; start again "
                "when only the one that is to fly is on"
            )
        return None

    def _heard_for(self, now: float) -> float:
        return 0.0 if self.heard_at is None else now - self.heard_at


def heights_agree(mission: Mission, where: VehicleLocation) -> None:
    """CompanionError: the mission's shape hangs on how high home lies, and the vehicle's lies at another height."""
    planned = mission.home
    if not mission.mixed_heights or planned is None or planned.altitude is None:
        return
    if where.home is None:
        raise NotKnownError("the plan has heights above home, and the vehicle has not set one (HOME_POSITION)")
    latitude, longitude, altitude = where.home
    if abs(altitude - planned.altitude) > HOME_ALTITUDE_AGREES:
        raise CompanionError(
            f"the plan has heights above home and above the sea; its home lies {planned.altitude:.1f} m above the "
            f"sea, the vehicle's {altitude:.1f} m; fly it with --home {latitude:.7f},{longitude:.7f},{altitude:.1f}"
        )


def complete_conduct(
    ordered: Conduct, vehicle: Vehicle, tuning: Tuning, table: ArcTable, home: Vec3 | None, stands_at: Vec3 | None
) -> Conduct:
    """``home``: of the vehicle, in its frame; ``stands_at``: where it stands if it does; None where not known."""
    limits = ordered.limits
    ground = home[2] if home is not None else stands_at[2] if stands_at is not None else None
    floor = limits.floor
    if floor is None and ground is not None:
        lowest = ground - max(float(point[2]) for point in table.samples(SAMPLES)[1])
        floor = min(FLOOR, lowest - UNDER_THE_PATH) if lowest > UNDER_THE_PATH else None
    tilt = None
    if vehicle.limits is not None:
        ends = (tuning.fail_roll, tuning.fail_pitch, vehicle.limits.failure_detector)
        tilt = min(angle for angle in ends if angle) - TILT_MARGIN
    return ordered._replace(
        limits=limits._replace(
            floor=floor,
            ground=ground,
            tilt=tilt if limits.tilt is None else limits.tilt,
            battery=tuning.battery_low or limits.battery,
            radius=tuning.fence_radius,
            height=tuning.fence_height,
            home=home,
        )
    )
