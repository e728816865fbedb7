# a shaken box of facets with a lid
from yade import geom, plot

material = O.materials.append(FrictMat(young=1e7, poisson=0.3, density=2500))
ids = O.bodies.append(geom.facetBox((0, 0, 0), (0.02, 0.02, 0.02), material=material))
O.bodies.append([sphere((0, 0, 0.004 * k), 1.5e-3, material=material) for k in range(4)])
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Facet_Aabb()]),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom(), Ig2_Facet_Sphere_ScGeom()],
        [Ip2_FrictMat_FrictMat_MindlinPhys(betan=0.1)],
        [Law2_ScGeom_MindlinPhys_Mindlin()],
    ),
    HarmonicMotionEngine(A=(0, 0, 1e-3), f=(0, 0, 50), fi=(0, 0, 0), ids=ids),
    NewtonIntegrator(damping=0, gravity=(0, 0, -9.81)),
]
O.dt = 4e-7
plot.plots = {"t": ("z",)}
O.run(1000, True)
