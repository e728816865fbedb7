// The menu to share: link, QR code, embed code, worksheet; and the sound of the film.
import type { PanelName } from "../scenario/story_view";
import type { State } from "../state/state";
import { find, refocus } from "../support/dom";
import { copyText, tell } from "../support/output";
import { tools } from "./load_tools";
import type { ContactSound } from "./sound";

const dialog = (): HTMLDialogElement => find<HTMLDialogElement>("dialog");

export function listenShare(state: State): void {
  const copy = find("copy");
  copy.addEventListener("click", () => {
    history.replaceState(null, "", state.link());
    void copyText(state.link()).then((done) => tell(copy, done ? "Copied" : "In address bar"));
  });
  find("qr").addEventListener("click", () => void showQr(state));
  find("embed").addEventListener("click", () => void showEmbed(state));
  find("dialog-close").addEventListener("click", () => dialog().close());
  dialog().addEventListener("close", () => refocus());
  listenWorksheet(state);
}

function show(title: string, ...content: (Node | string)[]): void {
  for (const menu of document.querySelectorAll<HTMLDetailsElement>("details.menu")) menu.open = false;
  find("dialog-title").textContent = title;
  find("dialog-body").replaceChildren(...content);
  dialog().showModal();
}

const paragraph = (textContent: string, className = ""): HTMLElement =>
  Object.assign(document.createElement("p"), { textContent, className });

// Others cannot open a link to this computer.
async function warning(link: string): Promise<HTMLElement[]> {
  const { isLocal } = await tools();
  return isLocal(link)
    ? [paragraph("This link leads to this computer only. For others, put the page on a web server first.", "note")]
    : [];
}

async function showQr(state: State): Promise<void> {
  const link = state.link();
  const { qrPicture } = await tools();
  show("This setting on a phone", qrPicture(link), paragraph(link, "link"), ...(await warning(link)));
}

async function showEmbed(state: State): Promise<void> {
  const { embedCode, titles } = await tools();
  const select = document.createElement("select");
  const text = Object.assign(document.createElement("textarea"), { readOnly: true, rows: 5 });
  text.setAttribute("aria-label", "Code to embed");
  const names = (Object.keys(titles) as PanelName[]).filter((name) => name !== "compare" || state.story.pin);
  select.append(...names.map((name) => new Option(titles[name], name)));
  const write = (): string => (text.value = embedCode(state.link(), select.value as PanelName));
  select.addEventListener("change", write);
  write();
  const label = document.createElement("label");
  label.append("Panel ", select);
  const copy = Object.assign(document.createElement("button"), { type: "button", textContent: "Copy code" });
  copy.addEventListener(
    "click",
    () => void copyText(text.value).then((done) => (done ? tell(copy, "Copied") : text.select())),
  );
  show("A panel in another page", label, text, copy, ...(await warning(state.link())));
}

// The worksheet takes the place of the page until it is closed.
function listenWorksheet(state: State): void {
  const root = document.documentElement;
  const leave = (): void => {
    delete root.dataset.worksheet;
    find("worksheet").hidden = true;
    refocus();
  };
  const enter = async (): Promise<void> => {
    const { worksheet } = await tools();
    for (const menu of document.querySelectorAll<HTMLDetailsElement>("details.menu")) menu.open = false;
    find("sheet").replaceChildren(...worksheet(state.scenario, state.link(), state.view.tolerance, reachOf(state)));
    root.dataset.worksheet = "";
    find("worksheet").hidden = false;
    scrollTo(0, 0);
    find("print-sheet").focus();
  };
  find("open-worksheet").addEventListener("click", () => void enter());
  find("print-sheet").addEventListener("click", () => print());
  find("leave-sheet").addEventListener("click", leave);
  addEventListener("keydown", (e) => {
    if (e.key === "Escape" && root.dataset.worksheet !== undefined) leave();
  });
}

// The way that ball 2 falls during the floor contact [m].
function reachOf({ drop }: State): number {
  const { tFloorEnd, impactSpeed } = drop?.newton.run ?? { tFloorEnd: NaN, impactSpeed: NaN };
  return tFloorEnd * impactSpeed || 1e-3;
}

// Off until the reader asks for it.
export class SoundSwitch {
  private sound: ContactSound | null = null;

  constructor(private readonly state: State) {
    const button = find("sound");
    button.addEventListener("click", () => void this.toggle(button));
  }

  private async toggle(button: HTMLElement): Promise<void> {
    const { ContactSound } = await tools();
    this.sound ??= new ContactSound();
    this.sound.switch(!this.sound.on);
    button.setAttribute("aria-pressed", String(this.sound.on));
  }

  // Called in each frame.
  follow(): void {
    const { state, sound } = this;
    if (!sound?.on || !state.drop) return;
    const clock = state.clock();
    sound.follow(
      state.drop,
      state.time(),
      state.playing && !state.story.step,
      (from, to) => clock.toScreen(to) - clock.toScreen(from),
    );
  }
}
