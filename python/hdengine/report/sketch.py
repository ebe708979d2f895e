# SPDX-License-Identifier: GPL-3.0-or-later
"""A drawing of the scene for the head of its report: cup, ring and contact band, cut along the axis, and the front view."""
import math

from .._engine import supported

__all__: list[str] = []
_FLEXSPLINE, _RING, _BAND, _BALL, _TEETH, _CAM = "#8fb0cc", "#dcc08a", "#d1495b", "#c8963e", "#4f8a6b", "#c9cdd3"


def _ellipse(x, y, a, b, colour, width):
    return f'<ellipse cx="{x:.1f}" cy="{y:.1f}" rx="{a:.1f}" ry="{b:.1f}" fill="none" stroke="{colour}" stroke-width="{width}"/>'


def _text(x, y, text, anchor="middle"):
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{text}</text>'


def _meridian(scene, g):
    """Quadrilaterals (z, r) of the cup in the cut: of its sections, fillets left out, or of the simple cup."""
    listed = [scene.get(f"cup.sections_{k}", 0) for k in ("r", "z", "thickness")]
    r, z, t = ([v] if isinstance(v, (int, float)) else list(v) for v in listed)
    if len(r) < 3:
        corner, bore, rim = g["cup_length"] - g["bottom_thickness"], g["bore_radius"], g["rim_length"]
        r, z = [bore, bore, bore, bore, bore, g["hub_radius"]], [0, rim, rim, corner, corner, corner]
        t = [g["rim_thickness"]] * 2 + [g["wall_thickness"]] * 2 + [g["bottom_thickness"]] * 2
    found = []
    for i in range(len(r) - 1):
        length = math.hypot(r[i + 1] - r[i], z[i + 1] - z[i])
        if length > 0:
            n = (z[i + 1] - z[i]) / length, -(r[i + 1] - r[i]) / length
            found.append([(z[i], r[i]), (z[i + 1], r[i + 1]), (z[i + 1] + t[i + 1] * n[1], r[i + 1] + t[i + 1] * n[0]),
                          (z[i] + t[i] * n[1], r[i] + t[i] * n[0])])
    return found


def _ring(scene, g):
    """Outline (z, r) of the ring in the cut, with the groove of the balls where it has one."""
    r, start, end = g["bore_radius"], g["band_start"], g["band_start"] + g["band_length"]
    inside, depth = r - g["ring_thickness"], scene.get("bearing.groove_depth", 0)
    groove = []
    if depth > 0:
        radius = scene["bearing.outer_conformity"] * scene["bearing.ball_diameter"]
        half = math.acos(1 - depth / radius)
        groove = [((start + end) / 2 + radius * math.sin(half * k / 8), inside + depth + radius * (math.cos(half * k / 8) - 1))
                  for k in range(8, -9, -1)]
    return [(start, r), (end, r), (end, inside), *groove, (start, inside)]


def _cam_and_balls(scene, x, y, a, b):
    """Cam and balls of the front view, inside of an ellipse; nothing where the scene has no balls."""
    balls = scene.get("bearing.balls", 0) if supported(scene, "struts") else 0
    size = 6.0
    cam = f'<ellipse cx="{x:.1f}" cy="{y:.1f}" rx="{a - 2 * size:.1f}" ry="{b - 2 * size:.1f}" fill="{_CAM}" ' \
          'stroke="currentColor" stroke-width=".6"/>'
    if not balls:
        return []
    start = math.radians(scene.get("bearing.cage_angle_deg", 0))
    return [cam, *(f'<circle cx="{x + (a - size) * math.cos(start + 2 * math.pi * i / balls):.1f}" '
                   f'cy="{y - (b - size) * math.sin(start + 2 * math.pi * i / balls):.1f}" r="{size - .8:.1f}" fill="{_BALL}"/>'
                   for i in range(balls))]


def _teeth(scene, x, y, a, b):
    """Pairs of teeth in mesh, about both ends of the long axis; the teeth are drawn wider than they are where they would merge."""
    if not supported(scene, "teeth"):
        return []
    half = scene["load.tooth_pairs"] // 2
    found = []
    for end in (0, math.pi):
        for i in range(half):
            t = end + (i - (half - 1) / 2) * 2 * math.pi / scene["load.teeth"]
            c, s = math.cos(t), math.sin(t)
            found.append(f'<line x1="{x + a * c:.1f}" y1="{y - b * s:.1f}" x2="{x + (a + 6) * c:.1f}" y2="{y - (b + 6) * s:.1f}" '
                         f'stroke="{_TEETH}" stroke-width="1.6"/>')
    return found


