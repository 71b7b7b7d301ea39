// The live page as a client of the service: shows what its events and answers say, and asks it for
// what can be done. Nothing is judged here.
'use strict';
(() => {
  const $ = (id) => document.getElementById(id);
  const kCoverage = 2; // of an expanded uncertainty: so many standard deviations
  const kActive = ['starting', 'running', 'paused', 'stopping'];

  // geometry/five_bar.h, for people.
  let session = '', collect = { state: 'idle' }, points = new Map(), live = null, liveAt = 0;
  let estimate = null, job = null, swarms = new Map(), planAsked = 0, choices = {}, choicesAsked = 0;
  let saidLost = false;

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
  const nameOf = (p) => `${p.set} point ${p.point}${p.repeat ? ` repeat ${p.repeat}` : ''}`;
  const kAt = { moving: 'moving to', settling: 'settling at', paused: 'paused at', stored: 'stored', skipped: 'skipped', failed: 'could not measure' };

  // ---- the link ---------------------------------------------------------------------------------
  const link = openLink({
    event: (event) => onEvent(event),
    gap: (gap) => { if (!gap.live) { note(`${gap.count} events left out`); refresh().catch(complain); } },
    greeting: ({ again, first, broken }) => {
      if (!again && !first) note('the service was started anew');
      if (!again) { job = null; swarms.clear(); estimate = null; live = null; }
      if (broken) note('connected again; what was missed is replayed');
    },
    greeted: () => refresh(),
    failed: (error) => complain(error),
    changed: () => { showLink(); showDials(); showButtons(); },
  });
  const call = link.call;
  const dials = openDials({ $, element, fixed, call, complain, session: () => session, changed: () => showDials() });
  const kWhy = {
    token: 'A service was started anew and this address is no longer its own. Open the new address: sixdiald printed it when it began.',
    service: 'The page is served, but the service behind it does not take the connection. It may be going down, or have too many clients.',
    silent: 'Nobody answers. Look whether sixdiald runs: sixdial doctor in a terminal tells. It is tried again by itself.',
    '': 'Trying again by itself.',
  };

  function showLink() {
    const { open, lostSince, why } = link.state();
    document.body.dataset.link = open ? 'open' : lostSince ? 'lost' : 'connecting';
    if (lostSince && !saidLost) note('connection to the service lost');
    saidLost = lostSince > 0;
    const words = lostSince ? `What you see is from ${clock(new Date(lostSince))}; the rig may still be moving. ${kWhy[why]}` : '';
    if ($('lost').dataset.words !== words) {  // an alert is read out at each change
      $('lost').dataset.words = words;
      $('lost').textContent = words ? '✕ Connection to the service lost' : '';
      if (words) element($('lost'), 'small', '', words);
    }
    $('lost').hidden = !lostSince;
    $('link').textContent = open ? `● connected ${clock(new Date())}` : lostSince ? '✕ not connected' : '… connecting';
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
    if (topic === 'session') onSession(data, time);
    if (topic === 'sample') onSample(data, time);
    if (topic === 'collect') onCollect(data, time);
    if (topic === 'job') onJob(data, time);
  }

  function onSample(data, time) {
    const place = data.position_mm ? `x ${fixed(data.position_mm[0], 3)}  y ${fixed(data.position_mm[1], 3)} mm` : 'no position';
    const remarks = data.remarks.length ? '; ' + data.remarks.join('; ') : '';
    note(`${data.retaken ? 'retaken' : 'stored'} ${nameOf(data)}: ${place}${remarks}`, time);
    const known = points.get(keyOf(data));
    if (data.session !== session || !known) return;
    known.state = data.doubt ? 'suspect' : 'done';
    known.why = data.doubt;
    showMap();
  }

  function onSession(data, time) {
    const by = data.operator ? ` by ${data.operator}` : '';
    note(data.type === 'undone' ? `the last sample of ${data.session} was withdrawn${by}; its point is open again` : `session ${data.session} ${data.type}`, time);
    if (data.type !== 'undone') refresh().catch(complain);
    else if (data.session === session) loadPlan().then(askChoices).catch(complain);
  }

  function onCollect(data, time) {
    const before = collect.state;
    if (data.type === 'estimate') {
      estimate = data.estimate;
      if (estimate && estimate.last_unusual && data.point && kActive.includes(data.state)) {
        note(`${nameOf(data.point)} is ${estimate.last_times_usual.toFixed(0)} times as far off as usual: r measures it again`, time);
      }
      showEstimate();
    }
    if (data.estimate === undefined) data.estimate = estimate;
    collect = data;
    if (['started', 'paused', 'skipped', 'failed', 'stopped', 'done', 'move'].includes(data.type)) {
      note(`collection ${data.type}${data.message ? ': ' + data.message : ''}`, time);
      if (data.type === 'started' && data.session !== session) choose(data.session).catch(complain);
    }
    if (data.type === 'skipped' && data.point && points.has(keyOf(data.point))) {
      points.get(keyOf(data.point)).state = 'left';
    }
    if (before !== data.state || data.type === 'move') { tellState(); dials.ask(collect.move); }
    if (data.type === 'started' || (before !== data.state && !kActive.includes(data.state))) loadPlan().catch(complain);
    if (before !== data.state) askChoices().catch(complain);
    showCollect();
    showMap();
  }

  function tellState() {
    const error = collect.error || {};
    if (collect.state === 'paused' && collect.pause_reason === 'dial_fault') say(`❚❚ Paused: ${sentence(collect.trouble)} Mend it, then Continue (c) measures this point again. Accept (a) stores it with the fault, Skip (s) leaves it out.`);
    else if (collect.state === 'paused' && collect.trouble) say(`❚❚ Paused: ${sentence(collect.trouble)} Then Continue (c).`);
    else if (collect.state === 'paused') say('❚❚ Paused. Continue (c) goes on with the plan.');
    else if (collect.state === 'failed') say(`✕ The collection failed: ${sentence(error.message || collect.ended_because)} ${sentence((error.data || {}).hint)} What was stored is kept. Start (g) goes on at the next open point.`, true);
    else if (collect.move) say(`${collect.move.words} Then: Moved (m).`);
    else if (collect.state === 'done' && collect.session === session) say('✓ The plan is finished: nothing is left to measure. Next: Calibrate (k), then Diagnose (d).');
    else if (collect.state === 'stopped' && collect.session === session) say('■ Stopped. What is stored is kept; Start (g) goes on at the next open point.');
    else say('');
  }
  function sentence(text) {
    const plain = (text || '').trim();
    return plain && !/[.!?]$/.test(plain) ? plain + '.' : plain;
  }

  function onJob(data, time) {
    const stage = data.progress && data.progress.stage;
    if (data.kind === 'calibration' && (stage === 'qpso1' || stage === 'qpso2') && typeof data.progress.best_mm === 'number') {
      if (!swarms.has(data.job)) swarms.set(data.job, [{ name: 'swarm 1: noise of the filter', points: [] }, { name: 'swarm 2: parameters', points: [] }]);
      const curve = swarms.get(data.job)[stage === 'qpso1' ? 0 : 1].points;
      if (!curve.length || curve[curve.length - 1][0] < data.progress.done) curve.push([data.progress.done, data.progress.best_mm]);
    }
    if (data.type !== 'progress') note(`${data.kind} of ${data.session} ${data.type}${data.error ? ': ' + data.error.message : ''}`, time);
    if (data.session !== session) return;
    job = data;
    if (data.type !== 'progress') { showResult().catch(complain); askChoices().catch(complain); }
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
    if (list.sessions.length) { tellState(); dials.ask(collect.move); }
  }

  async function choose(name) {
    session = name || '';
    $('session').value = session;
    if (collect.session !== session) estimate = null;
    const known = session ? (await call('job.list', { session, limit: 1 })).jobs[0] : null;
    job = known || null;
    await loadPlan();
    showJob();
    showResult().catch(complain);
    showEstimate();
    showCollect();
    await askChoices();
  }

  // What can be done, and why the rest cannot, is the service's to say.
  async function askChoices() {
    const asked = ++choicesAsked, name = session;
    const answer = name ? await call('session.choices', { session: name }) : { choices: {}, warnings: [] };
    if (asked !== choicesAsked) return;
    choices = answer.choices;
    $('against').textContent = answer.warnings.map((each) => each.message + (each.where ? ` (${each.where})` : '')).join(' ');
    showButtons();
  }

  async function loadPlan() {
    const asked = ++planAsked, name = session, fresh = new Map();
    let total = name ? 1 : 0;
    for (let offset = 0; offset < total; offset += 200) {
      const page = await call('session.plan', { session: name, limit: 200, offset });
      total = page.total;
      for (const p of page.points) {
        fresh.set(keyOf(p), { name: nameOf(p), x: p.target_mm[0], y: p.target_mm[1], state: p.state, why: p.why });
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
    const active = kActive.includes(collect.state), fresh = live && Date.now() - liveAt < 5000;
    const watching = !active && fresh && live.stage === 'watching' && live.session === session;
    dials.show({ live, reading: fresh && (active || watching), active, watching, session, byHand: !!collect.move });
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
    $('state').textContent = { idle: '○ idle', starting: '▶ starting', running: '▶ collecting', paused: '❚❚ PAUSED', stopping: '■ stopping', done: '✓ collected', stopped: '■ stopped', failed: '✕ FAILED' }[collect.state] + (active && !here ? ` ${collect.session}` : '');
    if (active && here) {
      const point = collect.point ? `${kAt[collect.stage] || collect.stage} ${nameOf(collect.point)}` : collect.stage;
      $('progress').textContent = [`${collect.done} of ${collect.total} points`, duration(collect.eta_s), point].filter(Boolean).join(' · ');
      $('bar').value = collect.done;
      $('bar').max = collect.total || 1;
    } else {
      const tail = here && collect.ended_because ? `Ended: ${collect.ended_because}.` : done < points.size ? 'Start goes on at the next open point.' : '';
      $('progress').textContent = points.size ? `${done} of ${points.size} points measured. ${tail}` : session ? 'No plan yet.' : 'No session yet.';
      $('bar').value = done;
      $('bar').max = points.size || 1;
    }
    showButtons();
    showDials();
  }

  // Why a command cannot be given now; empty: it can. Its button is there where `seen` says so.
  function reason(name) {
    if (!link.state().open) return 'not connected';
    const active = kActive.includes(collect.state), paused = collect.state === 'paused';
    if (name in kNeedsSession && !session) return 'make a session first';
    if (name === 'start' && !active && session && points.size === 0) return '';  // makes the plan first
    if (name in kNeedsSession) return choices[name] === undefined ? 'asking the service' : choices[name] || '';
    if (name === 'halt') return session ? '' : 'make a session first';
    if (name === 'cancel') return jobRuns() ? '' : 'nothing is being calculated';
    if (!active) return 'nothing is being collected';
    if (name === 'pause' && collect.state !== 'running') return paused ? 'it is paused' : 'it is ' + collect.state;
    if (name === 'resume' && !paused) return 'it is not paused';
    if (name === 'accept' && !(paused && collect.pause_reason === 'dial_fault')) return 'only while paused for a dial fault';
    if (name === 'moved' && !collect.move_to) return 'nobody was asked to move the robot';
    if (name === 'stop' && collect.state === 'stopping') return 'it is stopping';
    return '';
  }
  const jobRuns = () => !!job && (job.state === 'running' || job.state === 'queued');
  function seen(name) {
    const active = kActive.includes(collect.state), paused = collect.state === 'paused';
    return { start: !active, pause: active && !paused, resume: paused, retake: active, skip: active, stop: active, accept: paused && !reason('accept'), moved: !!collect.move_to, cancel: jobRuns() }[name] !== false;
  }
  function showButtons() {
    for (const button of document.querySelectorAll('button[data-do]')) {
      const name = button.dataset.do, why = reason(name), small = button.querySelector('small');
      // Not `disabled`: it stays in the order of the keyboard, and says why.
      button.setAttribute('aria-disabled', why ? 'true' : 'false');
      button.title = why ? `Not now: ${why}.` : '';
      button.hidden = !seen(name);
      const words = why || kHelp[name] || '';
      if (small.textContent !== words) small.textContent = words;
    }
  }

  function showEstimate() {
    $('estimate').hidden = !estimate;
    if (!estimate) { $('estimate-words').textContent = 'Comes with the first sample of set G1.'; return; }
    const sd = estimate.position_sd_mm, open = estimate.undetermined;
    $('estimate-words').textContent = `After ${estimate.samples} samples the position of the tool is known to ${fixed(kCoverage * sd.mean, 3)} mm on average and ${fixed(kCoverage * sd.max, 3)} mm at the worst place (expanded uncertainty, k = ${kCoverage}).` + (sd.of_rig === undefined ? '' : ` What is not known of the rig makes ${fixed(kCoverage * sd.of_rig, 3)} mm there by itself.`) + (estimate.last_times_usual === null ? '' : ` The last sample is ${fixed(estimate.last_times_usual, 1)} times as far off as usual.`) + (open.length ? ` ${open.length} parameters need more points.` : ' Every parameter is determined.');
    drawing.parameters($('estimate').tBodies[0], estimate, { element, fixed, coverage: kCoverage });
  }

  function showJob() {
    const p = (job && job.progress) || {}, running = jobRuns(), curves = job && swarms.get(job.job);
    $('job-bar').hidden = !running;
    if (running && p.total) { $('job-bar').max = p.total; $('job-bar').value = p.done; }
    const stages = { ekf: 'extended Kalman filter', qpso1: 'swarm 1 of 2', qpso2: 'swarm 2 of 2', lm: 'least squares to compare', anfis: 'learning what is left (ANFIS)', report: 'intervals and tables' };
    const best = typeof p.best_mm === 'number' ? `best ${p.best_mm.toPrecision(4)} mm` : '';
    $('job-words').textContent = !job ? 'Nothing is being calculated.'
      : running ? [`${job.kind}: ${stages[p.stage] || p.stage || job.state}`, p.total ? `${p.done} of ${p.total}` : '', best, duration(p.eta_s)].filter(Boolean).join(' · ')
      : `${job.kind} ${job.state}${job.error ? ': ' + job.error.message : ''}`;
    $('swarms').hidden = !curves;
    if (curves) drawing.convergence($('convergence'), curves);
    showButtons();
  }

  async function showResult() {
    const name = session;
    $('result').textContent = '';
    if (!name) return;
    try {
      // The same model as in the report and in `sixdial compensate`.
      const found = await call('result.recommend', { session: name });
      if (name !== session) return;
      const model = (id) => found.candidates.find((each) => each.id === id) || {};
      const first = model('before'), last = model(found.by);
      const again = typeof last.reached_mm === 'number' && typeof first.reached_mm === 'number';
      const of = (each) => again ? each.reached_mm : each.g2_mm;
      // What speaks against the data comes before any figure of them.
      const told = (found.warnings || []).map((each) => each.message);
      if (found.state === 'not_calibrated') told.unshift('Not calibrated.');
      if (typeof of(first) === 'number' && typeof of(last) === 'number') {
        told.push(`Position error on G2: ${fixed(of(first), 3)} mm before, ${fixed(of(last), 3)} mm after (mean${again ? ', commanded again and measured' : ''}).`);
      }
      told.push(found.why);
      $('result').textContent = told.join(' ');
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
  const kNeedsSession = { start: 1, undo: 1, calibrate: 1, diagnose: 1, report: 1 };
  const commands = {
    start: ['Start', 'g', start],
    pause: ['Pause', 'p', () => call('collect.pause')],
    resume: ['Continue', 'c', () => call('collect.resume')],
    retake: ['Retake', 'r', () => call('collect.retake')],
    skip: ['Skip', 's', () => call('collect.skip')],
    accept: ['Accept', 'a', () => call('collect.accept')],
    moved: ['Moved', 'm', () => dials.moved(collect.move)],
    undo: ['Undo last', 'u', async () => { const now = await call('session.undo', { session, reason: 'undone on the live page' }); if (now.undone === null) say('There is nothing to undo.'); }],
    stop: ['Stop collecting', 'q', () => call('collect.stop')],
    halt: ['Stop robot', 'h', async () => say((await call('robot.stop', { session })).words)],
    calibrate: ['Calibrate', 'k', () => call('calibrate.start', { session })],
    diagnose: ['Diagnose', 'd', () => call('diagnose.start', { session })],
    cancel: ['Cancel', 'x', () => call('job.cancel', { job: job.job })],
    report: ['Open report', 'o', async () => { window.open(`report/${encodeURIComponent(session)}`, '_blank', 'noopener'); }],
  };
  const kHelp = { pause: 'after this point', resume: 'with the plan', retake: 'this or the last point', skip: 'leave it out', accept: 'store with the fault', moved: 'the robot is there', undo: 'withdraw a sample', stop: 'halts the robot, drops the point in hand, keeps what is stored; Start goes on', halt: 'halts it where it is and pauses; no emergency stop', start: 'at the next open point', calibrate: 'find the parameters', diagnose: 'name the causes', cancel: 'end the job', report: 'in a new tab' };
  async function run(name, sure = true) {
    if (name in kNeedsSession && session && choices[name] === undefined && link.state().open) await askChoices().catch(() => {});
    const why = reason(name);
    if (why) { say(`“${commands[name][0]}” cannot be done now: ${why}.`); return; }
    say('');
    if (!sure && name in kAsk) { ask(name); return; }
    try { await commands[name][2](); } catch (error) { complain(error); }
  }
  // A letter may be struck by chance: what stops, leaves out or takes back is asked first.
  const kAsk = { stop: 'Stop collecting?', skip: 'Leave this point out?', retake: 'Withdraw this sample and measure it again?', undo: 'Withdraw the last sample?', cancel: 'End the calculation?' };
  let asked = null;
  function ask(name) {
    asked = name;
    $('ask').hidden = !name;
    $('ask-words').textContent = name ? `${kAsk[name]} You pressed ${commands[name][1]}.` : '';
  }
  function answer(yes) {
    const name = asked;
    ask(null);
    if (yes && name) run(name);
  }
  $('ask-yes').onclick = () => answer(true);
  $('ask-no').onclick = () => answer(false);
  function pressed(key) {
    if (asked) {  // any other key is a no
      answer(key === 'y');
      return true;
    }
    const name = Object.keys(commands).find((each) => commands[each][1] === key);
    if (!name) return false;
    run(name, false);
    return true;
  }
  for (const name in commands) {
    const group = ['calibrate', 'diagnose', 'cancel', 'report'].includes(name) ? 'jobs' : 'buttons';
    const button = element($(group), 'button', name === 'start' || name === 'resume' ? 'main' : '', commands[name][0]);
    button.type = 'button';
    button.dataset.do = name;
    button.setAttribute('aria-keyshortcuts', commands[name][1]);
    element(button, 'kbd', '', commands[name][1]);
    element(button, 'small');
    button.onclick = () => run(name);
  }
  for (const name in commands) {
    const item = element($('keys'), 'li');
    element(item, 'kbd', '', commands[name][1]);
    item.append(' ' + commands[name][0]);
  }
  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || /^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName)) return;
    // Tab and Enter are for the buttons, also for those of the question.
    if (event.key.length > 1 && event.key !== 'Escape') return;
    if (pressed(event.key)) event.preventDefault();
  });
  $('session').onchange = () => choose($('session').value).then(tellState).catch(complain);
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
})();
