// The explorer of the API: Swagger UI, with what it lacks for those who do not see it or use no pointer.

const root = document.getElementById("swagger-ui");
root.setAttribute("role", "main");
document.title = "graspd API";

window.ui = SwaggerUIBundle({
  dom_id: "#swagger-ui",
  url: "/openapi.json",
  deepLinking: true,
  validatorUrl: "none",
  syntaxHighlight: { theme: "monokai" },
  presets: [SwaggerUIBundle.presets.apis],
});

function name(element, text) {
  if (!element.hasAttribute("aria-label")) {
    element.setAttribute("aria-label", text);
  }
}

function mend() {
  for (const link of root.querySelectorAll("button a[href]")) {
    // The button around it leads to the same place.
    link.removeAttribute("href");
  }
  for (const example of root.querySelectorAll("pre.microlight")) {
    // What does not fit is scrolled to.
    example.tabIndex = 0;
  }
  for (const button of root.querySelectorAll(".copy-to-clipboard button")) {
    name(button, "Copy");
  }
  for (const button of root.querySelectorAll(".close-modal")) {
    name(button, "Close");
  }
  for (const field of root.querySelectorAll("input, select, textarea")) {
    if (field.labels.length === 0) {
      const row = field.closest("tr")?.querySelector(".parameter__name");
      const own = field.getAttribute("placeholder") || field.title;
      name(field, row?.firstChild?.textContent.trim() || own || "Request body");
    }
  }
}

new MutationObserver(mend).observe(root, { childList: true, subtree: true });
