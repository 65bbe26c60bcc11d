"""World files.

world       the file as a whole -> a simulated world
keys        what it may say; event_keys: what may happen in it
"""
