"""Short kills and a short soak: the long ones are the families `fuzz_kills`, `fuzz_workers` and `soak --limit 1800`."""

import pytest

from benchmarks.cases.fuzz import kills, soak, workers


@pytest.mark.parametrize("kind", ["page", "deck", "tree"])
def test_a_killed_writer_leaves_a_whole_file_or_none(kind):
    assert kills.is_whole_or_absent(kind, 0)


def test_half_a_file_would_be_seen(monkeypatch):
    def half(path, rng):
        path.write_bytes(b"<html>")

    monkeypatch.setitem(kills.WRITERS, "page", half)
    assert not kills.is_whole_or_absent("page", 0)


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:no worker of the cluster is left")
def test_a_killed_worker_costs_no_answer(monkeypatch):
    line = workers.kill_workers(0, 1)
    assert (line["solves"], line["bad"], line["kills"] >= 1) == (1, 0, True)


def test_growth_compares_the_last_fifth_with_the_second():
    flat = [(float(at), 100.0 if at < 50 else 103.0) for at in range(0, 101, 5)]
    assert soak.growth(flat, 100.0) == pytest.approx(0.03)
    assert soak.growth(flat[:3], 100.0) is None
