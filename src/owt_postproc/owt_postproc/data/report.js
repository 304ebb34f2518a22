"use strict";
// Draws the figures of the page: zoomed lines with all their samples, the structure in the colour that is chosen.
(function () {
  const figures = JSON.parse(document.getElementById("figures").textContent);
  const config = {
    responsive: true, displayModeBar: "hover", displaylogo: false, scrollZoom: "gl3d",
    modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"],
  };

  const isArray = (value) => value && typeof value === "object" && "bdata" in value;
  function decode(spec) {
    const raw = atob(spec.bdata);
    const bytes = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
    return new Float32Array(bytes.buffer);
  }
  function decodeIn(object) {
    for (const key of Object.keys(object)) {
      if (isArray(object[key])) object[key] = decode(object[key]);
    }
  }

  // A line of many samples is drawn as its envelope; all samples are drawn once few enough are in view.
  function fillOnZoom(place, figure) {
    const lines = figure.extra.samples.map((line) => ({ ...line, y: decode(line.y) }));
    const overview = lines.map((line) => ({ x: figure.data[line.trace].x, y: figure.data[line.trace].y }));
    let detailed = false;
    place.on("plotly_relayout", (change) => {
      if (!Object.keys(change).some((key) => key.startsWith("xaxis"))) return;
      const [low, high] = place.layout.xaxis.range;
      const fine = lines.every((line) => (high - low) / line.dx <= figure.extra.most);
      if (!fine && !detailed) return;
      detailed = fine;
      const drawn = lines.map((line, i) => (fine ? window_(line, low, high) : overview[i]));
      Plotly.restyle(place, { x: drawn.map((d) => d.x), y: drawn.map((d) => d.y) }, lines.map((d) => d.trace));
    });
  }
  function window_(line, low, high) {
    const first = Math.max(0, Math.floor((low - line.x0) / line.dx) - 1);
    const last = Math.min(line.y.length, Math.ceil((high - line.x0) / line.dx) + 2);
    const y = line.y.slice(first, last);
    return { x: Float64Array.from(y, (_, i) => line.x0 + (first + i) * line.dx), y };
  }

  // The structure: tubes in space, and the same colours in the drawings for paper.
  function mix(scale, share) {
    let i = 1;
    while (i < scale.length - 1 && share > scale[i][0]) i++;
    const [a, from] = scale[i - 1], [b, to] = scale[i];
    const t = (share - a) / (b - a);
    const part = (k) => Math.round((1 - t) * parseInt(from.substr(k, 2), 16) + t * parseInt(to.substr(k, 2), 16));
    return `rgb(${part(1)}, ${part(3)}, ${part(5)})`;
  }
  function colourBy(place, extra, key) {
    const chosen = extra.measures.find((one) => one.key === key);
    if (place) {
      Plotly.restyle(place, {
        intensity: [extra.end_of_vertex.map((end) => chosen.share[end])],
        "colorbar.title.text": chosen.title, "colorbar.tickvals": [chosen.tick], "colorbar.ticktext": [chosen.text],
      }, [0]);
    }
    document.getElementById("measure-note").textContent = chosen.note;
    for (const line of document.querySelectorAll(".views line")) {
      line.setAttribute("stroke", mix(extra.scale, chosen.share[line.dataset.end]));
    }
    document.getElementById("views-title").innerHTML = chosen.title;
    const ticks = document.getElementById("views-ticks");
    const every = Math.ceil(chosen.tick.length / 4);
    ticks.replaceChildren(...chosen.tick.map((share, i) => {
      const tick = document.createElement("span");
      tick.style.left = 100 * share + "%";
      tick.innerHTML = i % every ? "" : chosen.text[i];
      return tick;
    }));
  }
  function canDrawInSpace() {
    const canvas = document.createElement("canvas");
    return Boolean(canvas.getContext("webgl2") || canvas.getContext("webgl"));
  }
  function structure(place, figure) {
    const extra = figure.extra, select = document.getElementById("measure");
    if (!canDrawInSpace()) {
      document.body.classList.add("flat");
      place.remove();
      const note = document.createElement("p");
      note.className = "note";
      note.textContent = "This browser draws nothing in space (it has no WebGL): the views stand for the picture.";
      select.parentNode.after(note);
      place = null;
    } else {
      figure.data[0].text = extra.end_of_vertex.map((end) => extra.end_text[end]);
      Plotly.newPlot(place, figure.data, figure.layout, config);
    }
    const recolour = () => colourBy(place, extra, select.value);
    select.addEventListener("change", recolour);
    recolour();
  }

  for (const figure of figures) {
    const place = document.getElementById("plot-" + figure.key);
    figure.data.forEach(decodeIn);
    if (figure.extra.measures) {
      structure(place, figure);
      continue;
    }
    Plotly.newPlot(place, figure.data, figure.layout, config);
    if (figure.extra.samples) fillOnZoom(place, figure);
  }

  // Paper is narrower than the screen, and asks for the width before it lays the page out.
  const PAPER = 690, SHORTER = 0.75;
  const flat = figures.filter((figure) => !figure.extra.measures);
  function size(figure, height, change) {
    const place = document.getElementById("plot-" + figure.key);
    place.style.height = height + "px";
    Plotly.relayout(place, { height, ...change });
  }
  const heights = flat.map((figure) => figure.layout.height);
  window.addEventListener("beforeprint", () => {
    flat.forEach((figure, i) => size(figure, SHORTER * heights[i], { autosize: false, width: PAPER }));
  });
  window.addEventListener("afterprint", () => {
    flat.forEach((figure, i) => size(figure, heights[i], { autosize: true, width: null }));
  });
  document.body.dataset.ready = "yes";
})();
