# SPDX-License-Identifier: GPL-3.0-or-later
"""Boundary elements against closed forms: Hertz, Westergaard, Johnson, Persson; shear with Coulomb friction against Cattaneo and Mindlin."""
import numpy as np
import pytest
from test_prediction import rough

from hdengine import InputError, NotConvergedError
from hdengine.elastic import ElasticJoint, moduli, stiffness_from_spectrum
from hdengine.prediction import half_space
from hdengine.prediction.half_space import HalfSpace, corrected_area
from hdengine.prediction.shear import Slider

pytest.importorskip("tamaas")
E_STAR, RATIO = moduli(209e9, 0.295, 219e9, 0.30)
CELL, RADIUS, SPOT, MU = 96e-6, 2e-3, 14e-6, 0.15
LOAD = 4 * E_STAR * SPOT**3 / (3 * RADIUS) / CELL**2   # mean pressure that presses a spot of radius SPOT


def ball(n):
    x = (np.arange(n) + 0.5) * CELL / n - CELL / 2
    return HalfSpace(-np.hypot(*np.meshgrid(x, x)) ** 2 / (2 * RADIUS), (CELL / n,) * 2, E_STAR, RATIO)


def test_hertz_and_its_convergence():
    """Pressures of a ball are Hertz's; their rms error falls with the grid at least as the spacing, below 1 % of the peak at 14 points a
    radius."""
    errors, peak = [], 1.5 * LOAD * CELL**2 / (np.pi * SPOT**2)
    for n in (24, 48, 96):
        x = (np.arange(n) + 0.5) * CELL / n - CELL / 2
        r = np.hypot(*np.meshgrid(x, x))
        exact = peak * np.sqrt(np.maximum(1 - (r / SPOT) ** 2, 0))
        found = ball(n).press(LOAD)
        errors.append(np.sqrt(((found - exact)[r < 1.2 * SPOT] ** 2).mean()) / peak)
    assert errors[1] < 0.55 * errors[0] and errors[2] < 0.3 * errors[0] and errors[2] < 0.01


def test_ratio_of_a_round_spot():
    """k_T/k_N of a round spot is 4 G*/E* within 0.3 %."""
    space = ball(96)
    touching = space.press(LOAD) > 0
    assert space.tangential_stiffness(touching) / space.normal_stiffness(touching) == pytest.approx(RATIO, rel=3e-3)


def test_ratio_of_a_round_hole():
    """Where all touches but a round hole, k_T/k_N is 1 - nu/2, that of a penny-shaped crack, within 0.5 %."""
    x = np.arange(96) - 47.5
    touching = np.hypot(*np.meshgrid(x, x)) > 12
    space, nu = ball(96), (2 - 2 * RATIO) / (2 - RATIO)
    assert space.tangential_stiffness(touching) / space.normal_stiffness(touching) == pytest.approx(1 - nu / 2, rel=5e-3)


def test_westergaards_wave_and_its_convergence():
    """Pressure of a cosine is Westergaard's, 2 p cos(psi)/sin(a)^2 sqrt(sin(a)^2 - sin(psi)^2) with psi = pi x / lambda; the error is
    below 0.4, 0.2 and 0.15 % of the peak on 64, 128 and 256 points."""
    share, errors = 0.3, []
    edge = np.sqrt(share)                     # sin(pi a / lambda)
    for n in (64, 128, 256):
        psi = np.pi * np.arange(n) / n
        psi = np.minimum(psi, np.pi - psi)
        height = 1e-4 * n * 1e-6
        z = np.tile(height * np.cos(2 * psi), (4, 1))
        p = share * np.pi * E_STAR * height / (n * 1e-6)
        exact = 2 * p * np.cos(psi) / edge**2 * np.sqrt(np.maximum(edge**2 - np.sin(psi) ** 2, 0))
        found = HalfSpace(z, (1e-6, 1e-6), E_STAR, residual=1e-9).press(p)[0]
        errors.append(np.sqrt(((found - exact) ** 2).mean()) / exact.max())
    assert (np.array(errors) < [4e-3, 2e-3, 1.5e-3]).all()


