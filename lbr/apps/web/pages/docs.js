"use strict";
// Shows /openapi.json. All text goes in as text, never as HTML.

const make = (name, text, ...children) => {
  const made = document.createElement(name);
  if (text) made.textContent = text;
  made.append(...children);
  return made;
};

const kind = (schema) => {
  if (!schema) return "";
  if (schema.$ref) return schema.$ref.split("/").pop();
  if (schema.anyOf) return schema.anyOf.map(kind).join(" or ");
  if (schema.enum) return schema.enum.map((one) => JSON.stringify(one)).join(" or ");
  if (schema.type === "array") return `list of ${kind(schema.items) || "anything"}`;
  const limits = [
    "minimum" in schema ? `from ${schema.minimum}` : "", "maximum" in schema ? `to ${schema.maximum}` : "",
    "default" in schema ? `else ${JSON.stringify(schema.default)}` : "",
  ];
  return [schema.type || "anything", ...limits].filter(Boolean).join(" ");
};

const row = (...cells) => make("tr", "", ...cells.map((cell) => make("td", cell)));

const operation = (path, method, found) => {
  const summary = make("summary", "", make("b", method.toUpperCase()), make("code", path), ` ${found.summary} `);
  const role = make("span", found["x-role"]);
  role.className = "role";
  summary.append(role);
  const details = make("details", "", summary);
  if (found.description) details.append(make("p", found.description));
  const table = make("table");
  for (const one of found.parameters || [])
    table.append(row(`${one.name}${one.required ? "" : " (may be left out)"}`, kind(one.schema), one.description || ""));
  const body = found.requestBody && found.requestBody.content["application/json"];
  if (body) table.append(row("body", kind(body.schema), "JSON"));
  for (const [status, answer] of Object.entries(found.responses)) {
    const [media, content] = Object.entries(answer.content || {})[0] || ["", {}];
    table.append(row(status, media === "application/json" ? kind(content.schema) : media, answer.description));
  }
  details.append(table);
  return details;
};

const show = async () => {
  const document_ = await (await fetch("/openapi.json")).json();
  document.getElementById("title").textContent = document_.info.title;
  document.getElementById("about").textContent = document_.info.description;
  const routes = document.getElementById("routes");
  for (const [path, methods] of Object.entries(document_.paths))
    for (const [method, found] of Object.entries(methods)) routes.append(operation(path, method, found));
  routes.append(make("h2", "What is said"));
  for (const [name, schema] of Object.entries(document_.components.schemas))
    routes.append(make("details", "", make("summary", name), make("pre", JSON.stringify(schema, null, 2))));
};

show().catch((err) => { document.getElementById("about").textContent = `The document cannot be shown: ${err}`; });
