// The curve of rebound heights and the map as CSV files.
import type { CurvePoint } from "../views/rebound";
import { axes, stiffnessOf, type MapAxis } from "../scenario/axes";
import { settingLines, type Scenario } from "../scenario/scenario";
import type { CurveAxis } from "../scenario/story_view";
import { answers } from "../core/core";
import { csvText } from "../support/csv";

// "gap_m": the name of an axis with its unit, in letters that every program reads.
const columnName = (s: Scenario, axis: MapAxis): string =>
  [{ e: "restitution", gap: "gap", ratio: "radius_ratio", k: stiffnessOf(s), mass: "mass_ratio", h: "height" }[axis]]
    .concat(axes[axis].unit(s) === "" ? [] : [axes[axis].unit(s).replace("/", "_per_")])
    .join("_");

// Gap 0 comes first.
export function curveCsv(s: Scenario, axis: CurveAxis, points: CurvePoint[], touching: CurvePoint | null): string {
  const quantity = s.cradle ? "last_ball_velocity_m_per_s" : "top_ball_height_m";
  return csvText(
    [...settingLines(s), `${columnName(s, axis)} is varied; its value above is that of the setting`],
    [columnName(s, axis), `newton_${quantity}`, `icm_${quantity}`],
    [...(touching ? [touching] : []), ...points].map((p) => [p.x, p.newton, p.icm]),
  );
}

// `tolerance`: of the verdict; null: the map has none.
export function mapCsv(s: Scenario, across: MapAxis, up: MapAxis, tolerance: number | null, rows: number[][]): string {
  const verdict = tolerance !== null;
  const values = ["newton_contacts", "effective_over_restitution", "separation_over_restitution"];
  return csvText(
    [
      ...settingLines(s),
      `${columnName(s, across)} and ${columnName(s, up)} are varied; their values above are those of the setting`,
      "newton_contacts = nan: the lowest ball cannot fall, or Newton's equations have no answer",
      ...(verdict ? [`answer, to ${tolerance}: ${answers.map((name, i) => `${i} ${name}`).join(", ")}`] : []),
    ],
    [columnName(s, across), columnName(s, up), ...values, ...(verdict ? ["answer", "relative_error"] : [])],
    verdict ? rows : rows.map((row) => row.slice(0, 5)),
  );
}
