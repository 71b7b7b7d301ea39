// Draws the charts of a report from the JSON block "charts" with Observable Plot, as SVG. A figure
// whose chart was drawn folds its table; one that could not be drawn says so and leaves it open.
(() => {
  "use strict";
  // Okabe and Ito's colours, told apart by colour-blind eyes; each with its own symbol.
  const styles = [
    {color: "#5f6b76", symbol: "circle"},
    {color: "#0072b2", symbol: "square"},
    {color: "#d55e00", symbol: "triangle"},
    {color: "#009e73", symbol: "diamond"},
    {color: "#cc79a7", symbol: "star"},
    {color: "#8a6d00", symbol: "cross"},
    {color: "#56b4e9", symbol: "wye"},
    {color: "#000000", symbol: "asterisk"},
    {color: "#1b3a57", symbol: "circle"},
    {color: "#d55e00", symbol: "square"},
  ];
  const page_width = 940;
  const font = {fontFamily: "inherit", fontSize: "12px", fontVariantNumeric: "tabular-nums", color: "#16202a"};
  const style_of = (series) => styles[series.style % styles.length];
  const title_of = (axis) => (axis.unit ? `${axis.label} [${axis.unit}]` : axis.label);
  const is_across = (series) => series.mark === "rule_across" || series.mark === "rule_up";

  function rows_of(series) {
    const n = Math.max(series.x ? series.x.length : 0, series.y ? series.y.length : 0);
    return Array.from({length: n}, (_, i) => ({
      x: series.x && series.x[i], y: series.y && series.y[i],
      dx: series.dx && series.dx[i], dy: series.dy && series.dy[i],
      high: series.high && series.high[i],
    }));
  }

  function marks_of(series, panel, many) {
    const {color, symbol} = style_of(series);
    const rows = rows_of(series);
    const scale = panel.arrow_scale || 1;
    const line = (curve) => Plot.line(rows, {x: "x", y: "y", stroke: color, strokeWidth: 1.6, curve});
    const dots = (r, extra) => Plot.dot(rows, {x: "x", y: "y", r, symbol, stroke: color, strokeWidth: 1.2, fill: "white", ...extra});
    const label = series.label && rows.length
      ? [Plot.text(rows.slice(-1), {x: "x", y: "y", text: () => series.label, textAnchor: "start", dx: 5, fill: color})]
      : [];
    switch (series.mark) {
      case "line": return [line("linear"), ...label];
      case "step": return [line("step-after"), ...label];
      case "dots": return [dots(2.6, {}), ...label];
      case "line_dots":
        return [
          Plot.line(rows, {x: "x", y: "y", stroke: color, strokeWidth: 0.9, strokeOpacity: 0.55}),
          dots(many ? 1.6 : 2.4, {fill: color, stroke: "none"}),
          ...label,
        ];
      case "arrows":
        return [
          Plot.arrow(rows, {
            x1: "x", y1: "y", x2: (d) => d.x + scale * d.dx, y2: (d) => d.y + scale * d.dy,
            stroke: color, strokeWidth: 1.3, headLength: 6, inset: 0,
          }),
          Plot.dot(rows, {x: "x", y: "y", r: 1.7, symbol, fill: color}),
        ];
      case "rule_across": return [Plot.ruleY(rows, {y: "y", stroke: color, strokeDasharray: "5 3", strokeWidth: 1.2})];
      case "rule_up": return [Plot.ruleX(rows, {x: "x", stroke: color, strokeDasharray: "5 3", strokeWidth: 1.2})];
      case "band": return [Plot.areaY(rows, {x: "x", y1: "y", y2: "high", fill: color, fillOpacity: 0.18})];
      case "bars": return [Plot.ruleX(rows, {x: "x", y1: 0, y2: "y", stroke: color, strokeWidth: 4})];
      default: throw new Error(`no such mark: ${series.mark}`);
    }
  }

  // A panel's extent where the data do not fix it, with a little air.
  function domain(axis, values) {
    let low = axis.low ?? d3.min(values), high = axis.high ?? d3.max(values);
    if (low === undefined || high === undefined) return undefined;
    if (axis.log) return [low, high];
    const air = high > low ? 0.04 * (high - low) : Math.abs(high || 1) * 0.1;
    if (axis.low === undefined) low -= air;
    if (axis.high === undefined) high += air;
    return [low, high];
  }

  // Powers of ten, and 2 and 5 times them where there are few.
  function log_ticks([low, high]) {
    const steps = Math.log10(high / low) < 2 ? [1, 2, 5] : [1];
    const powers = d3.range(Math.floor(Math.log10(low)), Math.ceil(Math.log10(high)) + 1);
    return powers.flatMap((p) => steps.map((s) => s * 10 ** p)).filter((v) => v >= low && v <= high);
  }

  // Room for the widest number of an axis and its title.
  function left_margin(y, small) {
    const scale = d3.scaleLinear(y.domain, [0, 1]);
    const numbers = Array.isArray(y.ticks) ? y.ticks.map(y.tickFormat) : scale.ticks(y.ticks).map(scale.tickFormat(y.ticks));
    const letters = d3.max(numbers, (text) => text.length) || 1;
    return Math.max(small ? 40 : 46, 7.2 * letters + 12 + (y.label ? 20 : 0));
  }

  // A map keeps its proportions: it is drawn no higher than half a printed page.
  function map_width(panel, width) {
    const [x, y] = ["x", "y"].map((name) => domain(panel[name], panel.series.flatMap((s) => s[name] || [])));
    const most_height = 460, margins = 60;
    return Math.round(Math.min(width, margins + (most_height * (x[1] - x[0])) / (y[1] - y[0])));
  }

  function draw_panel(panel, width, height, small) {
    if (panel.equal) width = map_width(panel, width);
    const of = (name) => panel.series.flatMap((s) => s[name] || []);
    const ys = [...of("y"), ...of("high")];
    const x = {label: title_of(panel.x), domain: domain(panel.x, of("x")), ticks: small ? 3 : Math.min(10, width / 70)};
    const y = {label: panel.y.label ? title_of(panel.y) : null, domain: domain(panel.y, ys), ticks: small ? 4 : 6, grid: true};
    for (const [axis, spec] of [[x, panel.x], [y, panel.y]]) {
      axis.labelArrow = "none";
      axis.labelAnchor = "center";
      if (spec.log) Object.assign(axis, {type: "log", ticks: log_ticks(axis.domain), tickFormat: (v) => `${+v.toPrecision(3)}`});
      if (spec.sqrt) Object.assign(axis, {type: "sqrt", domain: [0, axis.domain[1]]});
    }
    const many = d3.max(panel.series, (s) => (s.x || []).length) > 60;
    const marks = [
      ...(panel.equal ? [Plot.frame({stroke: "#c9d1d9"})] : []),
      ...panel.series.flatMap((s) => marks_of(s, panel, many)),
    ];
    if (panel.arrow_key) {
      const size = panel.arrow_key * (panel.arrow_scale || 1);
      const at = [{x: x.domain[0] + 0.05 * (x.domain[1] - x.domain[0]), y: y.domain[1] - 0.045 * (y.domain[1] - y.domain[0])}];
      marks.push(
        Plot.arrow(at, {x1: "x", y1: "y", x2: (d) => d.x + size, y2: "y", stroke: "#16202a", strokeWidth: 1.6, headLength: 6}),
        Plot.text(at, {x: (d) => d.x + size, y: "y", dx: 6, text: () => `${panel.arrow_key} mm`, textAnchor: "start", fill: "#16202a", stroke: "white", strokeWidth: 3}),
      );
    }
    const svg = Plot.plot({
      width, ...(panel.equal ? {aspectRatio: 1} : {height}),
      marginLeft: left_margin(y, small), marginRight: small ? 6 : 12, marginTop: 10, marginBottom: small ? 34 : 40,
      x, y, style: font, marks, ariaLabel: panel.title,
    });
    svg.setAttribute("class", "plot");
    svg.setAttribute("role", "img");
    svg.style.maxWidth = `${width}px`;
    const box = document.createElement("div");
    box.className = "panel";
    const title = document.createElement("p");
    title.className = "panel-title";
    title.textContent = panel.title;
    if (panel.arrow_key) {
      const how = document.createElement("span");
      const scale = panel.arrow_scale || 1;
      how.textContent = scale === 1 ? "arrows in true length" : `arrows drawn ${scale} times as long`;
      title.append(how);
    }
    box.append(title, svg);
    return box;
  }

  function legend_of(chart) {
    const seen = new Map();
    for (const panel of chart.panels) {
      for (const s of panel.series) if (s.name) seen.set(`${s.name}|${s.style}|${s.mark}`, s);
    }
    if (seen.size === 0) return null;
    const legend = document.createElement("div");
    legend.className = "legend";
    for (const s of seen.values()) {
      const {color, symbol} = style_of(s);
      const key = d3.create("svg").attr("width", 26).attr("height", 12).attr("aria-hidden", "true");
      if (s.mark !== "dots" && s.mark !== "bars") {
        key.append("line").attr("x1", 1).attr("x2", 25).attr("y1", 6).attr("y2", 6).attr("stroke", color)
          .attr("stroke-width", 1.8).attr("stroke-dasharray", is_across(s) ? "5 3" : null);
      }
      if (s.mark === "line_dots" || s.mark === "dots") {
        const shape = d3["symbol" + symbol[0].toUpperCase() + symbol.slice(1)] || d3.symbolCircle;
        key.append("path").attr("transform", "translate(13,6)").attr("d", d3.symbol(shape, 36)()).attr("fill", color);
      } else if (s.mark === "arrows") {
        key.append("path").attr("d", "M25,6 l-7,-3.5 v7 z").attr("fill", color);
      }
      const item = document.createElement("span");
      item.append(key.node(), s.name);
      legend.append(item);
    }
    return legend;
  }

  function draw(place, chart) {
    const columns = chart.in_a_row;
    const small = columns > 3;
    const width = Math.round((page_width - (columns - 1) * 12) / columns);
    const panels = document.createElement("div");
    panels.className = small ? "panels small" : "panels";
    panels.style.gridTemplateColumns = `repeat(${columns}, minmax(0, 1fr))`;
    for (const panel of chart.panels) panels.append(draw_panel(panel, width, chart.height, small));
    const legend = legend_of(chart);
    place.replaceChildren(...(legend ? [legend] : []), panels);
  }

  const charts = JSON.parse(document.getElementById("charts").textContent);
  for (const place of document.querySelectorAll("[data-chart]")) {
    const table = place.closest("figure").querySelector("details");
    try {
      draw(place, charts[place.dataset.chart]);
      place.dataset.drawn = "yes";
      table.open = false;
    } catch (error) {
      const words = document.createElement("p");
      words.className = "chart-trouble";
      words.textContent = `This chart could not be drawn (${error.message}). Its numbers are in the table below.`;
      place.replaceChildren(words);
      place.dataset.drawn = "no";
    }
  }
})();
