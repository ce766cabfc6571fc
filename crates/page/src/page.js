"use strict";
const $ = id => document.getElementById(id);
// The address ends with the token, so that every request beside it has it.
const base = location.pathname.replace(/[^/]*$/, "");
const at = (path, query) => base + path + (query ? "?" + Object.entries(query).map(([k, v]) => k + "=" + encodeURIComponent(v)).join("&") : "");
const page = { data: null, look: null, spec: null, saved: null, version: "", conflict: false, saving: Promise.resolve(), checked: 0, job: null, asked: false, mine: null, languages: [], ok: false, open: false, ticked: [], datas: [], files: null, back: [], editing: Promise.resolve(), part: null, sketch: null, constants: null, running: false, gone: false };
const isSpec = name => /\.ron$/i.test(name);

async function ask(path, query, body, headers) {
  const method = body === undefined ? "GET" : "POST";
  let answer;
  try { answer = await fetch(at(path, query), { method, body, headers }); }
  catch { throw new Error("the program does not answer: start `phisindy open` again if it has ended; nothing is lost"); }
  const told = await answer.json();
  if (!answer.ok) throw Object.assign(new Error(told.error), { status: answer.status });
  return told;
}
const tell = why => { $("problem").textContent = why ? (why.message || why) : ""; };
const guarded = work => async (...all) => { try { tell(""); return await work(...all); } catch (why) { tell(why); } };
function made(tag, text, set) {
  const e = document.createElement(tag);
  if (text !== undefined) e.textContent = text;
  return Object.assign(e, set || {});
}
const short = x => x === null || x === undefined ? "" : (x === 0 ? "0" : (Math.abs(x) >= 1e5 || Math.abs(x) < 1e-3) ? x.toExponential(2) : String(+x.toPrecision(4)));

// The folder.
async function folder() {
  const state = await ask("api/state");
  page.languages = state.languages;
  page.datas = state.data;
  showFiles();
  steps();
  $("where").textContent = state.folder;
  document.title = "phisindy - " + state.folder.split(/[\\/]/).pop();
  const list = (id, all, open) => $(id).replaceChildren(...(all.length ? all.map(open) : [made("li", "none yet", { className: "soft" })]));
  const link = (name, open) => made("button", name, { type: "button", className: "link", onclick: guarded(() => open(name)) });
  const item = open => name => { const li = made("li"); li.append(link(name, open)); return li; };
  list("specs", state.specs, item(openSpec));
  list("datas", state.data, item(openData));
  list("results", state.results, result => {
    const li = made("li");
    const how = result.ended + (result.stopped ? ", stopped early" : "") + (result.laws.length ? ": " + result.laws.join(", ") : "");
    const tick = made("input", undefined, { type: "checkbox", value: result.name, checked: page.ticked.includes(result.name), ariaLabel: "compare " + result.name, onchange: guarded(() => ticked(tick)) });
    const head = made("div", undefined, { className: "row" });
    head.append(tick, link(result.name, showResult));
    li.append(head, made("div", result.title), made("div", how, { className: "soft" }), made("div", new Date(1000 * result.time).toLocaleString(), { className: "soft" }));
    return li;
  });
  return state;
}

