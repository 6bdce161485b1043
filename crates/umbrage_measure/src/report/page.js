"use strict";
(() => {
  for (const element of document.querySelectorAll(".js")) element.hidden = false;
  for (const element of document.querySelectorAll(".nojs")) element.hidden = true;

  const body = document.querySelector("#figures tbody");
  const rows = [...body.rows];
  const headers = [...document.querySelectorAll("#figures thead tr:last-child th")];

  // Numbers by value, what is missing last in either direction; names as people order them.
  const names = new Intl.Collator("en", { numeric: true });
  const compare = (column, sign) => (a, b) => {
    const [x, y] = [a.cells[column], b.cells[column]];
    if (x.classList.contains("name")) return sign * names.compare(x.textContent, y.textContent);
    const [u, v] = [x.dataset.v, y.dataset.v];
    if (u === undefined || v === undefined) return (u === undefined) - (v === undefined);
    return sign * (Number(u) - Number(v));
  };
  headers.forEach((header, column) => {
    header.querySelector("button").addEventListener("click", () => {
      const down = header.getAttribute("aria-sort") === "ascending";
      for (const other of headers) other.removeAttribute("aria-sort");
      header.setAttribute("aria-sort", down ? "descending" : "ascending");
      body.append(...rows.toSorted(compare(column, down ? -1 : 1)));
    });
  });

  const filter = document.querySelector("#scene-filter");
  const show = () => {
    for (const row of rows) row.hidden = filter.value !== "" && row.dataset.scene !== filter.value;
  };
  filter.addEventListener("change", show);
  show();

  // A link to a folded row opens it.
  const open = () => {
    const target = document.getElementById(location.hash.slice(1));
    if (target?.tagName !== "DETAILS") return;
    target.open = true;
    target.scrollIntoView();
  };
  addEventListener("hashchange", open);
  open();

  document.addEventListener("click", (event) => {
    const pictures = event.target.closest(".pictures img, .truth")?.closest(".pictures");
    pictures?.classList.toggle("big");
  });
})();
