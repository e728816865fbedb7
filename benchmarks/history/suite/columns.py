"""One column: the time of a solve, Python included, and of a trajectory."""

import hardlimit as hl

LAWS = {
    "linear": hl.LinearDashpot(stiffness=5e7, restitution=0.7),
    "viscoelastic": hl.Viscoelastic(
        youngs_modulus=6e9, poisson_ratio=0.45, restitution=0.7, impact_speed=3.0
    ),
}


class Drop:
    """The drop of Fig. 2 under each model that the law allows."""

    params = (list(LAWS), ["newton", "general", "independent"])
    param_names = ("law", "model")

    def setup(self, law: str, model: str) -> None:
        self.column = hl.Column.paper(law=LAWS[law])
        self.solve = {
            "newton": hl.newton,
            "general": lambda column: hl.newton(column, method="general"),
            "independent": hl.independent,
        }[model]

    def time_solve(self, law: str, model: str) -> None:
        self.solve(self.column)


class Trajectory:
    """Positions, forces and energies at a thousand times."""

    def setup(self) -> None:
        self.result = hl.newton(hl.Column.paper())

    def time_trajectory(self) -> None:
        self.result.trajectory()


class Stack:
    """Many balls, integrated."""

    params = (3, 6, 12)
    param_names = ("balls",)

    def setup(self, balls: int) -> None:
        self.column = hl.Column([hl.Ball(0.01, density=840.0)] * balls, 1e-4, 0.1, LAWS["linear"])

    def time_newton(self, balls: int) -> None:
        hl.newton(self.column)
