// Keeps the files of the client on the device, and nothing else: no answer of the service is ever stored. The build puts
// in which files belong to the shell.
const SHELL = 'telemotion-shell-';
const CACHE = SHELL + '__VERSION__';
const FILES = __FILES__;
const SERVICE = /^\/(api|ws|viewer)(\/|$)/;

self.addEventListener('install', (event) => {
  event.waitUntil(
    caches
      .open(CACHE)
      .then((cache) => cache.addAll(FILES))
      .then(() => self.skipWaiting()),
  );
});

self.addEventListener('activate', (event) => {
  const old = (name) => name.startsWith(SHELL) && name !== CACHE;
  event.waitUntil(
    caches
      .keys()
      .then((names) => Promise.all(names.filter(old).map((name) => caches.delete(name))))
      .then(() => self.clients.claim()),
  );
});

self.addEventListener('fetch', (event) => {
  const { request } = event;
  const url = new URL(request.url);
  if (request.method !== 'GET' || url.origin !== self.location.origin || SERVICE.test(url.pathname)) return;
  // The newest page where there is a link, the stored one where there is none.
  if (request.mode === 'navigate') event.respondWith(fetch(request).catch(() => caches.match('/')));
  // Built files carry a hash of their content in their name: what is stored is what was asked for.
  else if (url.pathname.startsWith('/assets/'))
    event.respondWith(caches.match(request).then((found) => found ?? fetch(request)));
});
