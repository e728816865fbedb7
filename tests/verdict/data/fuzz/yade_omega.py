# the scene under another name, spheres of a cloud one by one
from yade.pack import SpherePack as Cloud

o = Omega()
mat = ViscElMat(kn=4e4, ks=1e4, cn=0.5, cs=0, density=1500, frictionAngle=0.5)
o.materials.append(mat)
cloud = Cloud()
cloud.makeCloud((0, 0, 0), (0.1, 0.1, 0.1), rMean=2e-3, rRelFuzz=0.3)
for centre, r in cloud:
    o.bodies.append(sphere(centre, 1.5 * r, material=mat))
o.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb()]),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom()], [Ip2_ViscElMat_ViscElMat_ViscElPhys()], [Law2_ScGeom_ViscElPhys_Basic()]
    ),
    NewtonIntegrator(damping=0.05),
]
o.dt = 2e-5
o.run(200)
