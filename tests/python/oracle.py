# SPDX-License-Identifier: GPL-3.0-or-later
"""Eq. 3-44 (as derived, not as printed) in 50-digit arithmetic, written apart from the engine: powers and incomplete beta functions."""
from mpmath import betainc, findroot, log, mp, mpf, pi, quad, sqrt

mp.dps = 50
JUMPS = (mpf(1), mpf(6), mpf(110))
AREA = ((mpf(1), mpf(1)), (mpf("0.93"), mpf("1.136")), (mpf("0.94"), mpf("1.146")))  # s / s_ec = c x^n
FORCE = ((mpf(1), mpf("1.5")), (mpf("1.03"), mpf("1.425")), (mpf("1.40"), mpf("1.263")))  # f / f_ec = c x^n


class Oracle:
    """Integrals of one joint; arguments are floats, taken as exact."""

    def __init__(self, joint):
        e1, nu1, e2, nu2, nu_soft, h, d, g, gamma, r_m, mu, s_min, a0 = (mpf(float(x)) for x in joint._parameters()[:13])
        self.d, self.mu, self.s_min, self.a0, self.h = d, mu, s_min, a0, h
        self.e = e = 1 / ((1 - nu1**2) / e1 + (1 - nu2**2) / e2)
        self.g_prime = 1 / ((2 - nu1) * 2 * (1 + nu1) / e1 + (2 - nu2) * 2 * (1 + nu2) / e2)
        self.k_hard = k = mpf("0.454") + mpf("0.41") * nu_soft
        self.eta = (2 * r_m) ** (3 - d) * g ** (d - 2) * sqrt(log(gamma))   # amplitude of a cosine
        self.radius = radius = r_m**2 / (pi**2 * self.eta)
        self.eps_ec = (pi * k * h / (2 * e)) ** 2 * radius
        self.s_ec = pi * radius * self.eps_ec
        self.f_ec = 4 * e * self.s_ec ** mpf("1.5") / (3 * pi ** mpf("1.5") * radius)
        ds = d - 1
        with mp.workdps(80):  # the equation is 0/0 at D = 3
            self.psi = findroot(lambda x: (x ** ((2 - ds) / 2) - (1 + x ** (-ds / 2)) ** (-(2 - ds) / ds)) / ((2 - ds) / ds) - 1,
                                (mpf("1.71"), mpf("2.63")), tol=mpf(10) ** -100)
        self.edges = [self.s_ec] + [c * x**n * self.s_ec for (c, n), x in zip(AREA[1:], JUMPS[1:])]
        # load and stiffness of a spot as coefficient and power of s / s_ec, per regime
        self.load, self.stiff = [], []
        for (ca, na), (cf, nf) in zip(AREA, FORCE):
            q = nf / na
            self.load.append((self.f_ec * cf / ca**q, q))
            self.stiff.append((self.f_ec / self.eps_ec * cf * nf / ca ** ((nf - 1) / na), (nf - 1) / na))
        self.load.append((h * self.s_ec, mpf(1)))

    def share(self, s_l):
        return (self.d - 1) / 2 * self.psi ** ((3 - self.d) / 2) * (s_l / self.s_ec) ** ((self.d - 1) / 2)

    def limits(self, s_l):
        edges = [mpf(0), *self.edges, mp.inf]
        for i in range(4):
            lo, hi = max(edges[i], self.s_min) / self.s_ec, min(edges[i + 1], s_l) / self.s_ec
            if hi > lo:
                yield i, lo, hi

    def by_depth(self, x):
        """Area, load and stiffness of a spot at x times the depth of first yield."""
        i = sum(x > jump for jump in JUMPS)
        if i == 3:
            return 2 * self.s_ec * x, self.h * 2 * self.s_ec * x, mpf(0)
        (ca, na), (cf, nf) = AREA[i], FORCE[i]
        return self.s_ec * ca * x**na, self.f_ec * cf * x**nf, self.f_ec / self.eps_ec * cf * nf * x ** (nf - 1)

    def by_area(self, s, tau):
        """Load, normal and tangential stiffness of a spot."""
        i, x = sum(s > edge for edge in self.edges), s / self.s_ec
        load = self.load[i][0] * x ** self.load[i][1]
        if i == 3:
            return load, mpf(0), mpf(0)
        return load, self.stiff[i][0] * x ** self.stiff[i][1], 8 * self.g_prime * sqrt(s / pi) * max(1 - tau * s / (self.mu * load), 0) ** (mpf(1) / 3)

    def power(self, s_l, table):
        """Integral of each regime."""
        b, found = (self.d - 1) / 2, [mpf(0)] * 4
        for i, lo, hi in self.limits(s_l):
            if i < len(table):
                c, n = table[i]
                found[i] = self.share(s_l) * c * (hi ** (n - b) - lo ** (n - b)) / (n - b)
        return found

    def total_load(self, s_l):
        return sum(self.power(s_l, self.load))

    def k_n(self, s_l):
        return sum(self.power(s_l, self.stiff))

    def area(self, s_l):
        return (self.d - 1) / (3 - self.d) * self.psi ** ((3 - self.d) / 2) * s_l

    def k_t(self, s_l, tau, direct=False):
        return sum(self.k_t_parts(s_l, tau, direct))

    def k_t_parts(self, s_l, tau, direct=False):
        total = [mpf(0)] * 4
        e = 1 - self.d / 2
        for i, lo, hi in self.limits(s_l):
            if i == 3:
                continue
            c, n = self.load[i]
            p = n - 1
            h = tau * self.s_ec / (self.mu * c)
            x_lo, x_hi = min(h * lo**-p, mpf(1)), min(h * hi**-p, mpf(1))
            if direct:
                lo = max(lo, h ** (1 / p)) if h > 0 else lo
                if hi > lo:
                    total[i] = quad(lambda y: mp.exp(e * y) * (1 - h * mp.exp(-p * y)) ** (mpf(1) / 3), [log(lo), log(hi)])
            elif h == 0:
                total[i] = (hi**e - lo**e) / e
            elif x_lo > x_hi:
                a = -e / p
                total[i] = h**-a / p * betainc(a, mpf(4) / 3, x_hi, x_lo)
        return [self.share(s_l) * 8 * self.g_prime * sqrt(self.s_ec / pi) * x for x in total]
