// The page of commands. The token stays in this module's memory: no cookie, no storage, no address has it.
const part = (name) => document.getElementById(name);
const most_reports = 500;
let token = '';
let place = '';

// Text is only ever set as text, never as markup.
function item(text, kind = '') {
  const element = document.createElement('li');
  element.textContent = text;
  if (kind) element.className = kind;
  return element;
}

async function ask(path, options = {}) {
  const headers = { Authorization: `Bearer ${token}`, ...options.headers };
  const answer = await fetch(path, { ...options, headers, credentials: 'omit', cache: 'no-store' });
  if (!answer.ok) {
    const error = new Error((await answer.text()).replace(/^\d+: /, '').trim());
    error.status = answer.status;
    throw error;
  }
  return answer.json();
}

function connected(text, kind) {
  part('connection').textContent = text;
  part('connection').className = kind;
}

const kinds = [[/^(refused|failed|not sent|no answer yet|nothing has come|a wrong token)/, 'bad'], [/^done: /, 'good']];
const kind_of = (text) => kinds.find(([form]) => form.test(text))?.[1] ?? '';

function show(answer) {
  const list = part('reports');
  // Who reads further up is left there.
  const atEnd = list.scrollHeight - list.scrollTop - list.clientHeight < 24;
  if (answer.full) list.replaceChildren();
  for (const [utc_ms, text] of answer.lines) {
    list.append(item(`${new Date(utc_ms).toISOString().slice(11, 19)} ${text}`, kind_of(text)));
  }
  while (list.childElementCount > most_reports) list.firstElementChild.remove();
  if (atEnd) list.scrollTop = list.scrollHeight;
  part('panel').replaceChildren(...answer.panel.map((text) => item(text)));
  const waiting = answer.waiting.length ? answer.waiting.map((text) => item(text)) : [item('none', 'note')];
  part('waiting').replaceChildren(...waiting);
  place = answer.place;
}

const pause = (ms) => new Promise((done) => setTimeout(done, ms));

async function follow() {
  for (;;) {
    try {
      show(await ask(`/reports?after=${encodeURIComponent(place)}`));
      connected('connected', 'good');
    } catch (error) {
      if (error.status === 403 || error.status === 401) {
        token = '';
        part('desk').hidden = true;
        part('token-form').hidden = false;
        part('token-problem').textContent = error.message;
        connected('no token', 'warn');
        return;
      }
      connected(error.status ? error.message : 'not connected; trying again', 'bad');
      await pause(2000);
    }
  }
}

part('token-form').addEventListener('submit', async (event) => {
  event.preventDefault();
  token = part('token').value.trim();
  part('token').value = '';
  part('token-problem').textContent = '';
  try {
    part('help').replaceChildren(...(await ask('/help')).map((text) => item(text)));
  } catch (error) {
    token = '';
    part('token-problem').textContent = error.status ? error.message : 'the server does not answer';
    return;
  }
  part('token-form').hidden = true;
  part('desk').hidden = false;
  part('line').focus();
  place = '';
  follow();
});

part('line-form').addEventListener('submit', async (event) => {
  event.preventDefault();
  const line = part('line').value.trim();
  const answer = part('answer');
  try {
    const body = JSON.stringify({ line });
    const sent = await ask('/commands', { method: 'POST', headers: { 'Content-Type': 'application/json' }, body });
    answer.textContent = `taken: ${sent.line}`;
    answer.className = '';
    part('line').value = '';
  } catch (error) {
    answer.textContent = error.status ? error.message : 'the server does not answer; nothing may have been sent';
    answer.className = 'bad';
  }
});

part('line').addEventListener('input', async () => {
  const typed = part('line').value;
  try {
    const lines = await ask(`/complete?typed=${encodeURIComponent(typed)}`);
    if (typed !== part('line').value) return;
    part('complete').replaceChildren(...lines.slice(0, 60).map((line) => new Option(line, line)));
  } catch {
    // Completion is a help only; `follow` says what is wrong.
  }
});
