"""One step of the autopilot: estimate in, motor commands out; and what operators and companions ask of it."""

from __future__ import annotations

import math

from companion.frames import Quaternion, Vec3
from companion.geodesy import MapProjection
from companion.mavlink.modes import Landed, Mode
from companion.mavlink_common import MavResult, MavSeverity
from companion.vehicle import Vehicle
from companion.world import Battery as Pack
from companion.world import Home
from sim_bridge.autopilot import parameters
from sim_bridge.autopilot.commander.arming_checks import HealthAndArmingChecks
from sim_bridge.autopilot.commander.battery import Battery
from sim_bridge.autopilot.commander.commander import MANUAL, READY_AFTER, Commander
from sim_bridge.autopilot.commander.events import Events
from sim_bridge.autopilot.commander.external_modes import EXTERNAL
from sim_bridge.autopilot.commander.fence_watch import FenceWatch
from sim_bridge.autopilot.commander.home_position import HomePosition
from sim_bridge.autopilot.commander.landing import LandDetector, Stillness
from sim_bridge.autopilot.flight_modes.guidance import Guidance, TakeOff, Throttle
from sim_bridge.autopilot.flight_modes.manual import BY_PLACE_OR_HEIGHT, ManualFlight
from sim_bridge.autopilot.flight_modes.manual_control import CENTRED, ManualControl, ManualControlSetpoint
from sim_bridge.autopilot.flight_modes.offboard import Ground, OffboardFlight, fly
from sim_bridge.autopilot.flight_modes.setpoints import BELOW_ATTITUDE, MotorSetpoint, Setpoint
from sim_bridge.autopilot.flight_modes.topics import PAST_THE_LOOPS, Level, TopicSetpoint
from sim_bridge.autopilot.missions.flight import MissionFlight
from sim_bridge.autopilot.missions.mission_watch import MissionWatch
from sim_bridge.autopilot.missions.store import Store
from sim_bridge.control.cascade import Cascade
from sim_bridge.plant import Truth
from sim_bridge.rotors import Four
from sim_bridge.sensors import Estimate

BY_LEGS = frozenset({Mode.RETURN, Mode.MISSION, Mode.PRECISION_LAND, Mode.DESCEND})
"""Modes that may come to a landing."""
SUPERVISION_US = 20_000
"""The period at which timers, landing and the end of modes are looked at."""
UNIX_US_AT_BOOT = 1_767_225_600_000_000
"""What the wall's clock shows at boot where nobody sets it: the first of January 2026."""


