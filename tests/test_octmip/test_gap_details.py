"""Details of the diagnosis, each beside its definition: loads, units, campaigns, channels, noise."""

from dataclasses import dataclass, replace
from itertools import combinations, product
from math import comb, log
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import multivariate_normal

from octmip.errors import DataError, TwinError
from octmip.gap import Campaign, diagnose, function_twin, read_campaign
from octmip.gap.campaign.campaign import ENOUGH_FOR_HALVES
from octmip.gap.campaign.metered import MOST_LOADS, gathered_alike, looked_at
from octmip.gap.campaign.noise_estimate import _moderated
from octmip.gap.campaign.noise_parts import _has_trend, _part_along, _shared, _with_outstanding, greatest
from octmip.gap.campaign.spectrum import SHARED, SINGLE, WHITE, coefficients, fit
from octmip.gap.channels.jumps import jumps_in
from octmip.gap.doors.budget import OF_LOAD, OF_RANGE, _steps
from octmip.gap.effects.chain import CROSSTALK, DEAD_GAUGE, MISALIGNMENT, POSITION_OFFSET, SWAPPED_PAIR, Moment
from octmip.gap.effects.loads import errors_of_load
from octmip.gap.inference.candidates import SCALES
from octmip.gap.inference.inputs import OF_MODELS, prepare
from octmip.gap.inference.linear_model import linearise
from octmip.gap.inference.posterior import attribute
from octmip.gap.inference.unknown import SIZES, SMOOTH
from octmip.gap.next_test import next_tests
from octmip.gap.preparation import _histories, _typical
from octmip.twin import Loads
from tests.test_octmip.beam_twin import Beam, measured, own_effects
from tests.test_octmip.test_gap_built import at_forces
from tests.test_octmip.test_gap_campaign import lines_of, with_cell, write


@dataclass(frozen=True)
class Bent:
    """Two gauges that grow with the square of a force, up to a load."""

    most: float = np.inf
    gauges: tuple = ("a", "b")
    parameters: tuple = ()

    def predict(self, state, load):
        force, other = tuple(load.values()) if isinstance(load, Loads) else (load, 1.0)
        if force > self.most:
            raise TwinError("too much")
        return np.array([1.0, 3.0]) * force**2 * other


@pytest.mark.parametrize("load", [2.0, Loads(("force", "other"), (2.0, 5.0))])
@pytest.mark.parametrize("kind", [0, 1])
def test_a_load_that_was_another_changes_what_the_twin_says_of_it(load, kind):
    """Per cent of a factor, units of an offset; exactly, and linearly where the twin knows no greater load."""
    error, size = errors_of_load("force", 3.0, 0.0)[kind], 0.5
    there = 2.0 + size if kind else 2.0 * (1.0 + size / 100.0)
    here, slope = Bent().predict({}, load), 2.0 / 2.0 * (1.0 if kind else 2.0 / 100.0)
    exact = error.predict(Bent(), {}, load, size, "", 0.0)
    assert exact == pytest.approx(here * there**2 / 4.0, rel=1e-12)
    assert error.change(Moment(Bent(), {}, load, load_name="force"))[0] == pytest.approx(slope * here, rel=0.01)
    linear = error.predict(Bent(most=2.0), {}, load, size, "", 0.0)
    assert linear == pytest.approx(here * (1.0 + slope * size), rel=0.01)


def test_readings_are_in_the_units_of_the_twin():
    twin = Beam()
    twin.units = {name: "mm" if name == "g03" else "microstrain" for name in twin.gauges}
    found = prepare(measured(1), twin, twin.effects)[0].campaign
    assert [found.unit_of(name) for name in ("g02", "g03")] == ["microstrain", "mm"]


