"""Armed or not, which mode, and what to do when something is wrong.

commander       arming, modes, what is said of them: no I/O, no physics
failsafe        what to do when something is wrong: PX4's state machine
failsafe_checks what can go wrong, and what the parameters ask for then
failsafe_flags  what is wrong, as these decide by it
arming_checks   looks at battery, contacts, fence, sticks and tilt, and raises the flags
health_report   in which modes it could be armed and flown, and why not
offboard_check  whether offboard setpoints stay away
contacts        who has been heard lately
battery         how full it is
tilt_watch      whether the vehicle has tipped over
fence_watch     whether the vehicle is where it may be
landing         whether the vehicle is on the ground
external_modes  flight modes that others bring
home_position   when the vehicle knows where it is, and where its home is
events          what is said in numbers beside the texts
event_table     what the events mean, for ground stations
"""