class Autopilot:
    """The autopilot of one vehicle, stepped every ``step`` s. ``direct``: it takes motor commands.

    ``pack``: its battery, where the world has one. ``estimate``: the last one; ``offboard_flown``: whether offboard has
    flown a setpoint; ``truth``: what only the simulation knows, for the message that tells it.
    """

    def __init__(
        self, vehicle: Vehicle, home: Home, step: float, estimate: Estimate, truth: Truth, *, direct: bool,
        pack: Pack | None = None, rate_gains: Vec3 = (1.0, 1.0, 1.0),
    ) -> None:  # fmt: skip
        self.vehicle = vehicle
        self.home = home
        self.projection = MapProjection(home.latitude, home.longitude)
        self.direct = direct
        self.parameters = parameters.of(vehicle, home, pack, rate_gains)
        self.battery = Battery(self.parameters)
        self.commander = Commander(self.parameters, READY_AFTER)
        self.events = Events()
        self.missions = Store()
        self.mission = MissionFlight(self.parameters, self.missions, self.projection, home.altitude)
        self.guidance = Guidance(self.parameters, self.mission)
        self.fence = FenceWatch(self.parameters, self.missions, self.projection, self.commander)
        self.home_position = HomePosition(self.guidance, home, self.projection)
        self.mission_watch = MissionWatch(
            self.parameters, self.commander, self.missions, self.mission, self.guidance, self.home_position, self.fence,
            home, self.projection,
        )  # fmt: skip
        self.cascade = Cascade(vehicle, step, rate_gains)
        self.sticks = ManualControl(self.parameters)
        self.checks = HealthAndArmingChecks(self.parameters, self.commander, self.battery, self.fence, self.sticks)
        self.manual_flight = ManualFlight(self.parameters, self.cascade.hover, vehicle.gravity)
        self.offboard_flight = OffboardFlight(self.parameters, self.cascade, direct=direct)
        self._step = step
        self.estimate, self.truth = estimate, truth
        self.offboard_flown, self.unix_us_at_boot = False, UNIX_US_AT_BOOT
        self.log_files: dict[str, bytearray] = {}  # path -> the vehicle's own log, by the logger
        self.attitude_told: tuple[int, Quaternion, float] = (0, (1.0, 0.0, 0.0, 0.0), 0.0)  # by ATTITUDE_TARGET
        self._landing, self._stillness = LandDetector(landed=True), Stillness(self.parameters)
        self._stands = True
        self._supervise_at_us = 0
        self._flown: Mode | None = None

    def begin_in_flight(self, estimate: Estimate, truth: Truth, commands: Four, disturbance: Vec3) -> None:
        """Start armed in HOLD in the air, the motors at ``commands``, the loops knowing a steady ``disturbance``."""
        self.estimate = estimate
        self.truth = truth
        self.commander.begin_in_flight()
        self.home_position.begin_in_flight()
        self._landing = LandDetector(landed=False)
        self.guidance.enter(Mode.HOLD, estimate)
        self._stands = False
        self._flown = Mode.HOLD
        self.cascade.begin(estimate, disturbance)
        self.cascade.commands = commands
        self.cascade.thrust = self.cascade.hover

    @property
    def setpoint(self) -> Setpoint | None:
        """What offboard flies."""
        return self.offboard_flight.setpoint

    def level_in(self, mode: Mode) -> Level:
        """The level the vehicle's own loops are told at in a mode."""
        external = self.commander.external_modes.of(mode)
        return self.offboard_flight.level(mode, None if external is None else external.level)

    @property
    def commands(self) -> Four:
        """The last motor commands, in the rotors' units."""
        return self.cascade.commands

    @property
    def t(self) -> float:
        """The vehicle's clock, s; the stamps of its state may have jumped away from it."""
        return self.truth.t_boot

    @property
    def landed_state(self) -> Landed:
        """The state EXTENDED_SYS_STATE tells."""
        mode = self.commander.mode if self.commander.armed else None
        if self.commander.landed:
            return Landed.ON_GROUND
        flies = mode is self._flown  # else the guidance still speaks of the mode before
        if mode is Mode.TAKEOFF or (mode is Mode.MISSION and flies and self.guidance.is_taking_off):
            return Landed.TAKING_OFF
        descends = mode is Mode.LAND or (mode in BY_LEGS and flies and self.guidance.is_landing)
        return Landed.LANDING if descends else Landed.IN_AIR

    def control(self) -> Four | None:
        """The motor commands for the coming step, from the last estimate; None: motors off."""
        now, commander, cascade = self.estimate, self.commander, self.cascade
        mode = commander.mode
        if not commander.armed or mode is Mode.TERMINATION:
            self._flown = self.offboard_flight.setpoint = None
            cascade.stop(now)
            return None
        if mode is not self._flown:
            self._enter(mode)
        written = topics.take_fresh(self.level_in(mode)) if (topics := self.offboard_flight.topics).any else None
        if written is not None and not isinstance(written, PAST_THE_LOOPS):
            return fly(cascade, now, written, commander.landed)
        own = self._control(now, mode)
        return own if written is None else self.offboard_flight.fight(written)

    def _control(self, now: Estimate, mode: Mode) -> Four:
        """What the vehicle's own loops make of the mode."""
        commander, cascade = self.commander, self.cascade
        if mode is Mode.OFFBOARD or (mode in EXTERNAL and self.level_in(mode) >= Level.ATTITUDE):
            if self.setpoint is None:
                return self.offboard_flight.go_on(now, self.level_in(mode), commander.landed)
            on = Ground(commander.landed, self._stands, self._landing.touching)
            return self.offboard_flight.fly(now, on, self.t - commander.armed_at)
        if mode in MANUAL:
            return self._fly_by_stick(now)
        if cascade.wants_target:
            on_ground = commander.landed or (self.guidance.is_taking_off and self._stands)
            wanted = self.guidance.step(now, self.t, on_ground, self._landing.touching, cascade.position_step)
            if isinstance(wanted, Throttle):
                return cascade.open_throttle(now, wanted.of_hover)
            cascade.aim(now, wanted)
        return cascade.fly_aim(now)

    def _fly_by_stick(self, now: Estimate) -> Four:
        """What the pilot's sticks say; let go where nobody holds them."""
        commander, cascade, sticks = self.commander, self.cascade, self.sticks.position
        if commander.failsafe_flags.manual_control_signal_lost:
            sticks = CENTRED
        if commander.mode not in BY_PLACE_OR_HEIGHT:
            setpoint = self.manual_flight.setpoint(now, sticks, commander.landed, self._step)
            return fly(cascade, now, setpoint, commander.landed)
        if cascade.wants_target:
            wanted = self.manual_flight.aim(
                now, sticks, self.guidance.home_n[2] - now.p_n[2], self.t - commander.armed_at, commander.landed,
                self._stands, self._landing.touching, cascade.position_step,
            )  # fmt: skip
            if isinstance(wanted, Throttle):
                return cascade.open_throttle(now, wanted.of_hover)
            cascade.aim(now, wanted)
        return cascade.fly_aim(now)

    def observe(self, estimate: Estimate, truth: Truth) -> None:
        """What the sensors say after the step."""
        if estimate.resets != self.estimate.resets:
            self.guidance.notice_reset(estimate)
            self.cascade.notice_reset(self.estimate.q_nb, estimate.q_nb)
        self.estimate = estimate
        self.truth = truth
        self._stands = truth.on_ground  # felt by the legs; nothing else of the truth is used
        if round(truth.t_boot * 1e6) >= self._supervise_at_us:
            self._supervise_at_us += SUPERVISION_US
            self._supervise(estimate, self._stands)

    def _supervise(self, estimate: Estimate, contact: bool) -> None:
        """Notice landing and take-off, run the timers, change modes that end by themselves."""
        commander = self.commander
        throttle = self.cascade.thrust / self.cascade.hover
        if isinstance(self.setpoint, PAST_THE_LOOPS):
            contact = self._stillness.update(self.t, estimate, self.cascade.thrust) or contact
        commander.notice_landing(self._landing.update(self.t, contact, throttle), self.t)
        if not commander.landed and self.guidance.has_taken_off(estimate):
            commander.finish_takeoff()
        rates_alone = isinstance(self.setpoint, BELOW_ATTITUDE)
        self.checks.update(SUPERVISION_US * 1e-6, self.t, estimate, self.home_position.p_n, rates_alone)
        self.mission_watch.update(estimate, self.t)
        commander.update(self.t)
        for said in self.checks.report(self.t):
            self.events.keep(*said, estimate.time_us)
        self.home_position.update(estimate, commander.armed, commander.landed)

    def offboard(self, setpoint: Setpoint) -> None:
        """An offboard setpoint. Motor commands count only where the vehicle takes them."""
        if isinstance(setpoint, MotorSetpoint) and not self.direct:
            return
        self.commander.notice_setpoint(self.t)
        self.offboard_flight.topics.level = None
        if self.commander.armed and self.commander.mode is Mode.OFFBOARD:
            self.offboard_flight.take(setpoint)
            self.offboard_flown = True

    def take_offboard_mode(self, level: Level | None, at: float) -> None:
        """offboard_control_mode is written, by its own account at ``at`` (s). None: it asks for nothing."""
        self.offboard_flight.topics.level = level
        self.commander.notice_setpoint(-math.inf if level is None else at)
        self._take_topics()

    def write(self, written: TopicSetpoint) -> None:
        """A setpoint's own topic is written, in whatever mode."""
        self.offboard_flight.topics.write(written)
        self._take_topics()

    def _take_topics(self) -> None:
        wanted = self.offboard_flight.topics.wanted(self.level_in(self.commander.mode))
        if wanted is not None and self.commander.armed:
            self.offboard_flight.take(wanted)
            self.offboard_flown = True

    def take_sticks(self, position: ManualControlSetpoint, source: object) -> None:
        """Where a pilot's sticks are."""
        self.sticks.take(position, source, self.t)
        self.commander.throttle = position.throttle
        self.commander.failsafe_flags.manual_control_signal_lost = self.sticks.is_lost(self.t)
        if self.sticks.have_moved():
            self.commander.notice_sticks(self.t)

    def request_mode(self, mode: Mode, aloud: bool = True) -> MavResult:
        """Somebody asks for a mode. ``aloud``: a refusal is told in words."""
        return self.commander.request_mode(mode, self.t, aloud)

    def take_off(self, wanted: TakeOff) -> MavResult:
        """Somebody asks for a take-off; one that is under way already goes there instead."""
        self.guidance.takeoff = wanted
        result = self.request_mode(Mode.TAKEOFF)
        if self._flown is Mode.TAKEOFF:
            self._enter(Mode.TAKEOFF)
        return result

    def go_to(
        self, level: tuple[float, float] | None, down: float | None, heading: float | None, speed: float | None
    ) -> None:
        """In HOLD: hold at another place (m, NED), heading (rad) and cruise speed (m/s); None: as it is."""
        if self.commander.mode is Mode.HOLD:
            before = self.guidance.destination or self.estimate.p_n
            place = (*(before[:2] if level is None else level), before[2] if down is None else down)
            if self.parameters["GF_ACTION"] and self.fence.broken_at(place, self.home_position.p_n):
                self.commander.say(MavSeverity.CRITICAL, "Reposition is outside geofence\t")
                return
            if self._flown is not Mode.HOLD:
                self._enter(Mode.HOLD)
            self.guidance.go_to(self.estimate, level, down, heading, speed)

    def _enter(self, mode: Mode) -> None:
        """Change what is flown. A demand that came with the change to offboard stays; others end with offboard."""
        came_from_offboard = self._flown in (None, Mode.OFFBOARD)
        self._flown = mode
        if mode is Mode.TAKEOFF:
            top = self.guidance.takeoff.down
            if top is None:
                height = self.parameters["MIS_TAKEOFF_ALT"]
                self.commander.say(MavSeverity.INFO, f"Using default takeoff altitude: {height:.1f} m\t")
            elif top > self.estimate.p_n[2]:
                self.commander.say(MavSeverity.CRITICAL, "Already higher than takeoff altitude\t")
        if mode is Mode.RETURN:
            height = self.guidance.return_height(self.estimate)
            above = round(height + self.home.altitude), round(height)
            self.commander.say(
                MavSeverity.INFO, f"RTL: start return at {above[0]} m ({above[1]} m above destination)\t"
            )  # fmt: skip
        if mode in MANUAL:
            self.manual_flight.enter(mode, self.estimate)
        else:
            self.guidance.enter(Mode.HOLD if mode in EXTERNAL else mode, self.estimate)
        if mode is not Mode.OFFBOARD:
            self.offboard_flight.setpoint = None
            if came_from_offboard:
                self.cascade.begin(self.estimate)