def test_johnsons_limits():
    """Johnson, Greenwood and Higginson's egg box: light load touches pi (3 p / 8 pi p*)^(2/3), near full contact 1 - 3/(2 pi) (1 - p/p*),
    and p* = sqrt(2) pi E* h / lambda closes it."""
    n, h = 256, 1e-8
    x = 2 * np.pi * np.arange(n) / n
    full = np.sqrt(2) * np.pi * E_STAR * h / (n * 1e-6)
    space = HalfSpace(h * np.outer(np.cos(x), np.cos(x)), (1e-6, 1e-6), E_STAR, residual=1e-9)
    light = space.press(0.005 * full) > 0
    assert corrected_area(light) == pytest.approx(np.pi * (3 / (8 * np.pi) * 0.005) ** (2 / 3), rel=0.04)
    assert (space.press(0.97 * full) > 0).mean() == pytest.approx(1 - 1.5 / np.pi * 0.03, abs=0.004)
    assert (space.press(1.01 * full) > 0).all()


def test_perssons_limits():
    """Full contact spreads the pressure by E* slope / 2 (rms), Persson's variance, to 0.1 %; at light load the area is 1.6 (Persson) to
    2.5 (Bush, Gibson and Thomas) p / (E* slope)."""
    z = rough(128, 0.8, 32, 8, 3)
    spread = E_STAR * 0.05 / 2
    space = HalfSpace(z, (1e-6, 1e-6), E_STAR)
    closed = space.press(6 * spread)
    assert (closed > 0).all() and closed.std() == pytest.approx(spread, rel=1e-3)
    p = 0.02 * E_STAR * 0.05
    assert 1.6 < corrected_area(space.press(p) > 0) / 0.02 < 2.51


def test_stiffness_is_pressure_over_a_share_of_the_roughness():
    """With a roll-off k_N = P / (gamma h_rms) over a decade of pressures, gamma 0.35 to 0.5 (Persson 2007: about 0.4), by theory and by elements."""
    z = rough(256, 0.8, 32, 8, 3)
    h = np.abs(np.fft.fft2(z) / z.size) ** 2
    f = np.hypot(*np.meshgrid(*[np.fft.fftfreq(256, 1e-6)] * 2, indexing="ij"))
    order = np.argsort(f.ravel())[1:]
    q, v = 2 * np.pi * f.ravel()[order], h.ravel()[order]
    bins = np.unique(np.rint(q / q[0]).astype(int), return_inverse=True)[1]
    total = np.bincount(bins, v)
    use = total > 1e-20 * total.max()
    q = (np.bincount(bins, v * q)[use] / total[use])
    p = E_STAR * 0.05 * np.array([0.005, 0.015, 0.05])
    theory = stiffness_from_spectrum(q, total[use], p, E_STAR)[0]
    space = HalfSpace(z, (1e-6, 1e-6), E_STAR)
    elements = [space.normal_stiffness(space.press(x) > 0) for x in p]
    for k in (theory, elements):
        gamma = p / (np.array(k) * z.std())
        assert gamma.min() > 0.35 and gamma.max() < 0.5


def shears(space, pressure, path):
    """Mean shear [Pa] along a path of displacements [m], from no shear."""
    slider = Slider(space, pressure, MU)
    return np.array([slider.move(u) for u in path])


