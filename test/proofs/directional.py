"""Components of different directions, to second order: free surface, double sum, limits, symmetries."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from owt_wave_node.core.direct import DirectField
from owt_wave_node.core.directional import DirectionalField
from owt_wave_node.core.field import GridField
from owt_wave_node.core.grid import frequency_grid
from owt_wave_node.core.route import component_field
from owt_wave_node.core.sea import Waves
from proofs import cases, flow
from proofs.crossing import MULTIPLE, BothSums, crossing, off_grid, sea, seas
from proofs.registry import Proof

__all__ = ["PROOFS", "BothSums", "sea"]


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
)
