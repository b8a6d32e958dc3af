"""Measurement files of LabVIEW, as their specification writes them: columns of times, segments, decimal commas."""

import numpy as np
import pytest

from octmip.errors import DataError
from octmip.recordings import recording

HEAD = "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\nX_Columns\t{}\n"
HEAD += "Date\t2026/11/29\nTime\t12:00:00\n***End_of_Header***\t\n\n"
SEGMENT = "Channels\t2\nSamples\t3\t3\nDate\t2026/11/29\t2026/11/29\nTime\t{}\t{}\nY_Unit_Label\tum/m\tN\n"
SEGMENT += "X0\t0.5\t0.5\nDelta_X\t0.1\t0.2\n***End_of_Header***\t\n"
ONE = "X_Value\tstrain\tforce\tComment\n0.5\t1\t10\tbegun\n0.6\t2\t20\n0.7\t3\t30\n"
MULTI = "X_Value\tstrain\tX_Value\tforce\tComment\n0.5\t1\t0.5\t10\n0.6\t2\t0.7\t20\n0.7\t3\t\t\n"
NONE = "X_Value\tstrain\tforce\tComment\n\t1\t10\n\t2\t20\n\t3\t30\n"
BARE = "strain\tforce\tComment\n1\t10\n2\t20\n3\t30\n"
AT = "12:00:0{}"


def written(path, kind, *bodies, at=(0, 2)):
    times = [SEGMENT.format(AT.format(second), AT.format(second)) for second in at]
    parts = [time + body + "\n" for time, body in zip(times, bodies, strict=False)]
    path.write_text(HEAD.format(kind) + "".join(parts))
    return path


@pytest.mark.parametrize(
    ("kind", "body", "strain", "force"),
    [
        ("One", ONE, [0.5, 0.6, 0.7], [0.5, 0.6, 0.7]),
        ("Multi", MULTI, [0.5, 0.6, 0.7], [0.5, 0.7]),
        ("No", NONE, [0.5, 0.6, 0.7], [0.5, 0.7, 0.9]),
        ("No", BARE, [0.5, 0.6, 0.7], [0.5, 0.7, 0.9]),
    ],
)
@pytest.mark.parametrize("change", ["as it is", "lines of Windows", "decimal commas"])
def test_every_channel_has_its_times_and_unit(kind, body, strain, force, change, tmp_path):
    path = written(tmp_path / "run.lvm", kind, body)
    if change == "decimal commas":
        path.write_text(path.read_text().replace(".", ","))
    if change == "lines of Windows":
        path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    opened = recording(path)
    assert opened.channels == ("strain", "force")
    assert opened["strain"].time == pytest.approx(strain)
    assert opened["force"].time == pytest.approx(force)
    assert opened["force"].values.tolist() == [10.0, 20.0, 30.0][: len(force)]
    assert (opened["strain"].unit, opened["force"].unit) == ("um/m", "N")


def test_segments_follow_one_another_by_their_clock_and_are_told(tmp_path):
    opened = recording(written(tmp_path / "run.lvm", "One", ONE, ONE))
    assert opened["force"].values.tolist() == [10.0, 20.0, 30.0] * 2
    assert opened["force"].time == pytest.approx([0.5, 0.6, 0.7, 2.5, 2.6, 2.7])
    assert "2 segments follow one another." in opened.notes
    with pytest.raises(DataError, match=r"time goes back from 0\.7 s to 0\.5 s behind sample 3"):
        recording(written(tmp_path / "run.lvm", "One", ONE, ONE, at=(0, 0)))["force"]


def test_names_that_come_twice_are_numbered_and_times_that_are_not_there_are_refused(tmp_path):
    opened = recording(written(tmp_path / "run.lvm", "One", ONE.replace("force", "strain")))
    assert opened.channels == ("strain#1", "strain#2")
    path = written(tmp_path / "run.lvm", "No", NONE)
    path.write_text(path.read_text().replace("Delta_X", "Delta"))
    with pytest.raises(DataError, match="channel 'strain' has no times; expected X_Columns One or Delta_X"):
        recording(path)
    assert np.isfinite(opened["strain#2"].values).all()
