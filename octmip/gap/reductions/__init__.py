"""A time series reduced to readings by a stated rule.

* `windows`: mean, spread and rms of steps in given stretches of time, power in bands; a row is one series.
* `repeats`: means over parts of a cycle; a row is one cycle.
* `decay`: frequencies and dampings of a free decay with their covariance, amid hum and a wandering zero.

`octmip.gap.gathered` makes a campaign of the rows.
"""
