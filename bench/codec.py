"""Microseconds a message: the lean codec and pymavlink, unsigned and signed, decoding and encoding, in one run.

    python -m bench.codec

What signing adds to one message, signed and checked, is held to SIGNING_MAX at the median.
"""

from __future__ import annotations

import sys
import timeit
from collections.abc import Callable
from statistics import median

from pymavlink.dialects.v20 import development as pymavlink

from companion.mavlink.codec import Decoder, Encoder
from companion.mavlink.dialect import BY_NAME
from companion.mavlink.signing import Signing

MESSAGES = ("HEARTBEAT", "ATTITUDE_QUATERNION", "LOCAL_POSITION_NED", "ODOMETRY", "SET_ACTUATOR_CONTROL_TARGET")
KEY = bytes(range(32))
SIGNING_MAX = 10.0
"""us a message."""
CALLS, REPEATS = 3000, 7


def best(function: Callable[[], object], number: int = CALLS) -> float:
    """us a call, the best of REPEATS."""
    return min(timeit.repeat(function, number=number, repeat=REPEATS)) / number * 1e6


def p50(each: list[Callable[[], object]]) -> float:
    """us, the median over calls that are timed one by one; of REPEATS shares of them the one that other work on the
    machine disturbed least."""
    for call in each[:100]:
        call()
    times = [timeit.timeit(call, number=1) for call in each[100:]]
    size = len(times) // REPEATS
    return 1e6 * min(median(times[i * size : (i + 1) * size]) for i in range(REPEATS))


def signed(name: str) -> tuple[float, float, float, float]:
    """us (p50) of a message: decoded plain and signed, encoded plain and signed."""
    fmt = BY_NAME[name]
    values = fmt.unpack(bytes((7 * i + 1) % 251 for i in range(fmt.size)))
    theirs, plain = Encoder(1, 1, signing=Signing(KEY)), Encoder(1, 1)
    ours, none = Decoder(signing=Signing(KEY)), Decoder()
    frames = [theirs.encode(fmt, values) for _ in range(CALLS)]
    bare = [plain.encode(fmt, values) for _ in range(CALLS)]
    return (
        p50([lambda x=x: none.datagram(x) for x in bare]),  # type: ignore[misc]
        p50([lambda x=x: ours.datagram(x) for x in frames]),  # type: ignore[misc]
        p50([lambda: plain.encode(fmt, values)] * CALLS),
        p50([lambda: theirs.encode(fmt, values)] * CALLS),
    )


def main() -> None:
    """Print the tables; exit code 1 where signing costs too much."""
    print(f"{'message':28} {'decode':>7} {'pymavlink':>10} {'ratio':>6}   {'encode':>7} {'pymavlink':>10} {'ratio':>6}")
    for name in MESSAGES:
        fmt = BY_NAME[name]
        values = fmt.unpack(bytes((7 * i + 1) % 251 for i in range(fmt.size)))
        frame = Encoder(1, 1).encode(fmt, values)
        theirs = pymavlink.MAVLink(None, 1, 1)
        fields = {f: list(v) if isinstance(v := values[fmt.where[f]], tuple) else v for f in fmt.fields}
        decoder, encoder = Decoder(), Encoder(1, 1)
        a = best(lambda d=decoder, x=frame: d.datagram(x))  # type: ignore[misc]
        b = best(lambda m=theirs, x=frame: m.parse_buffer(x))  # type: ignore[misc]
        c = best(lambda e=encoder, f=fmt, v=values: e.encode(f, v))  # type: ignore[misc]
        d = best(lambda m=theirs, f=fields, i=fmt.id: pymavlink.mavlink_map[i](**f).pack(m))  # type: ignore[misc]
        print(f"{name:28} {a:7.2f} {b:10.2f} {b / a:6.1f}   {c:7.2f} {d:10.2f} {d / c:6.1f}")
    print(f"\n{'p50':28} {'decode':>7} {'signed':>10} {'adds':>6}   {'encode':>7} {'signed':>10} {'adds':>6}")
    worst = 0.0
    for name in MESSAGES:
        a, b, c, d = signed(name)
        worst = max(worst, b - a, d - c)
        print(f"{name:28} {a:7.2f} {b:10.2f} {b - a:6.2f}   {c:7.2f} {d:10.2f} {d - c:6.2f}")
    print(f"signing adds {worst:.2f} us at most (p50); limit {SIGNING_MAX:g} us")
    sys.exit(1 if worst > SIGNING_MAX else 0)


if __name__ == "__main__":
    main()
