"""The companion's process is restarted beside a PX4 whose client goes on in the old session: the stand-in's client."""

from __future__ import annotations

from companion.config.vehicle import load_vehicle
from companion.mavlink.modes import Mode
from companion.vehicle import MotorSetpoint, OutputLevel
from companion.world import World
from companion.xrce.commands import Commands
from companion.xrce.flight_mode import FlightMode
from sim_bridge.autopilot.xrce import Release
from sim_bridge.bridge import Bridge
from sim_bridge.world_events import XRCE

LIMIT = 30.0
"""s within which everything is there."""


class Restarted:
    """A vehicle on the ground, and companions one after the other."""

    def __init__(self) -> None:
        self.bridge = Bridge(load_vehicle("sih"), World(), landed=True, endpoints=1, xrce=Release.MAIN, only=())
        self.bridge.autopilot.parameters["UXRCE_DDS_SYNCT"] = 0

    def until_ready(self, commands: Commands) -> float:
        """s that it took."""
        begun = self.bridge.now
        while commands.missing is not None:
            self.step(commands)
            assert self.bridge.now - begun < LIMIT, commands.missing
        return self.bridge.now - begun

    def step(self, commands: Commands) -> None:
        bridge = self.bridge
        bridge.step()
        said = [data for endpoint, data in bridge.datagrams() if endpoint == XRCE]
        while said:
            for data in said:
                commands.receive(data, bridge.now)
            for data in commands.datagrams(bridge.now):
                bridge.receive(data, XRCE)
            said = [data for endpoint, data in bridge.datagrams() if endpoint == XRCE]


def test_a_restarted_companion_listens_until_the_client_begins_anew() -> None:
    vehicle = Restarted()
    vehicle.until_ready(Commands(OutputLevel.MOTORS))
    commands = Commands(OutputLevel.MOTORS)
    vehicle.step(commands)
    vehicle.step(commands)
    assert "begun a new session" in (commands.missing or "")
    assert not commands.send(MotorSetpoint((0.1,) * 4), 1.0, vehicle.bridge.now, True)
    assert commands.datagrams(vehicle.bridge.now) == []
    assert vehicle.until_ready(commands) < 10.0
    assert commands.agent.sessions == 1
    heard = commands.agent.counters.orphaned
    assert heard > 100
    assert f"{heard} messages of PX4's client came in a session whose agent was gone" in commands.words()[-1]
    assert commands.agent.counters.strange == 0


def test_a_mode_of_a_restarted_companion_takes_the_place_of_its_old_one() -> None:
    """PX4 drops what does not answer; by the time its client has begun anew the place is free again."""
    vehicle = Restarted()
    for _ in range(2):
        mode = FlightMode("Path")
        vehicle.until_ready(Commands(OutputLevel.ATTITUDE, flight_mode=mode))
        assert mode.mode is Mode.EXTERNAL1
        external = vehicle.bridge.autopilot.commander.external_modes
        assert external.of(Mode.EXTERNAL2) is None
