"""A time series reduced to readings by a stated rule.

* `windows`: mean, spread and rms of steps in given stretches of time, power in bands; a row is one series.
* `repeats`: means over parts of a cycle, peaks of a spectrum; a row is one repeat within a series.
* `decay`: frequencies and dampings of a free decay with their covariance, amid hum and a wandering zero.

`octmip.gap.gathered` makes a campaign of the rows.
"""
