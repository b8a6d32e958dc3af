"""A Parquet file of float32 columns becomes a problem as it is, and the tree is that of its values as float64."""

import numpy as np
import pandas as pd

from octmip import Problem, solve
from octmip.interfaces.cli.arguments import Parser
from octmip.interfaces.cli.options import solve as options
from octmip.interfaces.cli.samples.table_problem import read_problem


def test_a_parquet_file_of_float32_columns_makes_no_float64_table(tmp_path):
    rng = np.random.default_rng(5)
    features = rng.normal(size=(60, 3)).astype(np.float32)
    labels = (features.sum(axis=1) > 0).astype(int)
    frame = pd.DataFrame(features, columns=["a", "b", "c"])
    path = tmp_path / "table.parquet"
    frame.assign(y=labels).to_parquet(path)
    parser = Parser("octmip solve", None)
    options.add_arguments(parser)
    problem = read_problem(parser.parse_args([str(path), "--label", "y", "--depth", "2"])).problem
    assert problem.samples.features.dtype == np.float32
    wide = Problem(features.astype(np.float64), labels, depth=2)
    assert solve(problem, "exact").objective == solve(wide, "exact").objective