// 1. Data.
async function taken(files) {
  const names = [], wrong = [];
  for (const [k, file] of [...files].entries()) {
    $("data-name").textContent = "reading " + file.name + (files.length > 1 ? " (" + (k + 1) + " of " + files.length + ")" : "") + " ...";
    try { names.push((await ask(isSpec(file.name) ? "api/new-spec" : "api/data", { name: file.name }, file)).name); }
    catch (why) { wrong.push(file.name + ": " + why.message); }
  }
  $("data-name").textContent = page.data || "";
  await folder();
  const [spec, data] = [names.find(isSpec), names.find(name => !isSpec(name))];
  if (data) await openData(data);
  if (spec) await openSpec(spec);
  if (wrong.length) throw new Error(wrong.join("; "));
}
async function openData(name) {
  page.data = name;
  page.rate = page.rig = "";
  $("data-name").textContent = name;
  showColumns(await ask("api/look", { name }, "null"));
}
function showColumns(look) {
  $("seen").hidden = false;
  const mistakes = look.diagnostics.filter(d => d.error);
  $("data-mistake").textContent = mistakes.map(d => [d.message, ...d.help].join(" - ")).join("\n");
  $("write").disabled = mistakes.length > 0;
  if (!look.columns) {
    // Nothing is invented: the rate is asked for.
    if (look.counted) $("rate-row").hidden = false;
    if (look.counted && !(page.look && page.look.name === look.name)) {
      $("rate").value = "";
      for (const id of ["summary", "curves", "columns"]) $(id).replaceChildren();
    }
    return;
  }
  page.look = look;
  $("rig").replaceChildren(made("option", "as the columns say", { value: "" }), ...look.rigs.map(name => made("option", name, { value: name, selected: name === page.rig })));
  $("questions").replaceChildren(...look.questions.map(text => made("li", text)));
  $("rate-row").hidden = !look.counted;
  $("rate").value = look.rate;
  $("summary").replaceChildren(...look.summary.map(line => made("p", line)));
  const time = look.columns.find(c => c.role === "time");
  $("curves-of").textContent = "Curves of " + look.name + " over time (" + (time && time.unit || "s") + ")";
  $("curves").replaceChildren(...look.preview.map(curve));
  $("columns").replaceChildren(...look.columns.map(column => columnRow(column, look.roles)));
}
function columnRow(column, roles) {
  const row = made("tr");
  const cell = (content, className) => { const td = made("td", undefined, { className: className || "" }); td.append(content); row.append(td); };
  const role = made("select", undefined, { ariaLabel: "what " + column.heading + " is" });
  role.append(...roles.map(r => made("option", r.words, { value: r.id, selected: r.id === column.role })));
  const unit = made("input", undefined, { value: column.unit || "", ariaLabel: "unit of " + column.heading });
  row.dataset.heading = column.heading;
  role.onchange = guarded(() => { unit.value = ""; return reassign(); });
  unit.onchange = guarded(reassign);
  cell(column.heading); cell(role); cell(unit);
  for (const key of ["min", "max", "noise"]) cell(key === "noise" && column.role === "time" ? "" : short(column[key]), "number");
  cell(column.frequency ? short(column.frequency) + " Hz" : "", "number");
  cell(column.usage);
  return row;
}
async function reassign() {
  const said = [...$("columns").rows].map(row => ({ heading: row.dataset.heading, role: row.querySelector("select").value, unit: row.querySelector("input").value.trim() }));
  showColumns(await ask("api/look", { name: page.data, rate: page.rate, rig: page.rig || "" }, JSON.stringify(said)));
}
$("rig").onchange = guarded(() => { page.rig = $("rig").value; return reassign(); });
$("rate").onchange = guarded(() => { page.rate = $("rate").value.trim(); return reassign(); });
function curve(c) {
  const W = 900, H = 110, left = 8, points = c.points.filter(p => p[1] !== null);
  if (!points.length) return document.createElement("div");
  const xs = points.map(p => p[0]), ys = points.map(p => p[1]);
  const [x0, x1] = [Math.min(...xs), Math.max(...xs)], [y0, y1] = [Math.min(...ys), Math.max(...ys)];
  const X = x => left + (W - 2 * left) * (x - x0) / ((x1 - x0) || 1), Y = y => H - 22 - (H - 40) * (c.log ? Math.log(y / y0) / (Math.log(y1 / y0) || 1) : (y - y0) / ((y1 - y0) || 1));
  const { box, put } = drawing(W, H, `${c.heading} against time, from ${short(y0)} to ${short(y1)}`);
  put("text", { x: left, y: 12 }, `${c.heading}, from ${short(y0)} to ${short(y1)} ${c.unit || ""}`);
  put("polyline", { points: points.map(p => X(p[0]).toFixed(1) + "," + Y(p[1]).toFixed(1)).join(" "), fill: "none", stroke: "var(--blue)", "stroke-width": 1.3 });
  put("text", { x: left, y: H - 4 }, short(x0)); put("text", { x: W - left, y: H - 4, "text-anchor": "end" }, short(x1));
  return box;
}
// A picture with these words for who does not see it, and what puts a mark into it.
function drawing(W, H, words) {
  const box = document.createElement("div"), ns = "http://www.w3.org/2000/svg", svg = document.createElementNS(ns, "svg");
  svg.setAttribute("viewBox", `0 0 ${W} ${H}`); svg.setAttribute("width", "100%"); svg.setAttribute("role", "img");
  svg.setAttribute("aria-label", words);
  box.append(svg);
  return { box, put: (tag, set, text) => { const e = document.createElementNS(ns, tag); for (const k in set) e.setAttribute(k, set[k]); if (text) e.textContent = text; svg.append(e); } };
}

