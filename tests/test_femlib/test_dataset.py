"""The recipe is reproducible, files come back as they went, bad tables get a sentence."""

from pathlib import Path

import numpy as np
import pytest

from femlib.dataset import (
    MeanStrains,
    build_dataset,
    published_strains,
    study_states_percent,
)
from femlib.dataset.gauge_draws import STUDY_GAUGES
from femlib.errors import InputError


def table_text() -> str:
    header = "mu1_percent,mu2_percent,load_factor,modulus_scale,kind," + ",".join(
        f"strain_{k:02d}" for k in range(1, 25)
    )
    rows = [
        f"{a},{b},{load},1.0,{kind}," + ",".join(str(float(load * (a + b) + k)) for k in range(24))
        for a, b in study_states_percent()[::-1]
        for load in (2, 3)
        for kind in ("mean", "sample")
    ]
    return "\n".join([header, *rows]) + "\n"


def test_the_recipe_gives_the_size_split_and_labels_of_the_study() -> None:
    states, usable = study_states_percent(), np.array([True, True, True, False])
    strains = 1000.0 + states @ np.array([[3.0, 1.0, 0.0, 9.0], [0.0, 0.5, 2.0, 9.0]])
    data = build_dataset(MeanStrains(states, strains, 3.0, ("g01", "g02", "g03", "g04"), usable, "made up", "abc"))
    assert data.features.shape == (2500, 3)
    assert data.gauges == ("g01", "g02", "g03")
    assert int(data.is_train.sum()) == 1750
    assert np.bincount(data.mu1).nonzero()[0].tolist() == [0, 20, 40, 60, 80]
    assert (np.bincount(data.states) == 100).all()
    assert (data.states_percent[data.states, 1] == data.mu2).all()


def test_the_20_gauges_of_the_study_are_drawn_together_as_in_the_published_figures() -> None:
    states = study_states_percent()
    usable = np.ones(20, dtype=bool)
    data = build_dataset(MeanStrains(states, np.zeros((25, 20)), 3.0, STUDY_GAUGES, usable, "none", ""), seed=3)
    rng = np.random.default_rng(3)
    assert np.array_equal(data.features, rng.normal(0.0, np.sqrt(1000.0), (2500, 20)) / 3.0)
    assert sorted(rng.permutation(2500)[:1750]) == np.flatnonzero(data.is_train).tolist()


def test_the_published_layout_is_read_in_any_row_order(tmp_path: Path) -> None:
    path = tmp_path / "strains.csv"
    path.write_text(table_text())
    means = published_strains(path)
    assert means.strain_microstrain[7] == pytest.approx(3.0 * (20 + 40) + np.arange(24))
    assert means.gauges[0] == "g01"
    assert int(means.is_usable.sum()) == 20


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda text: text.replace("strain_07", "strain_7"), r"lacks the columns \['strain_07'\]"),
        (
            lambda text: text.replace("\n80,80,3", "\n80,80,4"),
            r"has 24 mean rows at load factor 3; expected one for each",
        ),
        (lambda text: text.replace("3,1.0,mean,480.0,", "3,1.0,mean,,"), r"strain_microstrain\["),
        (lambda text: "", r"cannot be read"),
    ],
)
def test_a_bad_table_gets_a_sentence(tmp_path: Path, change, sentence: str) -> None:
    path = tmp_path / "strains.csv"
    path.write_text(change(table_text()))
    with pytest.raises(InputError, match=sentence):
        published_strains(path)
