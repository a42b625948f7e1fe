"use strict";
const body = document.querySelector("tbody");
const rows = [...body.rows];
const text = document.getElementById("text");
const state = document.getElementById("state");
const words = new Map(rows.map((row) => [row, row.textContent.toLowerCase()]));

function filter() {
  const wanted = text.value.toLowerCase().split(/\s+/).filter(Boolean);
  let shown = 0;
  for (const row of rows) {
    const fits = wanted.every((word) => words.get(row).includes(word));
    row.hidden = !fits || (state.value !== "" && row.dataset.state !== state.value);
    shown += row.hidden ? 0 : 1;
  }
  document.getElementById("count").textContent = `${shown} of ${rows.length}`;
}

function sort(head) {
  const descending = head.getAttribute("aria-sort") === "ascending";
  for (const other of document.querySelectorAll("th[aria-sort]")) other.setAttribute("aria-sort", "none");
  head.setAttribute("aria-sort", descending ? "descending" : "ascending");
  const key = (row) => row.cells[head.cellIndex].dataset.key;
  const order = (one, other) => {
    const [a, b] = [key(one), key(other)];
    if (a === "" || b === "") return (a === "") - (b === "");  // what is not known comes last
    const found = head.dataset.kind === "number" ? a - b : a.localeCompare(b, "en", { numeric: true });
    return descending ? -found : found;
  };
  body.append(...rows.sort(order));
}

for (const head of document.querySelectorAll("th[aria-sort]")) head.firstChild.addEventListener("click", () => sort(head));
document.querySelector("form").addEventListener("submit", (event) => event.preventDefault());
text.addEventListener("input", filter);
state.addEventListener("change", filter);
filter();
document.documentElement.dataset.state = "ready";
