"""Studies: one mission flown many times, each time a little different; how often it does what is required.

reading    a study file -> a study, or every fault at once
variation  what may vary, and whether its ends may be flown
sampling   what varies -> the values of every flight, by its number
flying     one flight of a study -> one row of its results
engine     many flights on many workers, by dask
results    the rows: append-only, resumable, as CSV and Parquet
stored     the files of a study as JSON, and a study of them again
explaining rank correlations and Sobol indices of the error
telling    the pass rate with its bounds, what explains the errors, the worst flights
page       the same as one HTML file; figures in it
"""
