"use strict";
// Follows a run that `pathfit serve` shows: asks it for news, and draws the page anew where something changed.

const PAUSE_MS = 1000;

function say(words) {
  let line = document.getElementById("live");
  if (!line) {
    line = h("p", { id: "live", role: "status" });
    document.body.append(line);
  }
  line.textContent = words;
}

async function follow() {
  let version = "";
  for (;;) {
    try {
      const answer = await fetch("data.json", { headers: { "If-None-Match": version }, cache: "no-store" });
      if (answer.status === 200) {
        version = answer.headers.get("ETag");
        draw(await answer.json());
      } else if (answer.status !== 304) {
        throw new Error(await answer.text());
      }
      say("");
    } catch (problem) {
      say(problem instanceof TypeError ? "pathfit serve does not answer; what is shown may be old." : problem.message);
    }
    await new Promise((resolve) => setTimeout(resolve, PAUSE_MS));
  }
}

follow();
