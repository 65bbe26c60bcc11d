"""The whole vehicle without a socket and without a clock: datagrams and steps in, datagrams out.

    bridge.receive(datagram)     at the present time
    bridge.step()                one fixed step later
    bridge.datagrams()           what to send now

Its time is a count of steps, so that everything is exact and the same seed gives the same bytes.
"""

from __future__ import annotations

import math

from companion.frames import Vec3, euler_from_rotation, rotation_matrix
from companion.mavlink.codec import Counters, Frame
from companion.vehicle import MotorInterface, Vehicle
from companion.world import Start, World
from sim_bridge.autopilot.autopilot import Autopilot
from sim_bridge.autopilot.mavlink.link import COMPONENT, SYSTEM, Link
from sim_bridge.autopilot.mavlink.streams import GROUND_STATION, ONBOARD, Boot, Streams
from sim_bridge.autopilot.messages import Values
from sim_bridge.control.position import Target
from sim_bridge.link_model import Passage
from sim_bridge.noise import Cause, normals
from sim_bridge.plant import OFF, Plant, Truth
from sim_bridge.sensors import Sensors, exact
from sim_bridge.world_events import WorldEvents

FAST_STATE = 250.0
"""Hz. A vehicle that is asked for its state more often than this steps at 1 ms instead of PX4's 4 ms."""
TEXTS, TEXTS_PERIOD = 8, 0.1
"""How many texts are told in so many s; what somebody provokes beyond is dropped, as by PX4's queue."""
HOVER = Start.hover((0.0, 0.0, -10.0))