def test_cattaneo_and_mindlin():
    """A pressed ball that is pushed sideways sticks inside c = a (1 - q/mu P)^(1/3), and its shear is mu (p(a) - c/a p(c))."""
    space = ball(96)
    pressure = space.press(LOAD)
    slider = Slider(space, pressure, MU)
    k = space.tangential_stiffness(pressure > 0)
    share = slider.move(0.6 * 1.5 * MU * LOAD / k) / (MU * LOAD)
    assert 0.5 < share < 0.9
    x = (np.arange(96) + 0.5) * CELL / 96 - CELL / 2
    r, c = np.hypot(*np.meshgrid(x, x)), SPOT * (1 - share) ** (1 / 3)
    peak = MU * 1.5 * LOAD * CELL**2 / (np.pi * SPOT**2)
    exact = peak * (np.sqrt(np.maximum(1 - (r / SPOT) ** 2, 0)) - c / SPOT * np.sqrt(np.maximum(1 - (r / c) ** 2, 0)))
    assert np.sqrt(((slider.traction[..., 1] - exact)[r < SPOT] ** 2).mean()) < 0.03 * peak
    assert slider.slipping == pytest.approx(1 - (c / SPOT) ** 2, abs=0.02)


def test_full_slip_carries_mu_p_and_steps_do_not_matter():
    """Far enough all slips at mu P; a monotonic way in one step or four ends in the same shear; none moved, none carried."""
    z = rough(64, 0.7, 16, 8, 5)
    space = HalfSpace(z, (1e-6, 1e-6), E_STAR, RATIO)
    pressure = space.press(2e8)
    end = 2 * MU * 2e8 / space.tangential_stiffness(pressure > 0)
    steps = shears(space, pressure, [0.0, 0.25 * end, 0.5 * end, 0.75 * end, end])
    assert steps[0] == pytest.approx(0, abs=1e-9)
    assert shears(space, pressure, [end])[0] == pytest.approx(steps[-1], rel=2e-4)
    assert shears(space, pressure, [20 * end])[0] == pytest.approx(MU * 2e8, rel=1e-3)
    with pytest.raises(InputError, match="friction"):
        Slider(space, pressure, 0.0)


def test_shear_curve_and_loop_of_a_rough_patch():
    """Ciavarella and Jaeger, and Masing: shear curve and loop of a rough patch with Coulomb friction are those of the law that follows
    from k_N alone, within 3 % of mu P."""
    z, load = rough(64, 0.65, 16, 6, 7), 2e8
    space = HalfSpace(z, (1e-6, 1e-6), E_STAR, RATIO)
    p = load * np.geomspace(1e-3, 1, 20)
    k_n = np.array([space.normal_stiffness(space.press(x) > 0) for x in p])
    joint = ElasticJoint(p, k_n, RATIO * k_n, MU)
    pressure = space.press(load)
    turn = 1.2 * MU * load / space.tangential_stiffness(pressure > 0)
    up, back = np.array([0.2, 0.5, 1.0]) * turn, np.array([0.5, 0.0, -0.5, -1.0, -0.4, 0.3, 1.0]) * turn
    found = shears(space, pressure, [*up, *back]) / (MU * load)

    def law(u):
        return joint.shear(load, u)[0] / (MU * load)

    exact = [*law(up), *(law(turn) - 2 * law((turn - back[:4]) / 2)), *(-law(turn) + 2 * law((back[4:] + turn) / 2))]
    assert found == pytest.approx(exact, abs=0.03)
    assert abs(found[4] - 0) > 0.2, "a loop that is open at no displacement"


def test_boundary_of_the_stiffness_on_two_axes():
    """k_T/k_N of rough patches, mean of both directions, is (2 - 2 nu)/(2 - nu) within 1 %."""
    z, ratios = rough(128, 0.7, 16, 6, 8), []
    for heights in (z, z.T):
        k_n, k_t, _ = half_space.stiffness_on_map(heights, (1e-6, 1e-6), [1e8, 4e8], E_STAR, RATIO)
        ratios.append(k_t / k_n)
    assert np.mean(ratios, axis=0) == pytest.approx(RATIO, rel=0.01)


def free_ball(n, cell):
    x = (np.arange(n) + 0.5) * cell / n - cell / 2
    r = np.hypot(*np.meshgrid(x, x))
    return HalfSpace(-(r**2) / (2 * RADIUS), (cell / n,) * 2, E_STAR, RATIO, free=True), r


