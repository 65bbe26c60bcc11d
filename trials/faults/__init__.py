"""Flights in which something goes wrong, and what must be true of each of them.

case        a flight to be: where it begins, what happens to it and when, how it must end
traffic     what companion and vehicle told each other, as the companion heard and said it
flying      a case -> a flight, in lockstep
rules       what no flight may do, whatever happens
deck        the cases, by what goes wrong
table       the deck flown, as one table for docs/faults.md
chance      a case drawn from a seed, for the fuzz
"""
