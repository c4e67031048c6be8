// Dialogs that leave the rest of the page alive: Stop acts while one is open, by key, click and touch. (A
// modal dialog makes the page around it inert.)

/** Opens a dialog at its beginning. @param {HTMLDialogElement} dialog */
export function openDialog(dialog) {
  if (!dialog.open) dialog.show();
  dialog.scrollTop = 0;
}

addEventListener("keydown", (event) => {
  if (event.key === "Escape") for (const dialog of document.querySelectorAll("dialog[open]")) dialog.close();
});
