"""The whole vehicle without a socket and without a clock: datagrams and steps in, datagrams out.

    bridge.receive(datagram)     at the present time
    bridge.step()                one fixed step later
    bridge.datagrams()           what to send now

Its time is a count of steps, so that everything is exact and the same seed gives the same bytes.
"""

from __future__ import annotations

import math
from collections.abc import Collection

from companion.frames import euler_from_rotation, rotation_matrix
from companion.mavlink.codec import Frame
from companion.mavlink.counters import Counters
from companion.mavlink.signing import SETUP_SIGNING
from companion.mavlink_common import MavResult
from companion.vehicle import MotorInterface, Vehicle
from companion.world import Start, World
from companion.world.events import Operator, PayloadDrop, Stranger
from sim_bridge.autopilot.autopilot import Autopilot
from sim_bridge.autopilot.flight_modes.manual_control import ManualControlSetpoint
from sim_bridge.autopilot.mavlink.link import Link
from sim_bridge.autopilot.mavlink.setpoint_link import COMPONENT, SYSTEM
from sim_bridge.autopilot.mavlink.signing import KeyStore
from sim_bridge.autopilot.mavlink.streams import GROUND_STATION, ONBOARD, Boot, Streams
from sim_bridge.autopilot.messages import Values
from sim_bridge.autopilot.xrce import Release, xrce_client
from sim_bridge.control.position import Target
from sim_bridge.link_model import LinkWay
from sim_bridge.noise import RandomStream, normals
from sim_bridge.operator import ask
from sim_bridge.plant import OFF, Plant, Truth
from sim_bridge.sensors import Sensors, exact
from sim_bridge.strangers import FIRST_STRANGER, Speaker
from sim_bridge.teller import Teller
from sim_bridge.trim import steady_disturbance
from sim_bridge.world_events import COMPANION, XRCE, Reach, WorldEvents

FAST_STATE = 250.0
"""Hz. A vehicle that is asked for its state more often than this steps at 1 ms instead of PX4's 4 ms."""
STICKS_US = 20_000
"""us between two samples of a pilot's sticks: a joystick's 50 Hz."""
PAYLOAD_MAX = 0.75
"""Ratio to the mass of what may fall off in a flight. Engineering choice: what is left is a vehicle."""
HOVER = Start.hover((0.0, 0.0, -10.0))
"""10 m above the origin."""


