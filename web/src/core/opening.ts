// The core for the worker that opens the page, which is named after its link. It is asked for before anything else of the
// worker is evaluated.
import { compiled } from "../support/script";

export const opening = self.name ? compiled("core.wasm") : null;
