"use strict";
// Gives the token, from behind the # of the address or from the form, for a cookie that scripts cannot read.
const said = document.getElementById("said");

async function show(token) {
  history.replaceState(null, "", location.pathname + location.search);
  const answer = await fetch("session", { method: "POST", headers: { Authorization: `Bearer ${token}` } });
  if (answer.ok) location.replace("index.html");
  else said.textContent = (await answer.json()).message;
}

document.getElementById("form").addEventListener("submit", (event) => {
  event.preventDefault();
  show(document.getElementById("token").value.trim()).catch(() => { said.textContent = "The robot does not answer."; });
});

const given = new URLSearchParams(location.hash.slice(1)).get("token");
if (given) show(given).catch(() => { said.textContent = "The robot does not answer."; });
