// The drills of a demo: short tasks, each with a result, and what the camera laws would have done beside it.

import { openDialog } from "./dialogs.js";
import { element } from "./elements.js";
import { setText } from "./status.js";
import { sentence, words } from "./words.js";

const at = (id) => document.getElementById(id);

export class Drills {
  #drill = null;

  /** @param {(wanted: object) => Promise<void>} request makes a request and shows its refusal @param {(text: string) => void} say */
  constructor(request, say) {
    this.say = say;
    at("drill-list").replaceChildren(...words.drills.flatMap(({ name, title, task }) => {
      const id = `task-${name}`;
      return [element("button", sentence(title), { value: name, "aria-describedby": id }), element("p", task, { id })];
    }));
    for (const form of [at("drill-form"), at("result-form")]) {
      form.addEventListener("submit", ({ submitter }) => {
        if (submitter?.value === "all") this.open();
        else if (submitter?.value !== "no") request({ kind: "drill", drill: submitter.value, seed: (this.#drill?.seed ?? 0) + 1 });
      });
    }
  }

  /** Opens the list. */
  open() {
    openDialog(at("drill-dialog"));
  }

  /** @param {{drill: any}} snapshot */
  onSnapshot({ drill }) {
    const before = this.#drill;
    this.#drill = drill;
    at("drill-text").hidden = !drill;
    if (!drill) return;
    const { title, task } = words.drills.find(({ name }) => name === drill.name);
    if (before?.name !== drill.name || (before.result && !drill.result)) this.say(task);
    setText(at("drill-text"), words.drillText(sentence(title), Math.ceil(drill.left_s)));
    if (drill.result && !before?.result) this.#showResult(drill, title);
  }

  #showResult({ name, result }, title) {
    at("result-title").textContent = `${sentence(title)}: ${result.passed ? words.drillPassed : words.drillFailed}`;
    at("result-sentence").textContent = result.sentence;
    const rows = [["person", result.person], ["schema", result.schema], ["default", result.default_law]];
    at("result-rows").replaceChildren(...rows.map(([who, figures]) => {
      const row = element("tr", "");
      const head = element("th", words.drillBy[who], { scope: "row" });
      row.replaceChildren(head, ...words.drillFigures(figures).map((figure) => element("td", figure)));
      return row;
    }));
    const names = words.drills.map((drill) => drill.name);
    at("drill-again").value = name;
    at("drill-next").value = names[(names.indexOf(name) + 1) % names.length];
    openDialog(at("result-dialog"));
  }
}
