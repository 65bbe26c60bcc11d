"""The flight as a state machine: what it is doing, what may happen to it, what it does then.

phases    the phases and the events, and the table of what follows what
guards    what is seen -> events, each with its reason in words
"""
