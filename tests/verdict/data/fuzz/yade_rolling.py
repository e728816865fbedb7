# rolling resistance without cohesion, above a box
wheel = CohFrictMat(young=5e7, density=2600, isCohesive=False, momentRotationLaw=True, etaRoll=0.1, label="wheel")
floor = FrictMat(young=1e9, density=2600, label="floor")
O.materials.append([wheel, floor])
O.bodies.append(box((0, 0, -0.01), (0.1, 0.1, 0.01), fixed=True, material="floor"))
O.bodies.append([sphere((0.01 * k, 0, 0.01), 3e-3, material="wheel") for k in range(4)])
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Box_Aabb()]),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom6D(), Ig2_Box_Sphere_ScGeom()],
        [Ip2_CohFrictMat_CohFrictMat_CohFrictPhys(), Ip2_FrictMat_FrictMat_FrictPhys()],
        [Law2_ScGeom6D_CohFrictPhys_CohesionMoment(), Law2_ScGeom_FrictPhys_CundallStrack()],
    ),
    NewtonIntegrator(damping=0.3, gravity=(0, 0, -9.81)),
]
O.dt = 0.3 * utils.PWaveTimeStep()
O.run(2000, True)
