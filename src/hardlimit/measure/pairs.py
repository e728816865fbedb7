"""Structure of a state: radial distribution function, coordination number and rattlers."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from ..boxes.box import UNIT_BALL, Floats
from ..boxes.contacts import checked_system
from ..boxes.system import ROUNDING, ParticleSystem
from ..support import validation
from .labelled import array, checked_bins, variable

#: Default of ``r_max`` in mean radii, if the box allows it.
RANGE: Final = 10.0


def rdf(
    system: ParticleSystem, *, bins: int = 100, r_max: float | None = None, r_min: float = 0.0
) -> xr.DataArray:
    """Radial distribution function g(r) over ``bin_centers`` [m].

    g is the number of pairs at distance r over that of independent particles, which are uniform in the box: for an
    ideal gas it is 1, also between walls. Particles of different sizes count alike.

    Parameters
    ----------
    system : ParticleSystem
    bins : int
        Number of equal bins.
    r_max : float [m], optional
        At most half of each periodic edge, and the distance L that centres can have between two walls, the edge less
        the mean diameter. By default this limit, or ten mean radii if that is less.
    r_min : float [m]
        Lower end of the first bin. Start at a diameter to find the value at contact.

    Raises
    ------
    ValueError
        If a value is outside its range, or the system has fewer than two particles.

    Notes
    -----
    Names are those of freud (Ramasubramani et al., Comput. Phys. Commun. 254, 107275 (2020)). Between walls the
    displacement r from a random point stays inside with the probability Π (1 − abs(r_k)/L_k), the product over the
    walled axes. Its mean over all directions n is a polynomial in r up to the smallest L_k, because the mean of
    Π abs(n_k) over m axes is Γ(d/2)/(π^(m/2) Γ((d + m)/2)). It is integrated exactly over each bin. Walls that move
    count where they are. For unequal particles L_k is that of the mean diameter; the error is of the order of
    (spread of radii)²/(r L).

    Examples
    --------
    >>> box = hl.ParticleSystem.random(
    ...     500, 0.3, radius=1e-3, density=2500.0, rms_speed=1.0
    ... )
    >>> g = hl.measure.rdf(box, bins=50)
    >>> (
    ...     g.dims,
    ...     g.bin_centers.attrs["units"],
    ...     g.sel(bin_centers=1e-3, method="nearest").item(),
    ... )
    (('bin_centers',), 'm', 0.0)
    """
    from scipy.spatial import cKDTree

    if checked_system(system).n < 2:
        raise ValueError("system: got one particle, must be at least two")
    between_walls = np.array([side == "wall" for side in system.boundary])
    # Lengths of the region of the centres.
    edges_now = np.diff([system.domain.limits(axis) for axis in range(system.dimension)])[:, 0]
    lengths = edges_now - np.where(between_walls, 2.0 * system.radius.mean(), 0.0)
    limit = float(np.where(between_walls, lengths, 0.5 * lengths).min())
    least = validation.number("r_min", r_min, 0.0, limit, lowest_allowed=True)
    default = min(limit, max(RANGE * float(system.radius.mean()), 2.0 * least))
    most = default if r_max is None else validation.number("r_max", r_max, least, limit, highest_allowed=True)
    edges = np.linspace(least, most, checked_bins(bins) + 1)
    points, _, boxsize = _with_images(system, system.positions, most)
    tree, images = (cKDTree(part, boxsize=boxsize) for part in (points[: system.n], points[system.n :]))
    pairs = 0.5 * np.diff(_cumulative(tree, tree, edges)) + np.diff(_cumulative(tree, images, edges))
    expected = 0.5 * system.n * (system.n - 1) * np.diff(_share(edges, lengths, between_walls))
    if not (expected > 0.0).all():
        raise ValueError(
            f"r_max: got {most!r} with r_min {least!r}, must be so much larger that every bin has a volume"
        )
    return array(
        "rdf",
        "bin_centers",
        pairs / expected,
        "1",
        "radial distribution function g",
        bin_centers=variable("bin_centers", 0.5 * (edges[1:] + edges[:-1]), "m", "distance of centres"),
    )


def _cumulative(tree: Any, other: Any, edges: Floats) -> Floats:
    """Number of pairs of a point of each tree up to each distance."""
    return np.asarray(tree.count_neighbors(other, edges), float)


def _with_images(
    system: ParticleSystem, positions: Floats, reach: float, time: float = 0.0
) -> tuple[Floats, NDArray[np.int64], Floats]:
    """Points, the particle of each, and the periods for a search tree (0: none).

    Behind the particles stand the images of the lowest ones beyond the far side of a sheared box, as far as ``reach``.
    """
    periodic, box = np.array(system.domain.periodic), system.box
    points = np.where(periodic, positions % box, positions)  # an edge is its own image
    index = np.arange(system.n)
    if (axis := system.domain.gradient) is not None:
        low = np.flatnonzero(points[:, axis] <= reach)
        images = points[low]
        images[:, axis] += box[axis]
        images[:, 0] = (images[:, 0] + system.domain.displacement_after(time)) % box[0]
        points, index = np.concatenate([points, images]), np.concatenate([index, low])
    return points, index, np.where(periodic, box, 0.0)


def _share(r: Floats, lengths: Floats, between_walls: NDArray[np.bool_]) -> Floats:
    """Share of the pairs of independent particles that are closer than r."""
    d = len(lengths)
    product = Polynomial([1.0])
    for length in lengths[between_walls]:
        product *= Polynomial([1.0, -1.0 / length])
    moments = [
        math.gamma(0.5 * d) / (math.pi ** (0.5 * m) * math.gamma(0.5 * (d + m))) for m in range(len(product))
    ]
    shell = Polynomial([0.0] * (d - 1) + [d * UNIT_BALL[d]]) / float(np.prod(lengths))
    share: Floats = (shell * Polynomial(product.coef * moments)).integ()(r)
    return share


def coordination(system: ParticleSystem, *, tolerance: float = ROUNDING) -> xr.Dataset:
    """Coordination number and rattlers.

    Two particles, or a particle and a wall, are in contact if their gap is at most ``tolerance`` times the sum of the
    radii (at a wall, the radius). A rattler has fewer than d + 1 contacts with particles that are no rattlers and with
    walls; its contacts are removed until no further rattler appears. The rest is the backbone.

    Parameters
    ----------
    system : ParticleSystem
    tolerance : float
        In [0, 1]. The default allows for rounding errors. Moving hard spheres touch only at collisions: use a small
        gap, such as 1e-3.

    Returns
    -------
    Dataset
        ``coordination``, the mean number of contacts of a particle; ``backbone_coordination``, that of the backbone
        without rattlers (NaN if all are rattlers); ``rattlers``, the fraction of rattlers; over ``particle``,
        ``contacts`` and ``rattler``.

    Raises
    ------
    ValueError
        If a value is outside its range.

    Notes
    -----
    O'Hern, Silbert, Liu & Nagel, Phys. Rev. E 68, 011306 (2003) remove rattlers in the same way.
    """
    checked_system(system)
    allowed = validation.number("tolerance", tolerance, 0.0, 1.0, lowest_allowed=True, highest_allowed=True)
    n, d = system.n, system.dimension
    first, second = touching(system, allowed)
    on_walls = np.zeros(n, int)
    for _, axis, upper in system.domain.walls():
        x, wall = system.positions[:, axis], system.domain.limits(axis)[upper]
        gap = np.abs(x - wall) - system.radius
        on_walls += gap <= allowed * system.radius

    def counted(kept: NDArray[np.bool_]) -> NDArray[np.int64]:
        both = kept[first] & kept[second]
        ends = np.concatenate([first[both], second[both]])
        return np.asarray(np.bincount(ends, minlength=n) + on_walls * kept)

    contacts = counted(np.ones(n, bool))
    backbone, counts = np.ones(n, bool), contacts
    while (loose := backbone & (counts < d + 1)).any():
        backbone &= ~loose
        counts = counted(backbone)
    mean = float(counts[backbone].mean()) if backbone.any() else math.nan
    return xr.Dataset(
        {
            "coordination": variable((), contacts.mean(), "1", "mean number of contacts of a particle"),
            "backbone_coordination": variable((), mean, "1", "mean number of contacts without rattlers"),
            "rattlers": variable((), 1.0 - backbone.mean(), "1", "fraction of rattlers"),
            "contacts": variable("particle", contacts, "1", "number of contacts"),
            "rattler": variable("particle", ~backbone, "1", "whether the particle is a rattler"),
        }
    )


def touching(system: ParticleSystem, tolerance: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Pairs whose gap is at most ``tolerance`` times the sum of the radii."""
    return near(system, system.positions, 1.0 + tolerance)


def near(
    system: ParticleSystem, positions: Floats, factor: float, time: float = 0.0
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Pairs with a distance of at most ``factor`` times the sum of the radii, at positions in the box at a time [s]."""
    from scipy.spatial import cKDTree

    # A little more than the reach, because the tree rounds; the exact condition follows.
    reach = 2.0 * factor * (1.0 + 1e-9) * float(system.radius.max())
    points, index, period = _with_images(system, positions, reach, time)
    first, second = cKDTree(points, boxsize=period).query_pairs(reach, output_type="ndarray").T
    apart = points[first] - points[second]
    apart -= system.box * np.round(apart / system.box) * (period > 0.0)
    distance = np.sqrt(np.einsum("ij,ij->i", apart, apart))
    close = distance <= factor * (system.radius[index[first]] + system.radius[index[second]])
    close &= np.minimum(first, second) < system.n  # not of two images
    low, high = np.sort(np.stack([index[first[close]], index[second[close]]]), axis=0)
    codes = np.unique(low * system.n + high)  # once, even if an image in a sheared box is close too
    return codes // system.n, codes % system.n
