"""The same flights from Python as from the commands, and what both of them share.

public       what ``import companion`` offers: light to import; calls: what each function does once it is called
output       the output levels that may be asked for
files        mission, vehicle and world files as values: read, made or changed in Python
making       the makers of such files: a mission from a path, a speed and a heading
formulas     a Python function -> the expression that a mission file would hold
faults       what is wrong with several inputs, said all at once
orders       what is asked for -> what is to be flown, or every fault at once
checking     a mission and a vehicle -> the report of ``check``
simulation   a mission against the plant in one process
lockstep     plant and daemon exchange their datagrams under a simulated clock
outcome      how a flight ended, and its summary
flights      a flight that was flown, as arrays and figures
signals      the errors xi and the inputs u of a flight over time
comparing    two flights side by side
laws         the paper's law as a function of the state
"""
