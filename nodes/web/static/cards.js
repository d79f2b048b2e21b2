// Answers as cards.

import { picture, send } from "./wire.js";

const STATUS = {
  found: "found", ambiguous: "which one?", not_found: "not found", waiting: "asking …",
  error: "no answer", thing: "",
};
const SHOWN = 3;
const LIKELY = 0.2; // of the best one's probability: what is less waits behind "not this one"

export const percent = (p) => (p > 0 && p < 0.01 ? "<1 %" : `${Math.round(100 * p)} %`);

export function ago(seconds) {
  if (seconds < 100) return `${seconds.toFixed(0)} s`;
  return seconds < 6000 ? `${(seconds / 60).toFixed(0)} min` : `${(seconds / 3600).toFixed(0)} h`;
}

export function newCard(question) {
  const card = document.querySelector("#card").content.cloneNode(true).firstElementChild;
  card.querySelector("h2").textContent = question;
  say(card, "waiting");
  return card;
}

export function fail(card, message) {
  say(card, "error");
  card.querySelector(".said").textContent = message;
}

// Fills a card with an answer; hooks.show(record) points at a thing in the map.
export function fill(card, answer, hooks) {
  say(card, answer.status);
  card.querySelector(".said").textContent = answer.said ?? "";
  const things = card.querySelector(".things");
  const left = answer.status === "not_found" ? [] : [...answer.instances];
  const best = left[0]?.p ?? 0;
  const least = answer.status === "found" ? LIKELY * best : 0;
  const isNext = () => left.length && (!things.children.length || left[0].p >= least);
  const next = () => {
    while (things.children.length < SHOWN && isNext()) things.append(thing(left.shift(), hooks, next));
    if (!things.children.length && answer.status !== "not_found") {
      card.querySelector(".said").textContent = "None of these, then.";
      say(card, "not_found");
    }
  };
  next();
  const { took_ms: ms, route, reason, cost, map } = answer;
  const calls = cost?.vlm_calls ? `, ${cost.vlm_calls} model calls` : "";
  const age = map?.age_s === undefined ? "" : `, map ${ago(map.age_s)} old`;
  if (route) card.querySelector(".why").textContent = `${route}: ${reason} (${ms.toFixed(0)} ms${calls}${age})`;
}

export function thing(record, hooks, gone) {
  const part = document.querySelector("#thing").content.cloneNode(true).firstElementChild;
  const find = (selector) => part.querySelector(selector);
  part.dataset.id = record.id;
  find("h3").textContent = `${record.label} (${record.id})`;
  const p = record.p ?? record.label_p ?? 0;
  Object.assign(find("meter"), { value: p, ariaLabel: `probability ${percent(p)}` });
  Object.assign(find("output"), { textContent: percent(p), title: "how probable it is that this is meant" });
  const [x, y, z] = record.centre.map((metres) => metres.toFixed(2));
  find(".place").textContent = `at ${x}, ${y}, ${z} m${record.state === "stale" ? ", not seen there lately" : ""}`;
  find(".show").onclick = () => hooks.show(record);
  find(".not").onclick = () => { part.remove(); gone(); };
  const naming = find(".naming");
  find(".name").onclick = () => { naming.hidden = !naming.hidden; if (!naming.hidden) naming.querySelector("input").focus(); };
  naming.onsubmit = async (event) => {
    event.preventDefault();
    const name = naming.querySelector("input").value.trim();
    try {
      await send("PUT", `/instances/${record.id}/name`, { name });
      find("h3").textContent = `${name} (${record.id})`;
      naming.hidden = true;
      hooks.named();
    } catch (error) {
      find(".place").textContent = error.message;
    }
  };
  evidence(find("figure"), record);
  return part;
}

async function evidence(figure, record) {
  const view = record.views?.[0];
  if (!view) return;
  const image = figure.querySelector("img");
  try {
    image.src = await picture(view.seq);
    await image.decode();
  } catch {
    return; // the keyframe is gone; the card says the rest
  } finally {
    URL.revokeObjectURL(image.src);
  }
  const [left, top, right, bottom] = view.box_xyxy;
  const share = (value, of) => `${(100 * value) / of}%`;
  const { naturalWidth: width, naturalHeight: height } = image;
  Object.assign(figure.querySelector("i").style, {
    left: share(left, width), top: share(top, height),
    width: share(right - left, width), height: share(bottom - top, height),
  });
  image.alt = `${record.label} in keyframe ${view.seq}`;
  figure.querySelector("figcaption").textContent = `keyframe ${view.seq}`;
  figure.hidden = false;
}

function say(card, status) {
  const mark = card.querySelector(".status");
  mark.className = `status ${status}`;
  mark.textContent = STATUS[status] ?? status;
}
