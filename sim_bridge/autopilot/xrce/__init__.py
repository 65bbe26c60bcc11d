"""PX4's uxrce_dds_client: the vehicle's side of the line to an XRCE agent. No socket, no clock.

topic_table    which topics a PX4 takes and gives, in which order and version: topics_*.txt
reliable       the stream on which each message arrives once and in order
session        messages out of submessages, numbered; what came, sorted
publications   what the vehicle says of itself, how often
subscriptions  what is written to it
service        the one service, which nobody serves
samples        the state in PX4's layouts
client         the life of it: ping, session, time, objects, publish and listen, all over again
vehicle        the autopilot as its client sees it
"""

from __future__ import annotations

from sim_bridge.autopilot import parameters
from sim_bridge.autopilot.autopilot import Autopilot
from sim_bridge.autopilot.xrce.client import Client
from sim_bridge.autopilot.xrce.topic_table import Release
from sim_bridge.autopilot.xrce.vehicle import XrceVehicle

__all__ = ["Client", "Release", "xrce_client"]


def xrce_client(autopilot: Autopilot, release: Release) -> Client:
    """The client of an autopilot, as a PX4 of ``release`` has it, with its parameters."""
    autopilot.parameters.add(parameters.XRCE)
    return XrceVehicle(autopilot, release).client
