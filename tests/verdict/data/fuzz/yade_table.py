# parameters of a table for yade-batch
readParamsFromTable(noTableOk=True, stiffness=2e6, e=0.6, steps=40)
from yade.params.table import *

O.materials.append(ViscElMat(young=stiffness, en=e, et=e, density=2500))
O.bodies.append([sphere((0, 0, 0.005 * k), 2e-3) for k in range(3)])
O.bodies.append(facet([(-1, -1, -0.01), (1, -1, -0.01), (0, 2, -0.01)]))
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Facet_Aabb()]),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom(), Ig2_Facet_Sphere_ScGeom()],
        [Ip2_ViscElMat_ViscElMat_ViscElPhys()],
        [Law2_ScGeom_ViscElPhys_Basic()],
    ),
    NewtonIntegrator(damping=0),
]
mass = 4 / 3 * pi * 2e-3**3 * 2500
O.dt = sqrt(mass / (stiffness * 2e-3)) / steps
O.saveTmp()
O.run(1000, True)
