"""Tables of samples from CSV, TSV and Parquet, and the tables of costs and sensors that belong to them."""

from octmip.formats.table.costs import read_costs
from octmip.formats.table.samples import Table, read_table
from octmip.formats.table.sensors import Sensors, read_sensors
from octmip.formats.table.source import Source

__all__ = ["Sensors", "Source", "Table", "read_costs", "read_sensors", "read_table"]
