"""Contacts and stages of YADE scenes that are built by hand, without a script."""

import math

import pytest

from hardlimit.checking.scripts.description import Quote
from hardlimit.checking.scripts.motion import STEADY, UNKNOWN
from hardlimit.checking.scripts.python import Instance
from hardlimit.checking.scripts.yade_contacts import Contacts
from hardlimit.checking.scripts.yade_numbers import Contact
from hardlimit.checking.scripts.yade_scene import Body, Scene
from hardlimit.checking.scripts.yade_stages import damping, motion, pressure, weight


def made(name, *arguments, **attributes):
    return Instance(name, arguments, attributes, 1, name)


def scene(*engines, bodies=(), young=(1e7,)):
    """A scene with these engines and bodies, and a material of each modulus."""
    materials = [made("FrictMat", young=modulus, label=f"m{k}") for k, modulus in enumerate(young)]
    return Scene("", False, False, [], materials, list(bodies), engines=list(engines), engines_given=True)


def body(kind, material, frozen=False):
    return Body(kind, (1e-3, 1e-3), material, frozen, Quote("", 1, kind), several=True)


@pytest.mark.parametrize("size", [1.0, 2.0, 1e8])
def test_a_sphere_and_a_wall_are_two_springs_in_series(size):
    contact = Contact(scene(young=(1e7, 3e6)), made("Ip2_FrictMat_FrictMat_FrictPhys"), (0, 1), size, "walls")

    def in_series(first, second):
        return 1.0 / (1.0 / (2.0 * first) + 1.0 / (2.0 * second * size))

    modulus = contact.mean_modulus(contact.both("young"))
    assert in_series(modulus, modulus) == pytest.approx(in_series(1e7, 3e6), rel=1e-12)


def test_grains_that_move_meet_all_bodies_of_a_known_shape():
    functors = [made("Ip2_FrictMat_FrictMat_FrictPhys"), made("Law2_ScGeom_FrictPhys_CundallStrack")]
    names = [(f"Bo1_{shape}_Aabb", f"Ig2_{shape}_Sphere_ScGeom") for shape in ("Sphere", "Wall")]
    shapes = [made(name) for pair in names for name in pair]
    bodies = [
        body("sphere", 0),
        body("sphere", 1, frozen=True),
        body("walls", 1, True),
        body("boxes", 1, True),
    ]
    built = scene(*functors, *shapes, bodies=bodies, young=(1e7, 1e7))
    contacts = [(contact.types, contact.wall) for contact in Contacts(built).settings()]
    assert contacts == [(("m0", "m0"), None), (("m0", "m1"), None), (("m0", "wall"), "walls")]
    assert [note.what for note in built.ignored] == ["boxes without contacts: no Ig2_Box_Sphere_…"]


def test_engines_give_gravity_damping_pressure_and_motion():
    integrator = made("NewtonIntegrator", 0.3, gravity=(0.0, -3.0, 4.0))
    press = made("PeriTriaxController", goal=(-1e3, -2e3, 0.1), stressMask=3)
    built = scene(integrator, press)
    assert weight(built) == (5.0, (0.0, -0.6, 0.8))
    assert (damping(built), pressure(built), motion(built, None)) == (0.3, 1.5e3, None)
    turning = made("RotationEngine", rotationAxis=(0.0, 0.0, 2.0), angularVelocity=math.pi)
    assert motion(scene(turning), None).turning == (0.0, 0.0, math.pi)
    assert motion(scene(made("HelixEngine")), None) == STEADY
    assert motion(scene(turning, made("StepDisplacer")), None) == UNKNOWN


def test_gravity_that_is_not_known_is_quoted():
    built = scene(made("NewtonIntegrator", gravity="g"))
    assert weight(built) == (None, None)
    assert [quote.text for quote in built.unknown] == ["NewtonIntegrator"]
