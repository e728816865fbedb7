// One image of both worlds and all plots, with the verdict and the setting, at twice the screen's resolution.
import { sharpCanvas, type Sheet } from "../support/dom";
import { drawGraph, graphs } from "./graphs";
import type { Facts } from "./facts";
import { sentences } from "./sentences";
import { toQuery } from "./setting";
import type { GasTheme } from "./worlds";

const [width, height] = [1600, 1000];

// Writes a text in lines of this width; returns the place below.
function write(g: CanvasRenderingContext2D, text: string, x: number, y: number, most: number, line: number): number {
  let row = "";
  for (const word of text.split(" ")) {
    if (row && g.measureText(`${row} ${word}`).width > most) {
      g.fillText(row, x, y);
      y += line;
      row = word;
    } else row = row ? `${row} ${word}` : word;
  }
  g.fillText(row, x, y);
  return y + line;
}

export function picture(facts: Facts, worlds: Sheet[], theme: GasTheme): HTMLCanvasElement {
  const [canvas, g] = sharpCanvas(width, height);
  g.fillStyle = theme.ground;
  g.fillRect(0, 0, width, height);
  g.fillStyle = theme.ink;
  g.font = `600 24px ${theme.font}`;
  g.fillText("May events replace Newton’s equations here?", 20, 36);
  const side = 480;
  worlds.forEach(({ canvas: world }, i) => {
    const [w, h] = [world.width, world.height];
    const own = Math.min(w, h);
    g.font = `600 18px ${theme.font}`;
    g.fillStyle = i === 0 ? theme.icm : theme.newton;
    g.fillText(i === 0 ? "Event-driven" : "Newton", 20 + i * (side + 20), 70);
    g.drawImage(world, (w - own) / 2, (h - own) / 2, own, own, 20 + i * (side + 20), 80, side, side);
  });
  g.fillStyle = theme.ink;
  let y = 600;
  for (const topic of ["verdict", "mean", "law", "forecast", "spins", "hard", "newton"]) {
    const sentence = sentences(facts).find((s) => s.topic === topic);
    g.font = `${topic === "verdict" ? 600 : 400} 19px ${theme.font}`;
    if (sentence) y = write(g, sentence.text, 20, y, 2 * side, 26) + 6;
  }
  g.fillStyle = theme.muted;
  g.font = `400 15px ${theme.font}`;
  write(g, `hardlimit, gas.html?${toQuery(facts.start.setting)}`, 20, height - 20, 2 * side, 20);
  const shown = graphs.filter((graph) => graph !== (facts.start.setting.friction > 0 ? "share" : "ratio"));
  const each = (height - 20) / shown.length;
  shown.forEach((graph, i) => {
    const [sheet, own] = sharpCanvas(560, each);
    drawGraph(own, 560, each, graph, facts, theme, i === shown.length - 1);
    g.drawImage(sheet, 1030, 10 + i * each, 560, each);
  });
  return canvas;
}
