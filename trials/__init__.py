"""Flights and spoilt files made up for measuring: what tests and benchmarks both need."""
