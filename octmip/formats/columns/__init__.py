"""How the columns of any table, text and missing cells among them, become the numbers that a tree reads."""

from octmip.formats.columns.column import Feature
from octmip.formats.columns.columns import Columns, ColumnsError, FeatureNames

__all__ = ["Columns", "ColumnsError", "Feature", "FeatureNames"]
