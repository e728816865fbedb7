// The sound of each contact by Newton’s equations in the film. A short contact sounds high, a large impulse loud.
import type { Drop } from "../core/drop";

export interface Note {
  at: number; // begin of the contact [s]
  end: number;
  pitch: number; // Hz
  loudness: number; // 0 to 1
}

// 1 ms sounds as 440 Hz, and a contact eight times as short one octave higher.
const pitchOf = (duration: number): number => Math.min(Math.max(440 * Math.cbrt(1e-3 / duration), 80), 3000);

// Impulse of a contact: the integral of its force [N s], by the samples of the plot of forces.
export function impulseOf(
  { times, forces }: Pick<Drop, "times" | "forces">,
  pair: number,
  begin: number,
  end: number,
): number {
  let sum = 0;
  for (let i = 1; i < times.length; i++)
    if (times[i] > begin && times[i - 1] < end)
      sum += 0.5 * (forces[pair][i] + forces[pair][i - 1]) * (times[i] - times[i - 1]);
  return sum;
}

// Contacts of the sequence that have an end.
export function notesOf(d: Pick<Drop, "newton" | "times" | "forces">): Note[] {
  const contacts = d.newton.run.contacts.filter((c) => c.begin <= d.newton.run.last && c.end > c.begin).slice(0, 500);
  const impulses = contacts.map((c) => impulseOf(d, c.pair, c.begin, c.end));
  const most = Math.max(...impulses, Number.MIN_VALUE);
  return contacts.map(({ begin, end }, i) => ({
    at: begin,
    end,
    pitch: pitchOf(end - begin),
    loudness: Math.sqrt(Math.max(impulses[i], 0) / most), // the ear hears powers of the sound
  }));
}

export class ContactSound {
  private context: AudioContext | null = null;
  private notes: Note[] = [];
  private of: Drop | null = null;
  private before = NaN; // time of the film that was heard [s]

  constructor(private readonly make: () => AudioContext = () => new AudioContext()) {}

  get on(): boolean {
    return this.context !== null;
  }
  switch(on: boolean): void {
    if (on) this.context ??= this.make();
    else {
      void this.context?.close();
      this.context = null;
    }
    this.before = NaN;
  }

  // The film stands at `time`. `screen`: duration on the screen of a span of the film [s].
  follow(d: Drop, time: number, playing: boolean, screen: (from: number, to: number) => number): void {
    if (!this.context) return;
    if (d !== this.of) this.notes = notesOf(d);
    const from = d === this.of && playing ? this.before : NaN;
    this.of = d;
    this.before = time;
    for (const note of this.notes) if (note.at > from && note.at <= time) this.play(note, screen(note.at, note.end));
  }

  private play({ pitch, loudness }: Note, shown: number): void {
    const { context } = this;
    const lasts = Math.min(Math.max(shown, 0.12), 1.5);
    const now = context!.currentTime;
    const tone = context!.createOscillator();
    const volume = context!.createGain();
    tone.type = "triangle";
    tone.frequency.value = pitch;
    volume.gain.setValueAtTime(0.3 * loudness, now);
    volume.gain.exponentialRampToValueAtTime(1e-4, now + lasts);
    tone.connect(volume).connect(context!.destination);
    tone.start(now);
    tone.stop(now + lasts);
  }
}
