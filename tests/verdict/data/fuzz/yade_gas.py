# a cooling gas in a periodic box
from yade import pack

radius, e = 1e-3, 0.8
grain = O.materials.append(FrictMat(young=2e7, poisson=0.3, density=2500, frictionAngle=0.3, label="grain"))
O.periodic = True
cloud = pack.SpherePack()
cloud.makeCloud((0, 0, 0), (0.04, 0.04, 0.04), rMean=radius, rRelFuzz=0.1, periodic=True)
O.bodies.append([sphere(centre, r, material=grain) for centre, r in cloud])
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb()]),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom()],
        [Ip2_FrictMat_FrictMat_MindlinPhys(en=e, es=e)],
        [Law2_ScGeom_MindlinPhys_Mindlin()],
    ),
    NewtonIntegrator(damping=0.0),
]
O.dt = 0.1 * PWaveTimeStep()
O.run(5000, True)
