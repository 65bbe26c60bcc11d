"""The columns of the flight table: what the pilot saw at a tick, what it did, and the law's own words."""

from __future__ import annotations

from companion.record.table import Column, dtype_of

FACTS = ("armed", "mode", "intended", "landed", "ready", "failsafe", "battery", "estimator")
"""The facts of VehicleStatus, each with the time when it was said."""

OBSERVATION_COLUMNS = (
    Column("now", "d", "s, our monotonic clock"),
    Column("fresh", "b", "1: a state arrived with this tick; the columns t_boot to resets are it"),
    Column("t_boot", "d", "s, the vehicle's stamp of the state"),
    *(Column(name, "d", "m, position in the vehicle's local frame") for name in ("north", "east", "down")),
    *(Column(name, "d", "m/s, velocity") for name in ("v_north", "v_east", "v_down")),
    *(Column(name, "d", "attitude quaternion, body to world") for name in ("q_w", "q_x", "q_y", "q_z")),
    *(Column(name, "d", "rad/s, body rates") for name in ("p", "q", "r")),
    Column("resets", "i", "the estimator's reset counter"),
    Column("armed", "b", "1 armed, 0 disarmed, -1 not said"),
    Column("mode", "b", "index of vehicle.Mode, -1 not said"),
    Column("intended", "b", "index of vehicle.Mode, the user's intention, -1 not said"),
    Column("landed", "b", "index of vehicle.Landed, -1 not said"),
    Column("ready", "b", "1 would accept arming, 0 not, -1 not said"),
    Column("failsafe", "b", "1 in a failsafe, 0 not, -1 not said"),
    Column("battery", "d", "what remains, 0..1, nan not said"),
    Column("estimator", "i", "flags of ESTIMATOR_STATUS, -1 not said"),
    Column("answer_to", "b", "index of phases.Request that was answered, -1 none"),
    Column("answer", "b", "MAV_RESULT, -1 none"),
    Column("stop", "b", "1: told to stop"),
    Column("link_delay", "d", "s, round trip of a message, nan not measured"),
    Column("rate", "d", "Hz of states, nan not measured"),
    Column("behind", "i", "states that arrived with this one and were passed over"),
    Column("companions", "i", "other companions that speak on the link"),
    Column("speed_scale", "d", "the factor on the mission's speed that is asked for"),
    Column("late", "d", "s by which the state is older than the youngest that the link has brought"),
    Column("clock_pace", "d", "s of the vehicle's clock a second of ours, nan not measured"),
    Column("was_armed", "b", "1: it was seen armed since it was first heard"),
    *(
        Column(f"{fact}_{part}", "d", meaning)
        for fact in FACTS
        for part, meaning in (("at", "s, our clock, when it was said, nan never"), ("lasts", "s for which that counts"))
    ),
)

OUTCOME_COLUMNS = (
    Column("phase", "b", "index of phases.Phase after the tick"),
    Column("request", "b", "index of phases.Request that stands, -1 none"),
    Column("asked", "b", "1: it was sent at this tick"),
    Column("payload", "i", "commands for the payload that were sent at this tick"),
    Column("setpoint", "b", "0 none, 1 motors, 2 rates, 3 attitude, 4 torques"),
    *(
        Column(
            f"sent_{i}",
            "d",
            "motors: commands; rates: p, q, r (rad/s), thrust; attitude: q, thrust; torques: shares, thrust",
        )
        for i in range(5)
    ),
)

LAW_COLUMNS = (
    Column("zeta", "d", "N, the thrust the law integrates"),
    Column("zeta_dot", "d", "N/s"),
    Column("thrust", "d", "N, the collective thrust sent"),
    Column("saturated", "b", "1: a limit was met"),
    Column("ramp", "d", "factor on the mission's speed"),
    Column("s", "d", "m, arc length of the nearest point of the path"),
    Column("travelled", "d", "m along the path since following began"),
    Column("path_error", "d", "m, distance to the path"),
    Column("speed", "d", "m/s along the path, mu . V"),
    Column("alpha", "d", "m/s, the mission's speed here"),
    Column("yaw", "d", "rad, heading"),
    Column("beta", "d", "rad, the mission's heading here"),
    Column("yaw_error", "d", "rad, wrapped"),
    Column("tilt", "d", "rad, lean of the thrust axis"),
    Column("pace", "f", "share of the mission's speed that was asked for; less than 1 where it could not be flown"),
    Column("thrust_scale", "f", "found: acceleration made over acceleration asked for"),
    Column("drag", "f", "1/s, found"),
    *(Column(f"push_{axis}", "f", "m/s^2, found: the disturbance") for axis in ("north", "east", "down")),
    *(Column(f"bias_{axis}", "f", "m/s, found: velocity over moving position") for axis in ("north", "east", "down")),
    Column("delay", "f", "s, from a state to the effect of its command on the motors"),
    Column("rate_lag", "f", "s, found: of the rate loop; NaN at motors and torques"),
    Column("yaw_lag", "f", "s, found: of the yaw rate loop"),
    Column("path_pole", "f", "1/s, of h1 and h2, where it was chosen and not written"),
    Column("motor_lag", "f", "s, found: of the motors; NaN at motors and torques"),
    Column(
        "thrust_curve", "f", "found: slope of the thrust beyond proportion to its command; NaN at motors and torques"
    ),
    Column("thrust_curve_std", "f", "of it"),
    Column("latency", "f", "s from the arrival of the state to the return of the setpoint's send"),
)

COLUMNS = OBSERVATION_COLUMNS + OUTCOME_COLUMNS + LAW_COLUMNS
OUTCOME_DTYPE = dtype_of(OUTCOME_COLUMNS)
