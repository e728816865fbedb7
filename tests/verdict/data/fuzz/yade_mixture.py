# a matrix of restitutions, two packings, walls
from yade import pack

a, b = O.materials.append([FrictMat(young=1e7, poisson=0.2, density=d) for d in (2000, 3000)])
region = pack.inAlignedBox((0, 0, 0), (0.1, 0.1, 0.1))
O.bodies.append(pack.regularHexa(region, radius=2e-3, gap=1e-4, material=a))
O.bodies.append(pack.regularOrtho(region, radius=3e-3, gap=1e-4, material=b))
O.bodies.append(wall(-0.01, axis=2, material=a))
restitution = MatchMaker(matches=((a, a, 0.9), (a, b, 0.7), (b, b, 0.6)))
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()]),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom(hertzian=True)],
        [Ip2_FrictMat_FrictMat_MindlinPhys(en=restitution)],
        [Law2_ScGeom_MindlinPhys_Mindlin()],
    ),
    NewtonIntegrator(damping=0),
]
O.dt = 5e-7
O.run(100)
