# a bottom of larger spheres that do not move
O.materials.append(ViscElMat(tc=1e-3, en=0.7, et=1.0, density=2500))
for x in range(3):
    O.bodies.append(sphere((0.01 * x, 0, 0), 6e-3, fixed=True))
grains = [O.bodies.append(sphere((0.01 * x, 0, 0.02), 2e-3)) for x in range(3)]
last = O.bodies.append(sphere((0, 0, 0.05), 4e-3))
O.bodies[last].dynamic = False
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb()]),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom()], [Ip2_ViscElMat_ViscElMat_ViscElPhys()], [Law2_ScGeom_ViscElPhys_Basic()]
    ),
    NewtonIntegrator(damping=0),
]
O.dt = 1e-5
O.run(3000, True)
