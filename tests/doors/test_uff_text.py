"""Numbers of UFF58 that are read all at once are those that pyuff reads one by one."""

import itertools

import numpy as np
import pytest
import pyuff

from octmip.recordings import recording

AXES = "".join(f"{kind:10d}    0    0    0 NONE                 NONE                \n" for kind in (17, 3, 0, 0))


def text_of(kind, even, n, rng):
    """Return a set by the format: 6E13.5, 2(E13.5,E20.12) or 4E20.12."""
    values = rng.normal(size=n) * 10.0 ** rng.integers(-5, 6, n)
    wide, many = ("%13.5e", 6) if kind == 2 else ("%20.12e", 4)
    cells = [[] if even else ["%13.5e" % (0.1 * k)] for k in range(n)]
    cells = [*itertools.chain(*([*time, wide % one] for time, one in zip(cells, values, strict=True)))]
    head = "    -1\n    58\na\n" + "NONE\n" * 4
    head += "    1         0    0         0       NONE         1   1       NONE         0   0\n"
    head += f"{kind:10d}{n:10d}{even:10d}  0.00000e+00  1.00000e-01  0.00000e+00\n{AXES}"
    return head, ["".join(cells[k : k + many]) for k in range(0, len(cells), many)]


CHANGES = {
    "as it should be": lambda lines: "\n".join(lines) + "\n",
    "lines of Windows": lambda lines: "\r\n".join(lines) + "\r\n",
    "three digits of an exponent": lambda lines: "\n".join(lines).replace("e+00", "+100", 1) + "\n",
    "an empty line": lambda lines: "\n".join([*lines[:1], "", *lines[1:]]) + "\n",
    "a longer line": lambda lines: "\n".join([lines[0] + "   ", *lines[1:]]) + "\n",
    "a letter": lambda lines: "\n".join([*lines[:-1], lines[-1][:-4] + "x" + lines[-1][-3:]]) + "\n",
}


@pytest.mark.parametrize("n", [1, 6, 25])
@pytest.mark.parametrize("even", [0, 1])
@pytest.mark.parametrize("kind", [2, 4])
@pytest.mark.parametrize("change", CHANGES)
def test_numbers_are_those_of_pyuff(change, kind, even, n, tmp_path):
    head, lines = text_of(kind, even, n, np.random.default_rng(n))
    path = tmp_path / "run.uff"
    path.write_bytes((head + CHANGES[change](lines) + "    -1\n").encode())
    try:
        whole = pyuff.UFF(str(path)).read_sets(0)
    except Exception:
        with pytest.raises(Exception, match="cannot be read as UFF58"):
            recording(path)["a"]
        return
    found = recording(path)["a"]
    np.testing.assert_array_equal(found.values, whole["data"])
    assert found.time == pytest.approx(whole["x"], abs=1e-12)