class Bridge:
    """A vehicle in a world, speaking MAVLink as system 1, component 1.

    Endpoint 0 is the companion's, 1 the ground station's. ``landed``: it stands on the ground at the origin, switched
    on just now; otherwise it begins in the air as ``start`` says, by default in a hover 10 m above the origin.
    ``direct``: it takes SET_ACTUATOR_CONTROL_TARGET as motor commands, as it also does if its vehicle file says so.
    ``endpoints``: 1 leaves the ground station out. ``seed``: of every chance in the world. ``key``: what it signs with
    from the start. ``xrce``: it has an XRCE client too, of that PX4; its line is endpoint XRCE. ``only``: the ids of
    what is streamed; None: all that PX4 streams. ValueError: the vehicle cannot be flown. Nothing received ever raises.

    ``log``: lines for a person, to be taken out by whoever shows them. ``orders``: what a world's operator asked for,
    when, and the answer. ``ports_dialled``: how often the vehicle has changed its port to the companion.
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
        key: bytes | None = None,
        xrce: Release | None = None,
        only: Collection[int] | None = None,
    ) -> None:
        self._per_second = 1000 if vehicle.state_rate > FAST_STATE else 250
        self.step_s = 1.0 / self._per_second
        self._step_us = 1_000_000 // self._per_second
        self._count = 0
        self.direct = direct or vehicle.motors is MotorInterface.DIRECT
        self.plant = Plant(vehicle, world, self._per_second, seed)
        self._sensors = Sensors(world.estimate, self.step_s, normals(seed, RandomStream.ESTIMATE))
        self._up = LinkWay(world.link.up, seed, RandomStream.UP)
        self._down = LinkWay(world.link.down, seed, RandomStream.DOWN)
        said = normals(seed, RandomStream.SAID)
        reach = Reach(self.plant, self._sensors, self._down, self._up, self._ask, self._dial, said)
        self.world_events = WorldEvents(world.events, reach)
        _assert_flyable(vehicle.name, self.plant)
        self.autopilot = Autopilot(
            self.plant.vehicle, world.home, self.step_s, self._sensors.observe(self.plant.truth), self.plant.truth,
            direct=self.direct, pack=world.battery, rate_gains=world.truth.rate_gains,
        )  # fmt: skip
        self._held = False
        if not landed:
            self._begin_in_flight(start or HOVER, world)
        boot = Boot() if landed else None
        self.keys = KeyStore(key)
        self.links = [
            Link(
                self.autopilot,
                Streams(who, self._step_us, direct=self.direct, boot=boot, only=only),
                self.keys,
                boots=landed,
            )
            for who in (ONBOARD, GROUND_STATION)[:endpoints]
        ]
        self._strangers: list[Stranger] = []
        self._sticks_at_us = 0
        self.ports_dialled = 0
        self.orders: list[tuple[float, Operator, MavResult | None]] = []
        self._leaving: list[tuple[int, bytes]] = []
        self._teller = Teller(self.autopilot, self.links)
        self.log = self._teller.log
        self.xrce = None if xrce is None else xrce_client(self.autopilot, xrce)

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
        if not self._up.is_clear:
            for endpoint, datagram in self._up.take_arrived(now_us):
                self._deliver(datagram, endpoint)
        self._count += 1
        if self.world_events.any:
            self._let_happen(now_us)
        if not self._held:
            self._pass()
        self._teller.tell(self.now)
        now_us += self._step_us
        built: dict[int, Values | None] = {}  # what one link has just said is said to the other too
        for endpoint, link in enumerate(self.links):
            link.stream(now_us, built)
            if link.outbox:
                self._send(endpoint, link.outbox)
        if self.xrce is not None:
            self.xrce.step(now_us)
            self._send(XRCE, self.xrce.session.outbox)
            self._release()

    def _let_happen(self, now_us: int) -> None:
        """What the world's events bring, at ``now_us`` of our clock. While the vehicle is held, their time stands."""
        events, autopilot = self.world_events, self.autopilot
        events.update(
            self.plant.truth.t_boot, now_us, armed=autopilot.commander.armed, offboard_flown=autopilot.offboard_flown
        )
        alter = events.faults.alter if events.faults else None
        for link in self.links:
            link.alter = alter
        sticks = events.sticks
        if sticks is not None and now_us >= self._sticks_at_us:
            self._sticks_at_us = now_us + STICKS_US
            autopilot.take_sticks(ManualControlSetpoint(sticks.roll, sticks.pitch, sticks.yaw, sticks.throttle), events)
        for speaker in events.speakers:
            self._speak(speaker, now_us)

    def _speak(self, speaker: Speaker, now_us: int) -> None:
        """A stranger says what is due, from his own port or from ours."""
        for datagram in speaker.speak(now_us, self.autopilot.estimate.time_us):
            if not speaker.who.own_port:
                self._pass_down(COMPANION, datagram)
                continue
            if speaker.who not in self._strangers:
                self._strangers.append(speaker.who)
            self._leaving.append((FIRST_STRANGER + self._strangers.index(speaker.who), datagram))

    def _ask(self, order: Operator) -> None:
        self.orders.append((self.now, order, ask(self.autopilot, order)))

    def _dial(self) -> None:
        self.ports_dialled += 1

    def _pass(self) -> None:
        """A step in which the vehicle's own time passes."""
        plant = self.plant
        plant.step(self.autopilot.control())
        truth = plant.truth
        if plant.cells is not None:
            self.autopilot.battery.measure(plant.cells.voltage, plant.cells.current, plant.cells.charge)
        self.autopilot.observe(self._sensors.observe(truth), truth)

    def receive(self, datagram: bytes, endpoint: int = 0) -> None:
        """A datagram is sent to an endpoint, now."""
        if self._up.is_clear_for(endpoint):
            self._deliver(datagram, endpoint)
        else:
            self._up.send(self._count * self._step_us, endpoint, datagram)

    def datagrams(self) -> list[tuple[int, bytes]]:
        """What leaves now: (endpoint, datagram), oldest first. From FIRST_STRANGER on they are the strangers', who
        send to the companion from ports of their own."""
        ready, self._leaving = self._leaving, []
        return ready if self._down.is_clear else self._down.take_arrived(self._count * self._step_us) + ready

    def _begin_in_flight(self, start: Start, world: World) -> None:
        """Put the vehicle in the air. At rest and level it is trimmed to stay there; otherwise it is as told."""
        self._held = start.held
        p_n, v_n, q_nb, w_b = start.position_n, start.velocity_n, start.q_nb, start.rates_b
        vehicle = self.plant.vehicle
        at_rest = v_n == w_b == (0.0, 0.0, 0.0) and q_nb[1] == q_nb[2] == 0.0 and not start.held
        drag = vehicle.drag + world.truth.rotor_drag + world.truth.quadratic_drag * math.hypot(*world.wind_n)
        disturbance = steady_disturbance(world.wind_n, drag, vehicle.gravity)
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
        if endpoint == XRCE:
            if self.xrce is not None:
                self.xrce.receive(datagram)
                self._send(XRCE, self.xrce.session.outbox)
        else:
            frames = self.links[endpoint].receive(datagram, is_piece=self._up.cuts(endpoint))
            if len(self.links) > 1:
                for frame in frames:
                    self._forward(frame, endpoint)
        self._release()
        self._teller.tell(self.now)
        for number, link in enumerate(self.links):
            if link.outbox:
                self._send(number, link.outbox)

    def _release(self) -> None:
        """Time passes from the first setpoint in offboard on."""
        if self._held and self.autopilot.offboard_flown:
            self._held = False

    def _forward(self, frame: Frame, endpoint: int) -> None:
        """Pass a frame on to the other endpoints, as PX4 does with what is not for itself alone."""
        where = frame.format.where
        system = frame.values[where["target_system"]] if "target_system" in where else 0
        component = frame.values[where["target_component"]] if "target_component" in where else 0
        if (system, component) == (SYSTEM, COMPONENT) or (system == SYSTEM and component == 0):
            return
        if frame.format is SETUP_SIGNING:  # a key is never forwarded
            return
        for number, link in enumerate(self.links):
            known = system == 0 or any(system == s and component in (0, c) for s, c in link.peers)
            if number != endpoint and known:
                link.outbox.append(frame.raw)

    def _send(self, endpoint: int, outbox: list[bytes]) -> None:
        for datagram in outbox:
            self._pass_down(endpoint, datagram)
        outbox.clear()

    def _pass_down(self, endpoint: int, datagram: bytes) -> None:
        if self._down.is_clear_for(endpoint):
            self._leaving.append((endpoint, datagram))
        else:
            self._down.send(self._count * self._step_us, endpoint, datagram)


def _assert_flyable(name: str, plant: Plant) -> None:
    """ValueError: the rotors of the vehicle ``name`` do not lift it, or more falls off than it can spare."""
    weight, lift, world = plant.vehicle.weight, plant.vehicle.thrust_max, plant.world
    if plant.cells is not None:
        lift *= plant.cells.strength
    if weight >= lift:
        message = f"{name} in world {world.name} weighs {weight:.4g} N and its rotors lift {lift:.4g} N at most"
        raise ValueError(f"{message}; expected it to be able to fly")
    mass, dropped = plant.vehicle.mass, sum(event.mass for event in world.events if isinstance(event, PayloadDrop))
    if dropped > PAYLOAD_MAX * mass:
        message = f"{name} in world {world.name} has {mass:.4g} kg and drops {dropped:.4g} kg"
        raise ValueError(f"{message}; expected {PAYLOAD_MAX * mass:.3g} kg at most")
