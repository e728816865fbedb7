"""Fig. 3 of the paper as ``hardlimit paper`` draws it, without the caption; pages that show it have their own."""

import driver

from hardlimit.paper import figure3
from hardlimit.paper.setup import Paper
from hardlimit.plots.style import style


def draw():
    with style():
        return {"fig3.png": figure3.draw(figure3.compute(Paper()))}


if __name__ == "__main__":
    driver.main(driver.Study(file=__file__, draw=draw, dpi=200), __doc__)
