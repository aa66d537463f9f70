// Loads the planner in a thread of its own: the first message is the compiled module, which answers all others itself.
import { initSync } from "evencut-module";

// Of its own end the module tells only if it is a panic, before that stops it; what is told first counts. Whatever else
// stops it, or refuses one of its arrays, is a lack of memory: then Rust stops without a word.
addEventListener("error", (event) => {
  if (!(event.error instanceof WebAssembly.RuntimeError || event.error instanceof RangeError)) return;
  event.preventDefault();
  const message = "The browser ran out of memory for this job. Use a coarser mesh or a larger side step, or the command-line program, which may use more memory.";
  postMessage({ ended: { message } });
});

onmessage = ({ data: module }) => initSync({ module });
