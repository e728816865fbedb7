// This setting as a program for Python and as a command for a terminal.
import { constantAt, GRAVITY, hasOwn, lawOf, type Scenario, toToml } from "./scenario";
import { inPercent, usualTolerance } from "./tolerance";

const parametersOf = (s: Scenario, contact: number): [string, number][] =>
  lawOf(s).parameters.map((p) => [p.name, p.name === "restitution" ? s.restitution : constantAt(s, p.name, contact)]);

const list = (items: string[]): string => `[${items.join(", ")}]`;
// The classes of Python; a law without an entry has its name there.
const classes: Record<string, string> = { linear: "LinearDashpot", viscoelastic: "Viscoelastic", tsuji: "Tsuji" };
const classOf = (law: string): string => classes[law] ?? `LAWS["${law}"]`;

const shown = (s: Scenario): string[] =>
  ["newton", "independent"].map((model) => `result.${model}.${s.cradle ? "final_velocities" : "rebound_heights"}`);

// `tolerance`: of the page; that of Python's verdict is fixed.
export function toPython(s: Scenario, tolerance = usualTolerance): string {
  const lawAt = (contact: number): string =>
    `hl.${classOf(s.law)}(${parametersOf(s, contact)
      .map(([name, x]) => `${name}=${x}`)
      .join(", ")})`;
  const balls = list(s.balls.map((b) => `hl.Ball(${b.radius}, density=${b.density})`));
  const law = hasOwn(s) ? `[\n${s.balls.map((_, i) => `        ${lawAt(i)},\n`).join("")}    ]` : lawAt(0);
  const gaps = `gaps=${list(s.gaps.map(String))}`;
  const lines = s.cradle
    ? [balls, `velocities=${list(s.velocities.map(String))}`, `law=${law}`, gaps]
    : [balls, gaps, `height=${s.height}`, `law=${law}`, `gravity=${GRAVITY}`];
  return [
    "import hardlimit as hl",
    "",
    `column = hl.Column${s.cradle ? ".cradle" : ""}(`,
    ...lines.map((line) => `    ${line},`),
    ")",
    "result = hl.compare(column)",
    `print(${shown(s).join(", ")})`,
    "print(result.verdict.sentence)",
    ...(tolerance === usualTolerance
      ? []
      : [`# This verdict is for ${inPercent(usualTolerance)}, not ${inPercent(tolerance)}.`]),
    "",
  ].join("\n");
}

// The options of `hardlimit drop` describe one law for all contacts and a floor; other columns need a file.
export function toCommand(s: Scenario): string {
  if (s.cradle || hasOwn(s)) return `cat > drop.toml <<'END'\n${toToml(s)}END\nhardlimit drop drop.toml\n`;
  const options: [string, number][] = [
    ...s.balls.flatMap((b): [string, number][] => [
      ["radius", b.radius],
      ["density", b.density],
    ]),
    ...s.gaps.map((gap): [string, number] => ["gap", gap]),
    ["height", s.height],
    ["gravity", GRAVITY],
    ...parametersOf(s, 0),
  ];
  const text = options.map(([name, x]) => `--${name.replaceAll("_", "-")} ${x}`);
  return ["hardlimit drop", `--law ${s.law}`, ...text].join(" ") + "\n";
}
