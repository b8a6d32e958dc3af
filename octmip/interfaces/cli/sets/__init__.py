"""Commands about all near-optimal trees, and about sensors.

amount        what "within" means on a command line
near_optimal  octmip near-optimal: the set itself
sensors       octmip sensors: what each sensor is worth
"""
