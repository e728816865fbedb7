// One image of all plots, at twice the screen's resolution, with the parameters below.
import { clockText, drawMoment } from "../views/film";
import { drawForces } from "../views/forces";
import { sharpCanvas } from "../support/dom";
import { withUnit } from "../support/format";
import type { MapPanel } from "../map/map_panel";
import { joined } from "../support/sentence";
import { constantAt, constants, constantsOf, type Scenario } from "../scenario/scenario";
import type { State } from "../state/state";
import type { Timeline } from "../views/timeline";

export function picture(state: State, timeline: Timeline, map: MapPanel): HTMLCanvasElement {
  const [width, height] = [1600, 1200];
  const [canvas, g] = sharpCanvas(width, height);
  const { theme } = state;
  g.fillStyle = theme.ground;
  g.fillRect(0, 0, width, height);
  const d = state.drop!;
  const part = (x: number, y: number, w: number, h: number, draw: (g: CanvasRenderingContext2D) => void): void => {
    const [sheet, own] = sharpCanvas(w, h);
    draw(own);
    g.drawImage(sheet, x, y, w, h);
  };
  part(20, 96, 770, 540, (own) => void drawMoment(own, 770, 540, state));
  part(820, 96, 760, 540, (own) => void drawForces(own, 760, 540, d, theme));
  part(20, 656, 770, 460, (own) => void timeline.draw(own, 770, 460, d, theme));
  part(820, 656, 760, 460, (own) => void map.paint(own, 760, 460, theme));
  g.textBaseline = "alphabetic";
  g.font = `600 26px ${theme.font}`;
  const { report } = state;
  g.fillStyle = theme.newton;
  g.fillText(joined(report!.newton), 20, 36);
  g.fillStyle = theme.icm;
  g.fillText(joined(report!.icm), 20, 70);
  g.font = `400 17px ${theme.font}`;
  g.fillStyle = theme.muted;
  g.fillText(`${parameters(state.scenario)}; pictured at t = ${clockText(state.time(), d)}`, 20, 1150);
  g.fillText("hardlimit, after Müller & Pöschel, Phys. Rev. E 83, 041304 (2011)", 20, 1178);
  return canvas;
}

export function parameters(s: Scenario): string {
  const radii = s.balls.map((b) => withUnit(b.radius, "m")).join(", ");
  const gaps = s.gaps.map((x) => withUnit(x, "m")).join(", ");
  const law = constantsOf(s)
    .map(
      (name) =>
        `${constants[name].symbol} = ` +
        `${[...new Set(s.balls.map((_, i) => withUnit(constantAt(s, name, i), constants[name].range.unit)))].join(" and ")}`,
    )
    .join(", ");
  return (
    `ε = ${s.restitution}, radii ${radii}, gaps ${gaps}, ` +
    `${s.cradle ? "cradle" : `height ${withUnit(s.height, "m")}`}, ${law}`
  );
}
