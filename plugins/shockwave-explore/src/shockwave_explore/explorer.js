// The explorer's page: sends what the user changes, and shows the parts that the server answers.
"use strict";
const $ = (id) => document.getElementById(id);
const initial = $("text").defaultValue;
let valid = initial; // text of the scenario that is shown
let start = initial; // that to which Reset returns
let refused = {}; // edits that made no valid scenario, and stay in their fields
let typing = ""; // id of the field with text that is not sent yet
let waiting = null; // the request that follows the present one
let busy = false;
let settled; // the timer that puts the scenario into the address
let paused = matchMedia("(prefers-reduced-motion: reduce)").matches;

const hash = () => "#" + encodeURIComponent(valid);
const post = (path, body) =>
  fetch(path, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) });

// Two objects in one, the second behind the first, so that its values are applied last.
function joined(first, second) {
  const others = Object.entries(first).filter(([name]) => !(name in second));
  return { ...Object.fromEntries(others), ...second };
}

// One request at a time. Changes made meanwhile are sent together, so that the page never lags behind a slider.
async function ask(request) {
  if (waiting && !waiting.edits && request.edits) return; // the controls are about to be replaced
  waiting = waiting?.edits && request.edits
    ? { ...waiting, ...request, edits: joined(waiting.edits, request.edits) }
    : request;
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

// The parts of the page; or the `faults` of the scenario, or a `failure` of anything else.
async function answer(path, request) {
  try {
    const reply = await post(path, request);
    if (reply.ok) return path === "report" ? await reply.blob() : await reply.json();
    return reply.headers.get("Content-Type").startsWith("application/json")
      ? await reply.json()
      : { failure: await reply.text() };
  } catch {
    return { failure: "No answer: `shockwave explore` has ended." };
  }
}

async function show(request) {
  const { edits } = request;
  // values that were refused are tried again with the new ones, because some are valid only together
  const all = edits && joined(refused, edits);
  let reply = await answer("answer", { text: valid, ...request, edits: all });
  let left = {};
  if (reply.faults && edits && Object.keys(all).length > Object.keys(edits).length) {
    const alone = await answer("answer", { text: valid, ...request });
    if (alone.text !== undefined) {
      reply = alone;
      left = Object.fromEntries(Object.entries(refused).filter(([name]) => !(name in edits)));
    }
  }
  for (const place of document.querySelectorAll(".error")) {
    if (!(place.id.replace(/:error$/, "") in left)) complain(place.id.replace(/:error$/, ""), "");
  }
  fail(reply.failure ?? "");
  if (reply.text === undefined) {
    refused = all ?? {};
    if (reply.faults) mark(reply.faults, request);
    if (request.link) {
      const fault = $("fault").textContent;
      await show({ text: initial });
      fail(fault);
    }
    return;
  }
  refused = left;
  valid = $("text").value = reply.text;
  if (!edits) start = valid;
  clearTimeout(settled); // browsers limit how often the address may change
  settled = setTimeout(() => history.replaceState(null, "", valid === initial ? location.pathname : hash()), 300);
  $("preset").value = reply.preset;
  for (const name of ["headline", "results", "decision"]) {
    if ($(name).dataset.html !== reply[name]) $(name).innerHTML = $(name).dataset.html = reply[name];
  }
  $("decision").hidden = !reply.decision.trim();
  const time = document.querySelector("#figures svg")?.getCurrentTime() ?? 0;
  $("figures").innerHTML = reply.figures;
  animate(time);
  renew(reply.controls, request);
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
    const { for: name, value, low, high } = next.dataset;
    if (next.type === "range") {
      const ends = [Number(shown.dataset.low ?? shown.min), Number(shown.dataset.high ?? shown.max)];
      if (!edits || centre === name || value < ends[0] || value > ends[1]) {
        for (const attribute of next.attributes) shown.setAttribute(attribute.name, attribute.value);
        shown.value = next.value;
      } else if (shown !== document.activeElement) {
        shown.value = low ? Math.log(value / ends[0]) / Math.log(ends[1] / ends[0]) : value;
      }
      shown.ariaValueText = next.ariaValueText;
      continue;
    }
    const kept = shown.id in refused || shown.id === typing ? shown.value : next.value;
    if (next.type === "text") {
      shown.defaultValue = next.defaultValue;
      shown.dataset.unit = next.dataset.unit;
    } else {
      shown.replaceChildren(...next.children);
    }
    shown.value = kept;
  }
}

// ---------------------------------------------------------------- errors

// A message at a field, or none.
function complain(name, message) {
  const field = $(name);
  if (!field) return;
  $(`${name}:error`).textContent = message;
  field.ariaInvalid = message ? "true" : "false";
}

// The faults at the fields to which they belong, those of the text below it, and all others above the results.
function mark(faults, { edits, link }) {
  const messages = {};
  for (const { path, problem, location } of faults) {
    const field = edits ? (path in edits || path in refused ? path : Object.keys(edits).at(-1)) : link ? "fault" : "text";
    const message = edits ? (path && path !== field ? `${label(path)}: ` : "") + worded(problem)
      : [location.replace(/^scenario:(\d+):.*/, "line $1"), path, problem].filter(Boolean).join(": ");
    messages[field] = [messages[field], message].filter(Boolean).join("\n");
  }
  for (const [field, message] of Object.entries(messages)) {
    if (field === "fault") fail(message);
    else complain(field, message);
  }
  const line = !edits && !link && Number(faults[0].location.split(":")[1]);
  if (line) {
    const lines = $("text").value.split("\n");
    const begin = lines.slice(0, line - 1).join("\n").length + (line > 1);
    $("text").focus();
    $("text").setSelectionRange(begin, begin + (lines[line - 1] ?? "").length);
  }
}

const labels = () => [...document.querySelectorAll("#controls label")];
const label = (path) => labels().find(({ htmlFor }) => htmlFor === path)?.textContent ?? path;

// A problem with the labels of controls in place of their keys.
function worded(problem) {
  const keys = labels().map(({ htmlFor, textContent }) => [htmlFor.split(".").at(-1), textContent]);
  return keys.filter(([key]) => key.includes("_")).reduce((text, [key, words]) => text.replaceAll(key, words), problem);
}

function fail(fault) {
  $("fault").textContent = fault;
  $("fault").hidden = !fault;
  if (fault) $("fault").scrollIntoView({ block: "nearest" });
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
  const number = low ? Math.min(Math.max(near, low), high) : Number(target.value); // rounded, but within the ends
  target.ariaValueText = text.value = `${number} ${unit}`.trim();
  ask({ edits: { [text.id]: unit ? text.value : number } });
});
$("controls").addEventListener("change", ({ target }) => {
  if (target.type === "range") return;
  typing = "";
  ask({ edits: { [target.id]: complete(target.value.trim(), target.dataset.unit) }, centre: target.id });
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
  if (reply instanceof Blob) save("report.html", reply);
  else fail(reply.failure ?? reply.faults.map(({ problem }) => problem).join("\n"));
  $("done").textContent = reply instanceof Blob ? "report.html is saved" : "";
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
