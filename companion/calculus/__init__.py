"""Exact derivatives of what a mission writes as text, at the speed of straight-line Python.

    scalar       the arithmetic every number type below shares: sin(x), sqrt(x), ... for whatever x is
    taylor       truncated Taylor series in time, and numbers that carry their gradient in x, y, z
    straight     records arithmetic on symbols and prints it as one straight-line Python function
    machine_code the same function by LLVM, for processes that fly hundreds of times
    vectors      vectors of three of these numbers
    expression   the text of an expression -> a tree that evaluates on any of these numbers; executes no code

The law is written once, in the paper's notation, on these numbers. Evaluated on floats it is the textbook; evaluated
once on symbols it becomes a function of a few hundred float operations, which is what flies.
"""
