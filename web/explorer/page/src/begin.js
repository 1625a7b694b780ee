// The first script of a page: unpacks the main script and runs it.
import { unzipped } from "./packed.js";

/** @param {Error} error */
function broken(error) {
  const shown = /** @type {HTMLElement} */ (document.getElementById("broken"));
  shown.hidden = false;
  shown.textContent = `The page could not be unpacked: ${error.message}. It needs DecompressionStream, which browsers have since 2023: Chrome 80, Firefox 113, Safari 16.4. The command line vibro does the same without a browser.`;
}

async function begin() {
  const script = document.createElement("script");
  script.textContent = await unzipped("script").text();
  document.body.append(script);
}

begin().catch(broken);
