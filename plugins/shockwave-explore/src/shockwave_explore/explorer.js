// The explorer's page: sends what the user changes, and shows the parts that the server answers.
"use strict";
const $ = (id) => document.getElementById(id);
const initial = $("text").defaultValue;
let valid = initial; // text of the scenario that is shown
let waiting = null; // the request that follows the present one
let busy = false;
let settled; // the timer that puts the scenario into the address
let paused = matchMedia("(prefers-reduced-motion: reduce)").matches;

const hash = () => "#" + encodeURIComponent(valid);
const post = (path, body) =>
  fetch(path, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) });

// One request at a time. Changes made meanwhile are sent together, so that the page never lags behind a slider.
async function ask(request) {
  if (waiting && !waiting.edits && request.edits) return; // the controls are about to be replaced
  waiting = waiting?.edits && request.edits
    ? { edits: { ...waiting.edits, ...request.edits }, controls: waiting.controls || request.controls }
    : request;
  if (busy) return;
  busy = true;
  while (waiting) {
    const next = waiting;
    waiting = null;
    await show(next);
  }
  busy = false;
}

async function show(request) {
  let reply;
  try {
    const answer = await post("answer", { text: valid, ...request });
    reply = answer.ok ? await answer.json() : { fault: await answer.text() };
  } catch {
    reply = { fault: "No answer: `shockwave explore` has ended." };
  }
  fail(reply.fault ?? "");
  if (reply.fault) {
    for (const input of document.querySelectorAll("#controls input")) input.value = input.defaultValue;
    for (const option of document.querySelectorAll("#controls option")) option.selected = option.defaultSelected;
    if (request.first) await show({ text: initial, controls: true }).then(() => fail(reply.fault));
    return;
  }
  valid = $("text").value = reply.text;
  clearTimeout(settled); // browsers limit how often the address may change
  settled = setTimeout(() => history.replaceState(null, "", valid === initial ? location.pathname : hash()), 300);
  for (const name of ["headline", "results"]) $(name).innerHTML = reply[name];
  const time = document.querySelector("#figures svg")?.getCurrentTime() ?? 0;
  $("figures").innerHTML = reply.figures;
  animate(time);
  if (request.controls) {
    const focused = document.activeElement?.id;
    $("controls").innerHTML = reply.controls;
    if (focused) $(focused)?.focus();
  } else {
    for (const input of document.querySelectorAll("#controls input")) input.defaultValue = input.value;
  }
  document.body.dataset.shown = Number(document.body.dataset.shown ?? 0) + 1;
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
  if (target.type !== "range") return;
  const { low, high, unit } = target.dataset;
  const near = Number((low * (high / low) ** target.value).toPrecision(3));
  const number = low ? Math.min(Math.max(near, low), high) : Number(target.value); // rounded, but within the ends
  const text = $(target.dataset.for);
  target.ariaValueText = text.value = `${number} ${unit ?? ""}`.trim();
  ask({ edits: { [text.id]: unit ? text.value : number } });
});
$("controls").addEventListener("change", ({ target }) => {
  if (target.type !== "range") ask({ edits: { [target.id]: plain(target.value) }, controls: true });
});
const plain = (text) => (text.trim() !== "" && Number.isFinite(Number(text)) ? Number(text) : text);

$("preset").addEventListener("change", ({ target }) => target.value && ask({ preset: target.value, controls: true }));
$("apply").addEventListener("click", () => {
  const text = $("text").value;
  ask({ text: /^\s*http\S+#/.test(text) ? linked(text.trim()) : text, controls: true });
});

// ---------------------------------------------------------------- copies and files

function copy(text) {
  navigator.clipboard.writeText(text).then(
    () => ($("done").textContent = "copied"),
    () => ($("done").textContent = "The browser does not allow copying; select the text instead."),
  );
}
$("copy").addEventListener("click", () => copy(valid));
$("link").addEventListener("click", () => copy(location.origin + location.pathname + hash()));

function save(name, blob) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  URL.revokeObjectURL(link.href);
}
$("report").addEventListener("click", async () => {
  const reply = await post("report", { text: valid });
  if (reply.ok) save("report.html", await reply.blob());
  else fail(await reply.text());
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
  ask({ text, controls: true, first: text !== initial });
}
addEventListener("hashchange", open);
open();
