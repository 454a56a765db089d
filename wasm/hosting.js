// SPDX-License-Identifier: Apache-2.0
// What the page needs of the place where it lies. Threads take a page that is isolated from others, by two headers that many
// hosts of static files cannot send. There, this file is also a service worker of the page, which adds them.
/* global clients */
if (typeof window === "undefined") {
  addEventListener("install", () => skipWaiting());
  addEventListener("activate", (event) => event.waitUntil(clients.claim()));
  addEventListener("fetch", (event) => event.respondWith(fetch(event.request).then(({ status, statusText, headers, body }) => {
    if (status === 0) return Response.error();
    const more = new Headers(headers);
    more.set("Cross-Origin-Opener-Policy", "same-origin");
    more.set("Cross-Origin-Embedder-Policy", "require-corp");
    more.set("Cross-Origin-Resource-Policy", "same-origin");
    return new Response([101, 204, 205, 304].includes(status) ? null : body, { status, statusText, headers: more });
  })));
} else if (location.protocol === "file:") {
  addEventListener("DOMContentLoaded", () => {
    document.getElementById("app").textContent = "Browsers load no program from a file. Serve this folder, for example by " +
      "'python3 -m http.server' in it, and open http://localhost:8000.";
  });
} else if (!crossOriginIsolated && navigator.serviceWorker && !sessionStorage.getItem("juliavdb isolation")) {
  sessionStorage.setItem("juliavdb isolation", "asked");  // once: a browser that does not isolate would load the page for ever
  navigator.serviceWorker.register("hosting.js").then(() => navigator.serviceWorker.ready).then(() => location.reload());
  // A browser may keep this page, and show it again when the isolated one is loaded anew.
  addEventListener("pageshow", ({ persisted }) => {
    if (persisted) location.reload();
  });
}
