"""What a stranger may try: each wrong input gets one sentence of what, where, got, expected, cure."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from femlib.assembly import line_load, natural_modes, point_masses
from femlib.components import Component, DamagedStructure
from femlib.dataset import (
    Load,
    Recipe,
    Sampling,
    grid_states,
    listed_states,
    open_dataset,
    random_states,
    simulated_strains,
    stream_dataset,
)
from femlib.errors import FemlibError, InputError
from femlib.geometry import Naca4, Planform, grid_lines
from femlib.material import isotropic_plate
from femlib.mesh import Mesh
from femlib.rom import ReductionSettings
from femlib.sensors import StrainGauge, strain_rows
from femlib.wing import (
    Wing,
    WingTwin,
    bend,
    buckle,
    inertial_load,
    reduce_wing,
    uav_wing,
)
from femlib.wing.damage import UAV_REGIONS, DamageRegion
from femlib.wing.export.calculix import read_gauges, write_deck
from femlib.wing.export.pictures import strain_picture
from femlib.wing.export.vtu import write_vtu
from femlib.wing.structure import WingMaterials

NAN = float("nan")
SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
ALONG = np.array([0.0, 1.0, 0.0])


def region(*edges: object, name: str = "R9", parameter: str = "mu9", surface: str = "top") -> DamageRegion:
    return DamageRegion(name, parameter, *edges, surface)


def with_materials(**change: object) -> Wing:
    return uav_wing(refinement=0.3, materials=WingMaterials(**change))


def gauge(position: object = (0.0, 0.9, 0.05), direction: object = ALONG, **more: object) -> StrainGauge:
    return StrainGauge("q", position, direction, **({"patches": ("top",)} | more))


def square(patch: int = 0, corner: float = 3) -> Mesh:
    corners = [[0, 1, 2, corner]]
    return Mesh(SQUARE, corners, np.zeros((0, 3)), ("p",), [patch])


# without a wing: what is tried, and how its sentence begins
ALONE: list[tuple[Callable[[], object], str]] = [
    (lambda: region(0.5, 1.2, 0.3, 0.5), "damage region R9 has eta 0.5 to 1.2 .*move it onto the wing"),
    (lambda: region(NAN, 0.9, 0.3, 0.5), "damage region R9 has eta nan"),
    (lambda: region(0.5, 0.6, 0.3, 0.5, surface="side"), "damage region R9 is on 'side'; expected one of"),
    (lambda: uav_wing(regions=(region(0.5, 0.6, 0.05, 0.1),)), "damage region R9 has an edge at x/c 0.05"),
    (lambda: uav_wing(regions=UAV_REGIONS[0]), "regions are DamageRegion.*expected a list"),
    (lambda: uav_wing(regions=(UAV_REGIONS[0],) * 2), r"damage regions share the name \['R1'\]"),
    (
        lambda: uav_wing(regions=(UAV_REGIONS[0], region(0.67, 0.83, 0.345, 0.43, parameter="mu1"))),
        r"damage regions share the parameter \['mu1'\]",
    ),
    (lambda: uav_wing(regions=(region(0.5, 0.6, 0.4, 0.5, name="web"),)), r"damage regions are called \['web'\]"),
    (lambda: WingMaterials(skin_step=0.0), "skin_step is 0.0; expected a factor above 0"),
    (lambda: WingMaterials(skin_rise=float("inf")), "skin_rise is inf; expected a finite number"),
    (lambda: uav_wing(refinement=0), "refinement is 0; expected a positive finite number"),
    (lambda: uav_wing(effective_mass=NAN), "effective_mass is nan; expected a positive finite number"),
    (lambda: uav_wing(materials="carbon"), "materials are 'carbon'; expected WingMaterials"),
    (
        lambda: with_materials(skin_thickness=-1e-3),
        "face_height is 0.0011 m; expected 0 to half the skin's thickness, -",
    ),
    (lambda: with_materials(skin_young=NAN), "young is nan; expected a positive number of Pa"),
    (lambda: with_materials(skin_taper=-0.5), "skin_taper is -0.5; expected"),
    (lambda: isotropic_plate(1e9, 0.3, -1e-3), "ply thickness is -0.001; expected a positive number"),
    (lambda: isotropic_plate(0.0, 0.3, 1e-3), "ply young_1 is 0.0; expected a positive"),
    (lambda: isotropic_plate(1e9, 0.5, 1e-3), "poisson is 0.5; expected more than -1 and less than 0.5"),
    (lambda: isotropic_plate(1e9, 0.3, 1e-3, -1.0), r"ply density is -1.0 kg/m\^3; expected 0 or more"),
    (lambda: isotropic_plate(1e9, 0.3, 1e-3, NAN), "ply density is nan; expected a finite number"),
    (lambda: ReductionSettings(tolerance=2.0), r"reduction settings are tolerance 2\.0"),
    (lambda: Planform(float("inf"), 1.0, 1.0, 0.3), "planform span is inf m; expected a positive length"),
    (lambda: Naca4(0.04, 0.0, 0.15), "section has camber 0.04 at 0.0 and thickness 0.15; expected"),
    (lambda: Naca4(0.04, 0.4, 0.15).heights([2.0]), "section heights were asked for outside the chord"),
    (lambda: grid_lines([0.0, NAN], 0.1), "grid_lines got 2 different stops.*expected at least 2 finite stops"),
    (lambda: square(corner=7), "element 0 names node 7; expected 0 to 3"),
    (lambda: square().elements_in("tail"), r"patch 'tail' is not in the mesh; expected one of \['p'\]"),
    (lambda: square(patch=3), "element 0 is of patch number 3; expected 0 to 0"),
    (lambda: square(corner=2.7), "mesh quads holds 2.7; expected whole numbers"),
    (lambda: Mesh(SQUARE, np.zeros((0, 4)), np.zeros((0, 3)), ("p",), []), "mesh has no element"),
    (lambda: gauge((NAN, 0, 0)), r"gauge q position\[0\] is nan; expected finite numbers"),
    (lambda: gauge(direction=np.zeros(3)), "gauge q direction is zero; expected a direction"),
    (lambda: gauge(side="top"), "gauge q side is 'top'; expected -1"),
    (lambda: gauge(side=1.5), r"gauge q side is 1.5; expected -1 \(bottom\) to 1 \(top\)"),
    (lambda: gauge(patches=()), r"gauge q patches are \(\); expected a list"),
    (lambda: grid_states({}), r"damage parameters are \[\]; expected one name or more"),
    (lambda: grid_states({"mu1": []}), "levels of mu1 are empty; expected at least one"),
    (lambda: grid_states({"mu1": [0, 20]}), "levels of mu1 hold 20; .*not in percent"),
    (
        lambda: random_states("mu1", 5, seed=0),
        "damage parameters are 'mu1'; expected one name or more, each once, in a",
    ),
    (lambda: random_states(["mu1"], 5, seed=0, n_damaged=3), "n_damaged is 3; expected 1 to 1"),
    (lambda: random_states(["mu1"], 5, seed=0, largest=80), "largest is 80; .*not in percent"),
    (lambda: listed_states(["mu1"], np.zeros((0, 1))), "the list of states is empty; expected at least one"),
    (lambda: listed_states(["a", "b"], [[0.1, 0.2], [0.1]]), "listed states is no array of numbers"),
    (lambda: grid_states({"a": [0]}) + grid_states({"b": [0]}), r"state libraries have the parameters \['a'\] and"),
    (lambda: grid_states({"a": [0]}).between(0, 2), "states 0 to 2 were asked for; expected a range within 0 to 1"),
    (lambda: Load("a", 1.0, np.array([NAN])), r"force of load 'a'\[0\] is nan"),
    (lambda: Sampling(loads=[3.0]), r"sampling loads is \[3.0\]; expected a list of Load"),
    (lambda: Sampling(loads=[Load("a", 0.0)]), "a load has the factor 0 and readings are divided by it"),
    (lambda: Sampling(seed=-1), "seed is -1; expected 0 or more"),
    (lambda: Recipe(noise_variance=-1.0), "noise_variance is -1.0; expected 0 or more"),
]

# with a wing and a folder
ON_THE_WING: list[tuple[Callable[[Wing, Path], object], str]] = [
    (lambda w, p: w.strain_microstrain({"mu1": 1.0}, 3.0), "state 0 has mu1 = 1; .*leaves a mechanism"),
    (lambda w, p: w.strain_microstrain({"mu1": 40}, 3.0), "state 0 has mu1 = 40; .*not in percent"),
    (lambda w, p: w.strains_microstrain(np.array([[NAN, 0.0]]), 3.0), r"states\[0, 0\] is nan; expected finite"),
    (lambda w, p: w.structure.solve(np.zeros((1, 2)), NAN * w.lift), r"load\[0\] is nan; expected finite numbers"),
    (lambda w, p: w.strain_microstrain({"mu3": 0.1}, 3.0), r"state names \['mu3'\]; expected some of"),
    (lambda w, p: w.strains_microstrain(np.zeros(2), 3.0), r"states has shape \(2,\); expected \('n', 2\)"),
    (lambda w, p: w.strain_microstrain({}, None), "load_factor is None; expected a finite number"),
    (lambda w, p: w.strain_microstrain({}, 3.0, NAN * w.lift), r"lift\[0\] is nan; expected finite numbers"),
    (lambda w, p: w.strain_map(3.0, w.lift[1:]), r"lift has shape .*; expected"),
    (lambda w, p: write_deck(w, p / "none" / "a.inp", {}, 3.0), "a.inp cannot be written .*expected a writable folder"),
    (lambda w, p: write_deck(w, p / "folder.inp", {}, 3.0), "folder.inp cannot be written .it is a folder"),
    (lambda w, p: write_deck(w, p / "a.inp", {"mu1": 1.0}, 3.0), "state 0 has mu1 = 1; expected"),
    (lambda w, p: write_deck(w, p / "a.txt", {}, 3.0), "ends in '.txt'; expected .inp"),
    (lambda w, p: write_vtu(w, p / "folder.vtu", {}, 3.0), "folder.vtu cannot be written .it is a folder"),
    (lambda w, p: write_vtu(w, p / "a.vtk", {}, 3.0), "ends in '.vtk'; expected .vtu"),
    (lambda w, p: read_gauges(w, p / "none.dat"), "none.dat cannot be read"),
    (lambda w, p: read_gauges(w, p / "binary.dat"), r"has 0 strains of element \d+, which gauge g01 reads"),
    (lambda w, p: rows_of(w, gauge((9.0, 9.0, 9.0))), r"gauge q at \[9.0, 9.0, 9.0\] m lies outside \['top'\]"),
    (lambda w, p: rows_of(w, gauge(patches=("R3",))), "patch 'R3' is not in the mesh; expected one of"),
    (lambda w, p: rows_of(w), "no gauges were given; expected at least one"),
    (
        lambda w, p: strain_rows(w.structure.shells.mesh, np.ones(7), [gauge()]),
        r"thickness has shape \(7,\); expected",
    ),
    (
        lambda w, p: damaged(w, Component("a", "b", np.ones(3, dtype=bool))),
        r"region a has elements of shape \(3,\); expected",
    ),
    (
        lambda w, p: damaged(w, *(Component(c.name, "b", c.elements) for c in w.structure.components)),
        r"components have the parameters \['b', 'b'\]; expected a different one for each",
    ),
    (
        lambda w, p: natural_modes(w.structure.shells, w.structure.supports, 0),
        "n_modes is 0; expected 1 to",
    ),
    (lambda w, p: simulated_strains(uav_wing(refinement=0.3, regions=())), r"model has the parameters \(\); expected"),
    (lambda w, p: reduce_wing(w, lift=0.0 * w.lift), "lift is zero in all of .* entries; expected forces"),
    (lambda w, p: bend(w, {"mu1": 1.0}, 3.0), "state 0 has mu1 = 1; expected"),
    (lambda w, p: bend(w, {}, 3.0, steps=0), "steps is 0; expected 1 or more load steps"),
    (lambda w, p: bend(w, {}, 3.0, warming=np.ones(3)), r"warming has shape \(3,\); expected one number or"),
    (lambda w, p: w.solve({}, NAN), "load_factor is nan; expected a finite number"),
    (lambda w, p: buckle(w, {}, 0), "n_modes is 0; expected 1 to"),
    (lambda w, p: inertial_load(w, {0.5: -0.1}), "payload of -0.1 kg at eta 0.5; expected 0 kg or more at 0 to 1"),
    (lambda w, p: inertial_load(w, [1.0]), r"payload is \[1.0\]; expected masses by span fraction"),
    (lambda w, p: strain_picture(w, np.ones(24), "t"), r"strains have shape \(24,\); expected"),
    (lambda w, p: line_load(w.structure.shells.mesh, [0, 10**9], np.ones(3)), "line load path names 2 nodes; expected"),
    (lambda w, p: point_masses(w.structure.shells.mesh, {1: "a"}), "point mass 'a' kg at node 1"),
    (lambda w, p: stream(w, p, Sampling(gauges=["g99"])), r"sampling names the gauges \['g99'\]; expected each once"),
    (lambda w, p: stream(w, p, Sampling(gauges=[])), "none of 24 gauges is left; expected at least one"),
    (lambda w, p: stream(WingTwin(w), p), "model is a WingTwin; expected one with gauges"),
    (
        lambda w, p: stream(w, p, states=grid_states({"mu7": [0]})),
        r"the library has the parameters \['mu7'\]; expected",
    ),
    (lambda w, p: stream(w, p, states=[[0.1]]), "library is a list; expected a StateLibrary"),
    (lambda w, p: stream(w, p, path=p), "dataset path .* ends in ''; expected .parquet"),
    (lambda w, p: stream(w, p, path=p / "folder.parquet"), "folder.parquet is a folder; expected a file"),
    (
        lambda w, p: stream(w, p, path=p / "none" / "a.parquet"),
        "a.parquet cannot be written .*expected a writable folder",
    ),
    (lambda w, p: stream(w, p, Sampling([Load("a", 1.0, np.ones(3))])), r"lift has shape \(3,\); expected"),
    (
        lambda w, p: stream(reduce_wing(w), p, Sampling([Load("a", 1.0, np.ones(3))], gauges=["g01"])),
        "a load has forces, which a ReducedWing does not take",
    ),
    (
        lambda w, p: stream(reduce_wing(w), p),
        "sampling names no gauges, and a ReducedWing does not know which of its 24",
    ),
    (lambda w, p: open_dataset(p / "none.parquet"), "none.parquet.json does not exist"),
    (lambda w, p: list(stream(w, p).pieces(0)), "n_rows is 0; expected 1 or more"),
    (lambda w, p: stream(w, p).read(["g99"]), r"has no columns \['g99'\]; expected some of"),
]


def rows_of(wing: Wing, *gauges: StrainGauge) -> object:
    mesh = wing.structure.shells.mesh
    return strain_rows(mesh, np.full(mesh.n_elements, 4e-3), gauges)


def damaged(wing: Wing, *components: Component) -> object:
    return DamagedStructure(wing.structure.shells, wing.structure.supports, components)


def stream(model, folder, sampling=None, states=None, path=None, **more):
    library = grid_states({"mu1": [0.0]}) if states is None else states
    return stream_dataset(folder / "a.parquet" if path is None else path, model, library, sampling, **more)


@pytest.mark.parametrize(("attempt", "sentence"), ALONE, ids=[sentence[:40] for _, sentence in ALONE])
def test_a_wrong_noun_gets_a_sentence(attempt: Callable[[], object], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence) as told:
        attempt()
    assert_one_sentence(told.value)


@pytest.mark.parametrize(("attempt", "sentence"), ON_THE_WING, ids=[sentence[:40] for _, sentence in ON_THE_WING])
def test_a_wrong_call_gets_a_sentence_and_leaves_no_file(
    tiny: Wing, tmp_path: Path, attempt: Callable[[Wing, Path], object], sentence: str
) -> None:
    (tmp_path / "folder.inp").mkdir()
    (tmp_path / "folder.parquet").mkdir()
    (tmp_path / "folder.vtu").mkdir()
    (tmp_path / "binary.dat").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match=sentence) as told:
        attempt(tiny, tmp_path)
    assert_one_sentence(told.value)
    assert not [path.name for path in tmp_path.iterdir() if path.name.startswith(".")]


def assert_one_sentence(error: FemlibError) -> None:
    """One line that says what was expected or what to do."""
    text = str(error)
    assert "\n" not in text
    assert "expected" in text or "; " in text
