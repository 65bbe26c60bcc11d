"""At which level setpoints go out, and why: decided by what PX4 does when they stop coming.

At rates PX4 flies the last body rate until COM_OF_LOSS_T has passed; in a second that is a somersault. At motors it
keeps the last motor commands, which turn a vehicle over sooner. At attitudes it holds the last attitude, which is
harmless for as long.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

from companion.vehicle import CompanionError, MotorInterface, OutputLevel, Tuning, Vehicle

LOSS_TIME_MAX = 0.3
"""s that PX4 may fly a last body rate. Engineering choice."""
LOSS_TIME_MAX_MOTORS = 0.1
"""s that PX4 may fly last motor commands. Flown on PX4 when commands stop: 0.3 s cost 50 degrees, 0.1 s 20 degrees
and 5 cm."""
FLOWN_ON = {
    OutputLevel.RATES: ("the last body rate", LOSS_TIME_MAX),
    OutputLevel.MOTORS: ("the last motor commands", LOSS_TIME_MAX_MOTORS),
    OutputLevel.TORQUES: ("the last torques", LOSS_TIME_MAX_MOTORS),
}
"""What PX4 flies on when commands stop, and how long (s) it may."""
HOVER_APART = 1.6
"""Ratio of two hover thrusts from which on they are not one vehicle's: more than a battery or a payload makes.
Engineering choice."""
HOLD_ON_LOSS = 5
"""Code of PX4's COM_OBL_RC_ACT: Hold when offboard setpoints are lost."""
SANE_ON_LOSS = {0: "Position", 1: "Altitude", 3: "Return", 4: "Land", 5: "Hold"}
"""Codes of PX4's COM_OBL_RC_ACT that hand the vehicle to somebody or something that flies it on."""
NOT_ASKED = (
    "rates go over MAVLink, not over XRCE: PX4 then stabilises the vehicle itself and catches it sooner; ask for "
    "motors or torques with --output"
)
"""Why ``auto`` does not take motors or torques."""
FATAL_ON_LOSS = {6: "Terminate", 7: "Disarm"}
"""Codes of PX4's COM_OBL_RC_ACT that do not. 2, Stabilized, waits for sticks that may not be there."""


NO_LONGER = {
    OutputLevel.MOTORS: (
        "PX4 does not stabilise the vehicle, does not mix and does not limit: no rate loop, no allocator (no "
        "CA_FAILURE_MODE, no slew rate); its failure detector does not look at the attitude; its land detector "
        "believes the thrust that the companion tells it. Kill switch, disarming, termination and output limits still "
        "act"
    ),
    OutputLevel.TORQUES: (
        "PX4 does not stabilise the vehicle: no rate loop; its failure detector does not look at the attitude; its "
        "land detector believes the thrust that the companion tells it. Its allocator, kill switch, disarming, "
        "termination and output limits still act"
    ),
}
"""What PX4 does not do while it flies on these (measured: xrce.md, section 6)."""


@dataclass(frozen=True, slots=True)
class Choice:
    """An output ``level``, ``why`` it was chosen (a sentence), and the parameters to set for the flight."""

    level: OutputLevel
    why: str
    settings: tuple[tuple[str, float], ...] = ()


def unreachable(vehicle: Vehicle, level: OutputLevel, direct: bool | None = None) -> str | None:
    """Why a level does not reach a vehicle over MAVLink. ``direct``: whether it says it takes motor commands; None: it
    has not said."""
    if level is OutputLevel.TORQUES:
        return "torques go over XRCE alone; give --xrce, or fly it with --output rates or attitude"
    if level is not OutputLevel.MOTORS:
        return None
    if vehicle.motors is not MotorInterface.DIRECT:
        return (
            f"vehicle {vehicle.name} does not take motor commands (its file says motors: px4); "
            "fly it with --output rates or attitude, or through PX4's XRCE client (--xrce)"
        )
    if direct is False:
        return (
            "the vehicle does not take motor commands: PX4 has had no SET_ACTUATOR_CONTROL_TARGET since 1.14; "
            "fly it with --output rates or attitude"
        )
    return None


def direct_refused(vehicle: Vehicle, level: OutputLevel, *, accepted: bool) -> str | None:
    """Why a vehicle is not flown at a level without PX4's rate loop over XRCE. ``accepted``: the user knows why."""
    if level.without_rate_loop and any(rotor.command[0] < 0.0 for rotor in vehicle.rotors):
        return (
            f"the commands of {vehicle.name} go below 0, which stops a motor of PX4; fly it over MAVLink, or with "
            "--output rates or attitude"
        )
    if accepted or level not in NO_LONGER:
        return None
    return (
        f"output {level.value}: {NO_LONGER[level]}. Fly it on --output rates first; then say --accept-direct-motors if "
        "that is what you want"
    )


