// SPDX-License-Identifier: GPL-3.0-or-later
// Draws the charts of a report: every <div class="chart" data-chart="ID"> from the JSON in <script id="ID">.
(() => {
  "use strict";

  const kPrintWidth = 660;  // CSS px that fit a printed page
  const kNumColors = 6;
  const kAxisFont = "12px system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif";
  const kLabelFont = "13px system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif";

  const color = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

  // Five significant digits, with an exponent only where zeros would take over.
  function value_text(value) {
    if (value == null) return "–";
    const size = Math.abs(value);
    if (size !== 0 && (size >= 1e6 || size < 1e-4)) return String(+value.toPrecision(5)).includes("e")
      ? (+value.toPrecision(5)).toExponential() : value.toExponential(4);
    return String(+value.toPrecision(5));
  }

  // As many decimals as the step between ticks needs, the same for all of them.
  function linear_tick_texts(ticks, step) {
    const largest = Math.max(...ticks.map(Math.abs));
    if (largest >= 1e6 || step < 1e-5) {
      const digits = Math.max(0, Math.floor(Math.log10(largest / step) + 1e-9));
      return ticks.map((tick) => (tick === 0 ? "0" : tick.toExponential(digits)));
    }
    let decimals = 0;
    while (decimals < 6 && Math.abs(Math.round(step * 10 ** decimals) - step * 10 ** decimals) > 1e-6 * step * 10 ** decimals) ++decimals;
    return ticks.map((tick) => tick.toFixed(decimals));
  }

  function power_text(power) {
    return "10" + String(power).replace(/[-0-9]/g, (c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[c]));
  }

  // Powers of ten if there are two or more of them, all ticks otherwise.
  function log_tick_texts(ticks) {
    const power_of = (tick) => {
      const power = Math.log10(tick);
      return Math.abs(power - Math.round(power)) < 1e-9 ? Math.round(power) : null;
    };
    const shown = ticks.filter((tick) => tick != null);
    if (shown.filter((tick) => power_of(tick) !== null).length < 2) {
      return ticks.map((tick) => (tick == null ? "" : String(+tick.toPrecision(3))));
    }
    return ticks.map((tick) => (tick == null || power_of(tick) === null ? "" : power_text(power_of(tick))));
  }

  // A sample with gaps on both sides would be a line of no length: it gets a dot.
  function lonely_samples(plot, series_index, shown) {
    if (shown) return null;
    const y = plot.data[series_index];
    const lonely = [];
    let before = null;  // index of the sample before, null: a gap or nothing
    let candidate = null;
    for (let i = 0; i < y.length; ++i) {
      if (y[i] === undefined) continue;
      if (y[i] === null) {
        if (candidate !== null) lonely.push(candidate);
        before = candidate = null;
      } else {
        candidate = before === null ? i : null;
        before = i;
      }
    }
    if (candidate !== null) lonely.push(candidate);
    return lonely.length ? lonely : null;
  }

  function series_options(series, index) {
    const stroke = color(`--series-${(index % kNumColors) + 1}`);
    const points = series.style === "points";
    return {
      label: series.label,
      class: series.style,
      stroke,
      width: points ? 0 : 1.6,
      dash: series.style === "dashed" ? [6, 4] : undefined,
      paths: points ? () => null : undefined,
      points: { show: points, size: points ? 4 : 3, width: 0, fill: stroke, stroke, filter: lonely_samples },
      value: (plot, value) => value_text(value),
    };
  }

  // Vertical lines with their labels, which step down where they would overlap.
  function draw_marks(marks) {
    return (plot) => {
      const { ctx, bbox } = plot;
      const ratio = devicePixelRatio;
      const shown = marks
        .map((mark) => ({ label: mark.label, place: plot.valToPos(mark.x, "x", true) }))
        .filter((mark) => mark.place >= bbox.left - 1 && mark.place <= bbox.left + bbox.width + 1)
        .sort((a, b) => a.place - b.place);
      const row_ends = [];
      ctx.save();
      ctx.font = kAxisFont.replace("12px", `${12 * ratio}px`);
      ctx.textBaseline = "top";
      ctx.lineWidth = ratio;
      for (const mark of shown) {
        const width = ctx.measureText(mark.label).width;
        const flips = mark.place + width + 6 * ratio > bbox.left + bbox.width;
        const start = flips ? mark.place - width - 5 * ratio : mark.place + 5 * ratio;
        let row = row_ends.findIndex((end) => end < start);
        if (row < 0) row = row_ends.length;
        row_ends[row] = start + width + 8 * ratio;
        ctx.strokeStyle = color("--muted");
        ctx.setLineDash([2 * ratio, 3 * ratio]);
        ctx.beginPath();
        ctx.moveTo(mark.place, bbox.top);
        ctx.lineTo(mark.place, bbox.top + bbox.height);
        ctx.stroke();
        const top = bbox.top + (4 + 16 * row) * ratio;
        ctx.fillStyle = color("--paper");
        ctx.globalAlpha = 0.8;
        ctx.fillRect(start - 2 * ratio, top - ratio, width + 4 * ratio, 15 * ratio);
        ctx.globalAlpha = 1;
        ctx.fillStyle = color("--muted");
        ctx.fillText(mark.label, start, top);
      }
      ctx.restore();
    };
  }

  function axis_options(label, log) {
    return {
      label,
      labelFont: kLabelFont,
      font: kAxisFont,
      stroke: color("--muted"),
      grid: { stroke: color("--grid"), width: 1 },
      ticks: { show: false },
      values: log ? (plot, ticks) => log_tick_texts(ticks) : (plot, ticks, axis, space, step) => linear_tick_texts(ticks, step),
    };
  }

  function y_axis_size(plot, texts) {
    const longest = Math.max(0, ...(texts ?? []).map((text) => text.length));
    return Math.max(34, 14 + 7 * longest);
  }

  const height_for = (width) => Math.round(Math.min(360, Math.max(230, 0.46 * width)));

  function draw(chart) {
    const { host, content } = chart;
    const width = chart.width ?? host.clientWidth;
    host.replaceChildren();
    const options = {
      width,
      height: height_for(width),
      scales: { x: { time: false }, y: content.log_y ? { distr: 3 } : {} },
      axes: [
        { ...axis_options(content.x_label, false), labelGap: 2 },
        { ...axis_options(content.y_label, content.log_y), size: y_axis_size, labelGap: 4 },
      ],
      series: [
        { label: content.x_label, value: (plot, value) => value_text(value) },
        ...content.series.map(series_options),
      ],
      cursor: { drag: { x: true, y: false, setScale: true }, points: { size: 7 } },
      legend: {
        markers: {
          width: 2,
          stroke: (plot, index) => color(`--series-${((index - 1) % kNumColors) + 1}`),
          fill: (plot, index) => (content.series[index - 1].style === "points"
            ? color(`--series-${((index - 1) % kNumColors) + 1}`) : "transparent"),
          dash: (plot, index) => (content.series[index - 1].style === "dashed" ? "dashed" : "solid"),
        },
      },
      hooks: { draw: [draw_marks(content.marks)] },
    };
    chart.plot = new uPlot(options, chart.data, host);
  }

  const charts = [...document.querySelectorAll(".chart")].map((host) => {
    const content = JSON.parse(document.getElementById(host.dataset.chart).textContent);
    const column = (series) => series.y.map((y) => (y === "" ? undefined : y));
    return { host, content, data: [content.x, ...content.series.map(column)] };
  });
  const draw_all = () => charts.forEach(draw);
  draw_all();

  const watcher = new ResizeObserver(() => {
    for (const { host, plot, width } of charts) {
      if (width === undefined && Math.abs(plot.width - host.clientWidth) >= 1) {
        plot.setSize({ width: host.clientWidth, height: height_for(host.clientWidth) });
      }
    }
  });
  charts.forEach(({ host }) => watcher.observe(host));

  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw_all);

  const set_printing = (printing) => {
    document.documentElement.toggleAttribute("data-print", printing);
    charts.forEach((chart) => (chart.width = printing ? kPrintWidth : undefined));
    draw_all();
  };
  addEventListener("beforeprint", () => set_printing(true));
  addEventListener("afterprint", () => set_printing(false));
})();
