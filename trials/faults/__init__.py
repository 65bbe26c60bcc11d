"""Flights in which something goes wrong, and what must be true of each of them.

case         a flight to be: where it begins, what happens to it and when, how it must end
traffic      what companion and vehicle told each other, as the companion heard and said it
course       what a case asks for in the course of a flight, and the flight that comes of it
flying       a case -> a flight, in lockstep
real_time    a case -> a flight over UDP, in real time
rules        what no flight may do, whatever happens
deck         the cases, by what goes wrong
table        the deck flown, as one table for docs/faults.md
journal      what was flown already, in a file
random_cases a case drawn from a seed, for the fuzz
"""
