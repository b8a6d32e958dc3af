"""A tree in the languages of other machines, each returning what `predict` returns: text, number or Boolean.

Every export takes `(tree, columns, class_names)`: how the columns of the user's table became features
(`TreeFile.columns`, an estimator's `columns_`), or the names of columns of numbers. An export reads the user's own
columns, not the features, or is refused in one sentence. A missing cell goes to the side that the split names, as in
the tree; where a split on its way names none, there is no answer (SQL: NULL; C and ONNX: NaN, or no text). An infinite
reading is a number, and a sum of a hyperplane that is none (infinity minus infinity) goes right. Thresholds go out with
all the bits of float64.

Names and texts may be any: none of them can act in the language of the export.
"""

from octmip.monitor.export.c import c_source
from octmip.monitor.export.legend import Legend
from octmip.monitor.export.onnx import onnx_model
from octmip.monitor.export.sql import sql_expression

__all__ = ["Legend", "c_source", "onnx_model", "sql_expression"]