@pytest.mark.parametrize(("n_jumps", "named"), [(1, 1), (2, 2), (3, 0)])
def test_a_gauge_that_jumps_in_more_than_a_fifth_of_its_cells_is_slow_noise(n_jumps, named):
    campaign = measured(5, loads=tuple(np.linspace(0.5, 3.0, 10)))
    readings = np.array(campaign.readings)
    for k in range(n_jumps):
        readings[100 * k + 25 : 100 * k + 50, 8] += 20.0 * 31.6
    found = jumps_in(replace(campaign, readings=readings))
    assert [(fault.gauge, fault.first) for fault in found] == [("g09", 100 * k + 25) for k in range(named)]


def test_variances_of_few_repeats_are_drawn_toward_that_of_all():
    """Of gauges whose true variances are drawn: no bias, and a third of the error of each gauge's own."""
    rng = np.random.default_rng(3)
    true = 9.0 * 12.0 / rng.chisquare(12.0, 4000)
    degrees = np.full(4000, 5.0)
    own = true * rng.chisquare(degrees) / degrees
    found = _moderated(own, degrees)
    assert found.mean() == pytest.approx(true.mean(), rel=0.02)
    assert np.mean((found - true) ** 2) < 0.4 * np.mean((own - true) ** 2)


@pytest.mark.parametrize(("row", "cure"), [(1, "begin the row with #"), (2, "clear the cell")])
def test_a_text_among_readings_is_refused_with_what_its_row_may_be(tmp_path, row, cure):
    rows = with_cell(lines_of(measured(1)), row, "g03", "gauge")
    with pytest.raises(DataError, match=rf"row {row + 1}, column g03 is 'gauge'; .*{cure}"):
        read_campaign(write(tmp_path, rows), Beam())


@pytest.mark.parametrize(("unit", "seconds"), [("ms", 1e-3), ("min", 60.0), ("", 1.0)])
def test_a_time_is_in_the_unit_of_its_column(tmp_path, unit, seconds):
    campaign = measured(1, repeats=5)
    head, *rows = lines_of(campaign)
    named = head.replace(",time,", f",time [{unit}]," if unit else ",time,")
    found = read_campaign(write(tmp_path, [named, *rows]), Beam())
    assert found.time == pytest.approx(seconds * campaign.time)
    assert any(f"Column time was converted from {unit} to s." in note for note in found.notes) == (unit != "")


@pytest.mark.parametrize("unit", ["microstrain", "mm"])
def test_only_strains_of_load_factors_are_refused_with_words_on_lift(tmp_path, unit):
    twin, campaign = Beam(), measured(1)
    twin.units = dict.fromkeys(twin.gauges, unit)
    with pytest.raises(DataError, match="opposite sign of the twin's") as caught:
        read_campaign(write(tmp_path, lines_of(replace(campaign, readings=-campaign.readings))), twin)
    assert ("positive load factors for lift" in str(caught.value)) == (unit == "microstrain")
    assert "or of the column load_factor" in str(caught.value)


