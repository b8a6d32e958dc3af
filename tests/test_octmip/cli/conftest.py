"""A small table, a tree file of it, and the octmip command run in this process."""

import numpy as np
import pandas as pd
import pytest

from octmip.interfaces.cli import main


@pytest.fixture
def data(tmp_path):
    """Return a table with features a and b, label y and weight w; a splits y up to one sample."""
    rng = np.random.default_rng(0)
    a, b = np.arange(30.0), rng.random(30).round(3)
    frame = pd.DataFrame({"a": a, "b": b, "w": 1 + np.arange(30) % 3, "y": np.where(a < 12, "low", "high")})
    frame.loc[20, "y"] = "low"
    frame.to_csv(tmp_path / "data.csv", index=False)
    return tmp_path / "data.csv"


@pytest.fixture
def run(capsys):
    """Return a function that runs the command and returns exit code, standard output and standard error."""

    def call(*words):
        code = main([str(word) for word in words])
        out, err = capsys.readouterr()
        return code, out, err

    return call


@pytest.fixture
def refused(run):
    """Return a function that runs the command and returns the one line in which it refuses, all that it prints."""

    def call(*words):
        code, out, err = run(*words)
        assert (code, out, err.count("\n")) == (2, "", 1)
        return err

    return call


@pytest.fixture
def tree(data, run, tmp_path):
    """Return a tree file of the table."""
    path = tmp_path / "tree.json"
    assert (
        run("solve", data, "--label", "y", "--depth", 1, "--method", "cart", "--features", "a,b", "--out", path)[0] == 0
    )
    return path
