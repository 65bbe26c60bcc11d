"""The figures a user may set, under PX4's names, with PX4's defaults in simulation."""

from __future__ import annotations

Parameters = dict[str, float]


def defaults() -> Parameters:
    """A fresh set."""
    return {
        "COM_DISARM_LAND": 2.0,  # s from landing to disarming
        "COM_DISARM_PRFLT": 10.0,  # s from arming to disarming where no take-off follows
        "COM_OBL_RC_ACT": 0,  # what follows the loss of offboard setpoints: see commander.OFFBOARD_LOST
        "COM_OF_LOSS_T": 1.0,  # s without a setpoint until offboard is lost
        "COM_SPOOLUP_TIME": 1.0,  # s the motors idle after arming before a take-off
        "MIS_TAKEOFF_ALT": 2.5,  # m a take-off climbs where the command does not say
        "MPC_LAND_CRWL": 0.3,  # m/s of the last metres
        "MPC_LAND_SPEED": 0.7,  # m/s of a landing
        "MPC_TKO_RAMP_T": 3.0,  # s to open the throttle in
        "MPC_TKO_SPEED": 1.5,  # m/s of a take-off
        "NAV_ACC_RAD": 10.0,  # m within which a place is reached
        "RTL_DESCEND_ALT": 30.0,  # m above home
        "RTL_RETURN_ALT": 60.0,  # m above home
        "RTL_MIN_DIST": 10.0,  # m from home within which a return does not climb that high
    }
