"""Meshes that the gallery makes itself: closed, in metres, y up, as OBJ text.

Each function returns (text, impact), where impact is the point on the surface that the gallery hits.
"""
import math


CREASE = math.cos(math.radians(35))  # faces that meet at a larger angle keep a sharp edge


def _normal(points):
    """Returns a polygon's normal by Newell's method, with unit length."""
    n = [0.0, 0.0, 0.0]
    for p, q in zip(points, points[1:] + points[:1]):
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            n[k] += (p[i] - q[i]) * (p[j] + q[j])
    length = math.sqrt(sum(c * c for c in n))
    return [c / length for c in n]


def _obj(vertices, faces):
    normals = [_normal([vertices[v] for v in face]) for face in faces]
    around = [[] for _ in vertices]
    for f, face in enumerate(faces):
        for v in face:
            around[v].append(f)
    lines, count = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices], 0
    for f, face in enumerate(faces):
        corners = []
        for v in face:
            near = [normals[g] for g in around[v] if sum(a * b for a, b in zip(normals[f], normals[g])) > CREASE]
            mean = [sum(c) for c in zip(*near)]
            length = math.sqrt(sum(c * c for c in mean))
            lines.append("vn " + " ".join(f"{c / length:.6g}" for c in mean))
            count += 1
            corners.append(f"{v + 1}//{count}")
        lines.append("f " + " ".join(corners))
    return "\n".join(lines) + "\n"


def box(size, impact):
    x, y, z = (s / 2 for s in size)
    vertices = [(sx * x, sy * y + y, sz * z) for sx in (-1, 1) for sy in (-1, 1) for sz in (-1, 1)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return _obj(vertices, faces), impact


def lathe(profile, segments):
    """Rotates a closed polygon of (radius, height) points around y. The points are counter-clockwise with the radius to the right.
    Points with radius 0 become single vertices."""
    vertices, rings = [], []
    for radius, height in profile:
        if radius == 0:
            rings.append([len(vertices)] * segments)
            vertices.append((0.0, height, 0.0))
        else:
            rings.append(list(range(len(vertices), len(vertices) + segments)))
            vertices += [(radius * math.cos(2 * math.pi * k / segments), height, -radius * math.sin(2 * math.pi * k / segments))
                         for k in range(segments)]
    faces = []
    for ring in range(len(profile)):
        a, b = rings[ring], rings[(ring + 1) % len(profile)]
        for k in range(segments):
            n = (k + 1) % segments
            face = [a[k], a[n], b[n], b[k]]
            corners = [v for i, v in enumerate(face) if v != face[i - 1]]
            if len(corners) >= 3:
                faces.append(corners)
    return _obj(vertices, faces)


def pane():
    """Returns a window pane, 1.2 m by 0.9 m, 10 mm thick."""
    return box((1.2, 0.9, 0.01), (0.12, 0.52, 0.005))


def wall():
    """Returns a free-standing wall, 2.4 m by 1.5 m, one brick thick."""
    return box((2.4, 1.5, 0.24), (0.35, 0.85, 0.12))


def column():
    """Returns a column, 2.2 m high, with base and capital."""
    profile = [(0, 0), (0.34, 0), (0.34, 0.12), (0.30, 0.16), (0.30, 0.22), (0.235, 0.28)]
    profile += [(0.235 - 0.035 * t / 8, 0.28 + 1.58 * t / 8) for t in range(1, 9)]
    profile += [(0.25, 1.92), (0.25, 1.98), (0.32, 2.05), (0.32, 2.2), (0, 2.2)]
    return lathe(profile, 40), (0.218 * math.sin(math.radians(35)), 1.15, 0.218 * math.cos(math.radians(35)))


def vase():
    """Returns a vase, 0.32 m high, with walls 8 mm thick."""
    outside = [(0.050, 0.0), (0.058, 0.006), (0.075, 0.04), (0.098, 0.09), (0.108, 0.14), (0.100, 0.19), (0.075, 0.235),
               (0.048, 0.265), (0.042, 0.285), (0.052, 0.31), (0.060, 0.32)]
    inside = [(r - 0.008, h) for r, h in outside[:1:-1]]
    profile = [(0, 0)] + outside + inside[:-1] + [(0.060, 0.032), (0, 0.014)]
    return lathe(profile, 48), (0.107 * math.sin(math.radians(35)), 0.13, 0.107 * math.cos(math.radians(35)))


MESHES = {"pane": pane, "vase": vase, "wall": wall, "column": column}