// 2. The model: a line of the text is a block, a mistake stands below its line.
const code = $("code");
function setText(text) {
  code.replaceChildren(...text.replace(/\n$/, "").split("\n").map(line => { const div = made("div", line); if (!line) div.append(made("br")); return div; }));
}
function blocks() { return [...code.childNodes].map(node => [node, node.nodeName === "BR" ? "" : node.textContent.replace(/\n$/, "")]); }
function text() { return blocks().map(([, line]) => line).join("\n").replace(/\u00a0/g, " ") + "\n"; }
const dirty = () => page.spec !== null && text() !== page.saved;
async function openSpec(name) {
  while (dirty()) await save();
  const told = await ask("api/spec", { name });
  // What was typed meanwhile comes first.
  if (dirty()) return openSpec(name);
  if (page.spec !== name) Object.assign(page, { back: [], part: null, sketch: null, constants: null });
  Object.assign(page, { spec: name, version: told.version });
  $("spec-name").textContent = name;
  code.hidden = false;
  setText(told.text);
  page.saved = text();
  await checked();
}
// One after the other: each save names the version that the one before has made.
function save() {
  clearTimeout(page.timer);
  return page.saving = page.saving.catch(() => {}).then(saved);
}
async function saved() {
  if (page.conflict) throw new Error("`" + page.spec + "` was changed elsewhere: say below what is to become of your text");
  const now = text();
  if (page.spec === null || now === page.saved) return;
  try { page.version = (await ask("api/spec", { name: page.spec }, now, { "If-Match": page.version })).version; }
  catch (why) { if (why.status === 412) conflict(true); throw why; }
  page.saved = now;
}
function conflict(is) {
  page.conflict = is;
  $("conflict").hidden = !is;
  $("conflict-name").textContent = page.spec;
  buttons();
}
$("keep-mine").onclick = guarded(async () => {
  const now = text(), told = await ask("api/new-spec", { name: page.spec }, now);
  Object.assign(page, { spec: told.name, version: told.version, saved: now });
  $("spec-name").textContent = told.name;
  conflict(false);
  await folder();
  await checked();
});
$("take-other").onclick = guarded(async () => { page.saved = text(); conflict(false); await openSpec(page.spec); });
async function checked() {
  const turn = ++page.checked;
  const told = await ask("api/check", { name: page.spec }, text());
  if (turn !== page.checked) return;
  page.ok = told.ok; page.open = told.open;
  showModel(told);
  mark(told.diagnostics);
  const errors = told.diagnostics.filter(d => d.error).length, warnings = told.diagnostics.length - errors;
  const count = (n, word) => n + " " + word + (n === 1 ? "" : "s");
  $("told").textContent = errors ? count(errors, "mistake") : "no mistakes" + (warnings ? ", " + count(warnings, "warning") : "");
  $("told").className = errors ? "wrong" : "soft";
  buttons();
}
// The sketch and the constants are the text in another form: what is changed there is one edit of it, made by the program.
function edit(wish, said) {
  return page.editing = page.editing.then(async () => {
    const before = text(), name = page.spec;
    $("refused").textContent = $("edited").textContent = "";
    try {
      const after = (await ask("api/edit", { name }, JSON.stringify({ ...wish, text: before }))).text;
      if (page.spec !== name || text() !== before) throw new Error("the text was changed meanwhile: try again");
      if (after === before) return;
      setText(after);
      page.back.push([before, text()]);
      $("edited").textContent = said;
      await put();
    } catch (why) { $("refused").textContent = why.message; showModel({}); }
  });
}
async function put() {
  clearTimeout(page.timer);
  buttons();
  steps();
  await save();
  await checked();
}
const isBack = () => page.back.length > 0 && page.back.at(-1)[1] === text();
$("back").onclick = guarded(async () => {
  if (!isBack()) return;
  setText(page.back.pop()[0]);
  $("refused").textContent = "";
  $("edited").textContent = "went one step back";
  await put();
});
function showModel(told) {
  $("model").hidden = false;
  if (told.constants) { page.constants = told.constants; page.files = told.files; }
  if (!$("files").contains(document.activeElement) || told.files) showFiles();
  if (told.sketch || told.ok) {
    const same = page.sketch && told.sketch && page.sketch.svg === told.sketch.svg;
    page.sketch = told.sketch;
    if (!same) drawSketch();
  }
  if (told.diagnostics) $("sketch").classList.toggle("stale", !told.sketch);
  $("sketch").hidden = $("sketch-hint").hidden = !page.sketch;
  const all = page.constants || [];
  $("constants-box").hidden = !all.length;
  fill($("constants"), "form", all);
  showPart();
}
// Which files of the folder the spec reads, and what for.
function showFiles() {
  const roles = name => [...new Set(page.files.filter(f => f.file === name).map(f => f.role))];
  const all = page.files && page.files.length ? [...new Set([...page.files.map(f => f.file), ...page.datas])] : [];
  if ($("files-box").hidden && all.length > 1) $("files-box").open = true;
  $("files-box").hidden = !all.length;
  $("files").replaceChildren(...all.map(name => {
    const li = made("li"), now = roles(name), e = made("select", undefined, { ariaLabel: "what " + name + " is for" });
    const words = [["none", "not used"], ["Fit", "to fit"], ["Validate", "to validate"], ...(now.length > 1 ? [["both", "a part to fit, a part to validate"]] : [])];
    e.append(...words.map(([value, words]) => made("option", words, { value })));
    e.value = now.length > 1 ? "both" : now[0] || "none";
    e.onchange = () => edit({ what: "record", file: name, to: e.value }, name + ": changed in the text");
    li.append(made("b", name), e);
    return li;
  }));
}
function drawSketch() {
  const had = document.activeElement && document.activeElement.dataset.key;
  $("sketch").hidden = false;
  $("sketch").innerHTML = page.sketch ? page.sketch.svg : "";
  for (const g of $("sketch").querySelectorAll("[data-part]")) {
    const part = page.sketch.parts.find(p => p.key === g.dataset.part);
    if (!part) continue;
    const box = g.getBBox(), hit = document.createElementNS("http://www.w3.org/2000/svg", "rect");
    const set = { class: "hit", role: "button", tabindex: 0, "aria-label": part.title, "aria-controls": "part", "data-key": part.key, x: box.x - 5, y: box.y - 4, width: box.width + 10, height: box.height + 8, rx: 4 };
    for (const k in set) hit.setAttribute(k, set[k]);
    g.append(hit);
    for (const words of g.querySelectorAll("text")) words.setAttribute("aria-hidden", true);
    const choose = () => { page.part = part.key; showPart(); $("part-title").focus(); };
    hit.onclick = choose;
    hit.onkeydown = event => { if (event.key === "Enter" || event.key === " ") { event.preventDefault(); choose(); } };
    if (part.key === had) hit.focus();
  }
}
function closePart() {
  const g = $("sketch").querySelector("[data-key=\"" + page.part + "\"]");
  page.part = null;
  showPart();
  if (g) g.focus();
}
$("part-close").onclick = closePart;
$("part").onkeydown = event => { if (event.key === "Escape") closePart(); };
function showPart() {
  const part = page.part && page.sketch && page.sketch.parts.find(p => p.key === page.part);
  const inside = $("part").contains(document.activeElement);
  for (const g of $("sketch").querySelectorAll("[role=button]")) g.setAttribute("aria-expanded", Boolean(part) && g.dataset.key === part.key);
  $("part").hidden = !part;
  if (!part) { page.part = null; if (inside) $("back").focus(); return; }
  const all = (page.constants || []).filter(c => part.constants.includes(c.name));
  $("part-title").textContent = part.title;
  fill($("part-numbers"), "part", all);
  const body = Boolean(part.new), key = JSON.stringify([part.key, part.can, part.new]);
  if ($("part").dataset.shown === key) return;
  $("part").dataset.shown = key;
  const words = { base: "Move to the base", ground: "Move to the ground", remove: "Remove", contact: "Add a contact here (dry friction)" };
  const act = what => made("button", words[what], { type: "button", onclick: () => edit({ what, part: part.key }, words[what] + ": done") });
  const note = all.length || body || part.key.includes("friction") ? [] : [made("span", "Its number stands in the text.", { className: "soft" })];
  $("part-actions").replaceChildren(...part.can.filter(what => words[what]).map(act), ...note);
  const adds = { mass: "Name the mass", damper: "Add a damper", spring: "Add a spring" };
  $("part-new").replaceChildren(...part.can.filter(what => adds[what]).map(what => {
    const form = made("form", undefined, { className: "new" }), own = part.new[what];
    const field = (name, value, label) => made("input", undefined, { name, value, ariaLabel: label + ", " + adds[what], required: name !== "unit" });
    const all = [field("name", own.name, "name"), field("value", "", "number"), field("unit", own.unit, "unit")];
    all[1].placeholder = "number"; all[1].inputMode = "decimal";
    form.append(...all.slice(0, 1), made("span", "="), ...all.slice(1), made("button", adds[what]));
    form.onsubmit = event => { event.preventDefault(); edit({ what, part: part.key, name: all[0].value, value: all[1].value, unit: all[2].value }, adds[what] + ": done"); };
    return form;
  }));
}
// Rows that stay are not built again: somebody may be typing in one.
function fill(list, place, all) {
  const shape = JSON.stringify(all.map(c => [c.name, c.record, c.kind])), active = document.activeElement, had = active && active.dataset.at;
  if (list.dataset.shape !== shape) {
    list.dataset.shape = shape;
    list.replaceChildren(...all.map(c => constantRow(c, place)));
    const again = had && [...list.querySelectorAll("[data-at]")].find(e => e.dataset.at === had);
    if (again) again.focus();
  }
  for (const [k, c] of all.entries()) for (const e of list.children[k].querySelectorAll("[data-field]")) {
    const value = String(c[e.dataset.field] ?? "");
    if (e.dataset.was !== value || e !== document.activeElement) e.value = e.dataset.was = value;
  }
}
function constantRow(c, place) {
  const li = made("li"), of = c.name + (c.record === null ? "" : " of record " + (c.record + 1));
  const field = (field, label, e = made("input")) => {
    Object.assign(e.dataset, { field, at: [place, c.record, c.name, field].join("/") });
    e.ariaLabel = label + " of " + of;
    e.onchange = () => edit({ what: "constant", name: c.name, record: c.record, field, to: e.value }, of + ": changed in the text");
    return e;
  };
  li.append(made("b", of));
  if (c.kind === "greatest") { li.append(made("span", "the greatest " + c.value + " of each record")); return li; }
  const value = field("value", "value");
  li.append(value);
  if (c.kind === "formula") { value.className = "formula"; li.append(made("span", "follows from others")); return li; }
  value.inputMode = "decimal";
  const kind = made("select");
  kind.append(...[["held", "is known"], ["within", "is known roughly"], ["find", "is to be found"]].map(([value, words]) => made("option", words, { value })));
  li.append(field("unit", "unit"), field("kind", "how far", kind));
  if (c.kind !== "held") li.append(made("span", "from"), field("low", "least value"), made("span", "to"), field("high", "greatest value"));
  return li;
}
function mark(diagnostics) {
  const all = blocks(), lines = [], ranges = [], others = [];
  for (const [node, line] of all) for (const part of line.split("\n")) lines.push([node, part]);
  for (const [node] of all) if (node.dataset) { delete node.dataset.told; node.classList.remove("doubt"); }
  for (const d of diagnostics) {
    const words = [d.message + (d.place && d.place.words ? ": " + d.place.words : ""), ...d.help.map(h => "  " + h)];
    const there = d.place && !d.place.file && lines[d.place.line - 1];
    if (!there || !there[0].dataset) { others.push((d.place ? (d.place.file || "") + ":" + d.place.line + ": " : "") + words.join(" -")); continue; }
    const indent = " ".repeat(Math.max(0, d.place.column - 1));
    const caret = indent + "^".repeat(Math.min(d.place.length, 60)) + " ";
    const under = caret + words[0] + words.slice(1).map(w => "\n" + indent + w).join("");
    there[0].dataset.told = there[0].dataset.told ? there[0].dataset.told + "\n" + under : under;
    there[0].classList.toggle("doubt", !d.error);
    const leaf = there[0].firstChild, from = d.place.column - 1;
    if (leaf && leaf.nodeType === 3 && from < leaf.length) {
      const range = document.createRange();
      range.setStart(leaf, from); range.setEnd(leaf, Math.min(leaf.length, from + d.place.length));
      ranges.push(range);
    }
  }
  if (window.CSS && CSS.highlights) CSS.highlights.set("mistake", new Highlight(...ranges));
  $("others").replaceChildren(...others.map(words => made("li", words, { className: "wrong" })));
}
code.addEventListener("input", () => {
  // Deleting everything leaves no block.
  if (!code.firstElementChild) { setText(code.textContent); }
  clearTimeout(page.timer);
  page.ok = false; buttons();
  page.timer = setTimeout(guarded(async () => { await save(); await checked(); }), 400);
});
code.addEventListener("paste", event => {
  event.preventDefault();
  document.execCommand("insertText", false, event.clipboardData.getData("text/plain"));
});
code.addEventListener("keydown", event => {
  if (event.key === "Tab" && !event.shiftKey && !event.ctrlKey) { event.preventDefault(); document.execCommand("insertText", false, "    "); }
});
$("write").onclick = guarded(async () => {
  const told = await ask("api/new-spec", { name: page.data.replace(/\.[^.]*$/, "") + ".ron" }, page.look.spec);
  await folder();
  await openSpec(told.name);
});