def another_vehicle(vehicle: Vehicle, tuning: Tuning) -> str | None:
    """Why the vehicle that answers cannot be the one of the vehicle file: they hover at quite different thrusts."""
    hover = tuning.hover_thrust
    believed = vehicle.hover_thrust or vehicle.weight / vehicle.thrust_max
    if not hover or 1.0 / HOVER_APART < hover / believed < HOVER_APART:
        return None
    return (
        f"the vehicle hovers at a thrust of {hover:.2f} (MPC_THR_HOVER) and {vehicle.name} at {believed:.2f}: another "
        "mass or other motors; give the vehicle's own file with --vehicle, or set MPC_THR_HOVER"
    )


def chosen(level: OutputLevel, tuning: Tuning, *, auto: bool, consent: bool, over_xrce: bool = False) -> Choice:
    """The level to fly. ``level``: what was asked for; with ``auto`` attitude may be flown in the place of rates.
    ``consent``: parameters may be set for the flight. ``over_xrce``: setpoints go to PX4's XRCE client, and motors
    and torques then want Hold alone. CompanionError: what was asked for is not safe."""
    settings = []
    faults = []
    hold_alone = over_xrce and level.without_rate_loop
    sane = {HOLD_ON_LOSS} if hold_alone else set(SANE_ON_LOSS)
    fatal = FATAL_ON_LOSS.get(tuning.offboard_loss_action if tuning.offboard_loss_action is not None else -1)
    if level in FLOWN_ON:
        last, longest = FLOWN_ON[level]
        time = tuning.offboard_loss_time
        if time is None or exceeds(time, longest):
            settings.append(("COM_OF_LOSS_T", longest))
            faults.append(
                "PX4 does not say its COM_OF_LOSS_T"
                if time is None
                else f"COM_OF_LOSS_T is {time:g} s, and for so long PX4 would fly {last} if the link broke"
            )
    if fatal is not None or (level in FLOWN_ON and tuning.offboard_loss_action not in sane):
        settings.append(("COM_OBL_RC_ACT", HOLD_ON_LOSS))
        faults.append(
            f"COM_OBL_RC_ACT is {tuning.offboard_loss_action}"
            + (
                f" ({fatal}): a broken link would end the flight"
                if fatal
                else f", expected Hold (5){'' if hold_alone else ', Return (3) or Land (4)'}"
            )
        )
    if not faults:
        return Choice(level, _why(level, tuning, over_xrce=over_xrce))
    reason = "; ".join(faults)
    advice = " and ".join(f"{name} to {value:g}" for name, value in settings)
    known = tuning.offboard_loss_time is not None and tuning.offboard_loss_action is not None
    if consent and known:
        return Choice(level, f"output {level.value}: {reason}; {advice} for this flight", tuple(settings))
    if auto and fatal is None and level is OutputLevel.RATES:
        return Choice(
            OutputLevel.ATTITUDE, f"output attitude: {reason}; for rates set {advice}, or give --set-parameters"
        )
    offer = f"set {advice}, or give --set-parameters to have it set for this flight and restored after it"
    raise CompanionError(f"{reason}; {offer}" + ("" if fatal else ", or fly --output attitude"))


def exceeds(value: float, limit: float) -> bool:
    """Whether a parameter exceeds a limit, as PX4 holds both: 0.3 reads back as 0.30000001."""
    return float32(value) > float32(limit)


def float32(value: float) -> float:
    """``value`` as PX4's parameters hold it."""
    held: float = struct.unpack("<f", struct.pack("<f", value))[0]
    return held


def _why(level: OutputLevel, tuning: Tuning, *, over_xrce: bool) -> str:
    if level is OutputLevel.ATTITUDE:
        return "output attitude: as asked; PX4 holds the last attitude if the link breaks"
    if over_xrce:
        return f"output {level.value} over XRCE: PX4 acts {tuning.offboard_loss_time:g} s after commands stop"
    if level is OutputLevel.MOTORS:
        return "output motors: the vehicle declares direct motors"
    action = SANE_ON_LOSS[tuning.offboard_loss_action] if tuning.offboard_loss_action is not None else ""
    return f"output rates: if the link breaks PX4 acts after {tuning.offboard_loss_time:g} s, with {action}"