def test_hertz_on_a_free_patch():
    """A ball on a patch little larger than its spot has Hertz's pressures within 1 % of the peak, his approach a^2/R and stiffness 2 E* a within
    0.3 %, and the errors fall with the grid; the images of a periodic cell would move the approach by 60 %."""
    cell, load, errors = 32e-6, 4 * E_STAR * SPOT**3 / (3 * RADIUS) / (32e-6) ** 2, []
    peak = 2 * E_STAR * SPOT / (np.pi * RADIUS)
    for n in (32, 64, 128):
        space, r = free_ball(n, cell)
        found = space.press(load)
        exact = peak * np.sqrt(np.maximum(1 - (r / SPOT) ** 2, 0))
        k_n = space.normal_stiffness(found > 0)
        whole = cell**2 / (1 / k_n + 1 / space.bulk)
        errors.append([np.sqrt(((found - exact)[r < 1.2 * SPOT] ** 2).mean()) / peak, abs(space.approach(found) / (SPOT**2 / RADIUS) - 1),
                       abs(whole / (2 * E_STAR * SPOT) - 1)])
    errors = np.array(errors)
    assert (errors[:, 0] < 0.01).all() and (errors[:, 1:] < 3e-3).all() and (errors[2] < 0.7 * errors[0]).all()


def test_flat_punches_on_a_free_patch():
    """A round spot that is pressed flat is 2 E* a stiff within 0.5 %; a square smooth patch 1.15 E* times its side within 0.7 %, whatever its size."""
    space, r = free_ball(128, 40e-6)
    radius = 14e-6
    disc = r < radius
    whole = 40e-6**2 / (1 / space.normal_stiffness(disc) + 1 / space.bulk)
    assert whole == pytest.approx(2 * E_STAR * np.sqrt(disc.mean() * 40e-6**2 / np.pi), rel=5e-3)
    assert [space.bulk * 40e-6, free_ball(64, 1e-3)[0].bulk * 1e-3] == pytest.approx([1.1517 * E_STAR] * 2, rel=7e-3)


def test_a_small_spot_does_not_feel_the_patch():
    """The bulk takes 2 a / 1.15 L of the compliance of a spot of radius a on a patch of side L; where all touches no stiffness is left,
    and shear is refused by its reason."""
    space, r = free_ball(200, 200e-6)
    k_n = space.normal_stiffness(r < 8e-6)
    assert k_n / (k_n + space.bulk) == pytest.approx(16 / (1.15 * 200), rel=0.02)
    with pytest.raises(NotConvergedError, match="all of the free patch touches"):
        space.normal_stiffness(r >= 0)
    with pytest.raises(InputError, match="no shear"):
        space.tangential_stiffness(r < SPOT)


def test_a_free_patch_of_many_waves_is_its_periodic_map():
    """With the bulk of a smooth patch taken off, a free patch of many waves has k_N of its periodic map within 10 % while the bulk takes up to nine
    tenths of its compliance; left in, it would be a tenth. The bound of the pressure holds, and yield lowers k_N as it does there."""
    z, p = rough(128, 0.7, 8, 6, 1), 0.05 * E_STAR * np.array([0.004, 0.02, 0.06])
    free, periodic = ([s.normal_stiffness(s.press(x) > 0) for x in p] for s in (HalfSpace(z, (1e-6, 1e-6), E_STAR, free=f) for f in (True, False)))
    assert free == pytest.approx(periodic, rel=0.10)
    bulk = HalfSpace(z, (1e-6, 1e-6), E_STAR, free=True).bulk
    assert 0.85 < free[-1] / (free[-1] + bulk) < 0.92
    hard = HalfSpace(z, (1e-6, 1e-6), E_STAR, hardness=3e9, free=True)
    found = hard.press(p[1])
    assert found.max() == pytest.approx(3e9, rel=1e-6) and found.mean() == pytest.approx(p[1], rel=1e-9)
    assert half_space.stiffness_on_map(z, (1e-6, 1e-6), p, E_STAR, RATIO, free=True)[1] == pytest.approx(RATIO * np.array(free))