// 3. The answer.
function buttons() {
  $("back").disabled = !isBack() || page.conflict;
  $("gap").disabled = !page.spec || !page.ok || page.running || page.conflict;
  $("run").disabled = $("gap").disabled || !page.open;
  $("next").disabled = $("gap").disabled;
  $("stop").hidden = !page.running;
}
const start = what => guarded(async () => {
  await save();
  await ask("api/start", { name: page.spec, what }, "");
  $("answer").hidden = true;
  await watch();
});
$("gap").onclick = start("gap");
$("run").onclick = start("run");
$("next").onclick = start("next");
$("stop").onclick = guarded(() => { page.asked = true; return ask("api/stop", {}, ""); });
function working(job) {
  page.running = job.running;
  buttons();
  $("work").hidden = !job.job;
  if (!job.job) return;
  const what = { gap: "what is missing in ", run: "candidates of ", next: "the next run for " }[job.what] + job.spec, took = job.seconds.toFixed(1) + " s";
  $("bar").hidden = !job.running;
  $("bar").value = job.fraction;
  const stopped = job.ended && job.ended.stopped;
  $("line").textContent = job.running ? took + ", " + (job.stopping ? "stopping; " : "") + job.activity : what + (stopped ? ": stopped after " : ": ") + took;
  if (job.running) $("answer-name").textContent = what;
  $("curve").hidden = !job.running || !job.curve.length;
  if (!$("curve").hidden) {
    const now = job.curve.at(-1)[1], points = job.curve.flatMap(([t, gap], k) => k ? [[t, job.curve[k - 1][1]], [t, gap]] : [[t, gap]]);
    $("curve").replaceChildren(curve({ heading: "gap of the best model so far, now " + short(now) + " times the noise", unit: "over the seconds below", log: true, points: [...points, [job.seconds, now]] }));
  }
  if (job.ended && page.job !== job.job) {
    page.job = job.job;
    ended(job);
  }
}
const ended = guarded(async job => {
  const how = job.ended;
  await folder();
  if (how.lacks) tell(how.lacks);
  // A signal, another tab or a limit may have stopped it; its report says what did.
  if (how.stopped && page.asked) page.mine = how.result;
  page.asked = false;
  if (how.result) return showResult(how.result);
  if (how.diagnostics) { mark(how.diagnostics); throw new Error("the spec has mistakes"); }
  throw new Error([how.error, how.help].filter(Boolean).join(" - "));
});
async function showResult(name) {
  const result = await ask("results/" + encodeURIComponent(name) + "/result.json");
  $("answer").hidden = false;
  $("answer-name").textContent = name;
  const next = result.runs !== undefined, gap = !next && result.status !== undefined;
  const finding = next ? "Measure next: " + result.sentence : gap ? findingOfGap(result) : result.verdict + (result.reason ? ": " + result.reason : "");
  $("finding").textContent = result.stopped ? (name === page.mine ? "Stopped by you" : "Stopped early") + "; found so far: " + finding : finding;
  $("gaps").replaceChildren(...(gap ? bars(result) : []));
  $("numbers").replaceChildren(...(next ? [] : [numbers(result, gap)]));
  const file = (path, words, query) => made("a", words, { href: at("results/" + encodeURIComponent(name) + "/" + path, query) });
  const model = next ? "drive.csv" : gap ? "completed.ron" : "identified.ron";
  $("downloads").replaceChildren("Download:", file("report.html", "report", { keep: 1 }), file(model, model, { keep: 1 }), file("result.json", "numbers", { keep: 1 }),
    ...(next ? [] : page.languages).map(l => made("a", "model: " + l.id, { href: at("api/export", { result: name, to: l.id }), title: l.about })));
  const open = file("report.html", "open the report alone");
  open.target = "_blank"; open.rel = "noopener";
  $("downloads").append(open);
  $("report").src = at("results/" + encodeURIComponent(name) + "/report.html");
  $("answer").scrollIntoView({ block: "nearest" });
}
function findingOfGap(result) {
  const names = result.steps.map(s => s.name + " at " + s.at).join(", ");
  if (result.status === "nothing-missing") return "Nothing is missing: what is left is noise.";
  return result.status[0].toUpperCase() + result.status.slice(1) + (names ? ": " + names : "");
}
const shown = gap => gap.validate === null || gap.validate === undefined ? gap.fit : gap.validate;
function bars(result) {
  const rows = [["as it was", shown(result.initial)]];
  for (const step of result.steps) { const v = step.validate && step.validate.after; rows.push(["+ " + step.name, v === null || v === undefined ? step.fit.after : v]); }
  const most = Math.log(Math.max(...rows.map(r => r[1]), 2) / 0.5);
  return rows.flatMap(([words, value], k) => {
    const bar = made("i", undefined, { className: k ? "" : "before" });
    bar.style.width = Math.max(1, 100 * Math.log(Math.max(value, 0.51) / 0.5) / most) + "%";
    return [made("span", words), bar, made("span", short(value))];
  });
}
const row = (tag, cells) => { const tr = made("tr"); tr.append(...cells.map(c => made(tag, c))); return tr; };
const interval = ci => ci && ci.length === 2 ? "[" + short(ci[0]) + ", " + short(ci[1]) + "]" : "";
// The numbers of a result: name, value, interval, unit. Those of a law stand among the parameters again.
function listed(result) {
  const all = new Map(), put = (name, value, ci95, unit) => all.has(name) || all.set(name, { name, value, ci95, unit: unit || "" });
  const list = all => Array.isArray(all) ? all : [];
  for (const step of list(result.steps)) for (const [name, p] of Object.entries(step.parameters)) put(name, p.value, p.ci95, p.unit);
  for (const e of list(result.equations)) for (const t of list(e.terms)) put(t.candidate + " in " + e.state + "'", t.coefficient, t.ci95, t.unit);
  for (const p of list(result.parameters)) put(p.name, p.value, p.ci95, p.unit);
  return all;
}
async function ticked(tick) {
  // The two that were ticked last, the older first.
  page.ticked = [...page.ticked.filter(name => name !== tick.value), ...(tick.checked ? [tick.value] : [])].slice(-2);
  for (const other of $("results").querySelectorAll("[type=checkbox]")) other.checked = page.ticked.includes(other.value);
  $("compare").hidden = page.ticked.length < 2;
  if (page.ticked.length < 2) return;
  const newest = [...$("results").querySelectorAll("[type=checkbox]")].map(e => e.value);
  const names = [...page.ticked].sort((a, b) => newest.indexOf(b) - newest.indexOf(a)), all = await Promise.all(names.map(name => ask("results/" + encodeURIComponent(name) + "/result.json")));
  const [a, b] = all.map(listed), table = made("table");
  const error = p => p.ci95 && p.ci95.length === 2 ? (p.ci95[1] - p.ci95[0]) / 3.92 : NaN;
  table.append(row("th", ["number", ...names, "difference"]));
  for (const name of new Set([...a.keys(), ...b.keys()])) {
    const pair = [a.get(name), b.get(name)], said = p => p ? short(p.value) + " " + p.unit + " " + interval(p.ci95) : "none";
    const both = pair[0] && pair[1] && pair[0].unit === pair[1].unit, far = both ? (pair[1].value - pair[0].value) / Math.hypot(error(pair[0]), error(pair[1])) : NaN;
    table.append(row("td", [name, ...pair.map(said), isFinite(far) ? (far > 0 ? "+" : "") + far.toFixed(1) + " standard errors" : ""]));
  }
  $("compared").replaceChildren(table);
  $("compare").scrollIntoView({ block: "nearest" });
}
function numbers(result, gap) {
  const table = made("table"), box = made("div", undefined, { className: "scroll", tabIndex: 0, role: "region", ariaLabel: "numbers of the result" });
  table.append(row("th", ["number", "value", "95 % interval", "unit"]));
  for (const p of listed(result).values()) table.append(row("td", [p.name, short(p.value), interval(p.ci95), p.unit]));
  box.append(table);
  const doubts = [...(result.doubts || []), ...(result.warnings || [])];
  if (doubts.length) {
    const more = made("details", undefined, { open: doubts.length < 4 }), list = made("ul");
    list.append(...doubts.map(w => made("li", w)));
    more.append(made("summary", doubts.length === 1 ? "1 remark" : doubts.length + " remarks"), list);
    box.append(more);
  }
  return box;
}

