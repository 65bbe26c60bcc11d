"""The loops together: which of them run for which kind of setpoint.

One step: choose what is flown (a target, an attitude, rates, motors, nothing), get the motor commands.
"""

from __future__ import annotations

from companion.frames import Quaternion, Vec3, conjugate, multiply
from companion.vehicle import Vehicle
from sim_bridge.control.attitude import AttitudeReference, rates_for, smooth_attitude
from sim_bridge.control.mixing import Mixer
from sim_bridge.control.position import PositionLoop, Target
from sim_bridge.control.rates import RateLoop, RatesWanted, gains_for
from sim_bridge.rotors import Four
from sim_bridge.sensors import Estimate

POSITION_PERIOD = 0.008
"""s: the position loop runs at the rate of PX4's estimator."""
STOPPED: Four = (0.0, 0.0, 0.0, 0.0)
"""Motor commands of a vehicle that is not armed."""


class Cascade:
    """The loops of one vehicle. ``rate_gains``: over the usual ones, by axis. ``hover``: the normalised thrust that
    carries it (0..1). Thrusts are normalised.

    ``commands``: the last motor commands, in the rotors' units; ``thrust``: the last thrust asked for.
    """

    def __init__(self, vehicle: Vehicle, step: float, rate_gains: Vec3 = (1.0, 1.0, 1.0)) -> None:
        self._mixer = Mixer(vehicle.rotors)
        self.hover = vehicle.weight / self._mixer.thrust_per_unit
        self._rates = RateLoop(gains_for(vehicle, self._mixer, rate_gains), step)
        self._every = max(1, round(POSITION_PERIOD / step))
        self.position_step = self._every * step
        self._position = PositionLoop(self.hover, vehicle.gravity, self.position_step)
        self._until_position = 0
        self._aim: tuple[Quaternion, float, float] = ((1.0, 0.0, 0.0, 0.0), 0.0, 0.0)
        self.thrust = 0.0
        self.rates_wanted: RatesWanted = (0.0, 0.0, 0.0)
        self.attitude_wanted: Quaternion = (1.0, 0.0, 0.0, 0.0)
        self._smoothed = AttitudeReference(self.attitude_wanted)
        self._smoothed_at: int | None = None
        self.commands: Four = STOPPED
        self._by_hand = False

    def begin(self, now: Estimate, disturbance: Vec3 = (0.0, 0.0, 0.0)) -> None:
        """Begin afresh; ``disturbance``: the acceleration (m/s^2, NED) it takes to hold against the wind."""
        self._rates.reset(now.w_b)
        self.begin_position(disturbance)

    def begin_position(self, disturbance: Vec3 = (0.0, 0.0, 0.0)) -> None:
        """Begin position control afresh; the next target counts at once."""
        self._position.reset(disturbance)
        self._until_position = 0

    def trim(self, now: Estimate, target: Target, disturbance: Vec3) -> tuple[Quaternion, Four]:
        """The attitude and motor commands with which ``target`` is held at rest against ``disturbance``."""
        self.begin_position(disturbance)
        attitude, thrust = self._position.update(now, target)
        return attitude, self._mixer.mix((0.0, 0.0, 0.0), thrust)[0]

    def stop(self, now: Estimate) -> None:
        """The motors are off: forget what was flown."""
        self._rates.reset(now.w_b)
        self.thrust = 0.0
        self.rates_wanted = (0.0, 0.0, 0.0)
        self.commands = STOPPED

    def fly_motors(self, now: Estimate, commands: Four) -> Four:
        """Motor commands as they come, in the rotors' units."""
        self._by_hand = True
        self.thrust = sum(commands) / 4.0
        self.commands = commands
        return commands

    def hold_motors(self, commands: Four) -> Four:
        """Motor commands as they come, while the thrust asked for stays what it was."""
        self._by_hand = True
        self.commands = commands
        return commands

    def fly_torque(self, torque: Vec3) -> Four:
        """A normalised torque, and the thrust that was last asked for."""
        return self.hold_motors(self.mixed(torque))

    def mixed(self, torque: Vec3) -> Four:
        """The motor commands of a normalised torque and the thrust that was last asked for."""
        return self._mixer.mix(torque, self.thrust)[0]

    def fly_rates(self, now: Estimate, rates: RatesWanted, thrust: float, on_ground: bool = False) -> Four:
        """Body rates (rad/s) and thrust."""
        if self._by_hand:  # the loop has not seen the steps in which the motors were told directly
            self._rates.reset(now.w_b)
            self._by_hand = False
        torque = self._rates.update(now.w_b, rates, integrate=not on_ground)
        self.commands, self._rates.lost = self._mixer.mix(torque, thrust)
        self.rates_wanted = rates
        self.thrust = thrust
        return self.commands

    def open_throttle(self, now: Estimate, of_hover: float) -> Four:
        """On the ground or close to it: no turning, and the throttle so far open."""
        self.begin_position()
        return self.fly_rates(now, (0.0, 0.0, 0.0), of_hover * self.hover, on_ground=True)

    def fly_attitude(
        self, now: Estimate, attitude: Quaternion, thrust: float, heading_rate: float = 0.0, on_ground: bool = False
    ) -> Four:
        """An attitude and thrust, the heading turning at ``heading_rate`` rad/s."""
        if attitude is not self.attitude_wanted:  # a new setpoint moves the model, the time between two of them on
            self._smooth(attitude, heading_rate, now.time_us)
        return self.fly_rates(now, rates_for(now.q_nb, self._smoothed.q_nb, heading_rate), thrust, on_ground)

    def _smooth(self, attitude: Quaternion, heading_rate: float, time_us: int) -> None:
        self.attitude_wanted = attitude
        if self._smoothed_at is None or time_us <= self._smoothed_at:
            self._smoothed = AttitudeReference(attitude)
        else:
            self._smoothed = smooth_attitude(
                self._smoothed, attitude, heading_rate, 1e-6 * (time_us - self._smoothed_at)
            )
        self._smoothed_at = time_us

    def notice_reset(self, before: Quaternion, now: Quaternion) -> None:
        """The estimate has jumped from one attitude to another: as in PX4 what is followed turns along."""
        turned = multiply(multiply(now, conjugate(before)), self._smoothed.q_nb)
        self._smoothed = self._smoothed._replace(q_nb=turned)

    @property
    def wants_target(self) -> bool:
        """Whether the position loop runs in this step and is to be told where to go."""
        return self._until_position == 0

    def aim(self, now: Estimate, target: Target) -> None:
        """A place, a velocity, an acceleration or any mixture, for the next ``position_step`` s of ``fly_aim``."""
        attitude, thrust = self._position.update(now, target)
        self._aim = (attitude, thrust, target.heading_rate)
        self._until_position = self._every

    def fly_aim(self, now: Estimate) -> Four:
        """On to where ``aim`` pointed."""
        self._until_position -= 1
        attitude, thrust, heading_rate = self._aim
        return self.fly_attitude(now, attitude, thrust, heading_rate)
