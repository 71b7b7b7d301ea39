// The way from the live page to the service: the lines of doc/protocol.md over a WebSocket. Comes
// back by itself after a break, and finds out why it cannot.
'use strict';
const openLink = (() => {
  const kHeartbeat = 4000;  // ms between questions to a silent service
  const kNoAnswer = 8000;   // ms without a line: the link is lost
  const kTopics = ['job', 'sample', 'collect', 'session', 'live', 'service'];
  const kFirst = 300;       // events of a while ago for a page that is opened late

  /// on: {event(params), gap(params), greeted(again), changed()}. `greeted` may be asynchronous.
  return function openLink(on) {
    let socket = null, calls = new Map(), nextId = 1;
    let epoch = '', lastSeq = 0, heardAt = 0, lostSince = 0, retry = 0, why = '';

    function call(method, params = {}) {
      return new Promise((resolve, reject) => {
        if (!socket || socket.readyState !== WebSocket.OPEN) {
          reject({ message: 'The service is not connected; nothing was sent.' });
          return;
        }
        const id = nextId++;
        calls.set(id, { resolve, reject });
        socket.send(JSON.stringify({ jsonrpc: '2.0', id, method, params }));
      });
    }

    function connect() {
      const mine = new WebSocket(location.href.replace(/^http/, 'ws').replace(/[?#].*$/, '') + 'socket');
      socket = mine;
      mine.onopen = () => greet().catch((error) => on.failed(error));
      mine.onmessage = (message) => { if (mine === socket) take(JSON.parse(message.data)); };
      mine.onclose = () => { if (mine === socket) lose(); };
    }

    function lose() {
      socket = null;
      for (const waiting of calls.values()) waiting.reject({ message: 'The connection was lost before the answer came.' });
      calls.clear();
      if (!lostSince) lostSince = Date.now();
      retry = Math.min(retry + 1, 5);
      setTimeout(connect, 400 * retry);
      on.changed();
      findWhy();
    }

    // A WebSocket does not tell why it was refused; the page's own address does.
    async function findWhy() {
      let found = 'silent';
      try {
        const answer = await fetch(location.href.replace(/[?#].*$/, ''), { method: 'HEAD', cache: 'no-store' });
        found = answer.status === 403 ? 'token' : 'service';
      } catch (error) { found = 'silent'; }
      if (!lostSince || found === why) return;
      why = found;
      on.changed();
    }

    async function greet() {
      const hello = await call('hello');
      const again = hello.epoch === epoch;
      const since = again ? lastSeq : Math.max(0, hello.last_seq - kFirst);
      const first = !epoch, broken = lostSince > 0;
      epoch = hello.epoch;
      if (!again) lastSeq = 0;
      on.greeting({ again, first, broken });
      await call('events.subscribe', { topics: kTopics, since_seq: since });
      lostSince = 0;
      retry = 0;
      why = '';
      await on.greeted();
      on.changed();
    }

    function take(message) {
      heardAt = Date.now();
      if (message.method === 'events.event') {
        lastSeq = Math.max(lastSeq, message.params.seq);
        on.event(message.params);
      } else if (message.method === 'events.gap') {
        lastSeq = Math.max(lastSeq, message.params.to_seq);
        on.gap(message.params);
      } else if (calls.has(message.id)) {
        const waiting = calls.get(message.id);
        calls.delete(message.id);
        if (message.error) waiting.reject(message.error); else waiting.resolve(message.result);
      }
    }

    setInterval(() => {
      if (socket && socket.readyState === WebSocket.OPEN) {
        if (Date.now() - heardAt > kHeartbeat) call('hello').catch(() => {});
        if (heardAt && Date.now() - heardAt > kNoAnswer) { const dead = socket; lose(); dead.close(); }
      }
      on.changed();
    }, 1000);
    connect();

    return {
      call,
      /// {open, lostSince: ms or 0, why: '' (not known yet), 'silent', 'token' or 'service'}
      state: () => ({ open: !!socket && socket.readyState === WebSocket.OPEN && !lostSince, lostSince, why }),
    };
  };
})();
