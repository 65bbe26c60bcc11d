"""``fly``: a mission on a vehicle."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

from companion.cli.around import begin_record, exit_code_of, listen_to
from companion.cli.finish import Ended, Ending, finish
from companion.cli.output import Output, WhoStarts
from companion.cli.page import write_page
from companion.cli.terminal import say
from companion.cli.vehicle_log import fetch_and_join
from companion.config.syntax.faults import ConfigError, Fault
from companion.daemon.beside import parse_xrce_address
from companion.daemon.conductor import Conductor, Orders
from companion.daemon.forwarding import Endpoint
from companion.daemon.last_resort import error_words
from companion.daemon.loop import clock, run
from companion.daemon.port import Port
from companion.daemon.signals import Signals, ending_signals
from companion.daemon.signing_files import signing_with
from companion.feasibility.report import check
from companion.feasibility.words import headline
from companion.flight.conduct import Conduct, ControlAuthority
from companion.flight.output import direct_refused, unreachable
from companion.library.orders import Sortie
from companion.mavlink.signing import Signing
from companion.mission import Mission, Origin
from companion.record.folder import Recorder
from companion.record.learned import load_learned, save_learned, state_file
from companion.vehicle import CompanionError, OutputLevel, Vehicle
from companion.xrce.flight_mode import NAMED, level_refused
from companion.xrce.flight_mode import mode_name as checked_name

WAIT_FOR_VEHICLE = 10.0
"""s for a first heartbeat, which comes every second."""
SPEED_SCALE_MAX = 1.5
"""factor on the speed that a ground station may set at most (engineering choice)."""
WORDS = {
    ControlAuthority.COMPANION: "Ctrl-C hands it back",
    ControlAuthority.PILOT: "the path is flown while the pilot has OFFBOARD, or our own mode, selected",
    ControlAuthority.REHEARSAL: "a dry run: nothing is armed, nothing is commanded",
    ControlAuthority.BENCH: "the bench: PROPELLERS OFF; nothing is armed, nothing is commanded",
}


@dataclass(frozen=True)
class Flight:
    """One flight on a vehicle. ``key``: what the link is signed with. ``forward``: who shares it.
    ``log_from``: the address that the vehicle's own log is fetched from afterwards."""

    sortie: Sortie
    directory: Path
    duration: float | None
    ending: Ending
    set_parameters: bool = False
    conduct: Conduct = field(default_factory=Conduct)
    draw: bool = False
    accept_infeasible: bool = False
    key: bytes | None = field(default=None, repr=False)
    forward: tuple[Endpoint, ...] = ()
    log_from: str | None = None


def most_speed_scale(feasible: float) -> float:
    """How far the speed may be raised in flight, where ``feasible`` is the largest factor that keeps every limit."""
    return max(1.0, min(SPEED_SCALE_MAX, feasible))


def objection(mission: Mission, vehicle: Vehicle, ground: float) -> str | None:
    """Why a mission may not be flown over the ground (m, down in the local frame) that is really there; or None."""
    found = check(mission, vehicle, ground)
    return None if found.may_be_flown else headline(found)


def authority_of(start: WhoStarts | None, *, dry_run: bool, bench: bool, serial: bool) -> ControlAuthority:
    """Who does what. On a serial line, which is how a companion sits in a vehicle, the pilot is asked to begin.
    CompanionError: asked for two things that exclude each other."""
    if dry_run and bench:
        raise CompanionError("--dry-run and --bench exclude each other; expected one of them")
    if bench:
        return ControlAuthority.BENCH
    if dry_run:
        return ControlAuthority.REHEARSAL
    pilot = serial if start is None else start is not WhoStarts.COMPANION
    return ControlAuthority.PILOT if pilot else ControlAuthority.COMPANION


def mode_name(start: WhoStarts | None, name: str | None) -> str | None:
    """The name of the flight mode of our own that is asked for; None: OFFBOARD is. CompanionError: ``name`` is none, or
    no mode is asked for that could have it."""
    if start is WhoStarts.MODE:
        return checked_name(NAMED if name is None else name)
    if name is not None:
        raise CompanionError("--mode-name goes with --start mode; expected both or none of them")
    return None


def output_in(start: WhoStarts | None, output: Output, xrce: str | None) -> Output:
    """What is sent. CompanionError: it is not sent in a flight mode of our own, or there is no way to it."""
    if start is not WhoStarts.MODE:
        return output
    if xrce is None:
        raise CompanionError("--start mode needs --xrce: a flight mode is registered through PX4's XRCE client")
    if output is not Output.AUTO and (refused := level_refused(OutputLevel(output.value))) is not None:
        raise CompanionError(refused)
    return Output.ATTITUDE


