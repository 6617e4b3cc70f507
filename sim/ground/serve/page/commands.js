// The panel of commands, which the page loads where the server takes them. The token stays in this module's memory: no
// cookie, no storage, no address has it.
const part = (name) => document.getElementById(name);
const most_reports = 500;
let token = '';
let place = '';

const panel = document.createElement('section');
panel.innerHTML = `<h2>Commands</h2>
<form id="token-form" autocomplete="off">
  <p>The panel asks for the token that the server was started with. It is kept until the page is closed or loaded again.</p>
  <div class="bar">
    <label>Token <input id="token" type="password" autocomplete="off" spellcheck="false" required></label>
    <button>Begin</button>
  </div>
  <p id="token-problem" class="bad" role="alert"></p>
</form>
<div id="desk" hidden>
  <ul id="panel" class="log"></ul>
  <form id="line-form" class="bar" autocomplete="off">
    <label class="wide">Command <input id="line" list="complete" autocomplete="off" spellcheck="false" maxlength="1000"
      placeholder="capture +5"></label>
    <datalist id="complete"></datalist>
    <button>Send</button>
  </form>
  <p id="answer" role="status"></p>
  <details><summary>All commands</summary><ul id="help" class="log"></ul></details>
  <h3>Waiting for their last report</h3>
  <ul id="open" class="log"></ul>
  <h3>Reports</h3>
  <ol id="reports" class="log"></ol>
</div>`;
part('overview').after(panel);

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

function tell(text, kind) {
  part('answer').textContent = text;
  part('answer').className = kind;
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
  part('open').replaceChildren(...waiting);
  place = answer.place;
}

const pause = (ms) => new Promise((done) => setTimeout(done, ms));

async function follow() {
  for (;;) {
    try {
      show(await ask(`/reports?after=${encodeURIComponent(place)}`));
    } catch (error) {
      if (error.status === 403 || error.status === 401) {
        token = '';
        part('desk').hidden = true;
        part('token-form').hidden = false;
        part('token-problem').textContent = error.message;
        return;
      }
      // A lost connection is told on top of the page.
      if (error.status) tell(error.message, 'bad');
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
  try {
    const body = JSON.stringify({ line });
    const sent = await ask('/commands', { method: 'POST', headers: { 'Content-Type': 'application/json' }, body });
    tell(`taken: ${sent.line}`, '');
    part('line').value = '';
  } catch (error) {
    tell(error.status ? error.message : 'the server does not answer; nothing may have been sent', 'bad');
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