def draw_scene(scene: dict) -> str:
    """SVG of a scene: on the left the cut along the axis, to scale; on the right the front view, deformation enlarged.

    Parameters
    ----------
    scene : dict
        'group.key' to value, SI units.

    Returns
    -------
    str
    """
    g = {key.split(".")[1]: value for key, value in scene.items() if key.startswith("geometry.")}
    r, length = g["bore_radius"], g["cup_length"]
    cup = _meridian(scene, g)
    outside = max(radius for piece in cup for _, radius in piece)
    scale = min(260 / length, 150 / outside)  # px per m
    left, axis = 30.0, 30 + outside * scale

    def z(value):
        return left + value * scale

    def y(radius):
        return axis - radius * scale
    parts = [
        *(f'<polygon points="{" ".join(f"{z(at):.1f},{y(radius):.1f}" for at, radius in piece)}" fill="{_FLEXSPLINE}" '
          'stroke="currentColor" stroke-width=".6"/>' for piece in cup),
        f'<polygon points="{" ".join(f"{z(at):.2f},{y(radius):.2f}" for at, radius in _ring(scene, g))}" fill="{_RING}" '
        'stroke="currentColor" stroke-width=".6"/>',
        f'<line x1="{z(g["band_start"]):.1f}" y1="{y(r):.1f}" x2="{z(g["band_start"] + g["band_length"]):.1f}" y2="{y(r):.1f}" '
        f'stroke="{_BAND}" stroke-width="3"/>',
        f'<line x1="{left - 12:.1f}" y1="{axis:.1f}" x2="{z(length) + 12:.1f}" y2="{axis:.1f}" stroke="currentColor" '
        'stroke-dasharray="9 3 2 3"/>',
        _text(z(g["band_start"] + g["band_length"] / 2), y(r - g["ring_thickness"]) + 15, "ring of the bearing"),
        _text(z(g["band_start"] + g["band_length"] / 2), y(r - g["ring_thickness"]) + 29,
              f'<tspan fill="{_BAND}">contact band</tspan>, {1e3 * g["band_length"]:.3g} mm'),
        _text(left - 12, y(outside) - 6, f"flexspline (cup), {1e3 * length:.3g} mm long", "start"),
        _text(z(length), y(g["hub_radius"]) + 16,
              {"hub": "held at the hub", "bearing": "hub free to turn"}.get(scene["load.support"], "torque at the hub"), "end"),
        _text(z(0) - 4, axis - 4, "axis", "start"),
    ]
    centre, radius = 160.0, 0.62 * min(outside * scale, 120)
    half = axis - 0.5 * outside * scale
    a, b = 1.12 * radius, 0.88 * radius
    cam = _cam_and_balls(scene, centre, half, a - 8, b - 8)
    front = cam + _teeth(scene, centre, half, a + 9, b + 9) + [
        _ellipse(centre, half, a + 5, b + 5, _FLEXSPLINE, 7), _ellipse(centre, half, a - 3, b - 3, _RING, 8),
        _ellipse(centre, half, a + 1, b + 1, _BAND, 1.5),
        f'<line x1="{centre - a - 16:.1f}" y1="{half:.1f}" x2="{centre + a + 16:.1f}" y2="{half:.1f}" stroke="currentColor" '
        'stroke-dasharray="9 3 2 3"/>',
        _text(centre, half - 5, '<tspan fill="#222">cam</tspan>' if cam else "long axis, θ = 0"),
        _text(centre, half + b + 28, f'bore radius {1e3 * r:.4g} mm; θ = 0 to the right'),
        _text(centre, half + b + 44, f'w = {1e3 * scene["wave_generator.w"]:.3g} mm (drawn larger), '
              f'torque {scene["load.torque"]:.4g} N m'),
    ]
    height = max(axis + 12, half + b + 56)
    views = (("cut along the axis", parts), ("front view", front))
    return '<div class="views">' + "".join(
        f'<svg viewBox="0 0 320 {height:.0f}" role="img" aria-label="{name}" font-size="13" '
        f'font-family="system-ui,sans-serif" fill="currentColor">{"".join(view)}</svg>' for name, view in views) + "</div>"
