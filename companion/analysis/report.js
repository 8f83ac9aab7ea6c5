"use strict";
// Time charts: drag zooms all of them, double click shows all, the pointer reads values. Track: wheel and drag.
(() => {
  const LEFT = 112, RIGHT = 8, WIDTH = 1000;
  const charts = [...document.querySelectorAll("svg.chart")];
  const tip = document.body.appendChild(Object.assign(document.createElement("div"), { id: "tip" }));
  const boxOf = (svg) => svg.getAttribute("viewBox").split(" ").map(Number);
  const clock = (t) => {
    const sign = t < 0 ? "−" : "", s = Math.abs(Math.round(t)), two = (n) => String(n).padStart(2, "0");
    if (s < 60) return sign + s;
    if (s < 3600) return `${sign}${Math.floor(s / 60)}:${two(s % 60)}`;
    return `${sign}${Math.floor(s / 3600)}:${two(Math.floor(s / 60) % 60)}:${two(s % 60)}`;
  };
  const plots = charts.map((chart) => chart.querySelector("svg.plot")).filter(Boolean);
  if (plots.length) {
    const [first, , span] = boxOf(plots[0]);
    let view = [first, span];
    const STEPS = [1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 1800, 3600, 7200, 14400];
    const show = (from, width) => {
      view = [from, Math.max(width, 0.5)];
      const step = STEPS.find((s) => view[1] / s <= 10) ?? STEPS.at(-1);
      for (const chart of charts) {
        const plot = chart.querySelector("svg.plot"), times = chart.querySelector("g.times"), box = boxOf(plot);
        plot.setAttribute("viewBox", [view[0], box[1], view[1], box[3]].join(" "));
        const y = Number(plot.getAttribute("y")) + Number(plot.getAttribute("height")) + 15;
        let out = "";
        for (let t = Math.ceil(view[0] / step) * step; t <= view[0] + view[1]; t += step) {
          const x = LEFT + ((t - view[0]) / view[1]) * (WIDTH - LEFT - RIGHT);
          out += `<text class='tick' x='${x.toFixed(1)}' y='${y}' text-anchor='${x > WIDTH - 30 ? "end" : "middle"}'>${clock(t)}</text>`;
        }
        times.innerHTML = out;
      }
    };
    const timeAt = (chart, event) => {
      const area = chart.getBoundingClientRect(), x = ((event.clientX - area.left) / area.width) * WIDTH;
      return view[0] + ((x - LEFT) / (WIDTH - LEFT - RIGHT)) * view[1];
    };
    const points = new WeakMap();
    const pointsOf = (path) => {
      if (!points.has(path)) {
        points.set(path, path.getAttribute("d").split(/[ML]/).slice(1).map((p) => p.replace("h0", "").split(",").map(Number)));
      }
      return points.get(path);
    };
    const nearest = (list, t) => {
      let a = 0, b = list.length - 1;
      while (b - a > 1) { const m = (a + b) >> 1; if (list[m][0] < t) a = m; else b = m; }
      return Math.abs(list[a]?.[0] - t) < Math.abs(list[b]?.[0] - t) ? list[a] : list[b];
    };
    let drag = null;
    for (const chart of charts) {
      chart.addEventListener("pointerdown", (event) => { drag = { chart, t: timeAt(chart, event) }; });
      chart.addEventListener("dblclick", () => show(first, span));
      chart.addEventListener("pointerleave", () => { tip.style.display = "none"; });
      chart.addEventListener("pointermove", (event) => {
        const t = timeAt(chart, event);
        if (t < view[0] || t > view[0] + view[1]) { tip.style.display = "none"; return; }
        const lines = [`${clock(t)}  (${t.toFixed(1)} s)`];
        for (const path of chart.querySelectorAll("path[data-name]")) {
          const point = nearest(pointsOf(path), t);
          if (point && Math.abs(point[0] - t) < Math.max(2, view[1] / 100)) {
            const turn = Number(path.dataset.turn), value = turn ? ((-point[1] % turn) + turn) % turn : -point[1];
            lines.push(`${path.dataset.name}: ${value.toPrecision(4)}`);
          }
        }
        tip.textContent = lines.join("\n");
        tip.style.display = "block";
        tip.style.left = `${Math.min(event.clientX + 14, innerWidth - tip.offsetWidth - 8)}px`;
        tip.style.top = `${event.clientY + 14}px`;
      });
    }
    addEventListener("pointerup", (event) => {
      if (drag) {
        const end = timeAt(drag.chart, event), from = Math.max(first, Math.min(drag.t, end)), to = Math.min(first + span, Math.max(drag.t, end));
        if (to - from > view[1] / 200) show(from, to - from);
        drag = null;
      }
    });
  }
  for (const map of document.querySelectorAll("svg.track")) {
    const whole = boxOf(map), pixels = Number(map.getAttribute("width")), labels = [...map.querySelectorAll("text")];
    const set = (box) => {
      map.setAttribute("viewBox", box.join(" "));
      const scale = box[2] / pixels, taken = [];
      for (const label of labels) {
        const { x, y, dx, dy } = label.dataset, size = 12 * scale;
        label.setAttribute("font-size", size);
        const px = Number(x) + Number(dx) * scale, py = Number(y) + Number(dy) * scale;
        label.setAttribute("x", px);
        label.setAttribute("y", py);
        const own = [px, py - 1.1 * size, px + 0.62 * size * label.textContent.length, py];
        const free = taken.every((b) => own[2] < b[0] || own[0] > b[2] || own[3] < b[1] || own[1] > b[3]);
        label.classList.toggle("hidden", !free);
        if (free) taken.push(own);
      }
      const raw = box[2] / 6, power = 10 ** Math.floor(Math.log10(raw)), step = [1, 2, 5, 10].find((s) => s * power >= raw) * power;
      const bar = map.parentElement.querySelector(".scale");
      bar.querySelector("i").style.width = `${(100 * step) / box[2]}%`;
      bar.querySelector("span").textContent = `${Number(step.toPrecision(2))} m, north is up`;
      let net = "";
      for (let e = Math.ceil(box[0] / step) * step; e < box[0] + box[2]; e += step) net += `<line x1='${e}' x2='${e}' y1='${box[1]}' y2='${box[1] + box[3]}'/>`;
      for (let s = Math.ceil(box[1] / step) * step; s < box[1] + box[3]; s += step) net += `<line y1='${s}' y2='${s}' x1='${box[0]}' x2='${box[0] + box[2]}'/>`;
      map.querySelector("g.net").innerHTML = net;
    };
    map.addEventListener("wheel", (event) => {
      event.preventDefault();
      const box = boxOf(map), area = map.getBoundingClientRect(), factor = event.deltaY > 0 ? 1.25 : 0.8;
      const fx = (event.clientX - area.left) / area.width, fy = (event.clientY - area.top) / area.height;
      set([box[0] + fx * box[2] * (1 - factor), box[1] + fy * box[3] * (1 - factor), box[2] * factor, box[3] * factor]);
    }, { passive: false });
    let last = null;
    map.addEventListener("pointerdown", (event) => { last = event; map.setPointerCapture(event.pointerId); });
    map.addEventListener("pointerup", () => { last = null; });
    map.addEventListener("pointermove", (event) => {
      if (!last) return;
      const box = boxOf(map), scale = box[2] / map.getBoundingClientRect().width;
      set([box[0] - (event.clientX - last.clientX) * scale, box[1] - (event.clientY - last.clientY) * scale, box[2], box[3]]);
      last = event;
    });
    map.addEventListener("dblclick", () => set(whole));
  }
})();
