// The page: asks, shows what comes back, and how the graph is.

import { ago, fail, fill, newCard, percent, thing } from "./cards.js";
import { draw, heard } from "./strip.js";
import { get, listen, onTokenNeeded, points, send } from "./wire.js";

const $ = (id) => document.getElementById(id);
const HISTORY = "sceneq.history";
const CLOUD_MS = 2000;
const MAX_CARDS = 30;

let map3d = null;
let cloudTag = "";
let cloudDue = true;
let earlier = -1;

onTokenNeeded(() => new Promise((resolve) => {
  $("login").onclose = () => resolve($("token").value);
  $("login").showModal();
}));

const hooks = {
  show: (record) => {
    map3d?.choose(record);
    $("hint").hidden = true;
    $("whole").hidden = !map3d;
  },
  named: () => { loadThings(); },
};

$("whole").onclick = () => map3d.whole();

$("ask").onsubmit = async (event) => {
  event.preventDefault();
  const question = $("question").value.trim();
  if (!question) return;
  remember(question);
  const card = put(newCard(question));
  try {
    const body = { question, k: 5, ...($("think").checked && { mode: "reason" }) };
    const answer = await send("POST", "/ask", body);
    fill(card, answer, hooks);
    if (answer.status !== "not_found" && answer.instances.length) hooks.show(answer.instances[0]);
  } catch (error) {
    fail(card, error.message);
  }
  $("question").select();
};

$("question").onkeydown = (event) => {
  const step = { ArrowUp: 1, ArrowDown: -1 }[event.key];
  const past = history();
  if (!step || !past.length || (earlier < 0 && $("question").value)) return;
  event.preventDefault();
  earlier = Math.max(-1, Math.min(past.length - 1, earlier + step));
  $("question").value = earlier < 0 ? "" : past[earlier];
};
$("question").oninput = () => { earlier = -1; };

function put(card) {
  $("try").hidden = true;
  $("answers").prepend(card);
  [...$("answers").children].slice(MAX_CARDS).forEach((old) => old.remove());
  return card;
}

async function pick(id) {
  const card = put(newCard(`Thing ${id}`));
  try {
    const told = await get(`/instances/${id}/label?k=3`);
    const names = told.labels.map((one) => `${one.label} ${percent(one.p)}`).join(", ");
    const record = { ...told.instance, p: told.labels[0]?.p ?? 0 };
    card.querySelector("h2").textContent = record.label;
    card.querySelector(".status").textContent = "";
    card.querySelector(".said").textContent = `It may be: ${names}.`;
    card.querySelector(".things").append(thing(record, hooks, () => card.remove()));
    hooks.show(record);
  } catch (error) {
    fail(card, error.message);
  }
}

async function loadThings() {
  const [labels, listed] = await Promise.all([get("/labels"), get("/instances?k=500")]);
  const given = Object.keys(labels.given);
  $("known").replaceChildren(...given.map((label) => new Option(label)));
  const things = listed.instances.filter((one) => one.role === "object");
  $("list").replaceChildren(...things.map((one) => {
    const item = document.createElement("li");
    item.append(button(`${one.label} (${one.id})`, () => pick(one.id)));
    return item;
  }));
  propose(things);
}

// What somebody who has asked nothing yet could ask here.
function propose(things) {
  if ($("answers").children.length) return;
  const sure = [...new Set(things.toSorted((a, b) => b.p - a.p).map((one) => one.label))];
  const holds = (one) => things.filter((other) => other.supported_by === one.id).length;
  const table = things.toSorted((a, b) => holds(b) - holds(a))[0];
  const questions = [
    ...sure.slice(0, 1).map((label) => `the ${label}`),
    ...sure.slice(1, 2).map((label) => `what is near the ${label}?`),
    ...(table && holds(table) ? [`what is on the ${table.label}?`] : []),
  ];
  const buttons = questions.map((question) => button(question, () => {
    $("question").value = question;
    $("ask").requestSubmit();
  }));
  $("try").replaceChildren($("try").firstElementChild, ...buttons);
  $("try").hidden = !buttons.length;
}

function button(text, act) {
  return Object.assign(document.createElement("button"), { type: "button", textContent: text, onclick: act });
}

async function loadCloud() {
  if (!cloudDue || document.hidden) return;
  cloudDue = false;
  try {
    const [fresh, drawing] = await Promise.all([points(cloudTag), import("./map3d.js")]);
    if (!fresh) return;
    map3d ??= new drawing.Map3D($("cloud"), pick);
    cloudTag = fresh.etag;
    map3d.load(fresh.data);
    await loadThings();
  } catch (error) {
    cloudDue = true;
    $("hint").textContent = map3d ? error.message : `The map cannot be drawn: ${error.message}`;
  }
}

function hear(event) {
  if (event.type === "health") heard(event);
  else if (event.type === "map" || event.type === "lost") cloudDue = true;
}

async function showScene() {
  try {
    const scene = await get("/scene");
    $("scene").textContent = scene.scene;
    const { seq, age_s: age } = scene.map;
    $("map").textContent = `${scene.instances} things · revision ${seq} · ${ago(age)} old`;
  } catch (error) {
    $("map").textContent = error.message;
  }
}

function history() {
  try { return JSON.parse(localStorage.getItem(HISTORY)) ?? []; } catch { return []; }
}

function remember(question) {
  const kept = [question, ...history().filter((one) => one !== question)].slice(0, 50);
  localStorage.setItem(HISTORY, JSON.stringify(kept));
  earlier = -1;
}

showScene();
listen(hear, (connected) => {
  $("trouble").hidden = connected;
  $("trouble").textContent = "The connection is lost; trying again.";
  if (connected) { cloudDue = true; showScene(); }
});
loadCloud();
setInterval(() => draw($("nodes")), 500);
setInterval(loadCloud, CLOUD_MS);
setInterval(showScene, 3000);
