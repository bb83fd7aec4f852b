import { Camera, listenToKeys, listenToPointers } from "./camera.js";
import { Rpc } from "./rpc.js";
import { QuiltView } from "./view.js";

const STATUS_MS = 1000;
const at = (id) => document.getElementById(id);
const canvas = at("preview"), slider = at("view"), notice = at("notice");
const buttons = [at("fit"), at("pause")];
const rpc = new Rpc();

// The token of the URL becomes a cookie, and leaves the address bar.
async function exchangeToken() {
  const token = location.hash.slice(1);
  if (!token) return;
  const headers = { Authorization: `Bearer ${token}` };
  const answer = await fetch("/api/login", { method: "POST", headers });
  if (answer.ok) history.replaceState(null, "", location.pathname);
}

function complain(error) {
  notice.textContent = error?.message ?? "";
}

// Why there is no connection.
async function explain(reason) {
  for (const control of [slider, ...buttons]) control.disabled = true;
  at("progress").textContent = "";
  const answer = await fetch("/api/status").catch(() => undefined);
  const words = {
    401: "This page has no token. Open the URL that quiltweb printed when it started.",
    503: `quiltd does not answer${reason ? ` (${reason})` : ""}. This page connects as soon as it does.`,
  };
  if (!answer) notice.textContent = "quiltweb has ended. This page connects when it runs again.";
  else notice.textContent = words[answer.status] ?? "";
}

function number(value) {
  return value == null ? "unknown" : value.toPrecision(2);
}

function describe(status) {
  const words = [status.state];
  if (status.level) words.push(status.level === "none" ? "no image yet" : status.level);
  if (status.passes != null) words.push(`${status.passes.toPrecision(3)} passes`);
  if (status.error_estimate !== undefined)
    words.push(
      `error ${number(status.error_estimate)}, denoised ${number(status.denoised_error)}` +
        ` (target ${number(status.target_error)})`,
    );
  return words.join(" · ");
}

function applyStatus(status, view) {
  at("progress").textContent = describe(status);
  at("scene").textContent = status.scene?.split("/").pop() ?? "";
  at("pause").setAttribute("aria-pressed", String(Boolean(status.paused)));
  view.aspect = status.aspect;
  for (const button of buttons) button.disabled = !status.scene || status.is_quilt;
  if (status.error) notice.textContent = status.error.message;
}

async function followStatus(view) {
  if (!document.hidden)
    await rpc.call("status").then((status) => applyStatus(status, view), () => {});
  setTimeout(() => followStatus(view), STATUS_MS);
}

function followImages(view, turnTo) {
  rpc.addEventListener("image", async ({ detail }) => {
    try {
      const header = await view.show(detail);
      canvas.dataset.generation = header.generation;
      at("empty").hidden = true;
      slider.disabled = header.views < 2;
      turnTo(view.position);
    } catch (error) {
      complain(error);
    } finally {
      rpc.notify("preview.ack");
    }
  });
  rpc.addEventListener("frame", ({ detail }) => {
    if (detail.card) complain({ message: `The panel shows a card: ${detail.card}` });
    else complain();
  });
}

function start() {
  const view = new QuiltView(canvas);
  const camera = new Camera(rpc, canvas, complain);
  const turnTo = (position) => {
    view.position = position;
    slider.value = view.position;
    const last = Math.max(view.views - 1, 0);
    const shown = Math.round(Math.min(Math.max(view.position * view.views - 0.5, 0), last));
    at("view-number").textContent = view.views ? `${shown + 1} of ${view.views}` : "";
  };
  slider.addEventListener("input", () => turnTo(Number(slider.value)));
  listenToPointers(canvas, camera, turnTo);
  listenToKeys(canvas, camera, (step) => turnTo(view.position + step / Math.max(view.views, 1)));
  at("fit").addEventListener("click", () => rpc.call("camera.fit").then(() => complain(), complain));
  at("pause").addEventListener("click", ({ currentTarget }) => {
    const paused = currentTarget.getAttribute("aria-pressed") !== "true";
    currentTarget.setAttribute("aria-pressed", String(paused));
    rpc.call("render.set", { paused }).then(() => complain(), complain);
  });
  followImages(view, turnTo);
  rpc.addEventListener("open", () => {
    complain();
    rpc.call("preview.start").catch(complain);
  });
  rpc.addEventListener("close", ({ detail }) => explain(detail));
  rpc.connect();
  followStatus(view);
}

// Another token was pasted into the address bar.
addEventListener("hashchange", () => location.reload());
exchangeToken().then(start).catch(complain);
