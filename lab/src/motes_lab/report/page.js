for (const button of document.querySelectorAll("th button")) {
  button.addEventListener("click", () => {
    const head = button.closest("th"), body = head.closest("table").tBodies[0];
    const value = row => {
      const cell = row.cells[head.cellIndex], number = cell.dataset.value;
      return number === undefined ? cell.textContent.trim() : Number(number);
    };
    const rows = Array.from(body.rows);
    const numeric = rows.some(row => typeof value(row) === "number");
    const order = head.getAttribute("aria-sort");
    const up = order ? order === "descending" : !numeric;
    rows.sort((one, other) => {
      const a = value(one), b = value(other);
      if (typeof a !== typeof b) return typeof a === "number" ? -1 : 1;  // missing numbers last
      const less = typeof a === "number" ? a - b : a.localeCompare(b, undefined, {numeric: true});
      return up ? less : -less;
    });
    for (const other of head.parentNode.cells) other.removeAttribute("aria-sort");
    head.setAttribute("aria-sort", up ? "ascending" : "descending");
    body.append(...rows);
  });
}