def xrce_port(url: str | None) -> Callable[[Sortie, bool], Port | None]:
    """How to open the address of ``--xrce``, if there is one, for what is to be flown; whether the user knows what PX4
    no longer does. AddressError: it is no address, or cannot be opened. CompanionError: that is not flown over it, or
    without it."""
    opening = None if url is None else parse_xrce_address(url)

    def opened(sortie: Sortie, accepted: bool) -> Port | None:
        vehicle, level = sortie.vehicle, sortie.level
        refused = unreachable(vehicle, level) if opening is None else direct_refused(vehicle, level, accepted=accepted)
        if refused is not None:
            raise CompanionError(refused)
        return None if opening is None else opening()

    return opened


def log_address(url: str, *, signed: bool) -> str:
    """Where the vehicle's own log is fetched from after the flight. ConfigError: not over a signed link."""
    if signed:
        message = "does not go with --signing-key: MAVLink FTP is not signed here; take the log from the vehicle's card"
        raise ConfigError([Fault("--fetch-log", 0, "", message)])
    return url


def fly(flight: Flight, port: Port, xrce: Port | None = None) -> int:
    """Fly; the exit code. ``xrce``: where PX4's XRCE client is served."""
    report = flight.ending.report
    with contextlib.ExitStack() as stack:
        stack.enter_context(contextlib.closing(port))
        if xrce is not None:
            stack.enter_context(contextlib.closing(xrce))
            if xrce.exposed:
                say(
                    f"warning: {xrce.describe()} can be reached over the network, and XRCE knows no signing: whoever "
                    "sends there can pose as the vehicle's client; let nobody else onto that network"
                )
        signals = stack.enter_context(ending_signals(say))
        signing = None
        if flight.key is not None:
            signing = stack.enter_context(signing_with(flight.key, time.time() - clock()))
        elif port.exposed:
            say(
                f"warning: {port.describe()} can be reached over the network and nothing is signed: whoever sends "
                "there can pose as the vehicle; listen on 127.0.0.1, or sign (companion vehicle sign)"
            )
        recorder = begin_record(flight.directory, flight.sortie, time.time() - clock())
        # the page is drawn once, with the log
        ending = flight.ending if flight.log_from is None else replace(flight.ending, report=False)
        flight = replace(flight, ending=ending)
        code = exit_code_of(lambda: _fly_until_done(flight, port, recorder, signals, signing, xrce), recorder, ending)
    if flight.log_from is not None and (flight.directory / "flight.npy").is_file():
        fetch_and_join(flight.log_from, flight.directory)
        if report:
            write_page(flight.directory)
    return code


def _fly_until_done(
    flight: Flight, port: Port, recorder: Recorder, signals: Signals, signing: Signing | None, xrce: Port | None
) -> int:
    sortie = flight.sortie
    orders = Orders(
        sortie.mission,
        sortie.vehicle,
        sortie.level,
        flight.duration,
        Origin.TAKEOFF,
        auto=sortie.auto,
        set_parameters=flight.set_parameters,
        conduct=flight.conduct,
        draw=flight.draw,
        over_xrce=xrce is not None and (sortie.level.without_rate_loop or flight.conduct.own_mode is not None),
        has_xrce=xrce is not None,
        learned=load_learned(state_file(sortie.vehicle.name)),
        objection=None
        if flight.accept_infeasible
        else lambda mission, ground: objection(mission, sortie.vehicle, ground),
    )
    conductor = Conductor(orders, recorder, clock(), stream=port.stream)
    if signing is not None:
        conductor.link.sign(signing)
        conductor.decoder.signing = signing
    say(f"listening to {port.describe()} for a vehicle; {WORDS[flight.conduct.authority]}")
    listen_to(signals, conductor, recorder)
    failure = run(conductor, port, recorder, say, WAIT_FOR_VEHICLE, flight.forward, xrce)
    if failure is None:
        _remember(conductor, sortie.vehicle.name)
    return finish(conductor, recorder, flight.ending, Ended(clock(), bool(signals.came), failure))


def _remember(conductor: Conductor, vehicle: str) -> None:
    """Keep what the flight found out, for the next."""
    try:
        learned, file = conductor.learned, state_file(vehicle)
        if learned is not None and file is not None and not save_learned(file, learned):
            say(f"what the flight found out of the vehicle could not be kept in {file}; the next one begins without it")
    except Exception as error:  # the flight is over, and its outcome is still to be told
        say(f"what the flight found out of the vehicle could not be kept ({error_words(error)})")
