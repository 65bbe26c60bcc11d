"""The flight as a state machine: what it is doing, what may happen to it, what it does then.

conduct    how a flight is to be conducted, as values: authority, finish, limits
phases     the phases and the events, and the table of what follows what
situation  what is looked at, as one value
guards     what is seen -> events, each with its reason in words; interruptions: of what cuts in
asking     how a vehicle is asked for something
waiting    what a phase waits for, in words
preflight  what must be there before the flight begins; geometry: whether the vehicle file is the vehicle's
link_needs what an output level needs of the link
bench      tilted by hand: does the command turn it back?
safety     what may not go on: conditions, times, actions
output     at which level setpoints go out, and why
epilogue   how it ended, in one sentence
"""
