# two kinds of grains and the engines that YADE has at its start
heavy = O.materials.append(FrictMat(young=3e7, density=7800, label="heavy"))
light = O.materials.append(FrictMat(young=3e7, density=900, label="light"))
for material in heavy, light:
    O.bodies.append([sphere((k, 0, material), 4e-3, material=material) for k in range(3)])
newton.damping = 0.15
newton.gravity = (0, 0, -1.62)
O.dynDt = False
O.dt = 3e-6
O.run(500, True)
