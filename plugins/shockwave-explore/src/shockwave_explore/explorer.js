// The explorer's page: sends what the user changes, and shows the parts that the server answers.
"use strict";
const $ = (id) => document.getElementById(id);
const initial = $("text").defaultValue;
let valid = initial; // text of the scenario that is shown
let written = $("text").value; // the text as it was written into its field
let start = initial; // that to which Reset returns
let refused = {}; // edits that made no valid scenario, and stay in their fields
let count; // granules of the last finite chain, to which an endless one returns
let typing = ""; // id of the field with text that is not sent yet
let waiting = null; // the request that follows the present one
let busy = false;
let settled; // the timer that puts the scenario into the address
let paused = matchMedia("(prefers-reduced-motion: reduce)").matches;

const hash = () => "#" + encodeURIComponent(valid);
const post = (path, body) =>
  fetch(path, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) });

// Edits without those of the same names as others; and both together, the later ones last, as they are applied.
const without = (edits, others) => Object.fromEntries(Object.entries(edits).filter(([name]) => !(name in others)));
const joined = (edits, later) => ({ ...without(edits, later), ...later });

// One request at a time. Changes made meanwhile are sent together, so that the page never lags behind a slider.
async function ask(request) {
  if (waiting && !waiting.edits && request.edits) return; // the controls are about to be replaced
  waiting = waiting?.edits && request.edits ? { ...request, edits: joined(waiting.edits, request.edits) } : request;
  if (busy) return;
  busy = true;
  $("answer").ariaBusy = "true";
  while (waiting) {
    const next = waiting;
    waiting = null;
    await show(next);
  }
  busy = false;
  $("answer").ariaBusy = "false";
}

// The reply, or faults: those of the scenario have a path, a problem and a location, others a problem only.
async function answer(path, request) {
  try {
    const reply = await post(path, request);
    const type = reply.headers.get("Content-Type");
    if (type.startsWith("text/html")) return await reply.blob();
    return type.startsWith("application/json") ? await reply.json() : { faults: [{ problem: await reply.text() }] };
  } catch {
    return { faults: [{ problem: "No answer: `shockwave explore` has ended." }] };
  }
}

async function show(request) {
  const edits = request.edits ?? {};
  // values that were refused are tried again with the new ones, because some are valid only together
  const all = joined(request.edits ? refused : {}, edits);
  let left = {};
  let reply = await answer("answer", { text: valid, ...request, edits: all });
  if (reply.faults && Object.keys(all).length > Object.keys(edits).length) {
    const alone = await answer("answer", { text: valid, ...request });
    if (!alone.faults) [reply, left] = [alone, without(refused, edits)];
  }
  for (const { id } of document.querySelectorAll(".error")) if (!(fieldOf(id) in left)) complain(fieldOf(id), "");
  if (reply.faults) {
    refused = all;
    if (request.link) await show({ text: initial });
    for (const fault of reply.faults) mark(fault, request);
    return;
  }
  refused = left;
  const changed = request.edits && $("text").value !== written; // by the user, who has not applied it
  valid = reply.text;
  $("done").textContent = changed ? "Changes to the text are not yet applied." : "";
  if (!changed) $("text").value = valid;
  if (!changed) written = $("text").value;
  if (!request.edits) start = valid;
  clearTimeout(settled); // browsers limit how often the address may change
  settled = setTimeout(() => history.replaceState(null, "", valid === initial ? location.pathname : hash()), 300);
  $("preset").value = reply.preset;
  for (const name of ["headline", "results", "decision"]) $(name).innerHTML = reply[name];
  $("decision").hidden = !reply.decision.trim();
  const time = document.querySelector("#figures svg")?.getCurrentTime() ?? 0;
  $("figures").innerHTML = reply.figures;
  animate(time);
  renew(reply.controls, request);
  count = $("chain.granules")?.value ?? (request.edits && count);
  document.body.dataset.shown = Number(document.body.dataset.shown ?? 0) + 1;
}

// Controls of the scenario that is shown. If they are the same ones, only their values change, so that the focus, text
// that is being typed and the ends of sliders stay.
function renew(html, { edits, centre }) {
  const fresh = document.createElement("template");
  fresh.innerHTML = html;
  const names = (root) => [...root.querySelectorAll("[id]")].map(({ id }) => id).join();
  if (names(fresh.content) !== names($("controls"))) {
    const focused = document.activeElement?.id;
    $("controls").replaceChildren(fresh.content);
    if (focused) $(focused)?.focus();
    refused = {};
    return;
  }
  for (const next of fresh.content.querySelectorAll("input, select")) {
    const shown = $(next.id);
    const { for: name, value } = next.dataset;
    const { low, high } = shown.dataset;
    let kept = shown.id in refused || shown.id === typing ? shown.value : next.value;
    if (next.type === "range" && edits && centre !== name && value >= Number(low) && value <= Number(high)) {
      kept = next.max === "1" ? Math.log(value / low) / Math.log(high / low) : value;
      for (const end of ["min", "max", "data-low", "data-high"]) next.setAttribute(end, shown.getAttribute(end));
    }
    for (const attribute of next.attributes) shown.setAttribute(attribute.name, attribute.value);
    if (shown.options) shown.replaceChildren(...next.children);
    if (shown !== document.activeElement || shown.type !== "range") shown.value = kept;
  }
}

