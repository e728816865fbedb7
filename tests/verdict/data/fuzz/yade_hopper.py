# grains from a factory fall into a hopper
from yade import geom

steel = O.materials.append(ViscElMat(tc=2e-4, en=0.5, et=0.5, density=7800, frictionAngle=0.2, label="steel"))
glass = O.materials.append(ViscElMat(tc=1e-4, en=0.8, et=0.8, density=2500, frictionAngle=0.4, label="glass"))
O.bodies.append(geom.facetCylinder((0, 0, 0.05), radius=0.03, height=0.1, material=steel))
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Facet_Aabb()]),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom(), Ig2_Facet_Sphere_ScGeom()],
        [Ip2_ViscElMat_ViscElMat_ViscElPhys()],
        [Law2_ScGeom_ViscElPhys_Basic()],
    ),
    CircularFactory(rMin=1e-3, rMax=2e-3, materialId=glass, radius=0.02, center=(0, 0, 0.1)),
    NewtonIntegrator(damping=0, gravity=(0, 0, -9.81), label="newton"),
]
O.dt = 2e-6
O.run(1000, True)
newton.damping = 0.1
O.run(1000, True)