class Bridge:
    """A vehicle in a world, speaking MAVLink as system 1, component 1.

    Endpoint 0 is the companion's, 1 the ground station's. ``landed``: it stands on the ground at the origin, switched
    on just now; otherwise it begins in the air as ``start`` says, by default in a hover 10 m above the origin.
    ``direct``: it takes SET_ACTUATOR_CONTROL_TARGET as motor commands, as it also does if its vehicle file says so.
    ``endpoints``: 1 leaves the ground station out. ``seed``: of every chance in the world. ValueError: the vehicle
    cannot be flown. Nothing received ever raises.

    ``log``: lines for a person, to be taken out by whoever shows them.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        world: World,
        *,
        seed: int = 0,
        direct: bool = False,
        start: Start | None = None,
        landed: bool = False,
        endpoints: int = 2,
    ) -> None:
        self._per_second = 1000 if vehicle.state_rate > FAST_STATE else 250
        self.step_s = 1.0 / self._per_second
        self._step_us = 1_000_000 // self._per_second
        self._count = 0
        self.direct = direct or vehicle.motors is MotorInterface.DIRECT
        self.plant = Plant(vehicle, world, self._per_second, seed)
        self._sensors = Sensors(world.estimate, self.step_s, normals(seed, Cause.ESTIMATE))
        self.world_events = WorldEvents(world.events, self.plant, self._sensors)
        weight, lift = self.plant.vehicle.weight, self.plant.vehicle.thrust_max
        if self.plant.cells is not None:
            lift *= self.plant.cells.strength
        if weight >= lift:
            message = (
                f"{vehicle.name} in world {world.name} weighs {weight:.4g} N and its rotors lift {lift:.4g} N at most"
            )
            raise ValueError(f"{message}; expected it to be able to fly")
        self.autopilot = Autopilot(
            self.plant.vehicle,
            world.home,
            self.step_s,
            self._sensors.observe(self.plant.truth),
            self.plant.truth,
            direct=self.direct,
            pack=world.battery,
        )
        self._held = False
        if not landed:
            self._begin_in_flight(start or HOVER, world)
        boot = Boot() if landed else None
        self.links = [
            Link(self.autopilot, Streams(rates, self._step_us, direct=self.direct, boot=boot), boots=landed)
            for rates in (ONBOARD, GROUND_STATION)[:endpoints]
        ]
        self._up = Passage(world.link.up, seed, Cause.UP) if world.link.up else None
        self._down = Passage(world.link.down, seed, Cause.DOWN) if world.link.down else None
        self._leaving: list[tuple[int, bytes]] = []
        self.log: list[str] = []
        self._noted = ("", 0.0)
        self._texts_left, self._tell_again_at = TEXTS, 0.0
        self._logged = self.autopilot.commander.mode

    @property
    def now(self) -> float:
        """The bridge's time, s: steps taken, also while the vehicle is held."""
        return self._count / self._per_second

    @property
    def held(self) -> bool:
        """Whether the vehicle and its clock stand still until the first setpoint in offboard."""
        return self._held

    @property
    def truth(self) -> Truth:
        """The true state now."""
        return self.plant.truth

    @property
    def counters(self) -> list[Counters]:
        """What each endpoint has received, garbage included."""
        return [link.decoder.counters for link in self.links]

    def step(self) -> None:
        """Let one step pass."""
        now_us = self._count * self._step_us
        if self._up is not None:
            for endpoint, datagram in self._up.arrived(now_us):
                self._deliver(datagram, endpoint)
        self._count += 1
        if not self._held:
            self._pass()
        self._tell()
        now_us += self._step_us
        built: dict[int, Values | None] = {}  # what one link has just said is said to the other too
        for endpoint, link in enumerate(self.links):
            link.stream(now_us, built)
            if link.outbox:
                self._send(endpoint, link)

    def _pass(self) -> None:
        """A step in which the vehicle's own time passes."""
        events, plant = self.world_events, self.plant
        if events.any:
            events.look(plant.truth.t_boot, self.autopilot.offboard_flown)
            alter = events.altered if events.alters else None
            for link in self.links:
                link.alter = alter
        plant.step(self.autopilot.control())
        truth = plant.truth
        if plant.cells is not None:
            self.autopilot.battery.measure(plant.cells.voltage, plant.cells.current, plant.cells.charge)
        self.autopilot.observe(self._sensors.observe(truth), truth)

    def receive(self, datagram: bytes, endpoint: int = 0) -> None:
        """A datagram is sent to an endpoint, now."""
        if endpoint in self.world_events.cut_up:
            return
        if self._up is not None:
            self._up.send(self._count * self._step_us, endpoint, datagram)
        else:
            self._deliver(datagram, endpoint)

    def datagrams(self) -> list[tuple[int, bytes]]:
        """What leaves now: (endpoint, datagram), oldest first."""
        if self._down is not None:
            return self._down.arrived(self._count * self._step_us)
        ready, self._leaving = self._leaving, []
        return ready

    def _begin_in_flight(self, start: Start, world: World) -> None:
        """Put the vehicle in the air. At rest and level it is trimmed to stay there; otherwise it is as told."""
        self._held = start.held
        p_n, v_n, q_nb, w_b = start.position_n, start.velocity_n, start.q_nb, start.rates_b
        vehicle = self.plant.vehicle
        at_rest = v_n == w_b == (0.0, 0.0, 0.0) and q_nb[1] == q_nb[2] == 0.0 and not start.held
        drag = vehicle.drag + world.truth.rotor_drag + world.truth.quadratic_drag * math.hypot(*world.wind_n)
        disturbance = _against(world.wind_n, drag, vehicle.gravity)
        self.plant.fly(p_n, v_n, q_nb, w_b, OFF)
        heading = euler_from_rotation(rotation_matrix(q_nb))[0]
        target = Target(p_n, (0.0, 0.0, 0.0), heading)
        attitude, commands = self.autopilot.cascade.trim(
            exact(self.plant.truth), target, disturbance if at_rest else (0, 0, 0)
        )
        thrusts = self.plant.thrusts_of(commands)
        self.plant.fly(p_n, v_n, attitude if at_rest else q_nb, w_b, thrusts)
        self.autopilot.begin_in_flight(self._sensors.observe(self.plant.truth), self.plant.truth, commands, disturbance)

    def _deliver(self, datagram: bytes, endpoint: int) -> None:
        frames = self.links[endpoint].receive(datagram)
        if len(self.links) > 1:
            for frame in frames:
                self._forward(frame, endpoint)
        if self._held and self.autopilot.offboard_flown:
            self._held = False
        self._tell()
        for number, link in enumerate(self.links):
            if link.outbox:
                self._send(number, link)

    def _forward(self, frame: Frame, endpoint: int) -> None:
        """Pass a frame on to the other endpoints, as PX4 does with what is not for itself alone."""
        where = frame.format.where
        system = frame.values[where["target_system"]] if "target_system" in where else 0
        component = frame.values[where["target_component"]] if "target_component" in where else 0
        if (system, component) == (SYSTEM, COMPONENT) or (system == SYSTEM and component == 0):
            return
        for number, link in enumerate(self.links):
            known = system == 0 or any(system == s and component in (0, c) for s, c in link.peers)
            if number != endpoint and known:
                link.outbox.append(frame.raw)

    def _tell(self) -> None:
        """Send and log the commander's texts, and log what has changed."""
        commander = self.autopilot.commander
        if commander.texts:
            for text in commander.texts:
                self._note(text.text.rstrip("\t"))
                if self.now >= self._tell_again_at:
                    self._texts_left, self._tell_again_at = TEXTS, self.now + TEXTS_PERIOD
                if self._texts_left > 0:
                    self._texts_left -= 1
                    self.autopilot.events.happened(
                        text, self.autopilot.estimate.time_us, commander.user_intended_mode, commander.mode
                    )  # fmt: skip
                    for link in self.links:
                        link.say(text)
            commander.texts.clear()
        if commander.mode is not self._logged:
            self._logged = commander.mode
            self._note(f"mode {commander.mode.name}{'' if commander.failsafe is None else ' (failsafe)'}")

    def _note(self, line: str) -> None:
        """Log a line, but not again and again what somebody provokes many times a second."""
        if line != self._noted[0] or self.now - self._noted[1] >= 1.0:
            self.log.append(line)
            self._noted = (line, self.now)

    def _send(self, endpoint: int, link: Link) -> None:
        if endpoint not in self.world_events.cut_down:
            if self._down is not None:
                for datagram in link.outbox:
                    self._down.send(self._count * self._step_us, endpoint, datagram)
            else:
                self._leaving += [(endpoint, datagram) for datagram in link.outbox]
        link.outbox.clear()


def _against(wind_n: Vec3, drag: float, gravity: float) -> Vec3:
    """The acceleration the position loop must add to hold against the wind's drag (m/s^2, NED).

    The loop turns it into a thrust whose level part grows with its vertical part; that is taken out here.
    """
    north, east, down = (-drag * wind for wind in wind_n)
    lift = 1.0 - down / gravity
    return (north / lift, east / lift, down) if math.isfinite(lift) and lift > 0.1 else (north, east, 0.0)
