// The page: asks, shows what comes back, and how the graph is.

import { fail, fill, newCard, thing } from "./cards.js";
import { get, listen, onTokenNeeded, points, send } from "./wire.js";

const $ = (id) => document.getElementById(id);
const HISTORY = "sceneq.history";
const SILENT_MS = 2500;
const CLOUD_MS = 2000;

const seen = new Map(); // node -> {at, health}
let map3d = null;
let cloudTag = "";
let cloudDue = true;
let earlier = -1;

onTokenNeeded(() => new Promise((resolve) => {
  $("login").onclose = () => resolve($("token").value);
  $("login").showModal();
}));

const hooks = {
  show: (record) => { map3d?.choose(record); $("hint").hidden = true; },
  named: () => { loadThings(); },
};

$("ask").onsubmit = async (event) => {
  event.preventDefault();
  const question = $("question").value.trim();
  if (!question) return;
  remember(question);
  const card = newCard(question);
  $("answers").prepend(card);
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

async function pick(id) {
  const card = newCard(`Thing ${id}`);
  $("answers").prepend(card);
  try {
    const told = await get(`/instances/${id}/label?k=3`);
    const names = told.labels.map((one) => `${one.label} ${one.p.toFixed(2)}`).join(", ");
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
  const [labels, listed] = [await get("/labels"), await get("/instances?k=500")];
  const given = Object.keys(labels.given);
  $("known").replaceChildren(...given.map((label) => new Option(label)));
  const things = listed.instances.filter((one) => one.role === "object");
  $("list").replaceChildren(...things.map((one) => {
    const item = document.createElement("li");
    const button = document.createElement("button");
    button.textContent = `${one.label} (${one.id})`;
    button.onclick = () => pick(one.id);
    item.append(button);
    return item;
  }));
}

async function loadCloud() {
  if (!cloudDue || document.hidden) return;
  cloudDue = false;
  try {
    const fresh = await points(cloudTag);
    if (!fresh) return;
    if (!map3d) map3d = new (await import("./map3d.js")).Map3D($("cloud"), pick);
    cloudTag = fresh.etag;
    map3d.load(fresh.data);
    await loadThings();
  } catch (error) {
    cloudDue = true;
    $("hint").textContent = map3d ? error.message : `The map cannot be drawn: ${error.message}`;
  }
}

function hear(event) {
  if (event.type === "health") seen.set(event.node, { at: Date.now(), health: event });
  else if (event.type === "map") cloudDue = true;
}

function showNodes() {
  const items = [...seen].sort().map(([name, { at, health }]) => {
    const item = document.createElement("li");
    const gone = Date.now() - at > SILENT_MS;
    const dropped = Number(health.flows?.dropped ?? 0);
    item.className = gone ? "gone" : "";
    item.textContent = `${name}${gone ? " gone" : ""}${dropped ? `, ${dropped} dropped` : ""}`;
    return item;
  });
  $("nodes").replaceChildren(...items);
}

async function showScene() {
  try {
    const scene = await get("/scene");
    $("scene").textContent = scene.scene;
    const { epoch, seq, age_s: age } = scene.map;
    $("map").textContent = `${scene.instances} things, ${scene.answerable} answerable, map ${epoch % 100000}:${seq}, ${age.toFixed(0)} s old`;
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

await showScene();
listen(hear, (connected) => {
  $("trouble").hidden = connected;
  $("trouble").textContent = "The connection is lost; trying again.";
  if (connected) { cloudDue = true; showScene(); }
});
loadCloud();
setInterval(showNodes, 500);
setInterval(loadCloud, CLOUD_MS);
setInterval(showScene, 3000);