@pytest.mark.parametrize("seed", range(4))
def test_cells_halves_and_what_is_left_are_as_defined(seed):
    rng, n = np.random.default_rng(seed), 200
    tests, loads, states = rng.choice(["a", "b"], n), rng.choice([1.0, 2.0], n), rng.choice([0.0, 0.3, np.nan], (n, 1))
    readings = np.where(rng.random((n, 3)) < 0.3, np.nan, rng.normal(50.0, 3.0, (n, 3)))
    time = 7.0 + 2.0 * rng.permutation(n) if seed % 2 else np.full(n, np.nan)
    moments = (time - 5.0) / 2.0 if seed % 2 else np.arange(1.0, n + 1.0)
    own = {"states": states, "readings": readings, "time": time, "temperature": rng.random(n)}
    numbers = tuple(range(5, n + 5))
    campaign = Campaign(("g", "h", "i"), ("mu",), tuple(tests), loads, numbers=numbers, **own)
    keys = [(test, load, str(state)) for test, load, state in zip(tests, loads, states[:, 0], strict=True)]
    rows_of = [np.flatnonzero([key == one for key in keys]) for one in dict.fromkeys(keys)]
    expected = []
    for number, rows in enumerate(rows_of):
        rows = rows[np.argsort(time[rows], kind="stable")]
        halved = seed % 2 and len(rows) >= ENOUGH_FOR_HALVES
        expected += [
            (number, part) for part in ((rows[: len(rows) // 2], rows[len(rows) // 2 :]) if halved else (rows,))
        ]
    for found, wanted in ((campaign.cells, enumerate(rows_of)), (campaign.averages(True), expected)):
        for cell, (number, rows) in zip(found, wanted, strict=True):
            assert (cell.number, sorted(cell.rows)) == (number, sorted(rows))
            assert (cell.test, cell.load, cell.is_known) == (
                tests[rows[0]],
                loads[rows[0]],
                bool(np.isfinite(cell.state)),
            )
            assert cell.count.tolist() == np.isfinite(readings[rows]).sum(axis=0).tolist()
            assert cell.mean == pytest.approx(np.nanmean(readings[rows], axis=0))
            assert cell.time == (pytest.approx(time[rows].mean() - 7.0) if seed % 2 else 0.0)
            assert cell.moments == pytest.approx(moments[cell.rows])
            assert np.array_equal(cell.of_gauges([2, 0]).mean, cell.mean[[2, 0]])
    assert campaign.spreads() == pytest.approx(
        np.array([np.nanstd(readings[rows], axis=0, ddof=1) for rows in rows_of])
    )
    left = campaign.without({1, 2})
    kept = np.array([k for k in range(n) if k not in {*rows_of[1], *rows_of[2]}])
    assert left.numbers == tuple(kept + 5)
    for name, values in own.items():
        assert np.array_equal(getattr(left, name), values[kept], equal_nan=True)


def test_a_gauge_without_a_reading_has_no_mean_and_a_candidate_bears_its_place():
    campaign = measured(1, repeats=3)
    readings = campaign.readings.copy()
    readings[:3, 4] = np.nan
    means = [cell.mean for cell in replace(campaign, readings=readings).cells]
    assert np.argwhere(np.isnan(means)).tolist() == [[0, 4]]
    found = prepare(campaign, Beam(), {"dead": DEAD_GAUGE, **own_effects()}, noise_sd=3.0)[0].candidates
    names = [(one.name, one.place) for one in found]
    assert names[:2] == [("dead_gauge", "g01"), ("dead_gauge", "g02")]
    assert names[20] == ("modulus", "")


def test_the_typical_reading_of_a_unit_is_a_root_mean_square():
    campaign = measured(1, repeats=4)
    own = {name: np.where(k < 5, 2.0, 1.0) for k, name in enumerate(campaign.gauges)}
    twin = Beam()
    twin.units = {name: "mm" if value == 2.0 else "microstrain" for name, value in own.items()}
    found = _typical(campaign, twin)
    assert found["mm"] == pytest.approx(np.sqrt(np.mean(campaign.readings[:, :5] ** 2)))
    assert found["microstrain"] == pytest.approx(np.sqrt(np.mean(campaign.readings[:, 5:] ** 2)))


def test_the_shorter_of_two_series_says_how_many_loads_they_are_gathered_around():
    """Twelve rows for each, twenty at most."""
    rng = np.random.default_rng(0)
    long, short = (at_forces(np.ones((n, 4)), rng.uniform(1.0, 9.0, n)) for n in (600, 120))
    for both, n_loads in (((long, short), 10), ((short, long), 10), ((long, long), 20)):
        moved, notes = gathered_alike(both)
        assert len({load for campaign in moved for load in campaign.load_factor.tolist()}) == n_loads
        assert f"gathered around {n_loads} loads" in notes[0]


def test_a_course_of_the_temperature_goes_with_the_time_whatever_the_order_of_the_rows():
    campaign = measured(1, repeats=5, loads=(0.0, 2.0, 1.0))
    warm = replace(campaign, temperature=290.0 + campaign.time / 10.0)
    order = np.random.default_rng(0).permutation(len(campaign.test))
    rows = {name: getattr(warm, name)[order] for name in ("load_factor", "states", "readings", "time", "temperature")}
    mixed = replace(warm, test=tuple(warm.test[k] for k in order), **rows)
    later = warm.time - warm.time[0]
    courses = [_histories(one) for one in (warm, mixed)]
    for course in courses:
        assert np.array(course["warming"]) == pytest.approx(np.column_stack([later, later / 100.0]))
        assert course["direction"] == ((0.0, 0.0), (30.0, 1.0), (60.0, -1.0))


@pytest.mark.parametrize(("n_few", "left_out"), [(7, 7), (8, 0)])
def test_rows_around_a_load_that_are_too_few_for_a_line_are_left_out(n_few, left_out):
    """Four rows a coefficient; the loads of a campaign beside it are the centres."""
    rng = np.random.default_rng(0)
    forces = np.concatenate([rng.uniform(18.0, 22.0, 100), rng.uniform(58.0, 62.0, n_few)])
    series, steady = (at_forces(np.outer(own, np.ones(4)), own) for own in (forces, [20.0, 60.0] * 50))
    assert set(series.test) == {"test"}
    (moved, same), notes = gathered_alike([series, steady])
    assert len(moved.test) == 100 + n_few - left_out
    assert (f"{left_out} rows with too few like them are left out" in notes[0]) == (left_out > 0)
    assert np.array_equal(same.readings, steady.readings)
    assert np.unique(moved.load_factor).tolist() == ([20.0] if left_out else [20.0, 60.0])


def test_a_model_is_looked_at_by_a_few_of_many_loads_and_each_row_beside_the_nearest():
    forces = np.random.default_rng(0).permutation(np.linspace(1.0, 9.0, 200) ** 2)
    found = looked_at(at_forces(np.outer(forces, np.ones(4)), forces))
    loads = np.array([float(load) if isinstance(load, float) else load["force"] for load, _ in found])
    assert len(loads) == MOST_LOADS
    assert (loads.min(), loads.max()) == (1.0, 81.0)
    for load, (_, rows) in zip(loads, found, strict=True):
        apart = np.abs(forces[rows][:, None] - loads)
        assert (apart.min(axis=1) == np.abs(forces[rows] - load)).all()
    assert sorted(np.concatenate([rows for _, rows in found])) == list(range(200))


@pytest.mark.parametrize(("nominal", "sign"), [(5.0, 1.0), (14.0, -1.0)])
def test_the_step_of_a_parameter_stays_within_its_range(nominal, sign):
    twin = function_twin(lambda p, loads: [p["k"]], {"u": "mm"}, {"k": (nominal, 5.0, 14.0, "N")}, loads=("force",))
    steps = _steps(twin, np.array([[nominal, 30.0], [nominal, -60.0]]))
    assert steps == {0: pytest.approx(sign * OF_RANGE * 9.0), 1: pytest.approx(OF_LOAD * 60.0)}


def test_faults_of_the_measuring_chain_change_readings_by_their_formulas():
    """Readings grow by 100 microstrain a metre of span and load, of the last gauge in another unit."""
    x, y = np.tile([0.1, 0.2, 0.35], 2), np.array([0.5, 0.8, 1.0, 1.3, 1.7, 2.0])
    twin = SimpleNamespace(gauges=tuple("abcdef"), parameters=(), gauge_positions=np.column_stack([x, y]))
    twin.units = {name: "mm" if name == "f" else "microstrain" for name in twin.gauges}
    twin.predict = lambda state, load: load * (40.0 + 100.0 * y + 7.0 * x) * np.where(y == 2.0, 1e3, 1.0)
    r = twin.predict({}, 2.0)
    expected = {
        MISALIGNMENT: ("b", {1: -0.013 * r[1]}),
        POSITION_OFFSET: ("c", {2: 0.2}),  # a millimetre outboard
        DEAD_GAUGE: ("d", {3: -r[3]}),
        CROSSTALK: ("b<a", {1: 0.01 * r[0]}),
        SWAPPED_PAIR: ("a/e", {0: r[4] - r[0], 4: r[0] - r[4]}),
    }
    for effect, (place, changes) in expected.items():
        wanted = np.array([changes.get(k, 0.0) for k in range(6)])
        assert effect.signature(twin, {}, 2.0, place) == pytest.approx(wanted)
        assert effect.at_places(twin, {}, 2.0, (place,), 0.0) == pytest.approx(wanted[None])
        assert place in effect.places(twin)
        assert [twin.gauges.index(name) for name in effect.gauges_of(twin, place)][: len(changes)] == list(changes)
    assert "f" in DEAD_GAUGE.places(twin)
    assert not [place for one in expected if one is not DEAD_GAUGE for place in one.places(twin) if "f" in place]


def test_directions_that_gauges_share_stand_out_of_white_noise_and_no_others():
    rng = np.random.default_rng(1)
    for n_shared in (0, 1, 2):
        white, way = rng.standard_normal((300, 6)), np.linalg.qr(rng.standard_normal((6, 2)))[0][:, :n_shared]
        found = _with_outstanding(np.zeros((6, 0)), white + 3.0 * rng.standard_normal((300, n_shared)) @ way.T, 300.0)
        assert found.shape == (6, n_shared)
        assert np.linalg.norm(way.T @ found) ** 2 == pytest.approx(n_shared, rel=0.05)
        assert _with_outstanding(found, white, 300.0).shape == (6, n_shared)
    assert _with_outstanding(np.zeros((6, 0)), 9.0 * np.ones((3, 6)), 3.0).shape == (6, 0)
    most = [np.linalg.norm(rng.standard_normal((50, 8)), 2) ** 2 / 50.0 for _ in range(300)]
    assert 0.55 * greatest(50.0, 8) < np.median(most) < max(most) < greatest(50.0, 8)


def test_a_pattern_that_stands_out_over_long_periods_alone_is_shared():
    rng, way = np.random.default_rng(4), np.full(6, 6**-0.5)
    slow = np.cos(3 * np.pi * (np.arange(80) + 0.5) / 80)
    for size, n_shared in ((0.0, 0), (1.2, 1)):
        blocks = [rng.standard_normal((80, 6)) + size * np.outer(slow, way) for _ in range(3)]
        assert _with_outstanding(np.zeros((6, 0)), np.concatenate(blocks), 240.0).shape == (6, 0)
        assert _shared(blocks, WHITE, 1.0, np.zeros((6, 0))).shape == (6, n_shared)


def test_trends_of_one_pattern_over_the_gauges_are_no_noise():
    rng = np.random.default_rng(2)
    own, pattern = rng.standard_normal((9, 6)), 5.0 * np.arange(1.0, 7.0)
    by_chance = [np.stack([row, row]) for row in own]
    alike = [np.stack([row + rng.standard_normal() * pattern, row]) for row in own]
    assert (_has_trend(by_chance), _has_trend(alike), _has_trend(by_chance[:2])) == (True, False, False)


@pytest.mark.parametrize("n", [1, 3])
def test_every_hypothesis_weighs_what_its_definition_says(n):
    """Prior times density, the sizes and the difference at each of their scales; the unknown is any of its fields."""
    names = ["lift_distribution", "temperature_gradient", "large_deflection"][:n]
    twin = Beam(effects={name: own_effects()[name] for name in names})
    lift, odd = twin.effects["lift_distribution"], 8.0 * np.cos(np.arange(20))
    campaign = measured(2, lambda state, load, time: 1.5 * lift.signature(twin, state, load) + odd, mesh=0.02)
    inputs = prepare(campaign, twin, twin.effects)[0]
    inputs = replace(inputs, noises=inputs.noises[:1])  # no walk
    weights = {}
    for level, share in OF_MODELS.items():
        model = linearise(inputs, np.zeros((4, 2)), level)
        gauge, x = model.gauge, np.array(model.loads) / 3.0
        scale, same = inputs.frame.scale[gauge], gauge[:, None] == gauge
        smooth = inputs.frame.along(SMOOTH)[np.ix_(gauge, gauge)] + 1e-6 * same
        courses = [np.ones_like(x), np.sign(x), np.sqrt(x), x, x**2]
        fields = [np.outer(course, course) * field for field in (same, smooth) for course in courses]
        fields.append(same * (np.exp(-2.0 * (x[:, None] - x) ** 2) + 1e-6 * (x[:, None] == x)))
        every = [size**2 * np.outer(scale, scale) * field for field in fields for size in SIZES]

        def evidence(members, added=0.0, model=model):
            columns = model.signatures[:, members] * inputs.priors.sd[members]
            parts = [columns * scales for scales in product(SCALES, repeat=len(members))]
            spreads = [model.covariance + added + part @ part.T for part in parts]
            logs = [multivariate_normal.logpdf(model.residual, cov=spread) for spread in spreads]
            return logsumexp(logs) - log(len(logs))

        alone = [evidence([], field) for field in every]
        likely, kinds = every[int(np.argmax(alone))], log(len(every))
        prior = inputs.noises[0].log_share + log(share)
        weights[level, (), True] = prior + log(inputs.odds.unknown[0]) + logsumexp(alone) - kinds
        for k in range(min(n, 2) + 1):
            for members in combinations(range(n), k):
                own = prior - log(comb(n, k))
                weights[level, members, False] = own + log(inputs.odds.count[k]) + evidence(list(members))
                if k:
                    beside = log(inputs.odds.unknown[k]) + evidence(list(members), likely) - kinds
                    weights[level, members, True] = own + beside
    found, total = attribute(inputs), logsumexp(list(weights.values()))
    assert found.log_total == pytest.approx(total, abs=1e-6)
    for judged in found.judged:
        logs = [weights[level, judged.members, judged.has_unknown] for level in OF_MODELS]
        assert judged.probability == pytest.approx(np.exp(logs - total).sum(), rel=1e-6)
    assert len(found.judged) == len(weights) / 2


def test_the_next_test_separates_the_causes_of_the_library_whatever_the_unknown_weighs():
    found = diagnose(measured(5, lambda state, load, time: -0.03 * Beam().predict(state, load)), Beam()).posterior
    of_library = [judged for judged in found.judged if not judged.has_unknown][1:4]
    shares = list(zip(of_library, (0.5, 0.3, 0.2), strict=True))
    alone, beside = ([judged.times(0.0, part * share) for judged, share in shares] for part in (1.0, 0.06))
    unknown = next(judged for judged in found.judged if judged.has_unknown).times(0.0, 0.94)
    tests = next_tests(found.model, alone, None)
    assert tests
    assert next_tests(found.model, [unknown, *beside], None) == tests


@pytest.mark.parametrize(("is_single", "prior"), [(True, SINGLE), (False, SHARED)])
def test_what_gauges_share_has_odds_of_its_own_to_wander(is_single, prior):
    rng, direction = np.random.default_rng(3), np.full(3, 3**-0.5)
    blocks = [rng.normal(size=(12, 3)) + 0.4 * rng.normal(size=(12, 1)).cumsum(axis=0) for _ in range(3)]
    wanted = fit([coefficients(block @ direction[:, None]) for block in blocks], prior, has_trend=not is_single)
    found = _part_along(blocks, direction, is_single).serial
    assert (found.walk_probability, found.variance) == (wanted.walk_probability, wanted.variance)
