// Lists the other versions that stand beside this one; without a server, or with one version, there is no list.
(async () => {
  const root = new URL(document.documentElement.dataset.content_root || "./", location.href);
  const asked = await fetch(new URL("../versions.json", root)).catch(() => null);
  const versions = asked?.ok ? await asked.json() : [];
  const here = root.pathname.split("/").filter(Boolean).pop();
  const side = document.querySelector(".sidebar-sticky .sidebar-tree") ?? document.querySelector(".sidebar-tree");
  if (versions.length < 2 || !side) return;
  const label = document.createElement("label");
  label.className = "versions";
  label.append("Version ");
  const select = document.createElement("select");
  for (const one of versions) select.add(new Option(one, one, one === here, one === here));
  select.addEventListener("change", () => {
    location.href = new URL(`../${select.value}/`, root).href;
  });
  label.append(select);
  side.before(label);
})();
