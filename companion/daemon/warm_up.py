"""Warm-up: the last tick computed again and thrown away, so that the next finds its code and data in the caches."""

from __future__ import annotations

from companion import pilot
from companion.daemon.conductor import Conductor
from companion.mavlink import setpoints
from companion.mavlink.codec import Decoder, Encoder
from companion.mavlink.telemetry import ODOMETRY, WANTED, Telemetry
from companion.vehicle import TorqueSetpoint


class WarmUp:
    """Has a decoder, a telemetry and an encoder of its own, so that nothing of the flight changes."""

    def __init__(self) -> None:
        self._decoder = Decoder(wanted=WANTED)
        self._telemetry = Telemetry()
        self._encoder = Encoder(1, 1)
        self._frame = Encoder(1, 1).message(ODOMETRY, frame_id=1, child_frame_id=1, q=(1.0, 0.0, 0.0, 0.0))

    def run(self, conductor: Conductor) -> bool:
        """Do what the last tick did. False: nothing to repeat."""
        tick, plan = conductor.last, conductor.plan
        if tick is None or plan is None or tick.outcome.setpoint is None or tick.observation.state is None:
            return False
        for frame in self._decoder.datagram(self._frame):
            self._telemetry.receive(frame, tick.now)
        memory, early = pilot.compute_setpoint(plan, tick.before, tick.observation, tick.now)
        if early is None:
            pilot.supervise(plan, memory, tick.observation, tick.now, early)
        setpoint = tick.outcome.setpoint if early is None else early.steered.setpoint
        if conductor.xrce is not None:
            conductor.xrce.rehearse(setpoint, tick.observation.state.t_boot)
        elif not isinstance(setpoint, TorqueSetpoint):
            self._encoder.encode(*setpoints.encoded(setpoint, tick.observation.state.t_boot, 1, 1))
        return True
