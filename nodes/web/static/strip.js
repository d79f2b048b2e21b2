// The strip of processes: who is alive or came back, how much comes in each second, what was dropped.

const SILENT_MS = 2500;
const OWN = /^(health|metric)$|_(journal|snapshot)$/; // housekeeping: tells nothing of the work

const seen = new Map(); // node -> {at, rate, dropped, restarts, told}

export function heard(beat) {
  const before = seen.get(beat.node);
  const told = { at: beat.uptime_s, pid: beat.pid, count: total(beat, ["in"]) || total(beat, ["out"]) };
  const isNew = before && (told.pid !== before.told.pid || told.at < before.told.at);
  const restarts = (before?.restarts ?? 0) + (isNew ? 1 : 0);
  const seconds = before && told.at - before.told.at;
  const rate = seconds > 0 ? Math.max(0, told.count - before.told.count) / seconds : 0;
  const dropped = total(beat, ["dropped", "undecodable"]);
  seen.set(beat.node, { at: Date.now(), rate, dropped, restarts, told });
}

export function draw(list) {
  [...seen].sort().forEach(([name, node], index) => {
    const item = list.children[index] ?? list.appendChild(document.createElement("li"));
    const silent = Date.now() - node.at > SILENT_MS;
    const said = [silent ? `${name} silent` : name, ...restarted(node), ...(silent ? [] : facts(node))];
    const text = said.join(", ");
    if (item.textContent === text) return;
    item.className = silent ? "gone" : "";
    item.textContent = text;
    item.title = `${text} (process ${node.told.pid}): messages it reads each second, those that came too fast for it, `
      + "and how often it was started anew since this page was opened";
  });
}

function restarted({ restarts }) { // too quick to be seen as silence
  if (!restarts) return [];
  return [restarts === 1 ? "restarted once" : `restarted ${restarts} times`];
}

function facts({ rate, dropped }) {
  return [...(rate >= 0.5 ? [`${rate.toFixed(0)}/s`] : []), ...(dropped ? [`${dropped} dropped`] : [])];
}

function total(beat, events) {
  const topics = Object.entries(beat.topics ?? {}).filter(([name]) => !OWN.test(name));
  return topics.reduce((sum, [, flow]) => sum + events.reduce((n, event) => n + (flow[event] ?? 0), 0), 0);
}
