"""Microseconds a message: the lean codec and pymavlink, decoding and encoding, in one run."""

from __future__ import annotations

import timeit

from pymavlink.dialects.v20 import development as pymavlink

from companion.mavlink.codec import Decoder, Encoder
from companion.mavlink.dialect import BY_NAME

MESSAGES = ("HEARTBEAT", "ATTITUDE_QUATERNION", "LOCAL_POSITION_NED", "ODOMETRY", "SET_ACTUATOR_CONTROL_TARGET")


def best(function: object, number: int = 3000) -> float:
    """us a call, the best of 7."""
    return min(timeit.repeat(function, number=number, repeat=7)) / number * 1e6  # type: ignore[arg-type]


def main() -> None:
    """Print the table."""
    print(f"{'message':28} {'decode':>7} {'pymavlink':>10} {'ratio':>6}   {'encode':>7} {'pymavlink':>10} {'ratio':>6}")
    for name in MESSAGES:
        fmt = BY_NAME[name]
        values = fmt.unpack(bytes((7 * i + 1) % 251 for i in range(fmt.size)))
        frame = Encoder(1, 1).encode(fmt, values)
        theirs = pymavlink.MAVLink(None, 1, 1)
        fields = {f: list(v) if isinstance(v := values[fmt.where[f]], tuple) else v for f in fmt.fields}
        decoder, encoder = Decoder(), Encoder(1, 1)
        a = best(lambda d=decoder, x=frame: d.datagram(x))
        b = best(lambda m=theirs, x=frame: m.parse_buffer(x))
        c = best(lambda e=encoder, f=fmt, v=values: e.encode(f, v))
        d = best(lambda m=theirs, f=fields, i=fmt.id: pymavlink.mavlink_map[i](**f).pack(m))
        print(f"{name:28} {a:7.2f} {b:10.2f} {b / a:6.1f}   {c:7.2f} {d:10.2f} {d / c:6.1f}")


if __name__ == "__main__":
    main()
