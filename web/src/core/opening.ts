// The core for the worker that opens the page, whose name is the link of the page. It is requested before the rest of
// the worker is evaluated.
import { compiled } from "../support/script";

export const opening = self.name ? compiled("core.wasm") : null;
