"""Whole flights with everything going wrong at random, against the rules that hold whatever happens.

Each seed draws a flight: where it begins, who starts it, at which level, how bad the link is; what strikes in which
phases (operator's orders; cuts, repeats and delays of all or some messages; wrong states, strangers, weak motors); and
whether messages are mutated, their checksums right. The rules (trials/faults/rules.py): no exception; every setpoint
finite, within limits and made from a fresh state; no command that changes mode, arming or place once the operator's
mode was seen, nor more than 1 s after the vehicle last spoke of its mode; no setpoint once his mode was seen; over in
bounded time. A seed that breaks one is printed, with the simplest flight that still does.

    python -m bench.fuzz_flights [SECONDS] [FIRST_SEED] [JOBS]      600 s, from seed 0, as many jobs as there are cores
    python -m bench.fuzz_flights --seed SEED                        one flight again
"""

from __future__ import annotations

import os
import sys
import time

from trials.faults.fuzz import Result, flights, simplest, tried

PROGRESS = 20.0
"""s between two lines of progress."""


def main() -> None:
    """Fly, print what breaks a rule, and the sum of it; exit 1 where anything did."""
    if "--seed" in sys.argv:
        result = tried(int(sys.argv[sys.argv.index("--seed") + 1]))
        show(result)
        raise SystemExit(bool(result.broken))
    given = [float(argument) for argument in sys.argv[1:]]
    seconds, first, jobs = (*given, *(600.0, 0.0, float(os.cpu_count() or 1))[len(given) :])
    begun = said_at = time.monotonic()
    count = mutated = 0
    flown = 0.0
    bad: list[Result] = []
    for result in flights(int(first), seconds, int(jobs)):
        count, flown, mutated = count + 1, flown + result.flown, mutated + result.mutated
        if result.broken:
            bad.append(result)
            show(result)
        if time.monotonic() - said_at > PROGRESS:
            said_at = time.monotonic()
            print(
                f"{said_at - begun:5.0f} s: {count} flights, {flown:.0f} s flown, {len(bad)} broke a rule", flush=True
            )
    seeds = f"seeds {int(first)} to {int(first) + count - 1}"
    print(f"{seeds}: {flown:.0f} s flown, {mutated} messages mutated, {len(bad)} broke a rule")
    raise SystemExit(bool(bad))


def show(result: Result) -> None:
    """A flight that broke a rule, and the simplest that does."""
    if not result.broken:
        print(f"seed {result.seed}: {result.flown:.1f} s, no rule broken")
        return
    print(f"seed {result.seed}: {'; '.join(result.broken)}", flush=True)
    case, level = simplest(result.seed, result.broken[0])
    print(
        f"  the simplest: {level.value}, {case.begin.value}, {case.authority.value} starts, finish {case.finish.value}"
    )
    for strike in case.strikes:
        for event in strike.events:
            print(f"    in {strike.phase.value}: {event}")
    if case.link.down or case.link.up:
        print(f"    {case.link}")
    print(f"    mutated: {case.mutated:g}", flush=True)


if __name__ == "__main__":
    main()
