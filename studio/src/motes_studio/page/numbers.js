// Numbers that are typed into fields.

import { announce } from "./announce.js";

/** Return the numbers in fields, or null after saying what the first wrong one takes. */
export function numbersIn(fields) {
  const wrong = fields.find((field) => field.value === "" || !field.checkValidity());
  if (!wrong) return fields.map(({ valueAsNumber }) => valueAsNumber);
  const name = wrong.getAttribute("aria-label") ?? wrong.labels[0].textContent;
  const kind = wrong.step === "any" ? "a number" : "a whole number";
  const from = wrong.min && ` from ${wrong.min}`;
  const to = wrong.max && ` to ${wrong.max}`;
  announce(`${name}: give ${kind}${from}${to}.`, "error");
  return null;
}

/** Return the number that was typed into a field; one that it does not take gives way to that of before. */
export function numberTyped(field, before) {
  const numbers = numbersIn([field]);
  if (numbers) return numbers[0];
  field.value = before;
  return before;
}
