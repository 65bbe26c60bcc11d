"""At which level setpoints go out, and why: decided by what PX4 does when they stop coming.

At rates PX4 flies the last body rate until COM_OF_LOSS_T has passed; in a second that is a somersault. At attitudes it
holds the last attitude, which is harmless for as long.
"""

from __future__ import annotations

from dataclasses import dataclass

from companion.vehicle import CompanionError, MotorInterface, OutputLevel, Tuning, Vehicle

LOSS_TIME_MAX = 0.3
"""s that PX4 may fly a last body rate."""
HOVER_APART = 1.6
"""The factor between two hover thrusts from which on they are not one vehicle's: more than a battery or a payload."""
HOLD_ON_LOSS = 5
SANE_ON_LOSS = {0: "Position", 1: "Altitude", 3: "Return", 4: "Land", 5: "Hold"}
FATAL_ON_LOSS = {6: "Terminate", 7: "Disarm"}
"""COM_OBL_RC_ACT by what it does. 2, Stabilized, waits for sticks that may not be there."""


@dataclass(frozen=True, slots=True)
class Choice:
    """An output ``level``, ``why`` it was chosen (a sentence), and the parameters to set for the flight."""

    level: OutputLevel
    why: str
    settings: tuple[tuple[str, float], ...] = ()


def motors_refused(vehicle: Vehicle, direct: bool | None) -> str | None:
    """Why no motor commands are sent to a vehicle. ``direct``: whether it says it takes them; None: it has not said."""
    if vehicle.motors is not MotorInterface.DIRECT:
        return (
            f"vehicle {vehicle.name} does not take motor commands (its file says motors: px4); "
            "fly it with --output rates or attitude"
        )
    if direct is False:
        return (
            "the vehicle does not take motor commands: PX4 has had no SET_ACTUATOR_CONTROL_TARGET since 1.14; "
            "fly it with --output rates or attitude"
        )
    return None


def another_vehicle(vehicle: Vehicle, tuning: Tuning) -> str | None:
    """Why the vehicle that answers cannot be the one of the vehicle file: they hover at quite different thrusts."""
    told = tuning.hover_thrust
    believed = vehicle.hover_thrust or vehicle.weight / vehicle.thrust_max
    if not told or 1.0 / HOVER_APART < told / believed < HOVER_APART:
        return None
    return (
        f"the vehicle hovers at a thrust of {told:.2f} (MPC_THR_HOVER) and {vehicle.name} at {believed:.2f}: another "
        "mass or other motors; give the vehicle's own file with --vehicle, or set MPC_THR_HOVER"
    )


def chosen(level: OutputLevel, tuning: Tuning, *, auto: bool, consent: bool) -> Choice:
    """The level to fly. ``level``: what was asked for; with ``auto`` attitude may be flown in the place of rates.
    ``consent``: parameters may be set for the flight. CompanionError: what was asked for is not safe."""
    if level is OutputLevel.MOTORS:
        return Choice(level, "output motors: the vehicle declares direct motors")
    settings = []
    faults = []
    fatal = FATAL_ON_LOSS.get(tuning.offboard_loss_action if tuning.offboard_loss_action is not None else -1)
    if level is OutputLevel.RATES and (tuning.offboard_loss_time is None or tuning.offboard_loss_time > LOSS_TIME_MAX):
        settings.append(("COM_OF_LOSS_T", LOSS_TIME_MAX))
        faults.append(
            "PX4 does not say its COM_OF_LOSS_T"
            if tuning.offboard_loss_time is None
            else f"COM_OF_LOSS_T is {tuning.offboard_loss_time:g} s, and for so long PX4 would fly the last body rate "
            "if the link broke"
        )
    if fatal is not None or (level is OutputLevel.RATES and tuning.offboard_loss_action not in SANE_ON_LOSS):
        settings.append(("COM_OBL_RC_ACT", HOLD_ON_LOSS))
        faults.append(
            f"COM_OBL_RC_ACT is {tuning.offboard_loss_action}"
            + (
                f" ({fatal}): a broken link would end the flight"
                if fatal
                else ", expected Hold (5), Return (3) or Land (4)"
            )
        )
    if not faults:
        return Choice(level, _why(level, tuning))
    reason = "; ".join(faults)
    advice = " and ".join(f"{name} to {value:g}" for name, value in settings)
    known = tuning.offboard_loss_time is not None and tuning.offboard_loss_action is not None
    if consent and known:
        return Choice(level, f"output {level.value}: {reason}; {advice} for this flight", tuple(settings))
    if auto and fatal is None:
        return Choice(
            OutputLevel.ATTITUDE, f"output attitude: {reason}; for rates set {advice}, or give --set-parameters"
        )
    offer = f"set {advice}, or give --set-parameters to have it set for this flight and restored after it"
    raise CompanionError(f"{reason}; {offer}" + ("" if fatal else ", or fly --output attitude"))


def _why(level: OutputLevel, tuning: Tuning) -> str:
    if level is OutputLevel.ATTITUDE:
        return "output attitude: as asked; PX4 holds the last attitude if the link breaks"
    action = SANE_ON_LOSS[tuning.offboard_loss_action] if tuning.offboard_loss_action is not None else ""
    return f"output rates: if the link breaks PX4 acts after {tuning.offboard_loss_time:g} s, with {action}"