// ---------------------------------------------------------------- errors

// Name of the field to which a place of errors belongs, and the words of a key.
const fieldOf = (id) => id.replace(/:error$/, "");
const words = (key) => key.replace(/\b[a-z]+(_[a-z]+)+\b/g, (name) => name.replaceAll("_", " "));

// A message at a field, or none.
function complain(name, message) {
  if (!$(`${name}:error`)) return;
  $(`${name}:error`).textContent = message;
  if (name !== "answer") $(name).ariaInvalid = message ? "true" : "false";
  else if (message) $("answer").scrollIntoView({ block: "nearest" });
}

// A fault at the field that it belongs to or that was edited last; of a text, below it; of anything else, at the top.
function mark({ path, problem, location }, { edits, link }) {
  let field = path === undefined || link ? "answer" : "text";
  let message = [location?.replace(/^scenario:(\d+):.*/, "line $1"), path, problem].filter(Boolean).join(": ");
  if (edits && path !== undefined) {
    field = path in refused ? path : Object.keys(edits).at(-1);
    message = (path === field || !path ? "" : `${words(path.slice(path.indexOf(".") + 1))}: `) + words(problem);
  }
  if (link && path === "") message = `the link is incomplete: ${message}`;
  complain(field, [$(`${field}:error`)?.textContent, message].filter(Boolean).join("\n"));
  const line = field === "text" && Number(location.split(":")[1]);
  if (!line) return;
  const lines = $("text").value.split("\n");
  const begin = lines.slice(0, line - 1).join("\n").length + (line > 1);
  $("text").focus();
  $("text").setSelectionRange(begin, begin + lines[line - 1].length);
}

function animate(time) {
  for (const picture of document.querySelectorAll("#figures svg")) {
    if (time !== undefined) picture.setCurrentTime(time);
    if (paused) picture.pauseAnimations();
    else picture.unpauseAnimations();
  }
  if ($("pause")) $("pause").textContent = paused ? "Play" : "Pause";
}

// ---------------------------------------------------------------- controls

$("controls").addEventListener("input", ({ target }) => {
  if (target.type === "text") typing = target.id;
  if (target.type !== "range") return;
  const text = $(target.dataset.for);
  const { low, high } = target.dataset;
  const { unit } = text.dataset;
  const near = Number((low * (high / low) ** target.value).toPrecision(3));
  const number = target.max === "1" ? Math.min(Math.max(near, low), high) : Number(target.value); // within the ends
  target.ariaValueText = text.value = `${number} ${unit}`.trim();
  ask({ edits: { [text.id]: unit ? text.value : number } });
});
$("controls").addEventListener("change", ({ target }) => {
  if (target.type === "range") return;
  typing = "";
  const restored = target.id === "chain.end" && count && !$("chain.granules") ? { "chain.granules": count } : {};
  ask({ edits: { ...restored, [target.id]: complete(target.value.trim(), target.dataset.unit) }, centre: target.id });
});
$("controls").addEventListener("keydown", ({ key, target }) => {
  if (key !== "Escape" || target.type !== "text") return;
  target.value = target.defaultValue; // the last valid value
  delete refused[target.id];
  complain(target.id, "");
});
// A bare number has the unit that its field shows.
function complete(text, unit) {
  if (text === "" || !Number.isFinite(Number(text))) return text;
  return unit ? `${text} ${unit}` : Number(text);
}

$("preset").addEventListener("change", ({ target }) => target.value && ask({ preset: target.value }));
$("reset").addEventListener("click", () => ask({ text: start }));
$("apply").addEventListener("click", () => {
  const text = $("text").value;
  ask({ text: /^\s*http\S+#/.test(text) ? linked(text.trim()) : text });
});

// ---------------------------------------------------------------- copies and files

function copy(text) {
  navigator.clipboard.writeText(text).then(
    () => ($("done").textContent = "copied"),
    () => ($("done").textContent = "The browser does not allow copying; select the text instead."),
  );
}
$("copy").addEventListener("click", () => copy(valid));
$("save").addEventListener("click", () => save("scenario.yaml", new Blob([valid])));
$("link").addEventListener("click", () => copy(location.origin + location.pathname + hash()));

function save(name, blob) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  URL.revokeObjectURL(link.href);
}
$("report").addEventListener("click", async () => {
  $("done").textContent = "writing the report";
  const reply = await answer("report", { text: valid });
  if (reply.faults) for (const fault of reply.faults) mark(fault, { link: true });
  else save("report.html", reply);
  $("done").textContent = reply.faults ? "" : "report.html is saved";
});
$("figures").addEventListener("click", ({ target }) => {
  if (target.id === "pause") {
    paused = !paused;
    animate();
  } else if (target.className === "save") {
    const figure = target.closest("figure");
    const picture = new XMLSerializer().serializeToString(figure.querySelector("svg"));
    save(`${figure.ariaLabel}.svg`, new Blob([picture], { type: "image/svg+xml" }));
  }
});

// ---------------------------------------------------------------- links

// The scenario in a link, which may be that of another explorer.
function linked(link) {
  try {
    return decodeURIComponent(link.slice(link.indexOf("#") + 1));
  } catch {
    return link; // refused with a message
  }
}
function open() {
  const text = (location.hash && linked(location.hash)) || initial;
  ask({ text, link: text !== initial });
}
addEventListener("hashchange", open);
open();
