// Tables sort by the column whose heading is pressed; once more turns the order round.

/** Number at the beginning of a cell; none where there is none. */
function value(cell) {
  const text = cell ? cell.textContent.trim().replace(/−/g, '-') : '';
  const number = parseFloat(text);
  return { text, number };
}

function sortable(table) {
  const body = table.tBodies[0];
  const headings = table.tHead ? [...table.tHead.rows[table.tHead.rows.length - 1].cells] : [];
  if (!body || body.rows.length < 2) return;
  headings.forEach((heading, column) => {
    const button = element('button', { type: 'button', class: 'sort' }, ...heading.childNodes);
    heading.replaceChildren(button);
    button.addEventListener('click', () => {
      const falls = heading.getAttribute('aria-sort') === 'ascending';
      headings.forEach((other) => other.removeAttribute('aria-sort'));
      heading.setAttribute('aria-sort', falls ? 'descending' : 'ascending');
      const rows = [...body.rows].map((row) => ({ row, of: value(row.cells[column]) }));
      const all = rows.filter(({ of }) => of.text !== '' && of.text !== '–' && of.text !== 'not seen');
      const numeric = all.every(({ of }) => Number.isFinite(of.number));
      const rest = rows.filter((row) => !all.includes(row));
      const way = falls ? -1 : 1;
      all.sort((a, b) => way * (numeric
        ? a.of.number - b.of.number
        : a.of.text.localeCompare(b.of.text, 'en', { numeric: true })));
      body.append(...all.map(({ row }) => row), ...rest.map(({ row }) => row));
    });
  });
}
