// Requests to the gateway, and the events it tells.

const TOKEN = "sceneq.token";
let askForToken = async () => "";
let asking = null; // several requests are refused at once; the visitor is asked once

export function onTokenNeeded(ask) { askForToken = ask; }

export async function get(path) { return request(path); }

export async function send(method, path, body) {
  const headers = body ? { "Content-Type": "application/json" } : {};
  return request(path, { method, headers, body: body && JSON.stringify(body) });
}

export async function picture(seq) {
  const response = await call(`/views/${seq}.jpg`, {});
  return URL.createObjectURL(await response.blob());
}

// The points of the map, null when they are those that the page has already.
export async function points(etag) {
  const response = await call("/cloud", { headers: etag ? { "If-None-Match": etag } : {} });
  if (response.status === 304) return null;
  return { etag: response.headers.get("ETag"), data: await response.arrayBuffer() };
}

async function request(path, options = {}) { return (await call(path, options)).json(); }

async function call(path, options) {
  const token = sessionStorage.getItem(TOKEN);
  const headers = { ...options.headers, ...(token && { Authorization: `Bearer ${token}` }) };
  const response = await fetch(path, { ...options, headers, cache: "no-store" });
  if (response.ok || response.status === 304) return response;
  if (response.status === 401) {
    asking ??= askForToken().finally(() => { asking = null; });
    sessionStorage.setItem(TOKEN, await asking);
    return call(path, options);
  }
  const problem = await response.json().catch(() => ({}));
  throw new Error(problem.detail ?? `${response.status} ${response.statusText}`);
}

// Calls hear(event) for as long as the page is open; connected(bool) when that changes.
export function listen(hear, connected) {
  let pause = 500;
  const open = () => {
    const token = sessionStorage.getItem(TOKEN);
    const address = `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/events`;
    const socket = new WebSocket(address, token ? [`sceneq.token.${token}`] : []);
    socket.onopen = () => { pause = 500; connected(true); };
    socket.onmessage = (message) => hear(JSON.parse(message.data));
    socket.onclose = () => {
      connected(false);
      setTimeout(open, pause);
      pause = Math.min(2 * pause, 5000);
    };
  };
  open();
}
