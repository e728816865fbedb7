# numbers from the command line, in functions
import argparse
import sys

parser = argparse.ArgumentParser()
parser.add_argument("--restitution", type=float, default=0.9)
given = parser.parse_args()
try:
    scale = float(sys.argv[2])
except IndexError:
    scale = 0.2


def bodies(radius, density=2500):
    material = O.materials.append(FrictMat(young=1e8, poisson=0.25, density=density))
    O.bodies.append([sphere((0, 0, 3 * radius * k), radius, material=material) for k in range(5)])


def engines(e):
    O.engines = [
        ForceResetter(),
        InsertionSortCollider([Bo1_Sphere_Aabb()]),
        InteractionLoop(
            [Ig2_Sphere_Sphere_ScGeom()],
            [Ip2_FrictMat_FrictMat_MindlinPhys(en=e)],
            [Law2_ScGeom_MindlinPhys_Mindlin()],
        ),
        NewtonIntegrator(damping=0.0),
    ]


if __name__ == "__main__":
    bodies(radius=5e-3)
    engines(given.restitution)
    O.dt = (float(sys.argv[1]) if len(sys.argv) > 1 else 0.5) * scale * PWaveTimeStep()
    O.run(100, True)
