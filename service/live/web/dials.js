// The dials on the live page: as they are, whether a session is collected or not; the check "push
// each with a finger"; and the fields for a robot that a person moves.
'use strict';
const openDials = (() => {
  const kDeg = 180 / Math.PI;
  const kSymbols = { ok: '✓', settling: '≈', waiting: '…', free: '○', stale: '◷', lost: '✕', unread: '–' };
  const kWords = { ok: 'ok', settling: 'settling', waiting: 'moving', free: 'no contact', stale: 'STALE', lost: 'LOST', unread: 'not read' };
  const kAskAgain = 10000;  // ms: the service lets go of dials that nobody asks for
  const kSilent = 0.5;      // s without an answer of the controller

  /// on: {$, element, fixed, call, complain, session(), changed()}.
  return function openDials({ $, element, fixed, call, complain, session, changed }) {
    let asking = 0, askedFor = '', checking = false;

    function cards(ids) {
      const box = $('dials');
      if (box.children.length === ids.length && [...box.children].every((card, i) => card.dataset.dial === ids[i])) return box.children;
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
      return box.children;
    }

    function why(dial, state) {
      if (!dial || state === 'free') return '';
      if (state === 'waiting') return 'no value while the robot moves';
      return dial.detail || (dial.reason ? dial.words || dial.reason : '');
    }

    /// now: {live, reading: it is of now, active: a session is collected, watching, session}
    function show(now) {
      const { live, reading, active, watching } = now;
      for (const card of cards(live ? Object.keys(live.dials) : ['A', 'B', 'C', 'D', 'E', 'F'])) {
        const dial = reading ? live.dials[card.dataset.dial] : null;
        const state = dial ? dial.state : 'unread';
        card.dataset.state = state;
        card.dataset.asked = !!(watching && live.check && live.check.asked === card.dataset.dial);
        card.querySelector('span').textContent = `${kSymbols[state]} ${kWords[state]}`;
        const value = card.querySelector('.value');
        value.textContent = dial && typeof dial.value_mm === 'number' ? fixed(dial.value_mm, 3) : '––.–––';
        element(value, 'small', '', ' mm');
        const words = card.querySelector('.why');
        words.textContent = why(dial, state);
        words.title = words.textContent;
      }
      showPose(reading ? live.pose : null);
      showSettle(now);
      showSilent(reading && active ? live.robot_silent_s || 0 : 0);
      showWatch(now);
    }

    function showPose(pose) {
      $('pose').replaceChildren();
      const rows = [['x', pose && pose.x_mm, 3, 'mm'], ['y', pose && pose.y_mm, 3, 'mm'], ['γ', pose && pose.gamma_rad * kDeg, 3, '°']];
      for (const [name, value, digits, unit] of rows) {
        const cell = element($('pose'), 'div');
        element(cell, 'small', '', `${name} `);
        cell.append(pose ? fixed(value, digits) : '––.–––');
        element(cell, 'small', '', ` ${unit}`);
      }
    }

    function showSettle({ live, reading, active, watching, byHand }) {
      const settle = reading ? live.settle : null;
      const from = reading && live.pose ? `Position from dials ${live.pose.dials.join(', ')}` : reading && !watching ? 'No position: fewer than three dials tell' : '';
      if ($('pose-from').textContent !== from) $('pose-from').textContent = from;
      const bar = $('settle-bar'), share = settle && settle.limit_mm ? settle.spread_mm / settle.limit_mm : 0;
      bar.hidden = !(settle && settle.limit_mm);
      bar.firstElementChild.style.width = `${Math.min(100, 50 * share)}%`;
      bar.setAttribute('aria-valuenow', share.toFixed(2));
      bar.dataset.settled = !!(settle && settle.settled);
      let words = '';
      if (!reading) words = active ? '… waiting for the dials' : 'Nothing is collected. Show dials reads them without moving anything.';
      else if (watching) words = 'Nothing is collected: the dials as they are.';
      else if (settle.limit_mm) words = `${settle.settled ? '✓ settled' : '≈ settling'}: dial ${settle.dial} moves within ${fixed(settle.spread_mm, 3)} mm, ${fixed(settle.limit_mm, 3)} allowed`;
      else if (live.robot_silent_s >= kSilent) words = '✕ the robot\'s controller does not answer';
      else if (live.stage === 'moving') words = byHand ? '→ waiting until somebody has moved the robot' : '→ the robot is moving';
      else if (live.stage === 'paused') words = '❚❚ paused: readings as they are';
      else words = '≈ settling: too few readings yet';
      if ($('settle-words').textContent !== words) $('settle-words').textContent = words;
    }

    // An alert is read out at each change: the seconds stay out of it.
    function showSilent(seconds) {
      const words = seconds >= kSilent ? '✕ The robot\'s controller does not answer. The robot may be moving: keep clear, and use the emergency stop if in doubt.' : '';
      if ($('silent').textContent !== words) $('silent').textContent = words;
      $('silent').hidden = !words;
    }

    // ---- while nothing is collected ------------------------------------------------------------
    async function ask() {
      askedFor = session();
      await call('dials.watch', { session: askedFor, for_s: 30 });
    }
    async function watch() {
      await ask();
      clearInterval(asking);
      asking = setInterval(() => { if (askedFor === session()) ask().catch(leave); else leave(); }, kAskAgain);
      changed();
    }
    function leave() {
      clearInterval(asking);
      asking = 0;
      checking = false;
    }
    async function stop() {
      leave();
      await call('dials.stop');
      changed();
    }
    async function check(step) {
      if (step === 'start') await watch();
      await call('dials.check', { do: step });
      checking = step !== 'end';
    }

    function showWatch({ live, watching, active, session: name }) {
      if (active && asking) leave();
      $('watch').hidden = active || !name;
      $('watch-start').hidden = !!watching;
      $('watch-stop').hidden = !watching;
      const found = watching ? live.check : null;
      $('check-start').hidden = !!found && !found.done;
      for (const id of ['check-again', 'check-skip']) $(id).hidden = !found || (id === 'check-skip' && found.done);
      $('check').hidden = !found;
      if (!found) return;
      const words = found.done ? (found.good ? '✓ Every dial is wired, counts and measures as the rig file says.' : '✕ Not all are good: mend what the list says, then check again.') : found.instruction;
      if ($('check-words').textContent !== words) $('check-words').textContent = words;
      const lines = found.dials.filter((dial) => dial.verdict !== 'open').map((dial) => (dial.verdict === 'good' ? '✓ ' : '✕ ') + dial.words);
      if ($('check-list').dataset.lines === lines.join('\n')) return;
      $('check-list').dataset.lines = lines.join('\n');
      $('check-list').replaceChildren(...lines.map((line) => Object.assign(document.createElement('li'), { textContent: line })));
    }

    const on = (id, act) => { $(id).onclick = () => Promise.resolve(act()).catch(complain); };
    on('watch-start', watch);
    on('watch-stop', stop);
    on('check-start', () => check('start'));
    on('check-again', () => check('again'));
    on('check-skip', () => check('skip'));

    // ---- a robot that a person moves -----------------------------------------------------------
    /// move: of collect.status, or null.
    function askMove(move) {
      $('by-hand').hidden = !move;
      $('by-hand').replaceChildren();
      if (!move) return;
      element($('by-hand'), 'p', '', 'Where the encoders show it now, if that is not exactly what was asked for:');
      for (const joint of move.joints) {
        const label = element($('by-hand'), 'label', '', `${joint.joint} `);
        const field = element(label, 'input');
        Object.assign(field, { type: 'number', step: 'any', value: joint.to.toFixed(4) });
        field.dataset.joint = joint.joint;
        field.dataset.unit = joint.unit;
        field.dataset.asked = field.value;
        label.append(` ${joint.unit}`);
      }
      const sure = element($('by-hand'), 'label', '');
      const box = element(sure, 'input');
      Object.assign(box, { type: 'checkbox', id: 'by-hand-sure' });
      sure.append(' it really stands that far away');
    }
    /// What was asked for, or what the fields say.
    async function moved(move) {
      const fields = [...$('by-hand').querySelectorAll('input[type=number]')];
      const params = {};
      if (move && fields.some((field) => field.value !== field.dataset.asked)) {
        params.joints = {};
        for (const field of fields) {
          const turns = field.dataset.unit === 'deg';
          params.joints[`${field.dataset.joint}_${turns ? 'rad' : field.dataset.unit}`] = Number(field.value) / (turns ? kDeg : 1);
        }
        if ($('by-hand-sure').checked) params.confirm = true;
      }
      await call('collect.moved', params);
      askMove(null);
    }

    return { show, ask: askMove, moved, checking: () => checking };
  };
})();
