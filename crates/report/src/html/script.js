// Hover values, zoom of all figures over time at once, switches for what a figure shows. The page is complete without it.
(() => {
  "use strict";
  const make = (name, className, text) => {
    const made = document.createElement(name);
    made.className = className;
    if (text) made.textContent = text;
    return made;
  };
  const spread = { linear: (v) => v, log: (v) => Math.log(Math.max(v, 1e-300)), "from-zero": (v) => Math.log1p(Math.max(v, 0)) };
  const gather = { linear: (v) => v, log: Math.exp, "from-zero": Math.expm1 };
  const axis = (text) => {
    const [from, to, scale, name, unit] = text.split("|");
    const a = spread[scale](+from), b = spread[scale](+to);
    return { name, unit, from: +from, to: +to, value: (part) => gather[scale](a + (b - a) * part) };
  };
  const shown = (value, span) => {
    const decimals = Math.max(0, 3 - Math.floor(Math.log10(Math.abs(span) || 1)) - 1);
    const size = Math.abs(value);
    const text = decimals > 6 || size >= 1e6 ? value.toExponential(3) : value.toFixed(decimals);
    return text.replace("-", "\u2212");
  };
  const panels = [];
  for (const group of document.querySelectorAll("figure svg .panel")) {
    const [x, y, width, height] = group.dataset.place.split(" ").map(Number);
    const own = { group, svg: group.ownerSVGElement, x, y, width, height, across: axis(group.dataset.x), up: axis(group.dataset.y) };
    own.over = own.across.name === "time";
    own.view = [0, 1];
    panels.push(own);
  }
  const note = make("div", "hover");
  note.setAttribute("aria-hidden", "true");
  document.body.append(note);
  const line = (panel) => {
    if (!panel.line) {
      panel.line = document.createElementNS(panel.group.namespaceURI, "line");
      panel.line.setAttribute("class", "cursor");
      panel.line.setAttribute("y1", panel.y);
      panel.line.setAttribute("y2", panel.y + panel.height);
      panel.group.append(panel.line);
    }
    return panel.line;
  };
  const place = (event, svg) => {
    const box = svg.getBoundingClientRect(), view = svg.viewBox.baseVal;
    return [(event.clientX - box.left) * view.width / box.width, (event.clientY - box.top) * view.height / box.height];
  };
  const at = (svg, x, y) => panels.find((p) => p.svg === svg && x >= p.x && x <= p.x + p.width && y >= p.y && y <= p.y + p.height);
  const part = (panel, x) => panel.view[0] + (panel.view[1] - panel.view[0]) * (x - panel.x) / panel.width;
  const inUnit = (a, value) => `${a.name} ${shown(value, a.to - a.from)}${a.unit ? " " + a.unit : ""}`;
  // The height of each line at a place, from its path: lines over time go from left to right.
  const heights = (panel, x) => {
    const across = panel.x + panel.width * part(panel, x);
    const found = [];
    for (const path of panel.group.querySelectorAll("path.measured, path.before, path.model, path.residual, path.truth")) {
      if (path.classList.contains("dot") || path.style.display === "none") continue;
      path.points ??= (path.getAttribute("d").match(/-?[\d.]+ -?[\d.]+/g) ?? []).map((p) => p.split(" ").map(Number));
      let best = null;
      for (const p of path.points) if (!best || Math.abs(p[0] - across) < Math.abs(best[0] - across)) best = p;
      if (best && Math.abs(best[0] - across) < 8) {
        found.push([path.classList[0], panel.up.value(1 - (best[1] - panel.y) / panel.height)]);
      }
    }
    return found;
  };
  const hide = () => { note.style.display = "none"; for (const p of panels) if (p.line) p.line.style.display = "none"; };
  const names = { measured: "measured", before: "before", model: "model", residual: "residual", truth: "truth" };
  for (const svg of new Set(panels.map((p) => p.svg))) {
    let from = null;
    svg.addEventListener("pointermove", (event) => {
      const [x, y] = place(event, svg);
      const panel = at(svg, x, y);
      if (!panel) return hide();
      const rows = [inUnit(panel.across, panel.across.value(part(panel, x)))];
      const values = panel.over || panel.across.name === "lag" ? heights(panel, x) : [];
      for (const [name, value] of values) rows.push(`${names[name] ?? name} ${shown(value, panel.up.to - panel.up.from)} ${panel.up.unit}`);
      if (!values.length && panel.up.name) rows.push(inUnit(panel.up, panel.up.value(1 - (y - panel.y) / panel.height)));
      note.replaceChildren(...rows.map((row) => make("div", "", row)));
      note.style.display = "block";
      note.style.left = `${Math.min(event.clientX + 14, innerWidth - note.offsetWidth - 8)}px`;
      note.style.top = `${event.clientY + 16}px`;
      for (const other of panels) {
        const together = other === panel || (panel.over && other.over && other.svg === svg);
        if (together) { line(other).setAttribute("x1", x); line(other).setAttribute("x2", x); }
        if (other.line) other.line.style.display = together ? "" : "none";
      }
    });
    svg.addEventListener("pointerleave", hide);
    svg.addEventListener("pointerdown", (event) => { const [x, y] = place(event, svg); const panel = at(svg, x, y); from = panel?.over && event.pointerType === "mouse" ? [panel, x] : null; });
    // A drag selects time, not text.
    svg.addEventListener("mousedown", (event) => { if (from) event.preventDefault(); });
    svg.addEventListener("pointerup", (event) => {
      if (!from) return;
      const [panel, start] = from, [end] = place(event, svg);
      from = null;
      const ends = [start, Math.min(Math.max(end, panel.x), panel.x + panel.width)].map((x) => panel.across.value(part(panel, x))).sort((a, b) => a - b);
      if (Math.abs(end - start) > 12) zoom(ends);
    });
    svg.addEventListener("dblclick", () => zoom(null));
  }
  const ticks = (from, to, count) => {
    const rough = (to - from) / count, size = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map((s) => s * size).find((s) => s >= rough);
    const out = [];
    for (let k = Math.ceil(from / step); k * step <= to; k++) out.push([k * step, (k * step).toFixed(Math.max(0, -Math.floor(Math.log10(step))))]);
    return out;
  };
  // All panels over time show the same stretch; those of other records, which do not have it, stay as they are.
  function zoom(ends) {
    for (const p of panels.filter((p) => p.over)) {
      const whole = p.across.to - p.across.from;
      const view = ends ? ends.map((t) => (t - p.across.from) / whole) : [0, 1];
      if (view[1] <= 0 || view[0] >= 1) continue;
      p.view = [Math.max(view[0], 0), Math.min(view[1], 1)];
      const [a, b] = p.view;
      p.group.classList.toggle("zoomed", ends !== null);
      for (const inner of p.group.querySelectorAll(":scope > svg")) {
        inner.setAttribute("preserveAspectRatio", "none");
        inner.setAttribute("viewBox", `${p.x + a * p.width} ${p.y} ${(b - a) * p.width} ${p.height}`);
      }
      const marks = p.group.querySelector(".ticks"), below = p.y + p.height;
      p.words ??= [...p.group.querySelectorAll("text.middle:not(.label)")].filter((t) => +t.getAttribute("y") > below && +t.getAttribute("y") < below + 30);
      p.path ??= marks?.getAttribute("d");
      for (const word of p.words) word.style.display = ends ? "none" : "";
      p.group.querySelectorAll(".new").forEach((t) => t.remove());
      if (!ends) { marks?.setAttribute("d", p.path); continue; }
      const list = ticks(p.across.from + a * whole, p.across.from + b * whole, p.width / 84);
      const where = (t) => p.x + p.width * ((t - p.across.from) / whole - a) / (b - a);
      marks?.setAttribute("d", list.map(([t]) => `M${where(t)} ${below}v5`).join(""));
      if (p.words.length) for (const [t, text] of list) {
        const word = document.createElementNS(p.group.namespaceURI, "text");
        word.setAttribute("class", "middle new");
        word.setAttribute("x", where(t));
        word.setAttribute("y", below + 20);
        word.textContent = text;
        p.group.append(word);
      }
    }
    for (const button of document.querySelectorAll(".tools .reset")) button.hidden = !ends;
  }
  for (const figure of document.querySelectorAll("figure")) {
    const keys = [...(figure.querySelector("svg")?.querySelectorAll(".key") ?? [])];
    const tools = make("div", "tools");
    const lines = keys.filter((key) => ["measured", "before", "model", "truth", "band"].includes(key.dataset.of.split(" ")[0]));
    for (const key of lines.length > 1 && !figure.closest(".pair, .full") ? lines : []) {
      const name = key.dataset.of.split(" ")[0];
      const button = make("button", "toggle", key.textContent);
      button.type = "button";
      button.setAttribute("aria-pressed", "true");
      button.addEventListener("click", () => {
        const show = button.getAttribute("aria-pressed") !== "true";
        button.setAttribute("aria-pressed", show);
        for (const mark of figure.querySelectorAll(`.panel .${CSS.escape(name)}`)) mark.style.display = show ? "" : "none";
      });
      tools.append(button);
    }
    if (panels.some((p) => p.over && figure.contains(p.svg))) {
      const reset = make("button", "reset", "whole record");
      reset.type = "button";
      reset.hidden = true;
      reset.addEventListener("click", () => zoom(null));
      tools.append(reset);
    }
    if (tools.childElementCount) figure.querySelector("figcaption")?.before(tools);
  }
})();
