// A figure becomes one to zoom into when its button is pressed. The library lies packed in the page.
"use strict";
(() => {
  const packed = document.getElementById("plotly-packed");
  if (!packed || !("DecompressionStream" in window)) return;
  let library = null;
  const unpacked = () => {
    library = library || (async () => {
      const bytes = Uint8Array.from(atob(packed.textContent.trim()), (letter) => letter.charCodeAt(0));
      const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
      const script = document.createElement("script");
      script.textContent = await new Response(stream).text();
      document.head.append(script);
    })();
    return library;
  };
  const options = { responsive: true, displaylogo: false, scrollZoom: true, modeBarButtonsToRemove: ["select2d", "lasso2d"] };
  for (const data of document.querySelectorAll("script.chart")) {
    const figure = data.closest("figure"), still = figure.querySelector("svg");
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = "Zoom";
    figure.querySelector("figcaption").append(" ", button);
    let place = null;
    button.addEventListener("click", async () => {
      if (place) {
        const zoomed = place.hidden;
        place.hidden = !zoomed;
        still.classList.toggle("zoomed", zoomed);
        button.textContent = zoomed ? "Still picture" : "Zoom";
        return;
      }
      button.disabled = true;
      button.textContent = "unpacking";
      await unpacked();
      place = document.createElement("div");
      place.className = "chart";
      place.style.height = `${Math.max(360, still.getBoundingClientRect().height)}px`;
      still.after(place);
      still.classList.add("zoomed");
      const chart = JSON.parse(data.textContent);
      await window.Plotly.newPlot(place, chart.data, chart.layout, options);
      button.disabled = false;
      button.textContent = "Still picture";
    });
  }
})();
