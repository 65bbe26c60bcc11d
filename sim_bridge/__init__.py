"""A vehicle made of software: flown over MAVLink in the place of a PX4 quadrotor, for tests and for trying things out.

 datagrams ─► bridge ─► autopilot ─► motor commands ─► plant ─► truth ─► sensors ─► estimate ─► streams ─► datagrams

The machine
    rotors        command to thrust, thrust to torque, the motors' lag or the rotors' own motion
    battery       voltage and current, and what they leave of the thrust
    rigid_body    the derivative of the motion, summed rotor by rotor
    integrate     fixed-step Runge-Kutta
    environment   the ground, and hands that hold
    noise         processes with a memory
    gusts         Dryden's turbulence
    plant         all of it, one step at a time
    trim          what holds a vehicle that starts in the wind
    sensors       truth to the estimate the autopilot flies by
What happens
    event_schedule  a world's events by the clock
    world_events    what they do to machine, estimate (state_faults), messages and links
    operator        what he asks for at his ground station; strangers: others who speak
    link_model      what becomes of datagrams on their way
The stand-in PX4
    control/      rate, attitude and position loops, mixing
    autopilot/    arming, modes, offboard, landing; streams, commands, links
The whole
    bridge        datagrams and steps in, datagrams out; no socket, no clock; teller: what is said to everybody
    server        the bridge on UDP, in real time
    truth_file    the true state of every step, for a report
    __main__      the command sim-bridge

Of ``companion`` only frames, vehicle, world, geodesy and mavlink may be imported here, and never the law or the
allocation: plant and controller are two derivations, so that a sign error cannot cancel.
"""
