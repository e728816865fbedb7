// Starts Debian's Chromium for tests: its headless shell, which takes two thirds of the time, or the browser. The
// environment variable CHROMIUM names another program.
import { existsSync } from "node:fs";
import { chromium } from "playwright-core";

const places = ["/usr/bin/chromium-headless-shell", "/usr/bin/chromium"];

// `more`: further options of the command line; Playwright sets most.
export const launch = (...more) =>
  chromium.launch({
    executablePath: process.env.CHROMIUM ?? places.find(existsSync),
    args: ["--no-sandbox", "--disable-gpu", "--disable-quic", ...more],
  });
