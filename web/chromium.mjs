// Debian's Chromium for tests. The one without windows of its own takes two thirds of the time of the other.
// CHROMIUM: another one.
import { existsSync } from "node:fs";
import { chromium } from "playwright-core";

const places = ["/usr/bin/chromium-headless-shell", "/usr/bin/chromium"];

// `more`: further options of the command line; Playwright sets most.
export const launch = (...more) =>
  chromium.launch({
    executablePath: process.env.CHROMIUM ?? places.find(existsSync),
    args: ["--no-sandbox", "--disable-gpu", "--disable-quic", ...more],
  });
