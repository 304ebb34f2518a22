"use strict";
(function () {
  const figures = JSON.parse(document.getElementById("figures").textContent);
  const config = { responsive: true, displayModeBar: "hover", displaylogo: false, modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"] };
  for (const figure of figures) {
    Plotly.newPlot("plot-" + figure.key, figure.data, figure.layout, config);
  }
  // Paper has another width than the screen.
  const fit = () => { for (const figure of figures) Plotly.Plots.resize("plot-" + figure.key); };
  window.addEventListener("beforeprint", fit);
  window.addEventListener("afterprint", fit);

  for (const head of document.querySelectorAll("table.sort thead th")) {
    head.classList.add("sortable");
    head.title = "sort";
    head.addEventListener("click", () => {
      const body = head.closest("table").tBodies[0];
      const column = head.cellIndex;
      const down = head.dataset.order !== "down";
      for (const other of head.parentNode.cells) delete other.dataset.order;
      head.dataset.order = down ? "down" : "up";
      const key = (row) => {
        const text = row.cells[column].dataset.value ?? row.cells[column].textContent;
        const number = Number(text);
        return Number.isNaN(number) ? text : number;
      };
      const rows = Array.from(body.rows).sort((a, b) => {
        const x = key(a), y = key(b);
        return (x < y ? -1 : x > y ? 1 : 0) * (down ? -1 : 1);
      });
      body.append(...rows);
    });
  }
})();
