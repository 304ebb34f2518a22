"""Components of different directions, to second order: free surface, double sum, limits, symmetries."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from decimal import Decimal, localcontext

import numpy as np

from owt_wave_node.core.direct import DirectField
from owt_wave_node.core.directional import DirectionalField
from owt_wave_node.core.dispersion import wavenumber
from owt_wave_node.core.field import GridField
from owt_wave_node.core.grid import frequency_grid
from owt_wave_node.core.route import component_field
from owt_wave_node.core.sea import Waves
from owt_wave_node.kernels.directional import transfer_pair
from proofs import cases, flow
from proofs.registry import Proof

__all__ = ["PROOFS", "BothSums", "sea"]

G = 9.81
STEPS = 300


def sea(
    multiple: list[float],
    direction_deg: list[float],
    *,
    depth: float = 50.0,
    order: int = 2,
    stretching: str = "taylor",
) -> Waves:
    """Components at multiples of the spacing of 300 samples of 0.2 s, of 1 m to 0.1 m."""
    m = np.array(multiple, dtype=float)
    omega = 2.0 * np.pi / (STEPS * 0.2) * m
    return Waves(
        omega=omega,
        wavenumber=wavenumber(omega, water_depth=depth, gravity=G),
        angle=np.deg2rad(direction_deg),
        amplitude=4.0 / m * np.exp(1j * np.sqrt(np.arange(m.size)) * 5.0),
        depth=depth,
        gravity=G,
        order=order,
        stretching=stretching,
        dt=0.2,
        n=STEPS,
    )


MULTIPLE = [4, 5, 6, 7, 7, 8, 9, 9, 11, 13, 18, 25]
ANGLE = [-40, 12, 0, 25, -155, 60, 33, 33 + 180, -9, 140, -75, 5]


def seas() -> list[Waves]:
    """Twelve waves of all directions, pairs of one frequency, one opposite; and twelve of one direction."""
    between = [m + 0.37 * np.sin(7.0 * i) for i, m in enumerate(MULTIPLE)]
    return [
        *(sea(MULTIPLE, ANGLE, depth=depth) for depth in (50.0, 20.0, 9.0, 400.0)),
        sea(between, ANGLE),
        sea(MULTIPLE, [20.0] * len(MULTIPLE)),
    ]


def crossing() -> Waves:
    return seas()[0]


def off_grid() -> Waves:
    return seas()[4]


@dataclass(frozen=True)
class BothSums:
    """The equations of Sharma and Dean written out over all pairs, numpy, no symmetry used.

    Attributes
    ----------
    scalar_norm : bool
        | |k_m| - |k_n| | and |k_m| + |k_n| in place of the lengths of the vectors.
    no_dot : bool
        k_m k_n in place of the dot product of the vectors.
    exchanged : bool
        Signs of R_m R_n exchanged between the sum and the difference.
    coming_from : bool
        Directions that the waves come from.
    """

    waves: Waves
    scalar_norm: bool = False
    no_dot: bool = False
    exchanged: bool = False
    coming_from: bool = False

    @property
    def vectors(self) -> np.ndarray:
        """Wave-number vectors [component, 2]."""
        w = self.waves
        turn = -1.0 if self.coming_from else 1.0
        return turn * w.wavenumber[:, None] * np.column_stack([np.cos(w.angle), np.sin(w.angle)])

    def phasors(self, place: np.ndarray) -> np.ndarray:
        """A exp(i (omega t - k.x)) [time, component]."""
        w = self.waves
        t = w.dt * np.arange(w.n)
        return np.asarray(w.amplitude * np.exp(1j * (np.outer(t, w.omega) - self.vectors @ place[:2])))

    def pairs(self, sign: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Vector [m, n, 2] and length of k_m +- k_n, D and B, [m, n]."""
        w, vector = self.waves, self.vectors
        k, r, s = w.wavenumber, w.omega**2 / w.gravity, w.omega / np.sqrt(w.gravity)
        sech = (k / np.cosh(np.minimum(k * w.depth, 300.0))) ** 2  # k^2 - R^2
        both = vector[:, None] + sign * vector[None]
        length = np.sqrt((both**2).sum(axis=2))
        if self.scalar_norm:
            length = np.abs(k[:, None] + sign * k[None])
        dot = np.outer(k, k) if self.no_dot else vector @ vector.T
        inner = dot - (-sign if self.exchanged else sign) * np.outer(r, r)
        ss = s[:, None] + sign * s[None]
        above = ss * (s[None] * sech[:, None] + sign * s[:, None] * sech[None]) + 2.0 * ss**2 * inner
        below = ss**2 - length * np.tanh(length * w.depth)
        flat = ss == 0.0
        d = np.where(flat, 0.0, above / np.where(flat, 1.0, below))
        b = 0.25 * ((d - inner) / np.outer(s, s) + r[:, None] + r[None])
        return both, length, d, b

    def elevation(self, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """First- and second-order elevation [point, time]."""
        plus, minus = self.pairs(1)[3], self.pairs(-1)[3]
        v = [self.phasors(p) for p in place]
        return (
            np.array([p.real.sum(axis=1) for p in v]),
            np.array([((p @ plus * p) + (p @ minus * p.conj())).real.sum(axis=1) for p in v]),
        )

    def first(self, place: np.ndarray) -> np.ndarray:
        """u, v, w and their rates of the first order, Taylor expanded above still water [point, 6, time]."""
        w, out = self.waves, []
        k, d = w.wavenumber, w.depth
        unit = self.vectors / k[:, None]
        for p in place:
            z, above = min(p[2], 0.0), max(p[2], 0.0)
            up, down, scale = np.exp(k * z), np.exp(-k * (z + 2 * d)), 1.0 / (1.0 + np.exp(-2.0 * k * d))
            c, s = (up + down) * scale, (up - down) * scale
            v = self.phasors(p) * (w.gravity * k / w.omega)
            level = v * (c + above * k * s)
            channels = [level * unit[:, 0], level * unit[:, 1], 1j * v * (s + above * k * c)]
            out.append([q.real.sum(axis=1) for q in (*channels, *(1j * w.omega * q for q in channels))])
        return np.array(out)

    def second(self, place: np.ndarray) -> np.ndarray:
        """u, v, w and their rates of the second order, of still water above it [point, 6, time]."""
        w = self.waves
        b = 0.25 * w.gravity**2 / np.outer(w.omega, w.omega)
        out = np.zeros((len(place), 6, w.n))
        for sign in (1, -1):
            vector, length, d, _ = self.pairs(sign)
            rate = w.omega[:, None] + sign * w.omega[None]
            potential = b * np.where(rate == 0.0, 0.0, d / np.where(rate == 0.0, 1.0, rate))
            potential = potential / (1.0 + np.exp(-2.0 * length * w.depth))
            for p, here in enumerate(place):
                v = self.phasors(here)
                other, z = (v if sign > 0 else v.conj()), min(here[2], 0.0)
                up, down = np.exp(length * z), np.exp(-length * (z + 2.0 * w.depth))
                level = potential * (up + down)
                channels = [
                    level * vector[..., 0],
                    level * vector[..., 1],
                    1j * potential * length * (up - down),
                ]
                for i, factor in enumerate((*channels, *(1j * rate * q for q in channels))):
                    out[p, i] += np.einsum("tm,mn,tn->t", v, factor, other, optimize=True).real
        return out


def mistaken(**switches: bool) -> flow.Make:
    """Both sums with a mistake."""
    return lambda waves: BothSums(waves, **switches)


SCALAR, NO_DOT = mistaken(scalar_norm=True), mistaken(no_dot=True)
EXCHANGED, FROM = mistaken(exchanged=True), mistaken(coming_from=True)
LENGTHS = {"| |k_m| - |k_n| | for |k_m - k_n|": SCALAR}
MISTAKES = {
    "k_m k_n for the dot product": NO_DOT,
    "signs of R_m R_n exchanged": EXCHANGED,
}


def surface(condition: Callable[..., float]) -> Callable[[flow.Make], float]:
    """The worst residual of a condition of the free surface over the seas."""
    return lambda make: max(condition(make, waves, 7.3, -4.1) for waves in seas())


PLACE = flow.at((3.0, -7.0, -2.0), (-8.0, 4.0, -27.0), (0.0, 0.0, 2.5), (15.0, 1.0, -2.0), (2.0, 2.0, -50.0))


def different(got: flow.Flow, expected: flow.Flow, place: np.ndarray = PLACE) -> float:
    """Largest difference in elevation, either order, over the peak; channels that vanish need not agree."""
    pairs = [*zip(got.elevation(place), expected.elevation(place), strict=True)]
    worst = max(cases.relative(a, b) for a, b in pairs)
    for a, b in ((got.first(place), expected.first(place)), (got.second(place), expected.second(place))):
        for rows in (slice(0, 3), slice(3, 6)):
            worst = max(worst, cases.relative(a[:, rows], b[:, rows]))
    return worst


def double_sum(make: flow.Make) -> float:
    return max(different(make(waves), BothSums(waves)) for waves in seas())


def laplace(order: int) -> Callable[[flow.Make], float]:
    spans = ((-4.0, 0.0), (-50.0, -46.0))
    return lambda make: max(
        flow.potential_flow(make, crossing(), order=order, low=a, high=b) for a, b in spans
    )


@dataclass(frozen=True)
class Turned:
    """A field whose vectors are those of another one, turned by some angle about z."""

    inner: flow.Flow
    angle: float

    def elevation(self, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return self.inner.elevation(place)

    def _turn(self, motion: np.ndarray) -> np.ndarray:
        c, s, out = np.cos(self.angle), np.sin(self.angle), motion.copy()
        for u, v in ((0, 1), (3, 4)):
            out[:, u], out[:, v] = c * motion[:, u] - s * motion[:, v], s * motion[:, u] + c * motion[:, v]
        return out

    def first(self, place: np.ndarray) -> np.ndarray:
        return self._turn(self.inner.first(place))

    def second(self, place: np.ndarray) -> np.ndarray:
        return self._turn(self.inner.second(place))


def mirrored(waves: Waves) -> flow.Flow:
    """v of the other sign."""

    class Mirrored(Turned):
        def _turn(self, motion: np.ndarray) -> np.ndarray:
            return motion * np.array([1.0, -1.0, 1.0, 1.0, -1.0, 1.0])[:, None]

    return Mirrored(component_field(waves), 0.0)


@dataclass(frozen=True)
class Lifted:
    """A plane field along x as one of three axes."""

    plane: flow.Flow

    def elevation(self, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return self.plane.elevation(place)

    def _lift(self, motion: np.ndarray) -> np.ndarray:
        out = np.zeros((len(motion), 6, motion.shape[2]))
        out[:, [0, 2, 3, 5]] = motion
        return out

    def first(self, place: np.ndarray) -> np.ndarray:
        return self._lift(self.plane.first(place))

    def second(self, place: np.ndarray) -> np.ndarray:
        return self._lift(self.plane.second(place))


def long_crested(angle: Callable[[np.ndarray], np.ndarray]) -> float:
    """All components in one direction against the routes of long-crested seas, for 12 waves."""
    worst = 0.0
    for shift in (0.0, 0.231):
        waves = sea([m + shift for m in MULTIPLE], [0.0] * len(MULTIPLE))
        grid = frequency_grid(waves.omega, dt=waves.dt, n=waves.n, order=2)
        plane = DirectField(waves) if grid is None else GridField(waves, grid)
        turned = replace(waves, angle=angle(waves.omega))
        b = float(turned.angle[0])
        c, s = np.cos(b), np.sin(b)
        place = PLACE @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])  # along and across the waves
        expected = Turned(Lifted(plane), b)
        field = DirectionalField(turned)
        one = [*field.elevation(place), field.first(place), field.second(place)]
        other = [*expected.elevation(PLACE), expected.first(PLACE), expected.second(PLACE)]
        worst = max([worst, *(cases.relative(a, e) for a, e in zip(one, other, strict=True))])
    return worst


def rotation(vectors: float) -> float:
    """Sea and points turned by 1.234 rad: vectors turn by as much."""
    b = 1.234
    c, s = np.cos(b), np.sin(b)
    worst = 0.0
    for waves in (crossing(), off_grid()):
        field = component_field(replace(waves, angle=waves.angle + b))
        turned = Turned(component_field(waves), vectors)
        place = PLACE @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        pairs = [
            *zip(field.elevation(place), turned.elevation(PLACE), strict=True),
            (field.first(place), turned.first(PLACE)),
            (field.second(place), turned.second(PLACE)),
        ]
        worst = max([worst, *(cases.relative(a, e) for a, e in pairs)])
    return worst


def order_of_components(keep: Callable[[np.ndarray], np.ndarray]) -> float:
    """Components listed in another order; `keep` turns the order that the angles are listed in."""
    rng = np.random.default_rng(3)
    worst = 0.0
    for waves in (crossing(), off_grid()):
        order = rng.permutation(waves.omega.size)
        shuffled = replace(
            waves,
            omega=waves.omega[order],
            wavenumber=waves.wavenumber[order],
            amplitude=waves.amplitude[order],
            angle=waves.angle[keep(order)],
        )
        worst = max(worst, different(component_field(shuffled), component_field(waves)))
    return worst


def standing(make: flow.Make) -> float:
    """Two equal waves that meet, and the standing wave of Tadjbakhsh and Keller (1960), three depths.

    eta1 = A cos wt cos kx, eta2 = A^2 k / 8 [(T + 1/T) + (3 / T^3 - 1/T) cos 2wt] cos 2kx, T = tanh kd. The
    pair adds nothing that is the same everywhere; the set-down of either wave is that of its constant.
    """
    worst = 0.0
    x = np.array([0.0, 11.0, -37.0])
    place = np.column_stack([x, 3.0 * x, np.zeros(3)])
    for depth in (9.0, 50.0, 400.0):
        waves = replace(sea([6, 6], [0.0, 180.0], depth=depth), amplitude=np.array([0.5 + 0j, 0.5 + 0j]))
        k, t = waves.wavenumber[0], waves.dt * np.arange(waves.n)
        T = np.tanh(k * depth)
        steady, swing = T + 1.0 / T, 3.0 / T**3 - 1.0 / T
        expected = k / 8.0 * np.cos(2 * k * x)[:, None] * (steady + swing * np.cos(2 * waves.omega[0] * t))
        expected -= 0.25 * k / np.sinh(2.0 * k * depth)
        worst = max(worst, cases.relative(make(waves).elevation(place)[1], expected))
    return worst


@dataclass(frozen=True)
class Exact:
    """Both transfer functions in 150 digits, as printed: whatever cancels there does not matter."""

    depth: Decimal
    gravity: Decimal

    def tanh(self, x: Decimal) -> Decimal:
        q = (-2 * x).exp()
        return (1 - q) / (1 + q)

    def wavenumber(self, omega: Decimal, start: Decimal) -> Decimal:
        """Newton's method on g k tanh kd = omega^2."""
        k = start
        for _ in range(7):
            t = self.tanh(k * self.depth)
            miss = self.gravity * k * t - omega**2
            k -= miss / (self.gravity * (t + k * self.depth * (1 - t * t)))
        return k

    def cosine(self, angle: Decimal) -> Decimal:
        total, term = Decimal(1), Decimal(1)
        for j in range(2, 200, 2):
            term *= -angle * angle / (j * (j - 1))
            total += term
        return total

    def pair(self, k_m: float, k_n: float, omega_m: float, omega_n: float, angle: float) -> list[Decimal]:
        """D+, D-, B+, B-."""
        w_m, w_n = Decimal(omega_m), Decimal(omega_n)
        k, n = self.wavenumber(w_m, Decimal(k_m)), self.wavenumber(w_n, Decimal(k_n))
        r_m, r_n = w_m**2 / self.gravity, w_n**2 / self.gravity
        s_m, s_n, dot = r_m.sqrt(), r_n.sqrt(), k * n * self.cosine(Decimal(angle))
        d, b = [], []
        for sign in (1, -1):
            length, s = (k * k + n * n + 2 * sign * dot).sqrt(), s_m + sign * s_n
            inner = dot - sign * r_m * r_n
            above = s * (s_n * (k * k - r_m**2) + sign * s_m * (n * n - r_n**2)) + 2 * s * s * inner
            d.append(above / (s * s - length * self.tanh(length * self.depth)))
            b.append(((d[-1] - inner) / (s_m * s_n) + r_m + r_n) / 4)
        return [*d, *b]


def as_printed(k_m, k_n, omega_m, omega_n, angle, depth, gravity):  # type: ignore[no-untyped-def]
    """The transfer functions as printed, in double precision."""
    waves = replace(
        sea([4, 5], [0.0, 0.0], depth=depth),
        omega=np.array([omega_m, omega_n]),
        wavenumber=np.array([k_m, k_n]),
    )
    k, r, s = waves.wavenumber, waves.omega**2 / gravity, waves.omega / np.sqrt(gravity)
    found = []
    for sign in (1, -1):
        length = np.sqrt(k[0] ** 2 + k[1] ** 2 + 2 * sign * k[0] * k[1] * np.cos(angle))
        inner, ss = k[0] * k[1] * np.cos(angle) - sign * r[0] * r[1], s[0] + sign * s[1]
        above = (
            ss * (s[1] * (k[0] ** 2 - r[0] ** 2) + sign * s[0] * (k[1] ** 2 - r[1] ** 2)) + 2 * ss**2 * inner
        )
        d = above / (ss**2 - length * np.tanh(length * depth))
        found.append((d, 0.25 * ((d - inner) / (s[0] * s[1]) + r[0] + r[1])))
    return found[0][0], found[1][0], found[0][1], found[1][1]


def digits(pair: Callable[..., tuple[float, ...]]) -> float:
    """Largest relative error of D+-, B+-: deep and shallow water, pairs nearly equal and nearly opposite.

    B+ of opposite waves passes through zero: of B+- relative to (R_m + R_n) / 4 at least.
    """
    worst = 0.0
    for depth in (3.0, 50.0, 300.0):
        for omega_n, ratio in ((0.5, 1.001), (0.5, 1.7), (1.5, 1.001), (1.5, 1.3)):
            omega = omega_n * np.array([ratio, 1.0])
            k = wavenumber(omega, water_depth=depth, gravity=G)
            for angle in (0.0, 1e-3, 0.7, np.pi - 1e-3):
                with localcontext() as context:
                    context.prec = 150
                    exact = Exact(Decimal(depth), Decimal(G)).pair(*k.tolist(), *omega.tolist(), angle)
                got = pair(*k.tolist(), *omega.tolist(), angle, depth, G)
                least = float((omega**2).sum()) / (4.0 * G)
                for a, e, scale in zip(got, map(float, exact), (0.0, 0.0, least, least), strict=False):
                    worst = max(worst, abs(a - e) / max(abs(e), scale))
    return worst


PROOFS = (
    Proof(
        key="directional-kinematic",
        claim="kinematic condition of the free surface to second order, all directions",
        against="sum of its terms of order a^2; 12 waves, 4 depths, off the frequency grid, of one direction",
        error=surface(flow.kinematic),
        right=component_field,
        wrong=MISTAKES,
        allowed=1e-12,
        reason="round-off of the sum over pairs; no finite difference is involved",
    ),
    Proof(
        key="directional-dynamic",
        claim="dynamic condition of the free surface to second order, all directions",
        against="its gradient along x and y, the same seas",
        error=surface(flow.dynamic),
        right=component_field,
        wrong=MISTAKES,
        allowed=1e-12,
        reason="round-off of the sum over pairs; no finite difference is involved",
    ),
    *(
        Proof(
            key=f"directional-potential-flow-{name}",
            claim=f"continuity and no rotation in space, {name} order, all directions",
            against="Laplace, derivatives exact in x and y and spectral in z",
            error=laplace(order),
            right=component_field,
            wrong={"v of the other sign": mirrored} | (LENGTHS if order == 2 else {}),
            allowed=2e-11,
            reason="differentiation at 21 Chebyshev points multiplies round-off by about 1e3",
        )
        for order, name in ((1, "first"), (2, "second"))
    ),
    Proof(
        key="directional-double-sum",
        claim="short-crested field equals the double sum, above still water and at equal frequencies",
        against="Sharma and Dean's equations written out over all pairs; 12 waves, 4 depths, on and off grid",
        error=double_sum,
        right=component_field,
        wrong=LENGTHS | MISTAKES | {"directions that the waves come from": FROM},
        allowed=1e-11,
        reason="round-off; k^2 - R^2 cancels in neither",
    ),
    Proof(
        key="directional-one-direction",
        claim="equal directions give the long-crested field",
        against="its routes on and off the frequency grid, turned",
        error=long_crested,
        right=lambda omega: np.full(omega.size, 0.6),
        wrong={
            "one component 1e-6 rad astray": lambda omega: 0.6 + 1e-6 * (omega == omega[3]),
        },
        allowed=1e-12,
        reason="round-off",
    ),
    Proof(
        key="directional-rotation",
        claim="turning all directions and points turns the answer",
        against="rotation of the vectors by 1.234 rad, on and off the frequency grid",
        error=rotation,
        right=1.234,
        wrong={"vectors not turned": 0.0, "turned clockwise": -1.234},
        allowed=1e-12,
        reason="round-off",
    ),
    Proof(
        key="directional-order-of-components",
        claim="the order of the components changes nothing",
        against="the same components permuted, on and off the frequency grid",
        error=order_of_components,
        right=lambda order: order,
        wrong={"directions not permuted with them": np.sort},
        allowed=1e-12,
        reason="components of one frequency may be summed in another order",
    ),
    Proof(
        key="standing-wave",
        claim="two opposite waves of one frequency stand",
        against="second-order elevation of Tadjbakhsh and Keller (1960) at 3 depths",
        error=standing,
        right=component_field,
        wrong=LENGTHS | MISTAKES,
        allowed=1e-12,
        reason="round-off",
    ),
    Proof(
        key="directional-digits",
        claim="transfer functions lose no digits: deep, shallow, nearly equal, nearly opposite",
        against="the printed formulas in 150 digits; frequencies 0.1 % and directions 1e-3 rad apart",
        error=digits,
        right=transfer_pair,
        wrong={"as printed, in double precision": as_printed},
        allowed=1e-11,
        reason="wave numbers 0.1 % apart, each known to 2e-16, and a denominator of their difference",
    ),
)
