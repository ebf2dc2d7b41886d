"use strict";
document.querySelectorAll("a[download]").forEach(function (link) {
  const data = link.getAttribute("href");
  const comma = data.indexOf(",");
  const bytes = Uint8Array.from(atob(data.slice(comma + 1)), function (c) { return c.charCodeAt(0); });
  link.href = URL.createObjectURL(new Blob([bytes], { type: data.slice(5, data.indexOf(";")) }));
});

const views = document.querySelectorAll("svg.turns");
const vector = function (text) { return text.split(" ").map(Number); };
views.forEach(function (svg) {
  svg.addEventListener("pointerdown", function (event) { svg.setPointerCapture(event.pointerId); });
  svg.addEventListener("pointermove", function (event) {
    if (!svg.hasPointerCapture(event.pointerId)) return;
    views.forEach(function (view) { turn(view, event.movementX, event.movementY); });
  });
});

function turn(svg, dx, dy) {
  const azimuth = Number(svg.dataset.azimuth) - dx / 120;
  const elevation = Math.max(-1.57, Math.min(1.57, Number(svg.dataset.elevation) + dy / 120));
  svg.dataset.azimuth = azimuth;
  svg.dataset.elevation = elevation;
  const center = vector(svg.dataset.center), middle = vector(svg.dataset.middle);
  const scale = Number(svg.dataset.scale);
  const sa = Math.sin(azimuth), ca = Math.cos(azimuth), se = Math.sin(elevation), ce = Math.cos(elevation);
  const paper = function (text) {
    const p = vector(text).map(function (value, k) { return value - center[k]; });
    return [middle[0] + scale * (ca * p[1] - sa * p[0]),
            middle[1] - scale * (ce * p[2] - se * (ca * p[0] + sa * p[1]))];
  };
  const set = function (element, names, values) {
    names.forEach(function (name, k) { element.setAttribute(name, values[k].toFixed(1)); });
  };
  svg.querySelectorAll("line").forEach(function (line) {
    set(line, ["x1", "y1", "x2", "y2"], paper(line.dataset.p).concat(paper(line.dataset.q)));
  });
  svg.querySelectorAll("circle").forEach(function (circle) {
    set(circle, ["cx", "cy"], paper(circle.dataset.p));
  });
  svg.querySelectorAll("text[data-p]").forEach(function (text) {
    set(text, ["x", "y"], text.dataset.from ? inside(paper(text.dataset.from), paper(text.dataset.p))
                                            : paper(text.dataset.p));
  });
  svg.querySelectorAll("rect").forEach(function (rect) {
    const p = paper(rect.dataset.p);
    set(rect, ["x", "y"], [p[0] - 4, p[1] - 4]);
  });
}

// The point between both ends that is next to the second and on the paper, and a little above it.
function inside(from, to) {
  const low = [50, 42], high = [430, 350];
  let part = 1;
  [0, 1].forEach(function (k) {
    if (to[k] > high[k]) part = Math.min(part, (high[k] - from[k]) / (to[k] - from[k]));
    if (low[k] > to[k]) part = Math.min(part, (low[k] - from[k]) / (to[k] - from[k]));
  });
  part = Math.max(part, 0);
  return [from[0] + part * (to[0] - from[0]), from[1] + part * (to[1] - from[1]) - 8];
}
