"use strict";
// Tables: a heading sorts, a button saves what stands there as CSV.
(function () {
  const value = (row, column) => {
    const cell = row.cells[column], text = cell.dataset.value ?? cell.textContent, number = Number(text);
    return Number.isNaN(number) || text === "" ? text : number;
  };
  function sort(head) {
    const table = head.closest("table"), body = table.tBodies[0], column = head.cellIndex;
    const down = head.getAttribute("aria-sort") !== "descending";
    for (const other of head.parentNode.cells) other.setAttribute("aria-sort", "none");
    head.setAttribute("aria-sort", down ? "descending" : "ascending");
    const rows = Array.from(body.rows).sort((a, b) => {
      const x = value(a, column), y = value(b, column);
      return (x < y ? -1 : x > y ? 1 : 0) * (down ? -1 : 1);
    });
    const printed = Number(table.closest(".table").dataset.printed);
    rows.forEach((row, i) => row.classList.toggle("screen", i >= printed));
    body.append(...rows);
  }
  function csv(table) {
    const quote = (text) => (/[",\n]/.test(text) ? '"' + text.replaceAll('"', '""') + '"' : text);
    const lines = [Array.from(table.tHead.rows[0].cells, (cell) => quote(cell.textContent.trim()))];
    for (const row of table.tBodies[0].rows) {
      lines.push(Array.from(row.cells, (cell) => quote(cell.dataset.value ?? cell.textContent)));
    }
    return lines.map((line) => line.join(",")).join("\n") + "\n";
  }
  function save(name, text) {
    const link = document.createElement("a");
    Object.assign(link, { href: URL.createObjectURL(new Blob([text], { type: "text/csv" })), download: name });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }
  for (const place of document.querySelectorAll(".table")) {
    const table = place.querySelector("table");
    for (const button of table.querySelectorAll("thead button")) {
      button.title = "sort by " + button.textContent;
      button.addEventListener("click", () => sort(button.parentNode));
    }
    place.querySelector(".download").addEventListener("click", () => save(place.dataset.name + ".csv", csv(table)));
  }
})();