// A record that grows.
async function live() {
  try {
    const now = await ask("api/live");
    if (!now) return;
    $("live").hidden = false;
    $("live-name").textContent = now.source + " into " + now.name;
    $("live-line").textContent = now.lines + " lines" + (now.ended ? ", ended" : " in " + now.seconds.toFixed(0) + " s") + (now.judged && now.judged.left_out ? ", " + now.judged.left_out + " of them no rows, left out of the judgement" : "") + (now.trouble ? ": " + now.trouble : "");
    $("live-line").classList.toggle("wrong", !!now.trouble);
    $("live-stop").hidden = now.ended;
    if (now.judged) {
      $("live-words").textContent = now.judged.words;
      $("live-forces").replaceChildren(...now.judged.forces.map(forceCurve));
      $("live-curves").replaceChildren(...(now.judged.curves || []).map(curve));
    }
    if (now.ended && now.judged) {
      await folder();
      return now.spec ? undefined : openData(now.name);
    }
  } catch (why) { tell(why); }
  setTimeout(live, 500);
}
$("live-stop").onclick = guarded(() => ask("api/live-stop", {}, ""));
function forceCurve(force) {
  const nodes = force.nodes.filter(n => n[2] !== null), W = 900, H = 180, left = 8;
  const { box, put } = drawing(W, H, `missing force of ${force.speed}: ${force.words}`);
  const most = Math.max(...force.nodes.map(n => Math.abs(n[0])), 1e-300), high = Math.max(...nodes.map(n => Math.abs(n[1])), 1e-300);
  // Errors far above the force are cut.
  const top = Math.min(2 * high, Math.max(...nodes.map(n => Math.abs(n[1]) + n[2]), high));
  // Each halving of the speed is one step to the middle.
  const X = v => W / 2 + Math.sign(v) * Math.max(0, 6 + Math.log2(Math.abs(v) / most)) / 6.5 * (W / 2 - left);
  const Y = f => H / 2 - Math.max(-1, Math.min(1, f / top)) * (H / 2 - 24);
  put("text", { x: left, y: 12 }, `missing force against ${force.speed}, up to ${short(high)} ${force.unit} at ${short(most)} ${force.speed_unit}; each step to the middle halves the speed`);
  put("line", { x1: left, x2: W - left, y1: H / 2, y2: H / 2, stroke: "var(--soft)" });
  for (const [v, f, half] of nodes) put("line", { x1: X(v), x2: X(v), y1: Y(f - half), y2: Y(f + half), stroke: "var(--soft)", "stroke-width": 5 });
  for (const side of [-1, 1]) put("polyline", { points: nodes.filter(n => n[0] * side > 0).map(n => X(n[0]).toFixed(1) + "," + Y(n[1]).toFixed(1)).join(" "), fill: "none", stroke: "var(--blue)", "stroke-width": 2 });
  put("text", { x: left, y: H - 4 }, short(-most)); put("text", { x: W - left, y: H - 4, "text-anchor": "end" }, short(most) + " " + force.speed_unit);
  return box;
}

