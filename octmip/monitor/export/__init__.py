"""A tree in the languages of other machines, each returning bit for bit the result of the tree here.

Every export takes `(tree, feature_names, class_names)` and returns the index of the class. A missing reading (NaN,
NULL) goes to the side that the split names, as in the tree; where a split on its way names none, the result is -1.
An infinite reading is a number, and a sum of a hyperplane that is none (infinity minus infinity) goes right.
Thresholds go out with all the bits of float64.

Names may be any text: none of them can act in the language of the export. C and SQL hold no name of a class, C none of
a feature either; `names_json` says what places and codes stand for. A tree over columns that were encoded (text)
takes the encoded features: give `names_json` the `columns` of its tree file, and it says what each is.
"""

from octmip.monitor.export.c import c_source
from octmip.monitor.export.fit import names_json
from octmip.monitor.export.onnx import onnx_model
from octmip.monitor.export.sql import sql_expression

__all__ = ["c_source", "names_json", "onnx_model", "sql_expression"]
