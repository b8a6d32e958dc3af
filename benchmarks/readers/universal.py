"""A plate in a universal file as gmsh writes it: a quadrilateral, two triangles, a line, a mass and three groups."""

PLACES = ((0, 0), (1, 0), (1, 1), (0, 1), (2, 0), (2, 1), (0.5, 0.5))
LINE, QUAD, SHELLS = (4, 1), (1, 2, 3, 4), ((2, 5, 6), (2, 6, 3))
GROUPS = {"corner": ((7, 1), (8, 1)), "edge": ((7, 4), (8, 2)), "skin": ((8, 3), (8, 4), (8, 5))}


def unv(is_quadratic: bool = False) -> str:
    """Return the file; quadratic elements have corners and middles in turn, every middle the last node."""
    kinds = (24, 95, 92, 92) if is_quadratic else (21, 94, 91, 91)
    nodes, elements, groups = [], [], []
    for k, place in enumerate(PLACES[: 7 if is_quadratic else 6]):
        nodes += [_whole(k + 1, 1, 1, 11), "".join(f"{x:25.16E}" for x in (*place, 0)).replace("E", "D")]
    for k, (corners, kind) in enumerate(zip((LINE, QUAD, *SHELLS), kinds, strict=True)):
        row = [n for own in corners for n in ((own, 7) if is_quadratic else (own,))][: 3 if kind == 24 else None]
        elements += [_whole(k + 2, kind, 1, 0, 7, len(row)), *[_whole(0, 0, 0)] * (k == 0), _whole(*row)]
    elements += [_whole(90, 161, 1, 0, 7, 1), _whole(6)]
    for k, (name, members) in enumerate(GROUPS.items()):
        groups += [_whole(k + 1, *[0] * 6, len(members)), name]
        groups += [_whole(*(n for what, of in pair for n in (what, of, 0, 0))) for pair in (members[:2], members[2:])]
    datasets = {2411: nodes, 2412: elements, 2467: [line for line in groups if line]}
    return "".join(f"    -1\n{n:6}\n" + "\n".join(lines) + "\n    -1\n" for n, lines in datasets.items())


def _whole(*numbers: int) -> str:
    return "".join(f"{n:10}" for n in numbers)