// Ten minutes with an example; a step ticks itself when it is done.
const done = {
  data: () => page.data !== null, spec: () => page.spec !== null, change: () => page.back.length > 0,
  search: () => page.running || page.job > 0, answer: () => !$("answer").hidden,
};
function steps() {
  for (const li of $("steps").children) {
    if (done[li.dataset.step]()) li.classList.add("done");
    li.querySelector("i").textContent = li.classList.contains("done") ? "\u2713 done" : "";
  }
}
$("example").onclick = guarded(async () => { const told = await ask("api/example", {}, ""); await folder(); await openData(told.name); steps(); });
const tour = on => { $("tour").hidden = !on; $("tour-open").setAttribute("aria-expanded", on); steps(); };
$("tour-open").onclick = () => { tour($("tour").hidden); if (!$("tour").hidden) $("h-tour").focus(); };
$("tour-close").onclick = () => { tour(false); $("tour-open").focus(); };

// A file is dropped anywhere.
const over = on => event => { event.preventDefault(); $("drop").classList.toggle("over", on); };
addEventListener("dragover", over(true));
addEventListener("dragleave", over(false));
addEventListener("drop", event => { over(false)(event); if (event.dataTransfer.files.length) guarded(taken)(event.dataTransfer.files); });
$("choose").onclick = () => $("file").click();
$("file").onchange = guarded(async () => { const files = [...$("file").files]; $("file").value = ""; await taken(files); });
// The text is saved beside the file if that was changed elsewhere. A browser takes no long text from a page that closes: there it asks.
addEventListener("beforeunload", event => {
  if (!dirty()) return;
  const body = new Blob([text()]);
  if (body.size > 60000) return event.preventDefault();
  fetch(at("api/spec", { name: page.spec, beside: 1 }), { method: "POST", body, keepalive: true, headers: { "If-Match": page.version } });
});

// Looks at the work, and at the spec: an editor may change it too.
async function watch() {
  clearTimeout(page.watch);
  const version = page.version;
  try {
    const now = await ask("api/now", page.spec === null ? {} : { name: page.spec });
    if (page.gone) tell("");
    page.gone = false;
    working(now.job);
    steps();
    const elsewhere = now.version && now.version !== version && version === page.version && !page.conflict;
    if (elsewhere && !dirty()) await openSpec(page.spec);
  } catch (why) { page.gone = true; tell(why); }
  clearTimeout(page.watch);
  page.watch = setTimeout(watch, page.running ? 250 : 1000);
}
guarded(async () => {
  const state = await folder();
  tour(!state.results.length && !state.specs.length && !state.first);
  if (state.first) await (isSpec(state.first) ? openSpec(state.first) : openData(state.first));
  await live();
  await watch();
})();
