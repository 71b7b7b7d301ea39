// The live page as a client of the service: the lines of doc/protocol.md over a WebSocket. What is
// shown comes from events and from the methods' answers, nothing is guessed.
'use strict';
(() => {
  const $ = (id) => document.getElementById(id);
  const kDeg = 180 / Math.PI;
  const kUnusual = 4;             // times the usual residual: worth a look, as in the terminal
  const kHeartbeat = 4000;        // ms between questions to a silent service
  const kNoAnswer = 8000;         // ms without a line: the link is lost
  const kActive = ['starting', 'running', 'paused', 'stopping'];
  const kSymbols = { ok: '✓', settling: '≈', free: '○', stale: '◷', lost: '✕', unread: '–' };
  const kWords = { ok: 'ok', settling: 'settling', free: 'no contact', stale: 'STALE', lost: 'LOST', unread: 'not read' };

  // geometry/five_bar.h, for people.
  const kMeaning = { l11: 'motor link, leg 1', l12: 'far link, leg 1', l21: 'motor link, leg 2', l22: 'far link, leg 2', d: 'between the motors', x0: 'robot stands at x', y0: 'robot stands at y', alpha: 'robot turned by', dtheta1: 'zero of encoder 1', dtheta2: 'zero of encoder 2' };
  let socket = null, calls = new Map(), nextId = 1;
  let epoch = '', lastSeq = 0, heardAt = 0, lostSince = 0, retry = 0;
  let session = '', collect = { state: 'idle' }, points = new Map(), live = null, liveAt = 0;
  let estimate = null, job = null, swarms = null, planAsked = 0, doubts = new Map();

  function element(parent, name, className, text) {
    const made = document.createElement(name);
    if (className) made.className = className;
    if (text !== undefined) made.textContent = text;
    parent.appendChild(made);
    return made;
  }
  const fixed = (value, digits) => (typeof value === 'number' ? value.toFixed(digits) : '–');
  const clock = (date) => date.toTimeString().slice(0, 8);
  function duration(seconds) {
    if (typeof seconds !== 'number') return '';
    if (seconds < 90) return `${Math.ceil(seconds)} s left`;
    return `${Math.round(seconds / 60)} min left`;
  }
  const keyOf = (p) => `${p.set} ${p.point}.${p.repeat}`;

  // ---- the link ---------------------------------------------------------------------------------
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
    mine.onopen = () => greet().catch(complain);
    mine.onmessage = (message) => { if (mine === socket) take(JSON.parse(message.data)); };
    mine.onclose = () => { if (mine === socket) lose(); };
  }

  function lose() {
    socket = null;
    for (const waiting of calls.values()) waiting.reject({ message: 'The connection was lost before the answer came.' });
    calls.clear();
    if (!lostSince) { lostSince = Date.now(); note('connection to the service lost'); }
    retry = Math.min(retry + 1, 5);
    setTimeout(connect, 400 * retry);
    showLink();
  }

  async function greet() {
    const hello = await call('hello');
    const again = hello.epoch === epoch;
    // First visit: the events of a while ago, so that the page is not blank.
    const since = again ? lastSeq : Math.max(0, hello.last_seq - 300);
    if (epoch && !again) note('the service was started anew');
    if (!again) { job = null; swarms = null; estimate = null; doubts.clear(); }
    epoch = hello.epoch;
    await call('events.subscribe', { topics: ['job', 'sample', 'collect', 'live', 'service'], since_seq: since });
    if (lostSince) note('connected again; what was missed has been replayed');
    lostSince = 0;
    retry = 0;
    await refresh();
    showLink();
  }

  function take(message) {
    heardAt = Date.now();
    if (message.method === 'events.event') {
      lastSeq = Math.max(lastSeq, message.params.seq);
      onEvent(message.params);
    } else if (message.method === 'events.gap') {
      lastSeq = Math.max(lastSeq, message.params.to_seq);
      if (!message.params.live) { note(`${message.params.count} events left out`); refresh().catch(complain); }
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
    showLink();
    showDials();
  }, 1000);

  function showLink() {
    const open = socket && socket.readyState === WebSocket.OPEN && !lostSince;
    document.body.dataset.link = open ? 'open' : lostSince ? 'lost' : 'connecting';
    $('lost').hidden = !lostSince;
    if (lostSince) {
      const since = clock(new Date(lostSince));
      $('lost').textContent = 'Connection to the service lost';
      element($('lost'), 'small', '', `What you see is from ${since}. The rig may still be moving. Trying again by itself; if this stays, look whether sixdiald runs.`);
    }
    $('link').textContent = open ? `● connected ${clock(new Date())}` : lostSince ? '✕ not connected' : 'connecting …';
  }

  // ---- what happened ----------------------------------------------------------------------------
  function note(text, time) {
    const item = document.createElement('li');
    element(item, 'time', '', time ? clock(new Date(time)) : clock(new Date()));
    item.append(text);
    $('events').prepend(item);
    while ($('events').children.length > 200) $('events').lastChild.remove();
  }
  function complain(error) {
    const hint = error.data && error.data.hint ? ' ' + error.data.hint : '';
    say((error.message || String(error)) + hint, true);
    note((error.message || String(error)) + hint);
  }
  function say(text, bad) {
    $('notice').hidden = !text;
    $('notice').textContent = text;
    $('notice').classList.toggle('bad', !!bad);
  }

  function onEvent({ topic, data, time_utc: time }) {
    if (topic === 'live') { live = data; liveAt = Date.now(); showDials(); return; }
    if (topic === 'service') note(`service ${data.type}`, time);
    if (topic === 'sample') onSample(data, time);
    if (topic === 'collect') onCollect(data, time);
    if (topic === 'job') onJob(data, time);
  }

  function onSample(data, time) {
    const place = data.position_mm ? `x ${fixed(data.position_mm[0], 3)}  y ${fixed(data.position_mm[1], 3)} mm` : 'no position';
    const remarks = data.remarks.length ? '; ' + data.remarks.join('; ') : '';
    note(`${data.retaken ? 'retaken' : 'stored'} ${keyOf(data)}: ${place}${remarks}`, time);
    const known = points.get(keyOf(data));
    if (data.session !== session || !known) return;
    doubts.delete(keyOf(data));
    known.state = data.position_mm && !data.remarks.length ? 'done' : 'suspect';
    known.why = data.remarks.join('; ') || (data.position_mm ? '' : 'no position');
    showMap();
  }

  function onCollect(data, time) {
    const before = collect.state;
    if (data.type === 'estimate') {
      estimate = data.estimate;
      const odd = estimate.last_times_usual > kUnusual && data.point && points.get(keyOf(data.point));
      if (odd) {
        odd.state = 'suspect';
        odd.why = `${estimate.last_times_usual.toFixed(0)} times the usual residual`;
        doubts.set(keyOf(data.point), odd.why);
        note(`${keyOf(data.point)} looks ${odd.why}: r to retake`, time);
      }
      showEstimate();
    }
    if (data.estimate === undefined) data.estimate = estimate;
    collect = data;
    if (['started', 'paused', 'skipped', 'failed', 'stopped', 'done', 'move'].includes(data.type)) {
      note(`collection ${data.type}${data.message ? ': ' + data.message : ''}`, time);
      if (kActive.includes(data.state) && data.session && data.session !== session) choose(data.session);
    }
    if (data.type === 'skipped' && data.point && points.has(keyOf(data.point))) {
      points.get(keyOf(data.point)).state = 'left';
    }
    if (before !== data.state || data.type === 'move') tellState();
    if (data.type === 'started' || !kActive.includes(data.state)) loadPlan();
    showCollect();
    showMap();
  }

  function tellState() {
    if (collect.state === 'paused') say(`Paused. ${collect.message || ''} Continue: c. Measure it again: r. Skip: s.${/dial/i.test(collect.message || '') ? ' Store it as it is: a.' : ''}`);
    else if (collect.state === 'failed') say(`The collection failed: ${(collect.error && collect.error.message) || collect.ended_because || ''} What was stored is kept.`, true);
    else if (collect.move_to_rad) say(`Move the robot to theta1 ${fixed(collect.move_to_rad[0], 6)}, theta2 ${fixed(collect.move_to_rad[1], 6)} rad, then press m.`);
    else say('');
  }

  function onJob(data, time) {
    if (data.session !== session) return;
    const began = !job || job.job !== data.job;
    if (began) swarms = null;
    job = data;
    const stage = data.progress && data.progress.stage;
    if (data.kind === 'calibration' && (stage === 'qpso1' || stage === 'qpso2') && typeof data.progress.best_mm === 'number') {
      swarms = swarms || [{ name: 'swarm 1: noise of the filter', points: [] }, { name: 'swarm 2: parameters', points: [] }];
      swarms[stage === 'qpso1' ? 0 : 1].points.push([data.progress.done, data.progress.best_mm]);
    }
    if (data.type !== 'progress') note(`${data.kind} ${data.type}${data.error ? ': ' + data.error.message : ''}`, time);
    if (data.type === 'done') showResult();
    showJob();
  }

  // ---- snapshots --------------------------------------------------------------------------------
  async function refresh() {
    const [list, status] = [await call('session.list', { limit: 50 }), await call('collect.status')];
    collect = status;
    if (status.estimate) estimate = status.estimate;
    const wanted = kActive.includes(status.state) ? status.session : session || status.session || (list.sessions[0] && list.sessions[0].name) || '';
    $('session').replaceChildren();
    for (const each of list.sessions) {
      const option = element($('session'), 'option', '', each.name);
      option.value = each.name;
    }
    $('create').hidden = list.sessions.length > 0;
    if (!list.sessions.length) say('There is no session yet. Make one: a name, and the rig file that describes robot and dials.');
    await choose(wanted);
    if (kActive.includes(collect.state)) tellState();
  }

  async function choose(name) {
    session = name || '';
    $('session').value = session;
    if (collect.session !== session) estimate = null;
    const known = session ? (await call('job.list', { session, limit: 1 })).jobs[0] : null;
    if (!known || !job || job.job !== known.job) { job = known || null; swarms = null; }
    await loadPlan();
    showJob();
    showResult();
    showEstimate();
    showCollect();
  }

  async function loadPlan() {
    const asked = ++planAsked, name = session, fresh = new Map();
    let total = name ? 1 : 0;
    for (let offset = 0; offset < total; offset += 200) {
      const page = await call('session.plan', { session: name, limit: 200, offset });
      total = page.total;
      for (const p of page.points) {
        const doubt = p.state === 'done' && doubts.get(keyOf(p));
        fresh.set(keyOf(p), { name: keyOf(p), x: p.target_mm[0], y: p.target_mm[1], state: doubt ? 'suspect' : p.state, why: doubt || p.why });
      }
    }
    if (asked !== planAsked) return;  // a newer question is under way
    points = fresh;
    $('make-plan').hidden = !session || points.size > 0;
    showMap();
    showCollect();
  }

  // ---- what is seen -----------------------------------------------------------------------------
  function showDials() {
    const reading = kActive.includes(collect.state) && live && Date.now() - liveAt < 5000;
    const ids = live ? Object.keys(live.dials) : ['A', 'B', 'C', 'D', 'E', 'F'];
    const box = $('dials');
    if (box.children.length !== ids.length || [...box.children].some((c, i) => c.dataset.dial !== ids[i])) {
      box.replaceChildren();
      for (const id of ids) {
        const card = element(box, 'div', 'dial');
        card.dataset.dial = id;
        const top = element(card, 'div', 'top');
        element(top, 'b', '', id);
        element(top, 'span');
        element(card, 'div', 'value');
        element(card, 'div', 'why');
      }
    }
    for (const card of box.children) {
      const dial = reading ? live.dials[card.dataset.dial] : null;
      const state = dial ? dial.state : 'unread';
      card.dataset.state = state;
      card.querySelector('span').textContent = `${kSymbols[state]} ${kWords[state]}`;
      const value = card.querySelector('.value');
      value.textContent = dial && typeof dial.value_mm === 'number' ? fixed(dial.value_mm, 3) : '–––';
      element(value, 'small', '', ' mm');
      const why = card.querySelector('.why');
      why.textContent = !dial || state === 'free' ? '' : dial.detail || dial.reason || '';
      why.title = why.textContent;
    }
    const pose = reading ? live.pose : null;
    $('pose').replaceChildren();
    const rows = [['x', pose && pose.x_mm, 3, 'mm'], ['y', pose && pose.y_mm, 3, 'mm'], ['γ', pose && pose.gamma_rad * kDeg, 3, '°']];
    for (const [name, value, digits, unit] of rows) {
      const cell = element($('pose'), 'div');
      element(cell, 'small', '', `${name} `);
      cell.append(pose ? fixed(value, digits) : '–––');
      element(cell, 'small', '', ` ${unit}`);
    }
    const box2 = $('settle');
    box2.replaceChildren();
    if (!reading) {
      box2.textContent = kActive.includes(collect.state) ? 'Waiting for the dials …' : 'The dials are read while a session is collected.';
    } else if (live.settle && typeof live.settle.spread_mm === 'number') {
      const meter = element(box2, 'meter');
      meter.max = 3;
      meter.high = 1;
      meter.optimum = 0;
      meter.value = Math.min(3, live.settle.spread_mm / live.settle.limit_mm);
      box2.append(` ${live.settle.settled ? '✓ settled' : '≈ settling'}: last readings within ${fixed(live.settle.spread_mm, 3)} mm, ${fixed(live.settle.limit_mm, 3)} allowed${pose ? '; position from dials ' + pose.dials.join(', ') : ''}`);
    } else {
      box2.textContent = 'No dial gives a value.';
    }
  }

  const inHand = () => kActive.includes(collect.state) && collect.session === session && collect.point;
  function showMap() {
    const next = inHand();
    const odd = [...points.values()].filter((p) => p.state === 'suspect');
    $('suspects').textContent = odd.length ? 'Suspect: ' + odd.slice(0, 6).map((p) => `${p.name} (${p.why})`).join('; ') + (odd.length > 6 ? ` and ${odd.length - 6} more` : '') : '';
    drawing.map($('map'), [...points.values()], next ? { x: next.target_mm[0], y: next.target_mm[1] } : null);
  }

  function showCollect() {
    const active = kActive.includes(collect.state);
    const here = collect.session === session;
    const done = [...points.values()].filter((p) => p.state === 'done' || p.state === 'suspect').length;
    $('state').textContent = { idle: '○ idle', starting: '▶ starting', running: '▶ collecting', paused: '❚❚ PAUSED', stopping: '■ stopping', done: '✓ collected', stopped: '■ stopped', failed: '✕ FAILED' }[collect.state] || collect.state;
    if (active && here) {
      const point = collect.point ? `${collect.stage} ${keyOf(collect.point)}` : collect.stage;
      $('progress').textContent = [`${collect.done} of ${collect.total} points`, duration(collect.eta_s), point].filter(Boolean).join(' · ');
      $('bar').value = collect.done;
      $('bar').max = collect.total || 1;
    } else {
      const tail = here && collect.ended_because ? `Ended: ${collect.ended_because}.` : done < points.size ? 'Start goes on at the next open point.' : '';
      $('progress').textContent = points.size ? `${done} of ${points.size} points measured. ${tail}` : session ? 'No plan yet.' : 'No session yet.';
      $('bar').value = done;
      $('bar').max = points.size || 1;
    }
    const can = {
      start: session && !active && (points.size === 0 || done < points.size),
      pause: collect.state === 'running', resume: collect.state === 'paused', retake: active,
      skip: active, accept: collect.state === 'paused', stop: active && collect.state !== 'stopping',
      moved: active && collect.move_to_rad, undo: session && !(active && here) && done > 0,
      calibrate: session && !active && done > 0, diagnose: session && !active && done > 0,
      cancel: job && (job.state === 'running' || job.state === 'queued'), report: session && done > 0,
    };
    for (const name in can) { const button = document.querySelector(`button[data-do=${name}]`); if (button) button.disabled = !can[name]; }
    document.querySelector('button[data-do=moved]').hidden = !collect.move_to_rad;
    showDials();
  }

  function showEstimate() {
    $('estimate').hidden = !estimate;
    if (!estimate) { $('estimate-words').textContent = 'Comes with the first sample of set G1.'; return; }
    const sd = estimate.position_sd_mm, open = estimate.undetermined;
    $('estimate-words').textContent = `After ${estimate.samples} samples the tool is known to ${fixed(sd.mean, 3)} mm on average, ${fixed(sd.max, 3)} mm at the worst place (1 sd).` + (open.length ? ` ${open.length} parameters need more points.` : ' Every parameter is determined.');
    const body = $('estimate').tBodies[0];
    body.replaceChildren();
    for (const p of estimate.parameters) {
      const angle = p.unit === 'rad', times = angle ? kDeg : 1, unsure = open.includes(p.name);
      const row = element(body, 'tr', unsure ? 'open-parameter' : '');
      const name = element(row, 'td', '', p.name);
      element(name, 'small', '', ` ${kMeaning[p.name] || ''}`);
      element(row, 'td', 'n', fixed(p.value * times, 4));
      element(row, 'td', 'n', fixed(p.sd * times, 4));
      element(row, 'td', '', angle ? 'deg' : 'mm');
      element(row, 'td', '', unsure ? '… needs more points' : '✓');
    }
  }

  function showJob() {
    const p = (job && job.progress) || {}, running = job && (job.state === 'running' || job.state === 'queued');
    $('job-bar').hidden = !running;
    if (running && p.total) { $('job-bar').max = p.total; $('job-bar').value = p.done; }
    const stages = { ekf: 'extended Kalman filter', qpso1: 'swarm 1 of 2', qpso2: 'swarm 2 of 2', lm: 'least squares to compare', anfis: 'learning what is left (ANFIS)', report: 'intervals and tables' };
    const best = typeof p.best_mm === 'number' ? `best ${p.best_mm.toPrecision(4)} mm` : '';
    $('job-words').textContent = !job ? 'Nothing is being calculated.'
      : running ? [`${job.kind}: ${stages[p.stage] || p.stage || job.state}`, p.total ? `${p.done} of ${p.total}` : '', best, duration(p.eta_s)].filter(Boolean).join(' · ')
      : `${job.kind} ${job.state}${job.error ? ': ' + job.error.message : ''}`;
    $('swarms').hidden = !swarms;
    if (swarms) drawing.convergence($('convergence'), swarms);
    showCollect();
  }

  async function showResult() {
    const name = session;
    $('result').textContent = '';
    if (!name) return;
    try {
      const found = await call('result.get', { session: name });
      if (name !== session) return;
      const method = (id) => (found.summary.methods || []).find((each) => each.id === id);
      const first = method('before'), last = method('ekf_dqpso+anfis');
      const set = last && last.g2 ? 'g2' : 'g1';
      if (first && last && first[set] && last[set]) {
        $('result').textContent = `Position error on ${set.toUpperCase()}: ${fixed(first[set].mean_mm, 3)} mm before, ${fixed(last[set].mean_mm, 3)} mm after (mean).`;
      } else {
        $('result').textContent = `Result ${found.result} is stored.`;
      }
    } catch (error) {
      $('result').textContent = 'Not calibrated yet.';
    }
  }

  // ---- commands ---------------------------------------------------------------------------------
  async function start() {
    const params = { session, on_dial_fault: 'pause' };
    if (points.size === 0) {
      const plans = [];
      for (const [set, id, seed] of [['G1', 'g1', 1], ['G2', 'g2', 2]]) {
        const count = Number($(id).value);
        if (count > 0) plans.push((await call('plan.random', { session, set, count, seed })).plan_csv);
      }
      params.plan_csv = plans.map((text, i) => (i ? text.slice(text.indexOf('\n') + 1) : text)).join('');
    }
    await call('collect.start', params);
  }
  const commands = {
    start: ['Start', 'g', start],
    pause: ['Pause', 'p', () => call('collect.pause')],
    resume: ['Continue', 'c', () => call('collect.resume')],
    retake: ['Retake', 'r', () => call('collect.retake')],
    skip: ['Skip', 's', () => call('collect.skip')],
    accept: ['Accept', 'a', () => call('collect.accept')],
    moved: ['Moved', 'm', () => call('collect.moved')],
    undo: ['Undo last', 'u', async () => { const now = await call('session.undo', { session, reason: 'undone on the live page' }); note(now.undone === null ? 'nothing to undo' : 'the last sample was withdrawn; its point is open again'); await loadPlan(); }],
    stop: ['Stop', 'q', () => call('collect.stop')],
    calibrate: ['Calibrate', 'k', () => call('calibrate.start', { session })],
    diagnose: ['Diagnose', 'd', () => call('diagnose.start', { session })],
    cancel: ['Cancel', 'x', () => call('job.cancel', { job: job.job })],
    report: ['Open report', 'o', async () => { window.open(`report/${encodeURIComponent(session)}`, '_blank', 'noopener'); }],
  };
  const kHelp = { pause: 'after this point', retake: 'this or the last point', skip: 'leave it out', accept: 'store with the fault', undo: 'once stopped', stop: 'goes on later', start: 'at the next open point', report: 'after a calibration' };
  async function run(name) {
    const button = document.querySelector(`button[data-do=${name}]`);
    if (button.disabled) { say(`“${commands[name][0]}” is not possible now.`); return; }
    say('');
    try { await commands[name][2](); } catch (error) { complain(error); }
  }
  for (const name in commands) {
    const group = ['calibrate', 'diagnose', 'cancel', 'report'].includes(name) ? 'jobs' : 'buttons';
    const button = element($(group), 'button', name === 'start' ? 'main' : '', commands[name][0]);
    button.type = 'button';
    button.dataset.do = name;
    element(button, 'kbd', '', commands[name][1]);
    if (kHelp[name]) element(button, 'small', '', kHelp[name]);
    button.onclick = () => run(name);
  }
  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || /^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName)) return;
    const name = Object.keys(commands).find((each) => commands[each][1] === event.key);
    if (name) { event.preventDefault(); run(name); }
  });
  $('session').onchange = () => choose($('session').value).catch(complain);
  $('new').onclick = () => { $('create').hidden = !$('create').hidden; };
  $('make-plan').onsubmit = (event) => { event.preventDefault(); run('start'); };
  $('create').onsubmit = async (event) => {
    event.preventDefault();
    try {
      const name = $('new-name').value;
      await call('session.create', { name, rig_toml: await $('new-rig').files[0].text() });
      session = name;
      say('');
      await refresh();
      $('create').hidden = true;
    } catch (error) { complain(error); }
  };

  drawing.legend($('legend'));
  showDials();
  showCollect();
  connect();
})();
