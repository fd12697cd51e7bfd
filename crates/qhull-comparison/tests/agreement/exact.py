#!/usr/bin/env python3
"""Margin and volume of the hull of a kept wrench set, in whole numbers: who is right when engine and
Qhull differ.

    python3 crates/qhull-comparison/tests/agreement/exact.py target/tmp/disagreements/WRONG-1.txt

Every number of the set is a fraction with a power of two below, so that each axis times some power of two is
whole and every sign below is exact. The hull is a placing triangulation: each wrench is joined to the facets
that it lies strictly beyond. Least offsets of facets that are only there by rounding count too.
"""

import sys
from fractions import Fraction
from itertools import combinations
from math import factorial, sqrt


def determinant(rows):
    """Bareiss: every division comes out even."""
    m, sign, last = [list(row) for row in rows], 1, 1
    for k in range(len(m) - 1):
        pivot = next((i for i in range(k, len(m)) if m[i][k]), None)
        if pivot is None:
            return 0
        if pivot != k:
            m[k], m[pivot], sign = m[pivot], m[k], -sign
        for i in range(k + 1, len(m)):
            for j in range(k + 1, len(m)):
                m[i][j] = (m[i][j] * m[k][k] - m[i][k] * m[k][j]) // last
        last = m[k][k]
    return sign * m[-1][-1]


def plane(corners, inner):
    """The plane a·x = b through six points, with a·inner < 7 b for the sum of seven points inside."""
    edges = [[x - y for x, y in zip(p, corners[0])] for p in corners[1:]]
    normal = [(-1) ** c * determinant([row[:c] + row[c + 1:] for row in edges]) for c in range(6)]
    offset = sum(n * x for n, x in zip(normal, corners[0]))
    height = sum(n * x for n, x in zip(normal, inner)) - 7 * offset
    return (normal, offset) if height < 0 else ([-n for n in normal], -offset)


def hull(points):
    """Facets as corner numbers with their planes, and 6! times the volume; None for a flat set."""
    start = []
    for i in range(len(points)):
        edges = [[x - y for x, y in zip(points[j], points[start[0]])] for j in start[1:] + [i]] if start else []
        if not edges or any(
            determinant([[row[c] for c in axes] for row in edges]) for axes in combinations(range(6), len(edges))
        ):
            start.append(i)
        if len(start) == 7:
            break
    if len(start) < 7:
        return None
    inner = [sum(points[i][c] for i in start) for c in range(6)]
    volume = abs(determinant([[x - y for x, y in zip(points[i], points[start[0]])] for i in start[1:]]))
    facets = {}
    for corners in combinations(sorted(start), 6):
        facets[corners] = plane([points[i] for i in corners], inner)
    for new, point in enumerate(points):
        if new in start:
            continue
        ridges = {}
        for corners, (normal, offset) in list(facets.items()):
            if sum(n * x for n, x in zip(normal, point)) <= offset:
                continue
            del facets[corners]
            volume += abs(determinant([[x - y for x, y in zip(points[i], point)] for i in corners]))
            for ridge in combinations(corners, 5):
                ridges[ridge] = ridges.get(ridge, 0) + 1
        for ridge, count in ridges.items():
            if count == 1:
                corners = tuple(sorted(ridge + (new,)))
                facets[corners] = plane([points[i] for i in corners], inner)
    return facets, volume


def main(path):
    with open(path, encoding="utf-8") as file:
        lines = [line.split() for line in file if not line.startswith("#")]
    exact = [[Fraction(float(x)) for x in line] for line in lines]
    units = [max(w[c].denominator for w in exact) for c in range(6)]
    found = hull([[int(w[c] * units[c]) for c in range(6)] for w in exact])
    if found is None:
        print("flat")
        return
    facets, volume = found
    whole = 1
    for unit in units:
        whole *= unit
    margin = None
    for normal, offset in facets.values():
        # a·(units x) = b in the coordinates of the file.
        squared = sum(Fraction(n * u) ** 2 for n, u in zip(normal, units))
        square = Fraction(offset) ** 2 / squared
        signed = square if offset > 0 else -square
        margin = signed if margin is None else min(margin, signed)
    root = sqrt(abs(margin)) * (1 if margin > 0 else -1)
    print(f"margin {root!r}, volume {float(Fraction(volume, factorial(6) * whole))!r}, {len(facets)} simplices")


if __name__ == "__main__":
    main(sys.argv[1])
